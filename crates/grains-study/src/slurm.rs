//! Scripts by which SLURM runs a study: an array of jobs, one for each member, and a job that gathers, and begins the next array while
//! members are left.

use crate::error::StudyError;
use crate::folder::write;
use crate::study_file::Study;
use std::path::{Path, PathBuf};

/// Seconds before the end of a job at which its run leaves by itself; a tenth of its time if that is less.
const MARGIN: f64 = 600.0;

/// What each job of an array may take.
#[derive(Clone, Debug)]
pub struct JobArray {
    /// Time of one job (min).
    pub minutes: f64,
    /// Further lines of sbatch, such as `account=NAME`.
    pub sbatch: Vec<String>,
}

/// Writes `NAME.sbatch` and `NAME-gather.sbatch` beside a study; returns both.
///
/// # Errors
/// A file that cannot be written.
pub fn write_scripts(study: &Study, jobs: &JobArray) -> Result<[PathBuf; 2], StudyError> {
    let file = Path::new(&study.written.0);
    let name = study.name();
    let [array, gather] = ["", "-gather"].map(|ending| file.with_file_name(format!("{name}{ending}.sbatch")));
    let further: String = jobs.sbatch.iter().map(|line| format!("#SBATCH --{line}\n")).collect();
    let job_name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    let seconds = 60.0 * jobs.minutes;
    let walltime = (seconds - MARGIN.min(seconds / 10.0)).floor();
    let together = study.run.jobs.map_or(String::new(), |jobs| format!("%{jobs}"));
    let (ranks, minutes) = (study.run.ranks, jobs.minutes.ceil());
    let [file, array_file, gather_file] = [file, &array, &gather].map(quoted);
    let array_text = format!(
        r#"#!/bin/bash
#SBATCH --job-name={job_name}
#SBATCH --ntasks={ranks}
#SBATCH --cpus-per-task=1
#SBATCH --time={minutes}
#SBATCH --output=%x-%A-%a.log
#SBATCH --signal=B:USR1@60
{further}# One member of a study; {gather_file} submits it.
set -euo pipefail
export OMP_NUM_THREADS=1
grains-mpi sweep {file} --only "$SLURM_ARRAY_TASK_ID" --launcher srun --max-walltime {walltime} &
job=$!
trap 'kill -USR1 "$job" 2>/dev/null || true' USR1
# A signal interrupts wait; the code that counts is that of the member.
while kill -0 "$job" 2>/dev/null; do
    wait "$job" || true
done
wait "$job"
"#
    );
    let gather_text = format!(
        r#"#!/bin/bash
#SBATCH --job-name={job_name}-gather
#SBATCH --ntasks=1
#SBATCH --time=60
#SBATCH --output=%x-%j.log
{further}# Gathers a study. While members are left, submits an array of jobs that run them, and itself once more after those.
# Submit it from the directory in which it was written.
set -euo pipefail
left=$(grains-mpi sweep {file} --left)
if [ -n "$left" ]; then
    job=$(sbatch --parsable --array="$left{together}" {array_file})
    sbatch --dependency="afterany:${{job%%;*}}" {gather_file}
fi
grains-mpi sweep {file} --gather
"#
    );
    write(&array, &array_text)?;
    write(&gather, &gather_text)?;
    Ok([array, gather])
}

/// A word of a shell, quoted.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}

/// Numbers as the option `--array` takes them: `1-4,7`.
pub(crate) fn array(mut numbers: Vec<usize>) -> String {
    numbers.sort_unstable();
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let run = |run: &[usize]| match run {
        [first, .., last] => format!("{first}-{last}"),
        other => other.iter().map(usize::to_string).collect(),
    };
    runs.map(run).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_follow_each_other_are_joined() {
        assert_eq!(array(vec![7, 1, 2, 4, 3, 9, 10]), "1-4,7,9-10");
        assert_eq!(array(vec![]), "");
    }
}
