//! Errors of files, agreed upon by all ranks.

use mpi::collective::SystemOperation;
use mpi::traits::CommunicatorCollectives;
use std::path::Path;
use thiserror::Error;

/// A file that cannot be written or read.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FileError {
    /// This rank met the error.
    #[error("{path}: {problem}")]
    Here {
        /// The file.
        path: String,
        /// What went wrong and what to do.
        problem: String,
    },
    /// Another rank met it and reports it.
    #[error("another rank met an error of a file")]
    Elsewhere,
}

impl FileError {
    /// Error of a file met on this rank.
    pub fn new(path: &Path, problem: impl ToString) -> Self {
        Self::Here { path: path.display().to_string(), problem: problem.to_string() }
    }
}

/// Makes the outcome of all ranks an error if that of any is.
///
/// # Errors
/// The own error, or [`FileError::Elsewhere`].
pub fn agree<T>(
    communicator: &impl CommunicatorCollectives,
    outcome: Result<T, FileError>,
) -> Result<T, FileError> {
    let mut failed = 0_u8;
    communicator.all_reduce_into(&u8::from(outcome.is_err()), &mut failed, SystemOperation::max());
    match outcome {
        Ok(_) if failed > 0 => Err(FileError::Elsewhere),
        outcome => outcome,
    }
}
