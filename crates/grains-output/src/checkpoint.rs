//! Checkpoints: complete, checksummed, written aside and renamed.

use crate::collective::{read_rows, write_rows};
use crate::error::{FileError, agree};
use crate::polydata::{Metadata, write_metadata};
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, Communicator, CommunicatorCollectives};
use std::path::{Path, PathBuf};

/// Values of an array on this rank.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floating point.
    Real(Vec<f64>),
    /// Whole numbers.
    Integer(Vec<i64>),
}

/// A distributed array: each rank its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Values per row.
    pub width: usize,
    /// Rows of this rank.
    pub values: Values,
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Values::Real(v) => v.len(),
            Values::Integer(v) => v.len(),
        }
    }

    /// Sum of hashes of (place, bits): it does not depend on which rank holds which rows.
    fn checksum(&self, first: usize) -> u64 {
        let mix = |(k, bits): (usize, u64)| {
            let x = ((first + k) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ bits.rotate_left(17);
            let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            x ^ (x >> 31)
        };
        let sum = |bits: &mut dyn Iterator<Item = u64>| bits.enumerate().map(mix).fold(0, u64::wrapping_add);
        match self {
            Values::Real(v) => sum(&mut v.iter().map(|x| x.to_bits())),
            Values::Integer(v) => sum(&mut v.iter().map(|&x| x as u64)),
        }
    }
}

fn file_name(step: u64) -> String {
    format!("checkpoint-{step:012}.h5")
}

/// Writes `checkpoint-<step>.h5`; the previous ones stay untouched whatever happens.
///
/// # Errors
/// A full disk or a directory that cannot be written.
pub fn write_checkpoint(
    directory: &Path,
    step: u64,
    communicator: &SimpleCommunicator,
    arrays: &[Array],
    metadata: &Metadata,
) -> Result<PathBuf, FileError> {
    let path = directory.join(file_name(step));
    let aside = path.with_extension("h5.tmp");
    let written = write(&aside, communicator, arrays, metadata).map_err(|e| {
        FileError::new(&path, format!("cannot be written: {e}; free space or choose another output.directory; earlier checkpoints are intact"))
    });
    agree(communicator, written)?;
    let renamed = if communicator.rank() == 0 {
        std::fs::File::open(&aside)
            .and_then(|f| f.sync_all())
            .and_then(|()| std::fs::rename(&aside, &path))
            .map_err(|e| {
                FileError::new(&path, format!("cannot be completed: {e}; earlier checkpoints are intact"))
            })
    } else {
        Ok(())
    };
    agree(communicator, renamed)?;
    Ok(path)
}

fn write(
    path: &Path,
    communicator: &SimpleCommunicator,
    arrays: &[Array],
    metadata: &Metadata,
) -> hdf5::Result<()> {
    let file = File::with_options().with_fapl(|p| p.mpio(communicator.as_raw(), None)).create(path)?;
    write_metadata(&file, metadata)?;
    let state = file.create_group("state")?;
    for array in arrays {
        let own = array.values.len() / array.width;
        let (mut through, mut all) = (0_u64, 0_u64);
        communicator.scan_into(&(own as u64), &mut through, SystemOperation::sum());
        communicator.all_reduce_into(&(own as u64), &mut all, SystemOperation::sum());
        let (first, all) = ((through - own as u64) as usize, all as usize);
        let dataset = match &array.values {
            Values::Real(v) => {
                let dataset = create::<f64>(&state, array, all)?;
                write_rows(&dataset, first, array.width, v)?;
                dataset
            }
            Values::Integer(v) => {
                let dataset = create::<i64>(&state, array, all)?;
                write_rows(&dataset, first, array.width, v)?;
                dataset
            }
        };
        let mut checksum = 0_u64;
        let own_sum = array.values.checksum(first * array.width);
        communicator.all_reduce_into(&own_sum, &mut checksum, SystemOperation::sum());
        dataset.new_attr::<u64>().create("checksum")?.write_scalar(&checksum)?;
        let unit: VarLenUnicode = array.unit.parse().map_err(|_| "a unit is no text")?;
        dataset.new_attr::<VarLenUnicode>().create("unit")?.write_scalar(&unit)?;
    }
    // The file closes only when nothing in it is open any more.
    drop(state);
    file.flush()?;
    file.close()
}

fn create<T: hdf5::H5Type>(group: &hdf5::Group, array: &Array, rows: usize) -> hdf5::Result<Dataset> {
    let builder = group.new_dataset::<T>();
    if array.width == 1 {
        builder.shape(rows).create(array.name)
    } else {
        builder.shape((rows, array.width)).create(array.name)
    }
}

/// Deletes all but the newest `keep` checkpoints; failures are not errors of the run.
pub fn remove_old(directory: &Path, keep: usize) {
    let old = checkpoints(directory);
    for path in old.iter().rev().skip(keep.max(1)) {
        let _ = std::fs::remove_file(path);
    }
}

/// Checkpoints of a directory, oldest first.
fn checkpoints(directory: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = std::fs::read_dir(directory)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|p| {
            let name = p.file_name().unwrap_or_default().to_string_lossy().into_owned();
            name.starts_with("checkpoint-") && name.ends_with(".h5")
        })
        .collect();
    found.sort();
    found
}

/// A checkpoint whose checksums were right.
#[derive(Clone, Debug)]
pub struct CheckpointFile {
    /// Its path.
    pub path: PathBuf,
    metadata: Metadata,
    arrays: Vec<(String, usize, Values)>,
}

impl CheckpointFile {
    /// Reads and verifies a checkpoint; each rank gets an even share of every array's rows.
    ///
    /// # Errors
    /// A file that is missing, truncated or corrupt, naming the array.
    pub fn read(path: &Path, communicator: &SimpleCommunicator) -> Result<Self, FileError> {
        let outcome = read(path, communicator).map_err(|problem| {
            FileError::new(
                path,
                format!("is no valid checkpoint: {problem}; use an earlier one, or `--restart latest`"),
            )
        });
        let (metadata, arrays) = agree(communicator, outcome)?;
        Ok(Self { path: path.to_path_buf(), metadata, arrays })
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
        match self.arrays.iter().find(|(n, _, _)| n == name) {
            Some((_, _, Values::Real(values))) => Ok(values),
            _ => {
                Err(FileError::new(&self.path, format!("lacks the array `{name}`: it is of another version")))
            }
        }
    }

    /// This rank's rows of an array of whole numbers.
    ///
    /// # Errors
    /// An array that the checkpoint lacks.
    pub fn integer(&self, name: &str) -> Result<&[i64], FileError> {
        match self.arrays.iter().find(|(n, _, _)| n == name) {
            Some((_, _, Values::Integer(values))) => Ok(values),
            _ => {
                Err(FileError::new(&self.path, format!("lacks the array `{name}`: it is of another version")))
            }
        }
    }
}

type Contents = (Metadata, Vec<(String, usize, Values)>);

fn read(path: &Path, communicator: &SimpleCommunicator) -> Result<Contents, String> {
    // Opened by each rank alone first: a file that is no HDF5 must not stop the ranks at different calls.
    let readable = File::open(path).map(drop).map_err(|e| e.to_string());
    let mut failed = 0_u8;
    communicator.all_reduce_into(&u8::from(readable.is_err()), &mut failed, SystemOperation::max());
    if failed > 0 {
        return Err(readable.err().unwrap_or("unreadable on another rank".into()));
    }
    let file = File::with_options()
        .with_fapl(|p| p.mpio(communicator.as_raw(), None))
        .open(path)
        .map_err(|e| e.to_string())?;
    let metadata = read_metadata(&file).map_err(|e| e.to_string())?;
    let state = file.group("state").map_err(|e| e.to_string())?;
    let (rank, size) = (communicator.rank() as usize, communicator.size() as usize);
    let mut arrays = Vec::new();
    let mut corrupt = None;
    let mut names = state.member_names().map_err(|e| e.to_string())?;
    names.sort();
    for name in names {
        let dataset = state.dataset(&name).map_err(|e| e.to_string())?;
        let shape = dataset.shape();
        let (rows, width) = (shape[0], shape.get(1).copied().unwrap_or(1));
        let (first, end) = (rows * rank / size, rows * (rank + 1) / size);
        let count = (end - first) * width;
        let is_real = dataset.dtype().and_then(|t| t.to_descriptor()).map_err(|e| e.to_string())?
            == hdf5::types::TypeDescriptor::Float(hdf5::types::FloatSize::U8);
        let values = if is_real {
            let mut data = vec![0.0; count];
            read_rows(&dataset, first, width, &mut data).map_err(|e| e.to_string())?;
            Values::Real(data)
        } else {
            let mut data = vec![0; count];
            read_rows(&dataset, first, width, &mut data).map_err(|e| e.to_string())?;
            Values::Integer(data)
        };
        let expected =
            dataset.attr("checksum").and_then(|a| a.read_scalar::<u64>()).map_err(|e| e.to_string())?;
        let mut found = 0_u64;
        communicator.all_reduce_into(&values.checksum(first * width), &mut found, SystemOperation::sum());
        if found != expected {
            corrupt.get_or_insert(format!("the checksum of `{name}` is wrong: the file is corrupt"));
        }
        arrays.push((name, width, values));
    }
    match corrupt {
        Some(problem) => Err(problem),
        None => Ok((metadata, arrays)),
    }
}

fn read_metadata(file: &File) -> hdf5::Result<Metadata> {
    let group = file.group("grains-mpi")?;
    let mut metadata = Metadata::new();
    for name in group.attr_names()? {
        let value = group.attr(&name)?.read_scalar::<VarLenUnicode>()?.to_string();
        metadata.push((name, value));
    }
    for name in group.member_names()? {
        let bytes = group.dataset(&name)?.read_raw::<u8>()?;
        metadata.push((name, String::from_utf8_lossy(&bytes).into_owned()));
    }
    Ok(metadata)
}

/// The newest valid checkpoint of a directory, with what was wrong with newer ones.
///
/// # Errors
/// No valid checkpoint at all.
pub fn latest_valid(
    directory: &Path,
    communicator: &SimpleCommunicator,
) -> Result<(CheckpointFile, Vec<FileError>), FileError> {
    let mut refused = Vec::new();
    for path in checkpoints(directory).iter().rev() {
        match CheckpointFile::read(path, communicator) {
            Ok(file) => return Ok((file, refused)),
            Err(error) => refused.push(error),
        }
    }
    let problem = match refused.first() {
        None => "holds no checkpoint: run without --restart".to_string(),
        Some(error) => format!("holds no valid checkpoint; the newest: {error}"),
    };
    Err(FileError::new(directory, problem))
}
