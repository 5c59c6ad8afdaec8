//! Commands that concern no run: one rank answers.

use crate::import::{ImportArguments, import};
use crate::slurm::{self, JobSize};
use crate::sweep::{SweepArguments, sweep};
use crate::{Cli, control, pages, templates};
use clap::builder::PossibleValuesParser;
use clap::{CommandFactory, Subcommand};
use grains_simulation::RunError;
use std::path::PathBuf;

#[derive(Subcommand)]
pub enum Question {
    /// List the examples that `new` writes.
    Examples,
    /// Write a commented case to begin with.
    New {
        /// Which one; `grains-mpi examples` says what they are.
        #[arg(value_parser = PossibleValuesParser::new(templates::names()))]
        example: String,
        /// Where to write it; EXAMPLE.toml by default.
        #[arg(value_name = "FILE")]
        to: Option<PathBuf>,
    },
    /// Say how far a run is that was started elsewhere.
    Status {
        /// Its directory of results.
        run: PathBuf,
    },
    /// Ask a run to write a checkpoint and leave.
    Stop {
        /// Its directory of results.
        run: PathBuf,
    },
    /// Write `report.html` into a directory of results: a page about the run.
    Report {
        /// The directory of results.
        run: PathBuf,
    },
    /// Show the page of a run while it goes on, to browsers of this machine.
    Watch {
        /// Its directory of results.
        run: PathBuf,
        /// Port of the loopback interface; 0 takes a free one.
        #[arg(long, default_value_t = 0)]
        port: u16,
    },
    /// Write a SLURM script that runs a case, job by job, until it has ended.
    Slurm {
        /// Case file (TOML).
        case: PathBuf,
        /// Where to write it; the case's name with `.sbatch` by default.
        #[arg(value_name = "FILE")]
        to: Option<PathBuf>,
        #[command(flatten)]
        size: JobSize,
    },
    /// Run a study: a case with lists or ranges of values, gathered in a table and a picture, or fitted to measured numbers.
    Sweep(SweepArguments),
    /// Bring a case, particles and meshes over from LAMMPS or LIGGGHTS.
    Import(ImportArguments),
    /// Print the JSON schema of case files.
    Schema,
    /// Run every contact law against its closed forms and print found and exact values.
    Verify {
        /// Only rows whose law contains this, such as `jkr`.
        law: Option<String>,
    },
    /// Print the completion of a shell: `source <(grains-mpi completions bash)`.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page: `grains-mpi man | man -l -`.
    Man,
}

impl Question {
    /// Answers on standard output.
    ///
    /// # Errors
    /// Files that cannot be written, a law that is none, and one that is wrong.
    pub fn answer(&self) -> Result<(), RunError> {
        let mut text = Vec::new();
        match self {
            Self::Examples => templates::list(),
            Self::New { example, to } => templates::write(example, to.clone())?,
            Self::Status { run } => control::status(run)?,
            Self::Stop { run } => control::stop(run)?,
            Self::Report { run } => pages::report(run)?,
            Self::Watch { run, port } => pages::watch(run, *port)?,
            Self::Slurm { case, to, size } => slurm::write(case, to.clone(), size)?,
            Self::Sweep(arguments) => sweep(arguments)?,
            Self::Import(arguments) => import(arguments)?,
            Self::Schema => say!("{:#}", grains_case::schema()),
            Self::Verify { law } => verify(law.as_deref().unwrap_or_default())?,
            Self::Completions { shell } => {
                clap_complete::generate(*shell, &mut Cli::command(), "grains-mpi", &mut text);
            }
            Self::Man => clap_mangen::Man::new(Cli::command())
                .render(&mut text)
                .map_err(|e| RunError::files(e.to_string()))?,
        }
        if !text.is_empty() {
            say!("{}", String::from_utf8_lossy(&text).trim_end());
        }
        Ok(())
    }
}

/// Prints the rows of laws whose name contains `law` against their closed forms.
fn verify(law: &str) -> Result<(), RunError> {
    let rows = grains_verification::all().into_iter().filter(|row| row.law.contains(law)).collect::<Vec<_>>();
    if rows.is_empty() {
        return Err(RunError::case(format!("no law is called `{law}`; `grains-mpi verify` lists them all")));
    }
    say!("{}", grains_verification::heading());
    rows.iter().for_each(|row| say!("{row}"));
    match rows.iter().filter(|row| !row.is_right()).count() {
        0 => Ok(()),
        wrong => {
            Err(RunError::unphysical(format!("{wrong} of {} rows are farther off than allowed", rows.len())))
        }
    }
}
