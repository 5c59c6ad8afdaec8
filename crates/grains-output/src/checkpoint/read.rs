//! Reading a checkpoint, on any number of ranks.

use super::grid::{StoredGrid, read_block, read_checksum};
use super::{GRIDS, STATE, Values, checksum, seal};
use crate::collective::read_rows;
use crate::error::{FileError, agree, from_rank};
use crate::grid::GridBlock;
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
    grids: Vec<StoredGrid>,
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
        seal::verify(path, communicator, refuse)?;
        // Each rank opens the file by itself: one that cannot be read does not stop the ranks at different calls.
        let share = (communicator.rank() as usize, communicator.size() as usize);
        let contents = Contents::read(path, share).map_err(refuse);
        let contents = agree(communicator, contents)?;
        let Contents { arrays, grids, .. } = &contents;
        let rows = arrays.iter().map(|a| a.values.checksum(a.first * a.shape[1]));
        let own: Vec<u64> = rows.chain(grids.iter().map(|grid| grid.own)).collect();
        let mut found = vec![0_u64; own.len()];
        communicator.all_reduce_into(&own[..], &mut found[..], SystemOperation::sum());
        let arrays = arrays.iter().map(|a| (STATE, &a.name, a.expected));
        let mut all = arrays.chain(grids.iter().map(|grid| (GRIDS, &grid.name, grid.expected))).zip(&found);
        let verdict = match all.find(|((_, _, expected), found)| expected != *found) {
            Some(((group, name, _), _)) => Err(format!("the checksum of `{group}/{name}` is wrong")),
            None => Ok(()),
        };
        agree(communicator, verdict.map_err(refuse))?;
        let Contents { texts, arrays, grids } = contents;
        let metadata = unpack(&from_rank(communicator, 0, &texts));
        Ok(Self { path: path.to_path_buf(), metadata, arrays, grids })
    }

    /// The same with other texts and values than its file has, on one rank: to see what becomes of wrong ones.
    pub fn altered(
        mut self,
        mut text: impl FnMut(&str, &mut String),
        mut values: impl FnMut(&str, &mut Values),
    ) -> Self {
        self.metadata.iter_mut().for_each(|(name, value)| text(name, value));
        for array in &mut self.arrays {
            values(&array.name, &mut array.values);
            array.shape[0] = array.values.len() / array.shape[1].max(1);
        }
        self
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

    /// The next `count` rows of a floating-point array after those of the ranks before; all ranks take part, and
    /// together they take the whole array. The rows are read from the file again and verified again.
    ///
    /// # Errors
    /// An array that the checkpoint lacks or that has another number of rows, or a file that has changed.
    pub fn next_rows(
        &self,
        name: &str,
        count: usize,
        communicator: &SimpleCommunicator,
    ) -> Result<Vec<f64>, FileError> {
        let Stored { shape: [rows, width], expected, ref values, .. } = *self.stored(name)?;
        let (mut through, mut all) = (0_u64, 0_u64);
        communicator.scan_into(&(count as u64), &mut through, SystemOperation::sum());
        communicator.all_reduce_into(&(count as u64), &mut all, SystemOperation::sum());
        if all != rows as u64 {
            let problem = format!("`{name}` has {rows} rows, not {all}: it is of another version");
            return Err(FileError::new(&self.path, problem));
        }
        if let (1, Values::Real(values)) = (communicator.size(), values) {
            return Ok(values.clone());
        }
        let own = through as usize - count..through as usize;
        let read = File::open(&self.path)
            .and_then(|file| part::<f64>(&file.dataset(&format!("{STATE}/{name}"))?, own.clone(), width))
            .map_err(|e| FileError::new(&self.path, format!("`{STATE}/{name}` cannot be read ({e})")));
        let values = agree(communicator, read)?;
        let own_sum = checksum(own.start * width, values.iter().map(|x| x.to_bits()));
        let mut found = 0_u64;
        communicator.all_reduce_into(&own_sum, &mut found, SystemOperation::sum());
        match found == expected {
            true => Ok(values),
            false => Err(FileError::new(&self.path, format!("the checksum of `{STATE}/{name}` is wrong"))),
        }
    }

    /// Whether there is an array of rows of this name.
    pub fn has(&self, name: &str) -> bool {
        self.arrays.iter().any(|array| array.name == name)
    }

    /// Whether there is an array on a grid of this name.
    pub fn has_grid(&self, name: &str) -> bool {
        self.grids.iter().any(|grid| grid.name == name)
    }

    /// A block of an array on a grid, `width` values per place, x fastest; any rank may ask for any block.
    ///
    /// It is read from the file again, by this rank alone: let the ranks [`agree`] on the outcome.
    ///
    /// # Errors
    /// An array that the checkpoint lacks or that has another shape, or a file that cannot be read any more.
    pub fn grid(&self, name: &str, width: usize, block: &GridBlock) -> Result<Vec<f64>, FileError> {
        let grid = self.grids.iter().find(|grid| grid.name == name).ok_or_else(|| self.lacks(name))?;
        if (grid.all, grid.width) != (block.all, width) {
            let problem = format!(
                "`{name}` has {:?} places (x, y, z) of {} values, this run {:?} of {width}: it is of another grid",
                grid.all, grid.width, block.all
            );
            return Err(FileError::new(&self.path, problem));
        }
        File::open(&self.path)
            .and_then(|file| read_block(&file, name, block, width))
            .map_err(|e| FileError::new(&self.path, format!("`{GRIDS}/{name}` cannot be read ({e})")))
    }

    fn lacks(&self, name: &str) -> FileError {
        FileError::new(&self.path, format!("lacks the array `{name}`: it is of another version"))
    }

    fn stored(&self, name: &str) -> Result<&Stored, FileError> {
        self.arrays.iter().find(|array| array.name == name).ok_or_else(|| self.lacks(name))
    }

    fn wrong_type(&self, name: &str) -> FileError {
        FileError::new(&self.path, format!("`{name}` has values of another type: it is of another version"))
    }
}

/// What no text contains.
const END: &str = "\0";

/// What one rank reads.
struct Contents {
    /// Names and texts of the metadata, each with [`END`] after it, on rank 0.
    texts: String,
    arrays: Vec<Stored>,
    grids: Vec<StoredGrid>,
}

impl Contents {
    fn read(path: &Path, share: (usize, usize)) -> Result<Self, String> {
        let file = File::open(path).map_err(|e| format!("HDF5 cannot read it ({e})"))?;
        let mut texts = String::new();
        let is_first = share.0 == 0;
        for name in if is_first { names(&file, GROUP)? } else { Vec::new() } {
            let text =
                read_text(&file, &name).map_err(|e| format!("`{GROUP}/{name}` cannot be read ({e})"))?;
            [&name, &text].into_iter().for_each(|word| texts.extend([word, END]));
        }
        let mut arrays = Vec::new();
        for name in names(&file, STATE)? {
            let stored = read_array(&file, &name, share);
            arrays.push(stored.map_err(|e| format!("`{STATE}/{name}` cannot be read ({e})"))?);
        }
        let mut grids = Vec::new();
        if file.link_exists(GRIDS) {
            for name in names(&file, GRIDS)? {
                let stored = read_checksum(&file, &name, share);
                grids.push(stored.map_err(|e| format!("`{GRIDS}/{name}` cannot be read ({e})"))?);
            }
        }
        Ok(Self { texts, arrays, grids })
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
    let text = String::from_utf8(bytes).ok().filter(|text| !text.contains(END));
    text.ok_or_else(|| "it is no text".into())
}

/// The metadata of texts that were packed.
fn unpack(texts: &str) -> Metadata {
    let words: Vec<&str> = texts.split_terminator(END).collect();
    words.chunks_exact(2).map(|pair| (pair[0].to_string(), pair[1].to_string())).collect()
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
