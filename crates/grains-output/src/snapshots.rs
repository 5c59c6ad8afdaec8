//! Reading the snapshots of particles back, on any number of ranks.

use crate::arrays::{Cells, Place, places};
use crate::collective::read_rows;
use crate::digests::{Digested, Stored};
use crate::error::{FileError, agree};
use crate::growing::unit_of;
use crate::metadata::{Metadata, read_metadata};
use hdf5::{Dataset, File};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Values per row of a particle: no field has more.
const LARGEST_WIDTH: usize = 16;
/// Rows that are read at once for their checksum.
const ROWS_AT_ONCE: usize = 1 << 16;

const UNREADABLE: &str = "cannot be read as snapshots of particles";

/// A file of particle snapshots, open for reading; all calls are collective unless they say otherwise.
pub struct SnapshotFile {
    /// None if this process reads without MPI.
    communicator: Option<SimpleCommunicator>,
    /// Share k of n of the particles is this rank's.
    share: (usize, usize),
    path: PathBuf,
    file: File,
    fields: Vec<String>,
    metadata: Metadata,
    steps: Vec<Place>,
    /// None in a file of a version without.
    digests: Option<Stored>,
}

/// What opening a file finds.
struct Contents {
    file: File,
    fields: Vec<String>,
    metadata: Metadata,
    steps: Vec<Place>,
    /// None in a file of a version without.
    digests: Option<Stored>,
}

impl SnapshotFile {
    /// Opens a `particles.vtkhdf`; each rank opens it by itself, so a damaged one cannot stop the ranks at
    /// different calls.
    ///
    /// # Errors
    /// A file that is missing, damaged, or no file of particles.
    pub fn open(path: &Path, communicator: &SimpleCommunicator) -> Result<Self, FileError> {
        let contents = agree(communicator, Contents::open(path))?;
        let communicator = communicator.duplicate();
        let share = (communicator.rank() as usize, communicator.size() as usize);
        Ok(Self::new(path, Some(communicator), share, contents))
    }

    /// Opens a file for this process alone, which reads share `k` of `n` of the particles; nothing is collective then, and MPI need
    /// not run.
    ///
    /// # Errors
    /// As for [`SnapshotFile::open`].
    pub fn open_share(path: &Path, share: (usize, usize)) -> Result<Self, FileError> {
        Ok(Self::new(path, None, share, Contents::open(path)?))
    }

    fn new(
        path: &Path,
        communicator: Option<SimpleCommunicator>,
        share: (usize, usize),
        contents: Contents,
    ) -> Self {
        let Contents { file, fields, metadata, steps, digests } = contents;
        Self { communicator, share, path: path.to_path_buf(), file, fields, metadata, steps, digests }
    }

    /// Times of the snapshots (s), rising; not collective.
    pub fn times(&self) -> Vec<f64> {
        self.steps.iter().map(|place| place.time).collect()
    }

    /// Numbers of particles of the snapshots, over all ranks; not collective.
    pub fn counts(&self) -> Vec<usize> {
        self.steps.iter().map(|place| place.points).collect()
    }

    /// Names of the fields stored with every snapshot; not collective.
    pub fn fields(&self) -> &[String] {
        &self.fields
    }

    /// Unit of a field, if the file says it; not collective.
    pub fn unit(&self, field: &str) -> Option<String> {
        unit_of(&self.file, &format!("VTKHDF/{}/{field}", Cells::Vertices.data()))
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

    /// This rank's rows of an array, whose checksum is that of the file; HDF5 converts numbers of 32 bits.
    fn rows<T: Digested>(&self, name: &str, step: usize) -> Result<Vec<T>, FileError> {
        let rows = self.share(step);
        let read = (|| -> hdf5::Result<(Vec<T>, u64)> {
            let dataset = self.file.dataset(name)?;
            let width = width_of(&dataset)?;
            let values: Vec<T> = part(&dataset, rows.clone(), width)?;
            let own = if self.reads_with_others() {
                T::digest((rows.start - self.steps[step].first_point) * width, &values)
            } else if self.digests.is_some() && self.share.0 == 0 {
                self.whole_digest::<T>(&dataset, step, width)?
            } else {
                0
            };
            Ok((values, own))
        })();
        let read = read.map_err(|e| refuse(&self.path, &e));
        let (values, found) = match &self.communicator {
            None => read?,
            Some(communicator) => {
                let (values, own) = agree(communicator, read)?;
                let mut found = 0_u64;
                communicator.all_reduce_into(&own, &mut found, SystemOperation::sum());
                (values, found)
            }
        };
        let array = name.rsplit('/').next().unwrap_or(name);
        match &self.digests {
            // Of shares read without the others the first verifies all.
            Some(digests) if self.reads_with_others() || self.share.0 == 0 => {
                digests.compare(step, array, found).map_err(|e| refuse(&self.path, &e))?;
            }
            _ => (),
        }
        Ok(values)
    }

    /// Whether all shares are read at once.
    fn reads_with_others(&self) -> bool {
        self.communicator.as_ref().map_or(1, |communicator| communicator.size() as usize) == self.share.1
    }

    /// Checksum of an array of a step, read by this rank alone.
    fn whole_digest<T: Digested>(&self, dataset: &Dataset, step: usize, width: usize) -> hdf5::Result<u64> {
        let Place { first_point, points, .. } = self.steps[step];
        let end = first_point + points;
        (first_point..end).step_by(ROWS_AT_ONCE).try_fold(0_u64, |sum, first| {
            let values: Vec<T> = part(dataset, first..end.min(first + ROWS_AT_ONCE), width)?;
            Ok(sum.wrapping_add(T::digest((first - first_point) * width, &values)))
        })
    }

    fn share(&self, step: usize) -> Range<usize> {
        let (rank, size) = self.share;
        let Place { first_point, points, .. } = self.steps[step];
        first_point + points * rank / size..first_point + points * (rank + 1) / size
    }
}

impl Contents {
    /// What a file holds, for this process alone.
    fn open(path: &Path) -> Result<Self, FileError> {
        std::fs::File::open(path)
            .map_err(|e| FileError::new(path, e))
            .and_then(|_| Self::of(path).map_err(|e| refuse(path, &e)))
    }

    fn of(path: &Path) -> hdf5::Result<Self> {
        let file = File::open(path)?;
        let fields = file.group(&format!("VTKHDF/{}", Cells::Vertices.data()))?.member_names()?;
        let steps = places(&file, Cells::Vertices)?;
        let metadata = read_metadata(&file)?;
        let places: Vec<u64> = steps.iter().map(Place::digest).collect();
        let digests = Stored::read(&file, &fields, &metadata, &places)?;
        Ok(Self { file, fields, metadata, steps, digests })
    }
}

fn refuse(path: &Path, error: &hdf5::Error) -> FileError {
    let reason = error.to_string();
    let first = reason.lines().next().unwrap_or_default();
    FileError::new(
        path,
        format!(
            "{UNREADABLE}: {first}; it is damaged, or none: give the directory of a finished run, its particles.vtkhdf or a checkpoint"
        ),
    )
}

/// Values per row; a damaged number must not be taken for a size.
fn width_of(dataset: &Dataset) -> hdf5::Result<usize> {
    match dataset.shape()[..] {
        [_] => Ok(1),
        [_, width] if width <= LARGEST_WIDTH => Ok(width),
        _ => Err(format!("`{}` has another shape than arrays of particles have", dataset.name()).into()),
    }
}

fn part<T: Digested>(dataset: &Dataset, rows: Range<usize>, width: usize) -> hdf5::Result<Vec<T>> {
    if dataset.shape().first().is_none_or(|&all| all < rows.end) {
        return Err(format!("`{}` has fewer rows than the steps need", dataset.name()).into());
    }
    let mut values = vec![T::default(); rows.len() * width];
    read_rows(dataset, rows.start, width, &mut values)?;
    Ok(values)
}
