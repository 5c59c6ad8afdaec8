//! Starts the program as a process of its own, waits for it, and passes on the wish to stop.

use crate::error::StudyError;
use crate::folder::Folder;
use std::fs::OpenOptions;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often a process is looked after.
const INTERVAL: Duration = Duration::from_millis(20);

/// How the program is started.
#[derive(Clone, Debug)]
pub struct Launch {
    /// The program.
    pub program: PathBuf,
    /// Its version, as its files name it.
    pub version: String,
    /// Words before the program that start its ranks, such as `srun`; `mpirun -n RANKS` if empty and there are several.
    pub launcher: Vec<String>,
    /// Ranks of each run (-).
    pub ranks: usize,
    /// Time (s) after which a run writes a checkpoint and leaves.
    pub walltime: Option<f64>,
    /// Whether somebody wants to stop.
    pub interrupted: Arc<AtomicBool>,
}

impl Launch {
    /// Whether somebody wants to stop.
    pub fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// Runs the case of a member to its end, or from its last checkpoint on.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub(crate) fn run(&self, folder: &Folder, goes_on: bool) -> Result<ExitStatus, StudyError> {
        let mut words = vec!["run".into(), "case.toml".into()];
        if goes_on {
            words.extend(["--restart".into(), "latest".into()]);
        }
        if let Some(seconds) = self.walltime {
            words.extend(["--max-walltime".into(), seconds.to_string()]);
        }
        self.wait(self.command(words), folder, "log")
    }

    /// The program with some words, on its ranks.
    fn command(&self, words: Vec<String>) -> Command {
        let mut line = self.launcher.clone();
        if line.is_empty() && self.ranks > 1 {
            line = ["mpirun".into(), "-n".into(), self.ranks.to_string()].into();
        }
        let mut line = line.into_iter().chain([self.program.display().to_string()]).chain(words);
        let mut command = Command::new(line.next().unwrap_or_default());
        command.args(line);
        command
    }

    /// Analyses the run of a member: the words after `grains-mpi analyse`, and the folder of the tables.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub(crate) fn analyse(
        &self,
        folder: &Folder,
        words: &[&str],
        output: &str,
    ) -> Result<ExitStatus, StudyError> {
        let (what, options) = words.split_at(1.min(words.len()));
        let line = [&["analyse"], what, &[crate::member::RUN], options, &["--output", output]].concat();
        let command = self.command(line.into_iter().map(String::from).collect());
        self.wait(command, folder, &format!("{output}.log"))
    }

    /// Starts a command in the folder of a member and waits for its end; both its outputs go to a log.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub(crate) fn wait(
        &self,
        mut command: Command,
        folder: &Folder,
        log: &str,
    ) -> Result<ExitStatus, StudyError> {
        let path = folder.file(log);
        let open = || OpenOptions::new().create(true).append(true).open(&path);
        let outputs = open().and_then(|file| Ok([file.try_clone()?, file]));
        let [out, errors] =
            outputs.map_err(|error| StudyError::of_file(&path, format!("cannot be written: {error}")))?;
        // Open MPI would bind the ranks of all runs to the same cores.
        for (name, value) in [("OMPI_MCA_hwloc_base_binding_policy", "none"), ("OMP_NUM_THREADS", "1")] {
            if std::env::var_os(name).is_none() {
                command.env(name, value);
            }
        }
        // In a group of its own it does not see the Ctrl-C of this terminal, which would give mpirun one second.
        command.current_dir(folder.path()).process_group(0).stdin(Stdio::null()).stdout(out).stderr(errors);
        let name = command.get_program().to_string_lossy().into_owned();
        let mut child = command
            .spawn()
            .map_err(|error| StudyError::Files(format!("{name} cannot be started: {error}")))?;
        let mut is_told = false;
        loop {
            match child.try_wait() {
                Ok(Some(status)) => return Ok(status),
                Ok(None) => {}
                Err(error) => return Err(StudyError::Files(format!("{name}: {error}"))),
            }
            if self.is_interrupted() && !is_told {
                is_told = true;
                // SIGUSR1 gives the ranks the time they need for a checkpoint.
                let _ = Command::new("sh")
                    .args(["-c", &format!("kill -s USR1 {}", child.id())])
                    .stderr(Stdio::null())
                    .status();
            }
            std::thread::sleep(INTERVAL);
        }
    }

    /// Waits until no other run writes to the folder; returns whether there was one.
    pub(crate) fn wait_for_others(&self, folder: &Folder) -> bool {
        let begun = Instant::now();
        let mut waited = false;
        while folder.is_written_to() && !self.is_interrupted() {
            waited = true;
            let pause =
                if begun.elapsed() < Duration::from_secs(1) { INTERVAL } else { Duration::from_secs(1) };
            std::thread::sleep(pause);
        }
        waited
    }
}
