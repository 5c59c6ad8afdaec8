//! `grains-mpi sweep`: what the command line says of a study.

use crate::VERSION;
use clap::ArgGroup;
use grains_simulation::RunError;
use grains_study::{JobArray, Launch, Options, Study, StudyError, Task, carry_out, write_scripts};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What a study is asked.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("task").multiple(false))]
pub struct SweepArguments {
    /// Study file (TOML).
    #[arg(required_unless_present = "schema")]
    study: Option<PathBuf>,
    /// Runs side by side; `run.jobs` of the study by default, or as many as there are cores.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    jobs: Option<u32>,
    /// Check and list all members, and run nothing.
    #[arg(long, group = "task")]
    dry_run: bool,
    /// Write table, picture and fit of what there is, and run nothing.
    #[arg(long, group = "task")]
    gather: bool,
    /// Run one member.
    #[arg(long, group = "task", value_name = "MEMBER")]
    only: Option<usize>,
    /// Print the numbers of the members that are left, as `sbatch --array` takes them.
    #[arg(long, group = "task")]
    left: bool,
    /// Write the scripts by which SLURM runs the study.
    #[arg(long, group = "task")]
    slurm: bool,
    /// Print the JSON schema of study files.
    #[arg(long, group = "task")]
    schema: bool,
    /// Run members again that failed.
    #[arg(long)]
    retry: bool,
    /// Words that start the ranks of a run, such as `srun`; `mpirun -n RANKS` by default.
    #[arg(long, value_name = "COMMAND")]
    launcher: Option<String>,
    /// Wall-clock time (s) after which a run writes a checkpoint and leaves; `run.minutes` of the study by default.
    #[arg(long, value_name = "SECONDS", value_parser = crate::walltime)]
    max_walltime: Option<f64>,
    /// A further line of the scripts for SLURM, such as `account=NAME`; may be given again.
    #[arg(long, value_name = "OPTION=VALUE")]
    sbatch: Vec<String>,
}

/// Time of a job of SLURM (min) where the study gives none.
const MINUTES: f64 = 1440.0;

/// Carries out what is asked.
///
/// # Errors
/// A study that is wrong, files that cannot be written, and runs that failed.
pub fn sweep(arguments: &SweepArguments) -> Result<(), RunError> {
    let Some(path) = arguments.study.as_deref().filter(|_| !arguments.schema) else {
        say!("{:#}", grains_study::schema());
        return Ok(());
    };
    let study = Study::load(path).map_err(told)?;
    check_analyses(&study)?;
    if arguments.slurm {
        let jobs =
            JobArray { minutes: study.run.minutes.unwrap_or(MINUTES), sbatch: arguments.sbatch.clone() };
        let [array, gather] = write_scripts(&study, &jobs).map_err(told)?;
        say!("{}: one member, {} ranks, {} min", array.display(), study.run.ranks, jobs.minutes);
        say!("{}: submits that for all members that are left, and gathers", gather.display());
        say!("\nNext:\n  sbatch {}", gather.display());
        return Ok(());
    }
    let ranks = study.run.ranks;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let own = study.run.jobs.unwrap_or((cores / ranks).max(1));
    let task = match arguments {
        SweepArguments { dry_run: true, .. } => Task::DryRun,
        SweepArguments { gather: true, .. } => Task::Gather,
        SweepArguments { left: true, .. } => Task::Left,
        SweepArguments { only: Some(member), .. } => Task::Only(*member),
        _ => Task::Run,
    };
    let options =
        Options { task, jobs: arguments.jobs.map_or(own, |jobs| jobs as usize), retry: arguments.retry };
    let program = std::env::current_exe().map_err(|error| RunError::files(error.to_string()))?;
    let launcher = arguments.launcher.iter().flat_map(|words| words.split_whitespace());
    let launch = Launch {
        program,
        version: VERSION.into(),
        launcher: launcher.map(String::from).collect(),
        ranks,
        walltime: arguments.max_walltime.or(study.run.minutes.map(|minutes| 60.0 * minutes)),
        interrupted: interrupted()?,
    };
    carry_out(&study, &options, &launch, &|line| say!("{line}")).map_err(told)
}

/// Refuses analyses that are none before anything runs, and warns where nothing is measured.
fn check_analyses(study: &Study) -> Result<(), RunError> {
    for (name, measure) in &study.measure {
        let Some(asked) = &measure.analyse else { continue };
        let words = ["grains-mpi", "analyse"].into_iter().chain(asked.split_whitespace()).chain(["run"]);
        if let Err(problem) = crate::understood(words.map(OsString::from)) {
            let first = problem.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
            let message = format!("is no analysis ({first}); `grains-mpi analyse --help` lists them");
            return Err(RunError::case(study.about(&format!("measure.{name}.analyse"), message)));
        }
    }
    if study.measure.is_empty() {
        log::warn!(
            "{}",
            study.about("vary", "nothing is measured: the table will have no numbers of the runs; add [measure.NAME] with a column")
        );
    }
    Ok(())
}

/// Becomes true when somebody wants to stop; whoever insists need not wait for the checkpoints.
fn interrupted() -> Result<Arc<AtomicBool>, RunError> {
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP, SIGUSR1] {
        flag::register_conditional_shutdown(signal, 128 + signal, interrupted.clone())
            .and_then(|_| flag::register(signal, interrupted.clone()))
            .map_err(|error| RunError::files(error.to_string()))?;
    }
    Ok(interrupted)
}

fn told(error: StudyError) -> RunError {
    match error {
        StudyError::Study(message) => RunError::case(message),
        StudyError::Files(message) => RunError::files(message),
        StudyError::Runs(message) => RunError::unphysical(message),
    }
}
