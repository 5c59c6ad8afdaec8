//! Reading fields on the cells of a grid back, on any number of ranks.

use super::GridBlock;
use super::arrays::{DATA, digest_of_step, read_nodes, read_times};
use crate::collective::read_part;
use crate::digests::{Digested, Stored};
use crate::error::{FileError, agree};
use crate::growing::unit_of;
use crate::metadata::read_metadata;
use hdf5::File;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::path::{Path, PathBuf};

/// A file of [`GridFile`](crate::GridFile), open for reading.
pub struct GridSnapshotFile {
    path: PathBuf,
    file: File,
    fields: Vec<String>,
    nodes: [Vec<f64>; 3],
    times: Vec<f64>,
    /// None in a file of a version without.
    digests: Option<Stored>,
}

/// Cells that are read at once for their checksum.
const CELLS_AT_ONCE: usize = 1 << 18;

impl GridSnapshotFile {
    /// Opens a file, each rank by itself; collective.
    ///
    /// # Errors
    /// A file that is missing, damaged, or no file of cells.
    pub fn open(path: &Path, communicator: &SimpleCommunicator) -> Result<Self, FileError> {
        agree(communicator, Self::open_alone(path))
    }

    /// Opens a file for this process alone; MPI need not run.
    ///
    /// # Errors
    /// As for [`GridSnapshotFile::open`].
    pub fn open_alone(path: &Path) -> Result<Self, FileError> {
        std::fs::File::open(path)
            .map_err(|e| FileError::new(path, e))
            .and_then(|_| Self::of(path).map_err(|e| refuse(path, &e)))
    }

    fn of(path: &Path) -> hdf5::Result<Self> {
        let file = File::open(path)?;
        let root = file.group("VTKHDF")?;
        let fields = root.group(DATA)?.member_names()?;
        let (nodes, times) = (read_nodes(&file)?, read_times(&root.group("Steps")?)?);
        let places: Vec<u64> = times.iter().map(|&time| digest_of_step(time, &nodes)).collect();
        let digests = Stored::read(&file, &fields, &read_metadata(&file)?, &places)?;
        Ok(Self { path: path.to_path_buf(), file, fields, nodes, times, digests })
    }

    /// Compares a field of real numbers of a step with its checksum, each rank a share of the cells; collective.
    ///
    /// # Errors
    /// A field that the file lacks, or a damaged file.
    pub fn verify(
        &self,
        step: usize,
        field: &str,
        communicator: &SimpleCommunicator,
    ) -> Result<(), FileError> {
        let Some(digests) = &self.digests else { return Ok(()) };
        let (rank, size) = (communicator.rank() as usize, communicator.size() as usize);
        let all = self.nodes.each_ref().map(|nodes| nodes.len().saturating_sub(1));
        let share = all[2] * rank / size..all[2] * (rank + 1) / size;
        let layers = (CELLS_AT_ONCE / (all[0] * all[1]).max(1)).max(1);
        let mut own = 0_u64;
        let read = share.clone().step_by(layers).try_for_each(|first| {
            let count = layers.min(share.end - first);
            let block = GridBlock { all, first: [0, 0, first], own: [all[0], all[1], count] };
            let values = self.block(step, field, &block)?;
            // Whole layers follow each other in the array.
            let width = values.len() / block.count().max(1);
            own = own.wrapping_add(f64::digest(first * all[0] * all[1] * width, &values));
            Ok(())
        });
        agree(communicator, read)?;
        let mut found = 0_u64;
        communicator.all_reduce_into(&own, &mut found, SystemOperation::sum());
        digests.compare(step, field, found).map_err(|e| refuse(&self.path, &e))
    }

    /// Times of the steps (s), rising.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Names of the fields stored with every step.
    pub fn fields(&self) -> &[String] {
        &self.fields
    }

    /// Unit of a field, if the file says it.
    pub fn unit(&self, field: &str) -> Option<String> {
        unit_of(&self.file, &format!("VTKHDF/{DATA}/{field}"))
    }

    /// Coordinates (m) of the nodes along x, y, z, one more than cells.
    pub fn nodes(&self) -> &[Vec<f64>; 3] {
        &self.nodes
    }

    /// A field of real numbers in a block of the cells, `[z][y][x][components]`; only this rank takes part.
    ///
    /// # Errors
    /// A field or block that the file lacks, or a damaged file.
    pub fn block(&self, step: usize, field: &str, block: &GridBlock) -> Result<Vec<f64>, FileError> {
        let read = (|| {
            let dataset = self.file.dataset(&format!("VTKHDF/{DATA}/{field}"))?;
            let width = match dataset.shape()[..] {
                [_, _, _, _] => 1,
                [_, _, _, _, width] if width <= 3 => width,
                _ => return Err(format!("`{field}` has another shape than fields have").into()),
            };
            let mut values = vec![0.0; block.count() * width];
            read_part(&dataset, &block.part(&[step], width), &mut values)?;
            Ok(values)
        })();
        read.map_err(|e| refuse(&self.path, &e))
    }
}

fn refuse(path: &Path, error: &hdf5::Error) -> FileError {
    let reason = error.to_string();
    let first = reason.lines().next().unwrap_or_default();
    FileError::new(
        path,
        format!("cannot be read as fields of cells: {first}; give the directory of a finished run"),
    )
}
