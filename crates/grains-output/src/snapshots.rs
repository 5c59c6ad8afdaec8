//! Reading the snapshots of particles back, on any number of ranks.

use crate::arrays::{Cells, Place, places};
use crate::collective::read_rows;
use crate::error::{FileError, agree};
use crate::metadata::{GROUP, Metadata};
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, H5Type};
use mpi::topology::SimpleCommunicator;
use mpi::traits::Communicator;
use std::ops::Range;
use std::path::{Path, PathBuf};

const UNREADABLE: &str = "cannot be read as snapshots of particles";

/// A file of particle snapshots, open for reading; all calls are collective unless they say otherwise.
pub struct SnapshotFile {
    communicator: SimpleCommunicator,
    /// Share k of n of the particles is this rank's.
    share: (usize, usize),
    path: PathBuf,
    file: File,
    fields: Vec<String>,
    metadata: Metadata,
    steps: Vec<Place>,
}

/// What opening a file finds.
struct Contents {
    file: File,
    fields: Vec<String>,
    metadata: Metadata,
    steps: Vec<Place>,
}

impl SnapshotFile {
    /// Opens a `particles.vtkhdf`; each rank opens it by itself, so a damaged one cannot stop the ranks at
    /// different calls.
    ///
    /// # Errors
    /// A file that is missing, damaged, or no file of particles.
    pub fn open(path: &Path, communicator: &SimpleCommunicator) -> Result<Self, FileError> {
        let found = std::fs::File::open(path)
            .map_err(|e| FileError::new(path, e))
            .and_then(|_| Contents::of(path).map_err(|e| refuse(path, &e)));
        let Contents { file, fields, metadata, steps } = agree(communicator, found)?;
        let communicator = communicator.duplicate();
        let share = (communicator.rank() as usize, communicator.size() as usize);
        Ok(Self { communicator, share, path: path.to_path_buf(), file, fields, metadata, steps })
    }

    /// Opens a file for this rank alone, which reads share `k` of `n` of the particles; nothing is collective then.
    ///
    /// # Errors
    /// As for [`SnapshotFile::open`].
    pub fn open_share(path: &Path, share: (usize, usize)) -> Result<Self, FileError> {
        Ok(Self { share, ..Self::open(path, &SimpleCommunicator::self_comm())? })
    }

    /// Times of the snapshots (s), rising; not collective.
    pub fn times(&self) -> Vec<f64> {
        self.steps.iter().map(|place| place.time).collect()
    }

    /// Names of the fields stored with every snapshot; not collective.
    pub fn fields(&self) -> &[String] {
        &self.fields
    }

    /// A text of the metadata, such as `case`; not collective.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.metadata.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// Positions (m) of this rank's particles of a snapshot, `[particles][3]`: of `n` particles, rank `r`
    /// of `s` gets `n r / s` up to `n (r + 1) / s`.
    ///
    /// # Errors
    /// A damaged file.
    pub fn points(&self, step: usize) -> Result<Vec<f64>, FileError> {
        self.rows("VTKHDF/Points", step)
    }

    /// A floating-point field of the same particles, `[particles][components]`.
    ///
    /// # Errors
    /// A field that the file lacks, or a damaged file.
    pub fn real(&self, step: usize, field: &str) -> Result<Vec<f64>, FileError> {
        self.rows(&format!("VTKHDF/{}/{field}", Cells::Vertices.data()), step)
    }

    /// A field of whole numbers of the same particles.
    ///
    /// # Errors
    /// A field that the file lacks, or a damaged file.
    pub fn integer(&self, step: usize, field: &str) -> Result<Vec<i64>, FileError> {
        self.rows(&format!("VTKHDF/{}/{field}", Cells::Vertices.data()), step)
    }

    /// This rank's rows of an array; HDF5 converts numbers of 32 bits.
    fn rows<T: H5Type + Default + Clone>(&self, name: &str, step: usize) -> Result<Vec<T>, FileError> {
        let rows = self.share(step);
        let read = (|| -> hdf5::Result<Vec<T>> {
            let dataset = self.file.dataset(name)?;
            let width = dataset.shape().get(1).copied().unwrap_or(1);
            part(&dataset, rows, width)
        })();
        agree(&self.communicator, read.map_err(|e| refuse(&self.path, &e)))
    }

    fn share(&self, step: usize) -> Range<usize> {
        let (rank, size) = self.share;
        let Place { first_point, points, .. } = self.steps[step];
        first_point + points * rank / size..first_point + points * (rank + 1) / size
    }
}

impl Contents {
    fn of(path: &Path) -> hdf5::Result<Self> {
        let file = File::open(path)?;
        let fields = file.group(&format!("VTKHDF/{}", Cells::Vertices.data()))?.member_names()?;
        let steps = places(&file, Cells::Vertices)?;
        let group = file.group(GROUP)?;
        let text = |name: String| {
            let value = group.attr(&name)?.read_scalar::<VarLenUnicode>()?.to_string();
            Ok((name, value))
        };
        let metadata = group.attr_names()?.into_iter().map(text).collect::<hdf5::Result<_>>()?;
        Ok(Self { file, fields, metadata, steps })
    }
}

fn refuse(path: &Path, error: &hdf5::Error) -> FileError {
    let reason = error.to_string();
    let first = reason.lines().next().unwrap_or_default();
    FileError::new(
        path,
        format!(
            "{UNREADABLE}: {first}; give the directory of a finished run, its particles.vtkhdf or a checkpoint"
        ),
    )
}

fn part<T: H5Type + Default + Clone>(
    dataset: &Dataset,
    rows: Range<usize>,
    width: usize,
) -> hdf5::Result<Vec<T>> {
    if dataset.shape().first().is_none_or(|&all| all < rows.end) {
        return Err(format!("`{}` has fewer rows than the steps need", dataset.name()).into());
    }
    let mut values = vec![T::default(); rows.len() * width];
    read_rows(dataset, rows.start, width, &mut values)?;
    Ok(values)
}
