//! `mpirun -n 2 grains-mpi case.toml`: a distributed discrete-element solver for granular flow.

/// Prints a line to standard output; a reader that has gone away, as `head` does, is no error.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

mod analyse;
mod bench;
mod changes;
mod check;
mod composites;
mod cost;
mod duration;
mod error;
#[cfg(test)]
mod extreme_numbers;
mod files;
mod fluid;
mod geometry;
mod lock;
mod plausibility;
mod population;
mod random;
mod restart;
mod run;
mod system;
mod timestep;
mod wall_surfaces;

use clap::{Parser, Subcommand};
use error::{RunError, agreed};
use grains_case::Case;
use grains_comm::{Job, MpiTransport, exit};
use grains_domain::Transport;
use run::{Run, RunOptions};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Version and git hash of the program, as every file it writes names them.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (git ", env!("GRAINS_GIT_HASH"), ")");

#[derive(Parser)]
#[command(version = VERSION, about, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: Option<RunArguments>,
}

#[derive(Subcommand)]
enum Command {
    /// Run a case (the same as giving the case alone).
    Run(RunArguments),
    /// Explain a case: sizes, contacts, time step, memory, cost.
    Check {
        /// Case file (TOML).
        case: PathBuf,
        /// Number of ranks the run will have; that of this job by default.
        #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
        ranks: Option<u32>,
    },
    /// Print the JSON schema of case files.
    Schema,
    /// Analyse the stored states of a run: tables and pictures.
    Analyse {
        /// What to find out.
        #[command(subcommand)]
        what: Box<analyse::Analysis>,
    },
    /// Time the step of a case: segments without output.
    Bench {
        /// Case file (TOML).
        case: PathBuf,
        /// Begin from a checkpoint file, or from the last valid one with `latest`.
        #[arg(long, value_name = "FILE|latest")]
        restart: Option<PathBuf>,
        /// Steps before timing.
        #[arg(long, default_value_t = 300)]
        warm: u64,
        /// Steps per timed segment.
        #[arg(long, default_value_t = 1000)]
        steps: u64,
        /// Timed segments.
        #[arg(long, default_value_t = 3)]
        segments: u64,
    },
}

#[derive(clap::Args)]
struct RunArguments {
    /// Case file (TOML).
    case: PathBuf,
    /// Continue from a checkpoint file, or from the last valid one with `latest`.
    #[arg(long, value_name = "FILE|latest")]
    restart: Option<PathBuf>,
    /// Write a checkpoint and leave after this wall-clock time (s); without it there is no limit.
    #[arg(long, value_name = "SECONDS", value_parser = walltime)]
    max_walltime: Option<f64>,
    /// Options for PETSc, after `--`.
    #[arg(last = true, value_name = "PETSC OPTIONS")]
    petsc: Vec<String>,
}

/// A time that comes.
fn walltime(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds >= 0.0 => Ok(seconds),
        _ => Err("must be a number of seconds, 0 or more; leave it out for no limit".into()),
    }
}

fn main() {
    // Ask for nothing from MPI before the command line is known to be right.
    let cli = Cli::try_parse().unwrap_or_else(|answer| {
        if !is_first_launched() {
            std::process::exit(0);
        }
        let _ = answer.print();
        std::process::exit(answer.exit_code());
    });
    let job = match Job::start(grains_geometry::catches_panics) {
        Ok(job) => job,
        Err(message) => {
            eprintln!("grains-mpi: {message}");
            std::process::exit(exit::FILES);
        }
    };
    let transport = MpiTransport::new(job.world());
    let outcome = match cli.command.or(cli.run.map(Command::Run)) {
        Some(command) => execute(command, &job, &transport),
        None => Err(RunError::case("no case file given; try `grains-mpi --help`")),
    };
    let code = report(&transport, outcome);
    if code == exit::FILES {
        // HDF5 would try again to write what it could not, and might wait for ever.
        grains_comm::abort(code);
    }
    let is_first = transport.rank() == 0;
    drop(transport);
    drop(job);
    // mpirun kills the job at the first exit code that is not 0, and may lose what other ranks said.
    std::process::exit(if is_first { code } else { 0 });
}

/// Whether no launcher has given this process another rank than 0; what all ranks say is said once.
fn is_first_launched() -> bool {
    ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"]
        .iter()
        .find_map(|name| std::env::var(name).ok())
        .is_none_or(|rank| rank == "0")
}

fn execute(command: Command, job: &Job, transport: &MpiTransport) -> Result<(), RunError> {
    let is_first = transport.rank() == 0;
    match command {
        Command::Schema => {
            if is_first {
                say!("{:#}", grains_case::schema());
            }
            Ok(())
        }
        Command::Check { case, ranks } => {
            let case = load(&case, job, transport)?;
            if is_first {
                let ranks = ranks.map_or(transport.size(), |n| n as usize);
                let (text, warnings) = check::explain(&case, ranks).map_err(RunError::case)?;
                warnings.iter().for_each(|w| eprintln!("warning: {w}"));
                say!("{}", text.trim_end());
            }
            Ok(())
        }
        Command::Analyse { what } => analyse::run(&what, job, transport),
        Command::Bench { case, restart, warm, steps, segments } => {
            let case = load(&case, job, transport)?;
            bench::time(&case, job, transport, restart.as_deref(), [warm, steps, segments])
        }
        Command::Run(arguments) => {
            let case = load(&arguments.case, job, transport)?;
            let interrupted = Arc::new(AtomicBool::new(false));
            for signal in
                [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGUSR1]
            {
                signal_hook::flag::register(signal, interrupted.clone())
                    .map_err(|e| RunError::files(e.to_string()))?;
            }
            let options = RunOptions {
                restart: arguments.restart,
                max_walltime: arguments.max_walltime.unwrap_or(f64::INFINITY),
                interrupted,
                petsc: arguments.petsc,
            };
            Run::prepare(&case, job, transport, options)?.go()
        }
    }
}

/// The case on every rank: rank 0 reads the text, all ranks check it alike.
fn load(path: &Path, job: &Job, transport: &MpiTransport) -> Result<Case, RunError> {
    let text = (transport.rank() == 0).then(|| match std::fs::read_to_string(path) {
        Ok(text) if text.trim().is_empty() => Err(format!("{}: the case file is empty", path.display())),
        Ok(text) => Ok(text),
        // It says what is wrong, and which file may have been meant.
        Err(e) => Err(Case::load(path).err().map_or(e.to_string(), |errors| errors.to_string())),
    });
    let text = job.broadcast(text.unwrap_or(Ok(String::new()))).map_err(RunError::case)?;
    let base = path.parent().unwrap_or(Path::new(""));
    let case = Case::parse(&text, &path.display().to_string(), base);
    let case = agreed(transport, case.map_err(|e| RunError::case(e.to_string())))?;
    if transport.rank() == 0 {
        case.warnings.iter().for_each(|w| eprintln!("warning: {w}"));
    }
    Ok(case)
}

/// Prints the error of the lowest rank that has one, and returns the exit code of all.
fn report(transport: &MpiTransport, outcome: Result<(), RunError>) -> i32 {
    let (code, message) = match outcome {
        Ok(()) => (0, String::new()),
        Err(error) => (error.code, error.message),
    };
    let mut codes = [f64::from(code)];
    transport.max(&mut codes);
    if codes[0] == 0.0 {
        return 0;
    }
    // Texts travel as numbers: this happens once, at the end.
    let first = transport.first_rank_with(!message.is_empty());
    let is_own = first == Some(transport.rank());
    let own: Vec<f64> = message.bytes().filter(|_| is_own).map(f64::from).collect();
    let received = transport.exchange_sparse(vec![(0, own)]);
    if transport.rank() == 0 {
        let text: Vec<u8> = received.iter().flat_map(|(_, text)| text).map(|&b| b as u8).collect();
        eprintln!("error: {}", String::from_utf8_lossy(&text));
    }
    // Nobody leaves before the message is out.
    transport.any(false);
    codes[0] as i32
}
