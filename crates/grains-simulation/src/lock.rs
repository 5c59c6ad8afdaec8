//! One run at a time writes to a directory.

use grains_output::FileError;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// The file that the process of rank 0 keeps locked while its run goes on.
///
/// The operating system gives the lock back when the process ends, however it ends: what a crash leaves behind is a file, not a
/// lock.
const LOCK: &str = ".lock";

/// A directory that this process alone writes to, as long as this lives.
#[derive(Debug)]
pub struct DirectoryLock {
    file: File,
    directory: PathBuf,
}

impl DirectoryLock {
    /// Takes a directory that exists.
    ///
    /// # Errors
    /// One that another run writes to, or that cannot be written to.
    pub fn take(directory: &Path) -> Result<Self, FileError> {
        let path = directory.join(LOCK);
        let refuse = |error: std::io::Error| {
            FileError::new(&path, format!("cannot be written: {error}; choose another output.directory"))
        };
        let mut options = OpenOptions::new();
        let mut file =
            options.read(true).write(true).create(true).truncate(false).open(&path).map_err(refuse)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut owner = String::new();
                let _ = file.read_to_string(&mut owner);
                let owner = if owner.is_empty() { String::new() } else { format!(" ({})", owner.trim()) };
                return Err(FileError::new(
                    directory,
                    format!(
                        "another run{owner} writes to it: wait until it has ended, or choose another output.directory"
                    ),
                ));
            }
            Err(TryLockError::Error(error)) => {
                // Some network file systems know no locks; the run need not fail for it.
                log::warn!(
                    "{}: cannot be locked ({error}): take care that no other run writes to it",
                    directory.display()
                );
            }
        }
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let owner = format!("process {} on {}\n", std::process::id(), host.trim());
        file.set_len(0)
            .and_then(|()| file.rewind())
            .and_then(|()| file.write_all(owner.as_bytes()))
            .map_err(refuse)?;
        let lock = Self { file, directory: directory.to_path_buf() };
        // Another run may have moved the directory aside since its file was opened.
        lock.verify()?;
        Ok(lock)
    }

    /// Checks that the directory is still where it was when it was taken.
    ///
    /// # Errors
    /// One that has been renamed, removed or replaced.
    pub fn verify(&self) -> Result<(), FileError> {
        let identity = |m: &std::fs::Metadata| (m.dev(), m.ino());
        let ours = self.file.metadata().ok().map(|m| identity(&m));
        let there = std::fs::metadata(self.directory.join(LOCK)).ok().map(|m| identity(&m));
        if ours.is_some() && ours == there {
            return Ok(());
        }
        Err(FileError::new(
            &self.directory,
            "has been renamed, removed or replaced since this run began to write to it: put it back, and continue from its last checkpoint with --restart",
        ))
    }
}

/// Whether a run writes to a directory of results at present; true of one with a file system that knows no locks.
pub fn is_written_to(directory: &Path) -> bool {
    File::open(directory.join(LOCK)).is_ok_and(|file| file.try_lock_shared().is_err())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directory(name: &str) -> PathBuf {
        let directory = std::env::temp_dir().join(format!("grains-lock-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&directory);
        std::fs::create_dir_all(&directory).unwrap();
        directory
    }

    #[test]
    fn a_second_run_is_refused_until_the_first_has_ended() {
        let directory = directory("second");
        let first = DirectoryLock::take(&directory).unwrap();
        let refused = DirectoryLock::take(&directory).unwrap_err().to_string();
        assert!(
            refused.contains("another run (process ") && refused.contains("output.directory"),
            "{refused}"
        );
        assert!(is_written_to(&directory));
        drop(first);
        assert!(!is_written_to(&directory) && !is_written_to(&directory.join("none")));
        // The file is still there, as after a crash; the lock is not.
        assert!(directory.join(LOCK).exists());
        DirectoryLock::take(&directory).unwrap();
        std::fs::remove_dir_all(directory).unwrap();
    }

    #[test]
    fn a_directory_that_was_moved_or_replaced_is_noticed() {
        let (directory, aside) = (directory("moved"), directory("aside").join("moved"));
        let lock = DirectoryLock::take(&directory).unwrap();
        lock.verify().unwrap();
        std::fs::rename(&directory, &aside).unwrap();
        assert!(lock.verify().is_err());
        std::fs::create_dir_all(&directory).unwrap();
        let other = DirectoryLock::take(&directory).unwrap();
        assert!(lock.verify().is_err() && other.verify().is_ok());
        std::fs::remove_dir_all(&directory).unwrap();
        std::fs::remove_dir_all(aside.parent().unwrap()).unwrap();
    }
}
