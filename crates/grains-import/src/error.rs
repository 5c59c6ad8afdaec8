//! What ends an import.

use std::io::{Error, ErrorKind};
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
        move |source| {
            let kind = source.kind();
            let is_packed = path.extension().is_some_and(|e| e == "gz");
            let source = match kind {
                ErrorKind::InvalidData if !is_packed => Error::new(
                    kind,
                    "it holds bytes that are no text in UTF-8; save it in UTF-8 (iconv -f latin1 -t utf-8)",
                ),
                ErrorKind::InvalidInput | ErrorKind::InvalidData | ErrorKind::UnexpectedEof if is_packed => {
                    Error::new(
                        kind,
                        format!(
                            "{source}; it is not packed by gzip, or cut off: unpack it, or drop .gz from its name"
                        ),
                    )
                }
                ErrorKind::NotFound => Error::new(
                    kind,
                    format!(
                        "{source}; paths are relative to where the program is started, and those of a script to its folder"
                    ),
                ),
                ErrorKind::IsADirectory => Error::new(kind, "it is a folder; name a file in it"),
                _ => source,
            };
            Self::Read { path, source }
        }
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
