//! How a run is watched and stopped from another terminal: `status.json` beside its results, and a file that asks it to stop.

use grains_report::STATUS;
use grains_simulation::{RunError, Simulation, Status, duration, is_written_to};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Asks a run to write a checkpoint and leave.
const STOP: &str = ".stop";

/// How often a run looks whether it is asked to stop, and tells of itself.
const INTERVAL: Duration = Duration::from_secs(1);

/// The run's side, on rank 0.
pub struct Control {
    directory: PathBuf,
    looked: Instant,
    has_failed: bool,
}

impl Control {
    /// That of a run that begins; what an earlier one was asked is forgotten.
    pub fn new(simulation: &Simulation) -> Self {
        let directory = simulation.case().output.directory.clone();
        // There is none but after a run that was killed before it looked.
        let _ = fs::remove_file(directory.join(STOP));
        Self { directory, looked: Instant::now(), has_failed: false }
    }

    /// Whether it is time to look again.
    pub fn is_due(&mut self) -> bool {
        let is_due = self.looked.elapsed() >= INTERVAL;
        if is_due {
            self.looked = Instant::now();
        }
        is_due
    }

    /// Whether the run is asked to stop, which is asked once.
    pub fn is_stop_asked(&self) -> bool {
        fs::remove_file(self.directory.join(STOP)).is_ok()
    }

    /// Writes how far a run is, its state, and what stopped it; a file that cannot be written is warned of once.
    pub fn tell(&mut self, simulation: &Simulation, state: Status, stopped_by: Option<&str>) {
        let (time, end, seconds) = (simulation.time(), simulation.case().time.end, simulation.seconds());
        let speed = (time - simulation.begin()) / seconds;
        let state = match state {
            Status::Running => "running",
            Status::Stopped => "stopped",
            Status::Finished => "finished",
        };
        // JSON has no infinity: what is not known is null.
        let status = json!({
            "state": state,
            "stopped_by": stopped_by,
            "step": simulation.steps(),
            "time_s": time,
            "end_s": end,
            "particles": simulation.progress().map(|progress| progress.totals.particles),
            "steps_per_second": simulation.steps_done() as f64 / seconds,
            "simulated_seconds_per_second": speed,
            "seconds_left": (end - time) / speed,
            "unix_time": now(),
        });
        let (path, part) = (self.directory.join(STATUS), self.directory.join(".status.json"));
        let written = fs::write(&part, format!("{status:#}\n")).and_then(|()| fs::rename(&part, &path));
        if let Err(error) = written
            && !self.has_failed
        {
            self.has_failed = true;
            log::warn!(
                "{}: cannot be written, so `grains-mpi status` knows nothing: {error}",
                path.display()
            );
        }
    }
}

/// What the run told last.
fn told(directory: &Path) -> Result<Value, RunError> {
    let path = directory.join(STATUS);
    let text = fs::read_to_string(&path).map_err(|error| {
        RunError::files(format!(
            "{}: {error}; give the directory of results of a run that has made its first step",
            path.display()
        ))
    })?;
    serde_json::from_str(&text).map_err(|error| RunError::files(format!("{}: {error}", path.display())))
}

/// Prints how far a run is, and whether it still goes on.
///
/// # Errors
/// A directory of no run.
pub fn status(directory: &Path) -> Result<(), RunError> {
    let status = told(directory)?;
    let number = |key: &str| status[key].as_f64().unwrap_or(f64::NAN);
    let by = status["stopped_by"].as_str().unwrap_or("unknown");
    let (state, left) = match (status["state"].as_str().unwrap_or("unknown"), is_written_to(directory)) {
        ("running", false) => {
            ("ended without a word: killed, or ended by an error; see its log".into(), None)
        }
        ("running", true) => ("running".into(), status["seconds_left"].as_f64()),
        ("stopped", _) => (format!("stopped by {by}, to be continued with --restart latest"), None),
        (state, _) => (state.to_string(), None),
    };
    let particles =
        status["particles"].as_u64().map_or(String::new(), |count| format!(", {count} particles"));
    say!(
        "{}: {state}\nt = {:.6} of {} s{particles}, {:.3e} s per second{}; told {} ago",
        directory.display(),
        number("time_s"),
        number("end_s"),
        number("simulated_seconds_per_second"),
        left.map_or(String::new(), |left| format!(", left {}", duration(left))),
        duration((now() - number("unix_time")).max(0.0))
    );
    Ok(())
}

/// Seconds since 1970.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

/// Asks a run to write a checkpoint and leave, and says so.
///
/// # Errors
/// As for [`ask_to_stop`].
pub fn stop(directory: &Path) -> Result<(), RunError> {
    ask_to_stop(directory)?;
    let shown = directory.display();
    say!("{shown}: asked to write a checkpoint and leave; `grains-mpi status {shown}` says when it has");
    Ok(())
}

/// Asks a run to write a checkpoint and leave.
///
/// # Errors
/// A directory to which no run writes, or that cannot be written to.
pub fn ask_to_stop(directory: &Path) -> Result<(), RunError> {
    let shown = directory.display();
    if !is_written_to(directory) {
        return Err(RunError::files(format!("no run writes to {shown}: there is nothing to stop")));
    }
    fs::write(directory.join(STOP), "").map_err(|error| RunError::files(format!("{shown}: {error}")))
}
