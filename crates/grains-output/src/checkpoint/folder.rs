//! The checkpoints of a directory.

use super::CheckpointFile;
use crate::error::{FileError, from_rank};
use mpi::topology::SimpleCommunicator;
use mpi::traits::Communicator;
use std::path::{Path, PathBuf};

pub(super) fn file_name(step: u64) -> String {
    format!("checkpoint-{step:012}.h5")
}

/// Step of a file name, if it is that of a checkpoint.
fn step_of(name: &str) -> Option<u64> {
    name.strip_prefix("checkpoint-")?.strip_suffix(".h5")?.parse().ok()
}

/// Checkpoints of a directory, oldest first, with their steps.
pub fn checkpoints(directory: &Path) -> Vec<(u64, PathBuf)> {
    let entries = std::fs::read_dir(directory).into_iter().flatten();
    let mut found: Vec<(u64, PathBuf)> = entries
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            Some((step_of(path.file_name()?.to_str()?)?, path))
        })
        .collect();
    found.sort();
    found
}

/// Deletes all but the newest `keep` checkpoints, at least one; call it on one rank after a new one is
/// complete. Failures are not errors of the run.
pub fn remove_old(directory: &Path, keep: usize) {
    for (_, path) in checkpoints(directory).iter().rev().skip(keep.max(1)) {
        let _ = std::fs::remove_file(path);
    }
}

/// Takes checkpoints after a step out of the way, by the ending `.abandoned`: they are of a future that did not happen. Call it
/// on one rank.
pub fn abandon_later(directory: &Path, step: u64) {
    for (_, path) in checkpoints(directory).iter().filter(|(s, _)| *s > step) {
        let _ = std::fs::rename(path, path.with_extension("h5.abandoned"));
    }
}

/// The newest valid checkpoint of a directory, with what was wrong with newer ones (as texts on rank 0).
///
/// # Errors
/// No valid checkpoint at all.
pub fn latest_valid(
    directory: &Path,
    communicator: &SimpleCommunicator,
) -> Result<(CheckpointFile, Vec<FileError>), FileError> {
    // Rank 0 looks: on a network file system the ranks may see different files for a while.
    let is_first = communicator.rank() == 0;
    let found = if is_first { checkpoints(directory) } else { Vec::new() };
    let names: Vec<String> =
        found.iter().rev().filter_map(|(_, p)| Some(p.file_name()?.to_str()?.to_string())).collect();
    let names = from_rank(communicator, 0, &names.join("\n"));
    let mut refused = Vec::new();
    for name in names.lines() {
        match CheckpointFile::read(&directory.join(name), communicator) {
            Ok(file) => return Ok((file, refused)),
            Err(error) => refused.push(error),
        }
    }
    if !is_first {
        return Err(FileError::Elsewhere);
    }
    let problem = match refused.first() {
        None => "holds no checkpoint: run without --restart".to_string(),
        Some(error) => format!("holds no valid checkpoint; the newest: {error}"),
    };
    Err(FileError::new(directory, problem))
}
