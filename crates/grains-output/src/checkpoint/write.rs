//! Writing a checkpoint.

use super::dataset::{FAILED, create, create_checked};
use super::folder::{abandon_later, file_name};
use super::grid::write_grid;
use super::seal::{BLOCK, seal};
use super::{Array, GRIDS, GridArray, STATE, Values};
use crate::collective::{Participants, write_rows};
use crate::error::{FileError, Shared};
use crate::growing::unit;
use crate::metadata::{GROUP, Metadata};
use crate::watch::Watch;
use hdf5::{File, Group};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, CommunicatorCollectives};
use std::path::{Path, PathBuf};

/// Writes `checkpoint-<step>.h5`; all ranks take part. The previous ones stay untouched whatever happens.
///
/// Arrays of cells are asked for one by one, as they are written.
///
/// Checkpoints of later steps, left by a run that was restarted from before them, get the ending
/// `.abandoned` once this one is complete.
///
/// # Errors
/// A full disk, a directory that cannot be written, or arrays whose lengths or blocks do not fit.
pub fn write_checkpoint(
    directory: &Path,
    step: u64,
    communicator: &SimpleCommunicator,
    arrays: &[Array],
    grids: impl IntoIterator<Item = GridArray>,
    metadata: &Metadata,
) -> Result<PathBuf, FileError> {
    let path = directory.join(file_name(step));
    let shared = Shared::new(&path.with_extension("h5.tmp"), communicator);
    let watch = Watch::over(&shared);
    let written = shared
        .create_empty()
        .and_then(|()| write(&shared, arrays, grids, metadata))
        .and_then(|()| seal(&shared));
    if written.is_err() && shared.is_first() {
        // What there is of it only fills the disk; cut first, as the open handle keeps its bytes alive.
        let _ = std::fs::OpenOptions::new().write(true).truncate(true).open(&shared.path);
        let _ = std::fs::remove_file(&shared.path);
    }
    drop(watch);
    written?;
    shared.first(|| {
        complete(&shared.path, &path, directory).map_err(|e| {
            FileError::new(&path, format!("cannot be completed: {e}; earlier checkpoints are intact"))
        })
    })?;
    shared.first(|| {
        abandon_later(directory, step);
        Ok(())
    })?;
    Ok(path)
}

/// Brings the bytes to the disk, then gives the file its name, then brings the name to the disk.
fn complete(aside: &Path, path: &Path, directory: &Path) -> std::io::Result<()> {
    std::fs::File::open(aside)?.sync_all()?;
    std::fs::rename(aside, path)?;
    std::fs::File::open(directory)?.sync_all()
}

fn write(
    shared: &Shared,
    arrays: &[Array],
    grids: impl IntoIterator<Item = GridArray>,
    metadata: &Metadata,
) -> Result<(), FileError> {
    shared.has_room()?;
    let raw = shared.communicator.as_raw();
    let file = File::with_options()
        .with_fapl(|p| p.mpio(raw, None).libver_v110())
        .with_fcpl(|p| p.userblock(BLOCK))
        .create(&shared.path);
    let file = shared.written_or(FAILED, file)?;
    match fill(shared, &file, arrays, grids, metadata) {
        Ok(()) => shared.written_or(FAILED, file.close()),
        Err(error) => {
            // Closing would write again, fail on some ranks and leave the others waiting.
            std::mem::forget(file);
            Err(error)
        }
    }
}

fn fill(
    shared: &Shared,
    file: &File,
    arrays: &[Array],
    grids: impl IntoIterator<Item = GridArray>,
    metadata: &Metadata,
) -> Result<(), FileError> {
    let texts = shared.written_or(FAILED, file.create_group(GROUP))?;
    let state = shared.written_or(FAILED, file.create_group(STATE))?;
    for (name, value) in metadata {
        write_text(shared, &texts, name, value)?;
    }
    for array in arrays {
        write_array(shared, &state, array)?;
    }
    let mut group = None;
    for array in grids {
        let group = match &mut group {
            Some(group) => group,
            none => none.insert(shared.written_or(FAILED, file.create_group(GRIDS))?),
        };
        write_grid(shared, group, &array)?;
    }
    shared.has_room()?;
    shared.written_or(FAILED, file.flush())
}

fn write_text(shared: &Shared, group: &Group, name: &str, value: &str) -> Result<(), FileError> {
    let bytes = value.as_bytes();
    let dataset = shared.written_or(FAILED, create::<u8>(group, name, &[bytes.len()]))?;
    let written =
        if shared.is_first() { write_rows(&dataset, 0, 1, bytes, Participants::ThisRank) } else { Ok(()) };
    shared.written_or(FAILED, written)
}

fn write_array(shared: &Shared, group: &Group, array: &Array) -> Result<(), FileError> {
    let communicator = &shared.communicator;
    let width = array.width.max(1);
    let own = array.values.len() / width;
    shared.agree(if own * width == array.values.len() {
        Ok(())
    } else {
        Err(format!("`{}` has {} values in rows of {width}", array.name, array.values.len()))
    })?;
    let (mut through, mut all) = (0_u64, 0_u64);
    communicator.scan_into(&(own as u64), &mut through, SystemOperation::sum());
    communicator.all_reduce_into(&(own as u64), &mut all, SystemOperation::sum());
    let first = through as usize - own;
    let mut checksum = 0_u64;
    let own_sum = array.values.checksum(first * width);
    communicator.all_reduce_into(&own_sum, &mut checksum, SystemOperation::sum());
    let shape = &[all as usize, width];
    let stored = if width == 1 { &shape[..1] } else { shape };
    let created = match &array.values {
        Values::Real(_) => create_checked::<f64>(group, array.name, stored, checksum),
        Values::Integer(_) => create_checked::<i64>(group, array.name, stored, checksum),
    };
    let dataset = shared.written_or(FAILED, created)?;
    shared.written_or(FAILED, unit(&dataset, array.unit))?;
    let written = match &array.values {
        Values::Real(v) => shared.write_rows(&dataset, (first, width), v),
        Values::Integer(v) => shared.write_rows(&dataset, (first, width), v),
    };
    shared.written_or(FAILED, written)
}
