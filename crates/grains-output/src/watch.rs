//! Ends a job whose ranks wait in HDF5 for a rank that could not write.

use crate::error::{FAILED, FileError, Shared, unwritable_now};
use mpi::topology::SimpleCommunicator;
use mpi::traits::Communicator;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Variable of the environment: seconds without a write after which a file that is written is given up.
const TIMEOUT: &str = "GRAINS_WRITE_TIMEOUT";

/// Its value if it is not set (s).
const SECONDS: f64 = 300.0;

/// Watches a file while ranks write to it together.
///
/// Where one of them fails, HDF5 1.10 may let all wait for each other. A thread looks at the time of the last write; if that
/// is long ago, it tells so and ends the job. It ends when the watch is dropped.
pub(crate) struct Watch {
    _end: Sender<()>,
}

impl Watch {
    /// Begins to watch.
    pub fn over(shared: &Shared) -> Self {
        let (sender, end) = channel();
        let seconds = std::env::var(TIMEOUT).ok().and_then(|text| text.parse().ok());
        let seconds = seconds.filter(|s: &f64| *s > 0.0 && *s < 1e9).unwrap_or(SECONDS);
        // One rank tells of it.
        let timeout = Duration::from_secs_f64(if shared.is_first() { seconds } else { seconds + 10.0 });
        let path = shared.path.clone();
        std::thread::spawn(move || watch(&path, timeout, &end));
        Self { _end: sender }
    }
}

fn watch(path: &Path, timeout: Duration, end: &Receiver<()>) {
    let begun = Instant::now();
    while end.recv_timeout(Duration::from_secs(1).min(timeout)) == Err(RecvTimeoutError::Timeout) {
        if begun.elapsed() > timeout && is_idle(path, timeout) {
            let reason = unwritable_now(path).unwrap_or_else(|| {
                "a write may have failed on another rank; look for a full disk, a quota or a failing device".into()
            });
            let problem = format!(
                "has not been written to for {} s ({TIMEOUT}): {reason}; then --restart latest",
                timeout.as_secs_f64()
            );
            eprintln!("error: {}", FileError::new(path, problem));
            SimpleCommunicator::world().abort(FAILED);
        }
    }
}

/// Whether the last write is longer ago than this.
fn is_idle(path: &Path, timeout: Duration) -> bool {
    let written = std::fs::metadata(path).and_then(|metadata| metadata.modified());
    written.map_or(true, |time| time.elapsed().is_ok_and(|since| since > timeout))
}
