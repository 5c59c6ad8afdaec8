//! Where the messages of the libraries go: what they tell to standard output, warnings to standard error.

use crate::bar;
use log::{Level, LevelFilter, Log, Metadata, Record};
use std::sync::{Mutex, PoisonError};

struct Terminal;

/// Warnings so far, for the record of a run.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Warnings that are kept: a run that warns at every step fills no memory.
const KEPT: usize = 100;

impl Log for Terminal {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Info && metadata.target().starts_with("grains")
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        bar::clear();
        match record.level() {
            Level::Error | Level::Warn => {
                keep(record.args().to_string());
                eprintln!("warning: {}", record.args());
            }
            _ => say!("{}", record.args()),
        }
    }

    fn flush(&self) {}
}

/// Sends all messages to the terminal from now on.
pub fn install() {
    // The first one stays; there is no other.
    let _ = log::set_logger(&Terminal);
    log::set_max_level(LevelFilter::Info);
}

/// Keeps a warning for the record.
pub fn keep(warning: String) {
    let mut warnings = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
    if warnings.len() < KEPT && !warnings.contains(&warning) {
        warnings.push(warning);
    }
}

/// The warnings so far.
pub fn warnings() -> Vec<String> {
    WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).clone()
}
