//! How a run is watched and stopped from another terminal: `status.json` beside its results, and a file that asks it to stop.

use grains_simulation::{Progress, RunError, duration, is_written_to};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// What a run tells of itself.
const STATUS: &str = "status.json";

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
    /// That of a run that writes to a directory; what an earlier run was asked is forgotten.
    pub fn new(directory: &Path) -> Self {
        let _ = fs::remove_file(directory.join(STOP));
        Self { directory: directory.to_path_buf(), looked: Instant::now(), has_failed: false }
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

    /// Tells the state of a run in a word and how far it is on its way to its end (s), at so many steps per second; a file that cannot
    /// be written is warned of once.
    pub fn tell(&mut self, state: &str, progress: &Progress, (end, rate): (f64, f64)) {
        let left = (progress.end.saturating_sub(progress.step)) as f64 / rate;
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64());
        let status = json!({
            "state": state,
            "step": progress.step,
            "time_s": progress.time,
            "end_s": end,
            "particles": progress.totals.particles,
            "steps_per_second": rate,
            "seconds_left": left,
            "unix_time": now,
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
    let state = match (status["state"].as_str().unwrap_or("unknown"), is_written_to(directory)) {
        ("running", false) => "ended without a word: killed, or ended by an error; see its log",
        (state, _) => state,
    };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64());
    let left = if state == "running" {
        format!(", left {}", duration(number("seconds_left")))
    } else {
        String::new()
    };
    say!(
        "{}: {state}\nstep {:.0}, t = {:.6} of {} s, {:.0} particles, {:.1} steps/s{left}; told {} ago",
        directory.display(),
        number("step"),
        number("time_s"),
        number("end_s"),
        number("particles"),
        number("steps_per_second"),
        duration((now - number("unix_time")).max(0.0))
    );
    Ok(())
}

/// Asks a run to write a checkpoint and leave.
///
/// # Errors
/// A directory to which no run writes, or that cannot be written to.
pub fn stop(directory: &Path) -> Result<(), RunError> {
    let shown = directory.display();
    if !is_written_to(directory) {
        return Err(RunError::files(format!("no run writes to {shown}: there is nothing to stop")));
    }
    fs::write(directory.join(STOP), "").map_err(|error| RunError::files(format!("{shown}: {error}")))?;
    say!("{shown}: asked to write a checkpoint and leave; `grains-mpi status {shown}` says when it has");
    Ok(())
}
