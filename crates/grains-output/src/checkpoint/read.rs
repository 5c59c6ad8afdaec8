//! Reading a checkpoint, on any number of ranks.

use super::{FORMAT, STATE, Values, checksum_of_text, contents_checksum, entry};
use crate::collective::read_rows;
use crate::error::{FileError, agree};
use crate::metadata::{GROUP, Metadata};
use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use hdf5::{Dataset, File, H5Type};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A checkpoint whose checksums were right.
#[derive(Clone, Debug)]
pub struct CheckpointFile {
    /// Its path.
    pub path: PathBuf,
    metadata: Metadata,
    arrays: Vec<Stored>,
}

/// This rank's share of an array.
#[derive(Clone, Debug)]
struct Stored {
    name: String,
    /// Rows and values per row of the whole array.
    shape: [usize; 2],
    /// First of this rank's rows.
    first: usize,
    values: Values,
    expected: u64,
}

impl CheckpointFile {
    /// Reads and verifies a checkpoint; each rank gets an even share of every array's rows: of `n` rows,
    /// rank `r` of `s` gets `n r / s` up to `n (r + 1) / s`.
    ///
    /// # Errors
    /// A file that is missing, truncated or corrupt, naming the array.
    pub fn read(path: &Path, communicator: &SimpleCommunicator) -> Result<Self, FileError> {
        let refuse = |problem: String| {
            FileError::new(
                path,
                format!("is no valid checkpoint: {problem}; use an earlier one, or `--restart latest`"),
            )
        };
        // Each rank opens the file by itself: a damaged one cannot stop the ranks at different calls.
        let share = (communicator.rank() as usize, communicator.size() as usize);
        let contents = Contents::read(path, share).map_err(refuse);
        let Contents { metadata, arrays, expected } = agree(communicator, contents)?;
        let own: Vec<u64> = arrays.iter().map(|a| a.values.checksum(a.first * a.shape[1])).collect();
        let mut found = vec![0_u64; own.len()];
        communicator.all_reduce_into(&own[..], &mut found[..], SystemOperation::sum());
        let wrong = arrays.iter().zip(&found).find(|(array, found)| array.expected != **found);
        let verdict = match wrong {
            Some((array, _)) => Err(refuse(format!("the checksum of `{STATE}/{}` is wrong", array.name))),
            None if table(&metadata, &arrays) != expected => Err(refuse("an array is missing".into())),
            None => Ok(Self { path: path.to_path_buf(), metadata, arrays }),
        };
        agree(communicator, verdict)
    }

    /// A text of the metadata.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.metadata.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// This rank's rows of a floating-point array.
    ///
    /// # Errors
    /// An array that the checkpoint lacks.
    pub fn real(&self, name: &str) -> Result<&[f64], FileError> {
        match &self.stored(name)?.values {
            Values::Real(values) => Ok(values),
            Values::Integer(_) => Err(self.wrong_type(name)),
        }
    }

    /// This rank's rows of an array of whole numbers.
    ///
    /// # Errors
    /// An array that the checkpoint lacks.
    pub fn integer(&self, name: &str) -> Result<&[i64], FileError> {
        match &self.stored(name)?.values {
            Values::Integer(values) => Ok(values),
            Values::Real(_) => Err(self.wrong_type(name)),
        }
    }

    fn stored(&self, name: &str) -> Result<&Stored, FileError> {
        let lacks =
            || FileError::new(&self.path, format!("lacks the array `{name}`: it is of another version"));
        self.arrays.iter().find(|array| array.name == name).ok_or_else(lacks)
    }

    fn wrong_type(&self, name: &str) -> FileError {
        FileError::new(&self.path, format!("`{name}` has values of another type: it is of another version"))
    }
}

/// What one rank reads.
struct Contents {
    metadata: Metadata,
    arrays: Vec<Stored>,
    /// Checksum of the table of contents.
    expected: u64,
}

impl Contents {
    fn read(path: &Path, share: (usize, usize)) -> Result<Self, String> {
        std::fs::File::open(path).map_err(|e| e.to_string())?;
        let file = File::open(path).map_err(|e| format!("it is truncated or no HDF5 file ({e})"))?;
        let attribute = |name| file.attr(name).map_err(|_| format!("it lacks the attribute `{name}`"));
        let format = attribute("format")?.read_scalar::<i64>().map_err(|e| e.to_string())?;
        if format != FORMAT {
            return Err(format!("its format is {format}, this program reads {FORMAT}"));
        }
        let expected = attribute("contents")?.read_scalar::<u64>().map_err(|e| e.to_string())?;
        let mut metadata = Metadata::new();
        for name in names(&file, GROUP)? {
            let bad = |e: &dyn std::fmt::Display| format!("`{GROUP}/{name}` cannot be read ({e})");
            metadata.push((name.clone(), read_text(&file, &name).map_err(|e| bad(&e))?));
        }
        let mut arrays = Vec::new();
        for name in names(&file, STATE)? {
            let stored = read_array(&file, &name, share);
            arrays.push(stored.map_err(|e| format!("`{STATE}/{name}` cannot be read ({e})"))?);
        }
        Ok(Self { metadata, arrays, expected })
    }
}

fn names(file: &File, group: &str) -> Result<Vec<String>, String> {
    let names = file.group(group).and_then(|group| group.member_names());
    let mut names = names.map_err(|e| format!("the group `{group}` cannot be read ({e})"))?;
    names.sort();
    Ok(names)
}

fn read_text(file: &File, name: &str) -> hdf5::Result<String> {
    let dataset = file.dataset(&format!("{GROUP}/{name}"))?;
    let bytes: Vec<u8> = part(&dataset, 0..dataset.size(), 1)?;
    if dataset.attr("checksum")?.read_scalar::<u64>()? != checksum_of_text(&bytes) {
        return Err("its checksum is wrong".into());
    }
    String::from_utf8(bytes).map_err(|_| "it is no text".into())
}

fn read_array(file: &File, name: &str, (rank, size): (usize, usize)) -> hdf5::Result<Stored> {
    let dataset = file.dataset(&format!("{STATE}/{name}"))?;
    let expected = dataset.attr("checksum")?.read_scalar::<u64>()?;
    let (rows, width) = match dataset.shape()[..] {
        [rows] => (rows, 1),
        [rows, width] => (rows, width),
        _ => return Err("it has neither one nor two dimensions".into()),
    };
    let (first, end) = (rows * rank / size, rows * (rank + 1) / size);
    let values = match dataset.dtype()?.to_descriptor()? {
        TypeDescriptor::Float(FloatSize::U8) => Values::Real(part(&dataset, first..end, width)?),
        TypeDescriptor::Integer(IntSize::U8) => Values::Integer(part(&dataset, first..end, width)?),
        _ => return Err("its values are neither f64 nor i64".into()),
    };
    Ok(Stored { name: name.to_string(), shape: [rows, width], first, values, expected })
}

/// Rows of a dataset.
fn part<T: H5Type + Default + Clone>(
    dataset: &Dataset,
    rows: Range<usize>,
    width: usize,
) -> hdf5::Result<Vec<T>> {
    let mut data = vec![T::default(); rows.len() * width];
    read_rows(dataset, rows.start, width, &mut data)?;
    Ok(data)
}

/// Checksum of what was found.
fn table(metadata: &Metadata, arrays: &[Stored]) -> u64 {
    let text = |(name, value): &(String, String)| {
        let bytes = value.as_bytes();
        entry(GROUP, name, "text", [bytes.len(), 1], checksum_of_text(bytes))
    };
    let array = |array: &Stored| {
        let kind = match array.values {
            Values::Real(_) => "f64",
            Values::Integer(_) => "i64",
        };
        entry(STATE, &array.name, kind, array.shape, array.expected)
    };
    contents_checksum(metadata.iter().map(text).chain(arrays.iter().map(array)).collect())
}
