//! A SLURM script for a case that goes on, job by job, until the run has ended.

use grains_case::Case;
use grains_simulation::RunError;
use std::fs;
use std::path::{Path, PathBuf};

/// Seconds before the end of a job at which its run leaves by itself; a tenth of its time if that is less.
const MARGIN: u64 = 600;

/// What a job may take.
#[derive(clap::Args)]
pub struct JobSize {
    /// Number of ranks.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    ranks: u32,
    /// Time of one job (min).
    #[arg(long, default_value_t = 1440, value_parser = clap::value_parser!(u64).range(10..))]
    minutes: u64,
    /// A further line of sbatch, such as `account=NAME`; may be given again.
    #[arg(long, value_name = "OPTION=VALUE")]
    sbatch: Vec<String>,
}

/// Writes the script beside the case, and prints what comes next.
///
/// # Errors
/// A case that is wrong, and a file that cannot be written.
pub fn write(case: &Path, to: Option<PathBuf>, size: &JobSize) -> Result<(), RunError> {
    let read = Case::load(case).map_err(|errors| RunError::case(errors.to_string()))?;
    let script = to.unwrap_or_else(|| case.with_extension("sbatch"));
    let text = script_of(case, &read, &script, size);
    fs::write(&script, text)
        .map_err(|e| RunError::files(format!("cannot write {}: {e}", script.display())))?;
    say!(
        "{}: {} ranks, {} min a job, submitted again until the run has ended",
        script.display(),
        size.ranks,
        size.minutes
    );
    say!("\nNext:\n  sbatch {}", script.display());
    Ok(())
}

/// A word of a shell, quoted.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}

fn script_of(case: &Path, read: &Case, script: &Path, size: &JobSize) -> String {
    let JobSize { ranks, minutes, sbatch } = size;
    let name: String = read.name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    let further: String = sbatch.iter().map(|line| format!("#SBATCH --{line}\n")).collect();
    let seconds = 60 * minutes;
    let walltime = seconds - MARGIN.min(seconds / 10);
    let (results, case, script) = (quoted(&read.output.directory), quoted(case), quoted(script));
    format!(
        r#"#!/bin/bash
#SBATCH --job-name={name}
#SBATCH --ntasks={ranks}
#SBATCH --cpus-per-task=1
#SBATCH --time={minutes}
#SBATCH --output=%x-%j.log
#SBATCH --signal=B:USR1@60
{further}# Runs {case} from its last checkpoint, if there is one. The run leaves with a checkpoint before the time is up, and this
# script submits itself again until the run has ended, or `grains-mpi stop` is asked. Submit it from the directory in which it was written.
set -euo pipefail
export OMP_NUM_THREADS=1
results={results}
restart=()
if compgen -G "$results/checkpoint-*.h5" >/dev/null; then
    restart=(--restart latest)
fi
srun grains-mpi {case} "${{restart[@]}}" --max-walltime {walltime} &
job=$!
trap 'kill -USR1 "$job" 2>/dev/null || true' USR1
# A signal interrupts wait; the code that counts is that of the run.
while kill -0 "$job" 2>/dev/null; do
    wait "$job" || true
done
wait "$job"
if grep -q '"stopped_by": "\(signal\|walltime\)"' "$results/status.json"; then
    sbatch {script}
fi
"#
    )
}
