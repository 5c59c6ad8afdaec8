//! What ends a simulation, and how the ranks agree on it.

use grains_domain::Transport;
use grains_output::FileError;
use std::path::Path;

/// What an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The case, the command line or an input file is wrong.
    Case,
    /// The state can no longer be trusted: a lost particle, an overlap beyond its limit, a number that is none.
    Unphysical,
    /// A file cannot be written or read.
    Files,
}

/// An error that ends all ranks with one message.
#[derive(Clone, Debug)]
pub struct RunError {
    /// What it is about.
    pub kind: ErrorKind,
    /// Message; empty on ranks that did not meet the error.
    pub message: String,
}

impl std::fmt::Display for RunError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for RunError {}

impl RunError {
    /// Error in the case or command line.
    pub fn case(message: impl Into<String>) -> Self {
        Self { kind: ErrorKind::Case, message: message.into() }
    }

    /// Error of the state.
    pub fn unphysical(message: impl Into<String>) -> Self {
        Self { kind: ErrorKind::Unphysical, message: message.into() }
    }

    /// Error of a file.
    pub fn files(message: impl Into<String>) -> Self {
        Self { kind: ErrorKind::Files, message: message.into() }
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
        match &error {
            FileError::Elsewhere => Self::files(""),
            FileError::Here { .. } => Self::files(error.to_string()),
        }
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
