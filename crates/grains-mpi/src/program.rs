//! `mpirun -n 2 grains-mpi case.toml`: a distributed discrete-element solver for granular flow.

/// Prints a line to standard output; a reader that has gone away, as `head` does, is no error.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

mod answers;
mod bar;
mod bench;
mod control;
mod explanation;
mod huge_pages;
mod import;
mod messages;
mod pages;
mod progress;
mod record;
mod slips;
mod slurm;
mod sweep;
mod templates;

use answers::Question;
use clap::{Parser, Subcommand};
use grains_analysis::{Analysis, analyse};
use grains_comm::{Job, MpiTransport};
use grains_domain::Transport;
use grains_simulation::{Case, ErrorKind, Options, RunError, Simulation, check, load, start};
use progress::Limits;
use record::{Beginning, Record};
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Version and git hash of the program, as every file it writes names them.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (git ", env!("GRAINS_GIT_HASH"), ")");

/// What the program is, in a line.
const ABOUT: &str = "Granular and particulate flow on many processors: mpirun -n 2 grains-mpi case.toml";

#[derive(Parser)]
#[command(version = VERSION, about = ABOUT, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<AnyCommand>,
    #[command(flatten)]
    run: Option<RunArguments>,
}

impl Cli {
    /// Whether it asks for steps, of which there may be many.
    fn is_long(&self) -> bool {
        let steps = matches!(self.command, Some(AnyCommand::Job(Command::Run(_) | Command::Bench { .. })));
        steps || self.run.is_some()
    }
}

#[derive(Subcommand)]
enum AnyCommand {
    #[command(flatten)]
    Job(Command),
    #[command(flatten)]
    Question(Question),
}

// What all ranks do together. Words for documentation would take the place of those of the program.
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
    /// Analyse the stored states of a run: tables and pictures.
    Analyse {
        /// What to find out.
        #[command(subcommand)]
        what: Box<Analysis>,
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
        #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
        steps: u64,
        /// Timed segments.
        #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..))]
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

/// Whether the words of a command line, the program's name first, are understood.
pub fn understands(words: impl IntoIterator<Item = OsString>) -> bool {
    understood(words).is_ok()
}

/// As [`understands`], with what is wrong.
fn understood(words: impl IntoIterator<Item = OsString>) -> Result<(), String> {
    Cli::try_parse_from(words).map(drop).map_err(|error| error.to_string())
}

/// The program, which ends the process.
pub fn main() {
    // Ask for nothing from MPI before the command line is known to be right.
    let cli = Cli::try_parse().unwrap_or_else(|answer| {
        if !is_first_launched() {
            std::process::exit(0);
        }
        let _ = answer.print();
        if answer.use_stderr() {
            let words: Vec<String> = std::env::args().skip(1).collect();
            slips::remedy(&words).iter().for_each(|remedy| eprintln!("\n  tip: {remedy}"));
        }
        std::process::exit(answer.exit_code());
    });
    if cli.is_long() {
        huge_pages::ask();
    }
    messages::install();
    let command = match cli.command {
        Some(AnyCommand::Question(question)) => answer(&question),
        Some(AnyCommand::Job(command)) => Some(command),
        None => cli.run.map(Command::Run),
    };
    let job = match start() {
        Ok(job) => job,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::exit(exit_code(error.kind));
        }
    };
    let mut record = None;
    let outcome = match command {
        Some(command) => execute(command, &job, &mut record),
        None => Err(RunError::case("no case file given; try `grains-mpi --help`")),
    };
    let code = report(job.transport(), outcome, record);
    if code == exit_code(ErrorKind::Files) {
        // HDF5 would try again to write what it could not, and might wait for ever.
        grains_comm::abort(code);
    }
    let is_first = job.transport().rank() == 0;
    drop(job);
    // mpirun kills the job at the first exit code that is not 0, and may lose what other ranks said.
    std::process::exit(if is_first { code } else { 0 });
}

/// Answers a question on one rank, without MPI, and ends the program.
fn answer(question: &Question) -> ! {
    let outcome = if is_first_launched() { question.answer() } else { Ok(()) };
    let code = outcome.map_or_else(
        |error| {
            eprintln!("error: {error}");
            exit_code(error.kind)
        },
        |()| 0,
    );
    std::process::exit(code)
}

/// Exit code of an error; a panic, which is a bug, has 101.
fn exit_code(kind: ErrorKind) -> i32 {
    match kind {
        ErrorKind::Case => 2,
        ErrorKind::Unphysical => 3,
        ErrorKind::Files => 4,
    }
}

/// Whether no launcher has given this process another rank than 0; what all ranks say is said once.
fn is_first_launched() -> bool {
    ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"]
        .iter()
        .find_map(|name| std::env::var(name).ok())
        .is_none_or(|rank| rank == "0")
}

/// Does what a command says; a run leaves its record on rank 0.
fn execute(command: Command, job: &Job, record: &mut Option<Record>) -> Result<(), RunError> {
    let is_first = job.transport().rank() == 0;
    let program = format!("grains-mpi {VERSION}");
    match command {
        Command::Check { case, ranks } => {
            let case = load(&case, job)?;
            let asked = ranks.map(|n| n as usize);
            let report = check::report_by(&case, asked.unwrap_or(job.size()), job)?;
            if is_first {
                warn_of_ranks(&case, asked);
                report.warnings.iter().for_each(|w| log::warn!("{w}"));
                explanation::tell(&case, &report);
            }
            Ok(())
        }
        Command::Analyse { what } => {
            let findings = analyse(&what, &program, job)?;
            if is_first {
                progress::tell(&findings);
            }
            Ok(())
        }
        Command::Bench { case, restart, warm, steps, segments } => {
            let case = load(&case, job)?;
            let options = Options { restart, program, writes_files: false, ..Options::default() };
            bench::time(Simulation::new(&case, job, options)?, [warm, steps, segments])
        }
        Command::Run(RunArguments { case: file, restart, max_walltime, petsc }) => {
            let case = load(&file, job)?;
            if is_first && !petsc.is_empty() && case.fluid.is_none() {
                log::warn!(
                    "{}: without effect: PETSc solves for the fluid, and the case has none; leave out what follows --",
                    petsc.join(" ")
                );
            }
            let interrupted = Arc::new(AtomicBool::new(false));
            for signal in
                [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGUSR1]
            {
                signal_hook::flag::register(signal, interrupted.clone())
                    .map_err(|e| RunError::files(e.to_string()))?;
            }
            let options =
                Options { restart: restart.clone(), program: program.clone(), petsc, writes_files: true };
            let simulation = Simulation::new(&case, job, options)?;
            // The meshes in it are part of walls and shapes now.
            drop(case);
            let beginning = Beginning { file: &file, program: &program, restart: restart.as_deref() };
            let limits = Limits { interrupted, walltime: max_walltime.unwrap_or(f64::INFINITY) };
            progress::run(simulation, &beginning, &limits, record)
        }
    }
}

/// Warns of a number of ranks that the case leaves without effect.
fn warn_of_ranks(case: &Case, asked: Option<usize>) {
    let Some((asked, ranks)) = asked.zip(case.domain.ranks) else { return };
    let product: usize = ranks.iter().map(|&n| n as usize).product();
    if product != asked {
        let message = format!(
            "makes {product} subdomains, so that --ranks {asked} is without effect and a run on {asked} ranks is refused; change or remove the key"
        );
        log::warn!("{}", case.about("domain.ranks", message));
    }
}

/// Prints the error of the lowest rank that has one, completes the record of a run, and returns the exit code of all.
fn report(transport: &MpiTransport, outcome: Result<(), RunError>, record: Option<Record>) -> i32 {
    let (code, message) = match outcome {
        Ok(()) => (0, String::new()),
        Err(error) => (exit_code(error.kind), error.message),
    };
    let mut codes = [f64::from(code)];
    transport.max(&mut codes);
    if codes[0] == 0.0 {
        record.iter().filter(|record| record.is_shown()).for_each(pages::finish);
        return 0;
    }
    // Texts travel as numbers: this happens once, at the end.
    let first = transport.first_rank_with(!message.is_empty());
    let is_own = first == Some(transport.rank());
    let own: Vec<f64> = message.bytes().filter(|_| is_own).map(f64::from).collect();
    let received = transport.exchange_sparse(vec![(0, own)]);
    if transport.rank() == 0 {
        bar::clear();
        let text: Vec<u8> = received.iter().flat_map(|(_, text)| text).map(|&b| b as u8).collect();
        let text = String::from_utf8_lossy(&text);
        eprintln!("error: {text}");
        if let Some(mut record) = record {
            record.fail(&text);
            // What cannot be written cannot be read either.
            if record.is_shown() && codes[0] != f64::from(exit_code(ErrorKind::Files)) {
                pages::finish(&record);
            }
        }
    }
    // Nobody leaves before the message is out.
    transport.any(false);
    codes[0] as i32
}
