//! Why a study cannot go on.

use grains_case::CaseErrors;
use std::fmt::Display;
use std::path::Path;

/// Why a study cannot go on, in a message that names the file or key, the value and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// The study or one of its cases is wrong.
    #[error("{0}")]
    Study(String),
    /// A file cannot be read or written, or a program not be started.
    #[error("{0}")]
    Files(String),
    /// Runs failed.
    #[error("{0}")]
    Runs(String),
}

impl From<CaseErrors> for StudyError {
    fn from(errors: CaseErrors) -> Self {
        Self::Study(errors.to_string())
    }
}

impl StudyError {
    /// What is wrong with a file, in the manner of the system.
    pub(crate) fn of_file(path: &Path, error: impl Display) -> Self {
        Self::Files(format!("{}: {error}", path.display()))
    }
}
