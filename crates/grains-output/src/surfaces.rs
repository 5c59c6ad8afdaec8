//! Reading snapshots of surfaces back, by a single process.

use crate::arrays::{Cells, Place, places};
use crate::collective::read_rows;
use crate::error::FileError;
use crate::metadata::{Metadata, read_metadata};
use hdf5::{Dataset, File, H5Type};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file of triangles such as `walls.vtkhdf`, open for reading; MPI need not run.
pub struct SurfaceFile {
    path: PathBuf,
    file: File,
    metadata: Metadata,
    steps: Vec<Place>,
}

/// The triangles of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Positions (m), `[points][3]`.
    pub points: Vec<f64>,
    /// Point numbers, `[triangles][3]`.
    pub corners: Vec<i64>,
}

impl SurfaceFile {
    /// Opens a file.
    ///
    /// # Errors
    /// A file that is missing, damaged, or no file of triangles.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        std::fs::File::open(path).map_err(|e| FileError::new(path, e))?;
        let read = || -> hdf5::Result<Self> {
            let file = File::open(path)?;
            let (metadata, steps) = (read_metadata(&file)?, places(&file, Cells::Triangles)?);
            Ok(Self { path: path.to_path_buf(), file, metadata, steps })
        };
        read().map_err(|e| refuse(path, &e))
    }

    /// Times of the steps (s), rising.
    pub fn times(&self) -> Vec<f64> {
        self.steps.iter().map(|place| place.time).collect()
    }

    /// A text of the metadata, such as `case`.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.metadata.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// The triangles of a step.
    ///
    /// # Errors
    /// A damaged file.
    pub fn triangles(&self, step: usize) -> Result<Triangles, FileError> {
        let Place { first_point, points, first_cell, cells, .. } = self.steps[step];
        let corners = format!("{}/Connectivity", Cells::Triangles.name());
        Ok(Triangles {
            points: self.rows("Points", first_point..first_point + points, 3)?,
            corners: self.rows(&corners, 3 * first_cell..3 * (first_cell + cells), 1)?,
        })
    }

    /// A whole number per triangle of a step, such as that of the wall.
    ///
    /// # Errors
    /// A field that the file lacks, or a damaged file.
    pub fn integer(&self, step: usize, field: &str) -> Result<Vec<i64>, FileError> {
        let Place { first_cell, cells, .. } = self.steps[step];
        self.rows(&format!("{}/{field}", Cells::Triangles.data()), first_cell..first_cell + cells, 1)
    }

    fn rows<T: H5Type + Default + Clone>(
        &self,
        name: &str,
        rows: Range<usize>,
        width: usize,
    ) -> Result<Vec<T>, FileError> {
        let read = || -> hdf5::Result<Vec<T>> {
            let dataset: Dataset = self.file.dataset(&format!("VTKHDF/{name}"))?;
            if dataset.shape().first().is_none_or(|&all| all < rows.end) {
                return Err(format!("`{name}` has fewer rows than the steps need").into());
            }
            let mut values = vec![T::default(); rows.len() * width];
            read_rows(&dataset, rows.start, width, &mut values)?;
            Ok(values)
        };
        read().map_err(|e| refuse(&self.path, &e))
    }
}

fn refuse(path: &Path, error: &hdf5::Error) -> FileError {
    let reason = error.to_string();
    let first = reason.lines().next().unwrap_or_default();
    FileError::new(path, format!("cannot be read as snapshots of surfaces: {first}"))
}
