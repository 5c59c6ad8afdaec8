//! Messages of the libraries go to Python's `logging`, to the logger `grains`.

use log::{Level, LevelFilter, Log, Metadata, Record};
use pyo3::prelude::*;

struct Logger;

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Info && metadata.target().starts_with("grains")
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let method = if record.level() <= Level::Warn { "warning" } else { "info" };
        let text = record.args().to_string();
        Python::attach(|py| {
            let told = || -> PyResult<()> {
                let logger = py.import("logging")?.call_method1("getLogger", ("grains",))?;
                // A text may hold per cent signs.
                logger.call_method1(method, ("%s", text.as_str()))?;
                Ok(())
            };
            if told().is_err() {
                eprintln!("{text}");
            }
        });
    }

    fn flush(&self) {}
}

/// Sends all messages to `logging` from now on.
pub fn install() {
    // The first one stays; there is no other.
    let _ = log::set_logger(&Logger);
    log::set_max_level(LevelFilter::Info);
}
