//! Reading fields on the cells of a grid back, on any number of ranks.

use super::GridBlock;
use super::arrays::{DATA, read_nodes, read_times};
use crate::collective::read_part;
use crate::error::{FileError, agree};
use hdf5::File;
use mpi::topology::SimpleCommunicator;
use std::path::{Path, PathBuf};

/// A file of [`GridFile`](crate::GridFile), open for reading.
pub struct GridSnapshotFile {
    path: PathBuf,
    file: File,
    fields: Vec<String>,
    nodes: [Vec<f64>; 3],
    times: Vec<f64>,
}

impl GridSnapshotFile {
    /// Opens a file, each rank by itself; collective.
    ///
    /// # Errors
    /// A file that is missing, damaged, or no file of cells.
    pub fn open(path: &Path, communicator: &SimpleCommunicator) -> Result<Self, FileError> {
        let found = std::fs::File::open(path)
            .map_err(|e| FileError::new(path, e))
            .and_then(|_| Self::of(path).map_err(|e| refuse(path, &e)));
        agree(communicator, found)
    }

    fn of(path: &Path) -> hdf5::Result<Self> {
        let file = File::open(path)?;
        let root = file.group("VTKHDF")?;
        let fields = root.group(DATA)?.member_names()?;
        let (nodes, times) = (read_nodes(&file)?, read_times(&root.group("Steps")?)?);
        Ok(Self { path: path.to_path_buf(), file, fields, nodes, times })
    }

    /// Times of the steps (s), rising.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Names of the fields stored with every step.
    pub fn fields(&self) -> &[String] {
        &self.fields
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
            let width = dataset.shape().get(4).copied().unwrap_or(1);
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
