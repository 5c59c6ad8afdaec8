//! `report.html`: written at the end of a run, made for old runs, and served while a run goes on.

use crate::control;
use crate::record::Record;
use grains_report::Stop;
use grains_simulation::{RunError, is_written_to};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Writes the page of a run that has ended, and says where; a page that cannot be written is warned of.
pub fn finish(record: &Record) {
    match grains_report::write(record.directory()) {
        Ok(path) => say!("report in {}", path.display()),
        Err(error) => eprintln!("warning: no report: {error}"),
    }
}

/// Makes the page of a directory of results.
///
/// # Errors
/// A directory of no run, or one that cannot be written to.
pub fn report(run: &Path) -> Result<(), RunError> {
    without_file_locks()?;
    let path = grains_report::write(run).map_err(|error| RunError::files(error.to_string()))?;
    say!("report in {}", path.display());
    Ok(())
}

/// Serves the page of a run while it goes on, until this program is ended.
///
/// # Errors
/// A directory of no run, or a port that is taken.
pub fn watch(run: &Path, port: u16) -> Result<(), RunError> {
    without_file_locks()?;
    let watched = Watched(run.to_path_buf());
    grains_report::watch(run, port, &watched, |address| {
        say!(
            "{}: open {address} in a browser of this machine; Ctrl-C ends the page, not the run",
            run.display()
        );
    })
    .map_err(|error| RunError::files(error.to_string()))
}

/// A directory that a run may write to.
struct Watched(PathBuf);

impl Stop for Watched {
    fn stop(&self) -> Result<(), String> {
        control::ask_to_stop(&self.0).map_err(|error| error.message)
    }

    fn is_running(&self) -> bool {
        is_written_to(&self.0)
    }
}

/// Begins this program anew so that HDF5 locks no file: a run that continues a file would find it taken by a reader.
///
/// HDF5 reads the variable once, when it starts.
fn without_file_locks() -> Result<(), RunError> {
    const LOCKING: &str = "HDF5_USE_FILE_LOCKING";
    if std::env::var_os(LOCKING).is_some_and(|value| value == "FALSE") {
        return Ok(());
    }
    let program = std::env::current_exe().map_err(|error| RunError::files(error.to_string()))?;
    // It comes back only if it fails.
    let error = Command::new(program).args(std::env::args_os().skip(1)).env(LOCKING, "FALSE").exec();
    Err(RunError::files(format!("this program cannot be started anew: {error}")))
}
