//! Errors of the program and how the ranks agree on them.

use grains_comm::exit;
use grains_domain::Transport;
use grains_output::FileError;
use std::path::Path;

/// An error that ends all ranks with one message.
#[derive(Clone, Debug)]
pub struct RunError {
    /// Exit code.
    pub code: i32,
    /// Message; empty on ranks that did not meet the error.
    pub message: String,
}

impl RunError {
    /// Error in the case or command line.
    pub fn case(message: impl Into<String>) -> Self {
        Self { code: exit::CASE, message: message.into() }
    }

    /// Error of a file.
    pub fn files(message: impl Into<String>) -> Self {
        Self { code: exit::FILES, message: message.into() }
    }

    /// The same error, naming the file it is about; ranks that have no text get none.
    pub fn of(self, path: &Path) -> Self {
        if self.message.is_empty() {
            return self;
        }
        Self { message: format!("{}: {}", path.display(), self.message), ..self }
    }
}

impl From<FileError> for RunError {
    fn from(error: FileError) -> Self {
        let message = match &error {
            FileError::Elsewhere => String::new(),
            FileError::Here { .. } => error.to_string(),
        };
        RunError { code: exit::FILES, message }
    }
}

/// The outcome for all ranks: an error on one is an error on all, and those that met it have its text.
///
/// # Errors
/// The rank's own error, or one without text.
pub fn agreed<T>(transport: &impl Transport, outcome: Result<T, RunError>) -> Result<T, RunError> {
    match (transport.any(outcome.is_err()), outcome) {
        (true, Ok(_)) => Err(RunError::case("")),
        (_, outcome) => outcome,
    }
}
