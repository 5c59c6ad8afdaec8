//! Where the messages of the libraries go: what they tell to standard output, warnings to standard error.

use log::{Level, LevelFilter, Log, Metadata, Record};

struct Terminal;

impl Log for Terminal {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Info && metadata.target().starts_with("grains")
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        match record.level() {
            Level::Error | Level::Warn => eprintln!("warning: {}", record.args()),
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
