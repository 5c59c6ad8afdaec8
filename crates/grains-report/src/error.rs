//! Why a report cannot be made.

use std::path::Path;
use thiserror::Error;

/// A report that cannot be made: the file, what is wrong and the remedy.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{path}: {problem}")]
pub struct ReportError {
    path: String,
    problem: String,
}

impl ReportError {
    /// Error of a file or directory.
    pub fn new(path: &Path, problem: impl ToString) -> Self {
        Self { path: path.display().to_string(), problem: problem.to_string() }
    }
}
