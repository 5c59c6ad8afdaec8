//! What ends an import.

use std::path::{Path, PathBuf};

/// Why nothing can be imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{file}:{line}: {message}")]
    Content {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong and what to do about it.
        message: String,
    },
    /// What was read makes no case.
    #[error("{0}")]
    Case(String),
}

impl ImportError {
    /// An error of a line (from 1) of a file.
    pub fn at(file: &Path, line: usize, message: impl Into<String>) -> Self {
        Self::Content { file: file.display().to_string(), line, message: message.into() }
    }

    /// An error of reading a file.
    pub fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Read { path, source }
    }

    /// An error of writing a file.
    pub fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Write { path, source }
    }

    /// Whether a file cannot be read or written, and not what it says is wrong.
    pub fn is_of_files(&self) -> bool {
        matches!(self, Self::Read { .. } | Self::Write { .. })
    }
}
