//! A file of HDF5 that is open for all ranks.

use hdf5::File;
use mpi::topology::SimpleCommunicator;
use mpi::traits::AsRaw;
use std::ops::Deref;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a file could not be written.
static IS_LOST: AtomicBool = AtomicBool::new(false);

/// An open file, closed when it is dropped, by all ranks.
///
/// From the first failed write on no file is closed any more: HDF5 would try again to write what it could not, fail on some
/// ranks and leave the others waiting for ever. What was flushed before is in the files.
pub(crate) struct ParallelFile(File);

impl ParallelFile {
    /// Creates a file; all ranks take part.
    pub fn create(path: &Path, communicator: &SimpleCommunicator) -> hdf5::Result<Self> {
        let raw = communicator.as_raw();
        File::with_options().with_fapl(|p| p.mpio(raw, None)).create(path).map(Self)
    }

    /// Opens a file for reading and writing; all ranks take part.
    pub fn open(path: &Path, communicator: &SimpleCommunicator) -> hdf5::Result<Self> {
        let raw = communicator.as_raw();
        File::with_options().with_fapl(|p| p.mpio(raw, None)).open_rw(path).map(Self)
    }
}

/// Leaves open files as they are from now on, as after a failed write.
pub(crate) fn close_no_file() {
    IS_LOST.store(true, Ordering::Relaxed);
}

impl Deref for ParallelFile {
    type Target = File;

    fn deref(&self) -> &File {
        &self.0
    }
}

impl Drop for ParallelFile {
    fn drop(&mut self) {
        if IS_LOST.load(Ordering::Relaxed) {
            // A file with a handle that is never given back stays open.
            std::mem::forget(self.0.clone());
        }
    }
}
