//! Reading a checkpoint, on any number of ranks.

use super::grid::StoredGrid;
use super::layout::{Stored, names};
use super::{GRIDS, STATE, Values, checksum, seal};
use crate::collective::read_rows;
use crate::error::{FileError, agree, from_rank};
use crate::grid::GridBlock;
use crate::metadata::{GROUP, Metadata};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::fs::File;
use std::path::{Path, PathBuf};

/// A checkpoint whose checksums were right.
#[derive(Clone, Debug)]
pub struct CheckpointFile {
    /// Its path.
    pub path: PathBuf,
    metadata: Metadata,
    arrays: Vec<Rows>,
    grids: Vec<StoredGrid>,
}

/// This rank's share of an array of rows.
#[derive(Clone, Debug)]
struct Rows {
    stored: Stored,
    /// Rows of the whole array.
    rows: usize,
    /// Values per row.
    width: usize,
    /// First of this rank's rows.
    first: usize,
    values: Values,
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
        let is_first = communicator.rank() == 0;
        let index = if is_first { Index::read(path).map_err(refuse) } else { Ok(Index::default()) };
        let Index { texts, lines } = agree(communicator, index)?;
        let [texts, lines] = [texts, lines].map(|text| from_rank(communicator, 0, &text));
        let share = (communicator.rank() as usize, communicator.size() as usize);
        let (arrays, grids) = agree(communicator, read_shares(path, &lines, share).map_err(refuse))?;
        let of_rows = arrays.iter().map(|rows| rows.values.checksum(rows.first * rows.width));
        let own: Vec<u64> = of_rows.chain(grids.iter().map(|grid| grid.own)).collect();
        let mut found = vec![0_u64; own.len()];
        communicator.all_reduce_into(&own[..], &mut found[..], SystemOperation::sum());
        let all = arrays.iter().map(|rows| &rows.stored).chain(grids.iter().map(|grid| &grid.stored));
        let verdict = match all.zip(&found).find(|(stored, found)| stored.checksum != **found) {
            Some((Stored { group, name, .. }, _)) => {
                Err(format!("the checksum of `{group}/{name}` is wrong"))
            }
            None => Ok(()),
        };
        agree(communicator, verdict.map_err(refuse))?;
        Ok(Self { path: path.to_path_buf(), metadata: unpack(&texts), arrays, grids })
    }

    /// The same with other texts and values than its file has, on one rank: to see what becomes of wrong ones.
    pub fn altered(
        mut self,
        mut text: impl FnMut(&str, &mut String),
        mut values: impl FnMut(&str, &mut Values),
    ) -> Self {
        self.metadata.iter_mut().for_each(|(name, value)| text(name, value));
        for array in &mut self.arrays {
            values(&array.stored.name, &mut array.values);
            array.rows = array.values.len() / array.width.max(1);
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
        match &self.rows(name)?.values {
            Values::Real(values) => Ok(values),
            Values::Integer(_) => Err(self.wrong_type(name)),
        }
    }

    /// This rank's rows of an array of whole numbers.
    ///
    /// # Errors
    /// An array that the checkpoint lacks.
    pub fn integer(&self, name: &str) -> Result<&[i64], FileError> {
        match &self.rows(name)?.values {
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
        let Rows { stored, rows, width, values, .. } = self.rows(name)?;
        let (mut through, mut all) = (0_u64, 0_u64);
        communicator.scan_into(&(count as u64), &mut through, SystemOperation::sum());
        communicator.all_reduce_into(&(count as u64), &mut all, SystemOperation::sum());
        if all != *rows as u64 {
            let problem = format!("`{name}` has {rows} rows, not {all}: it is of another version");
            return Err(FileError::new(&self.path, problem));
        }
        let Values::Real(values) = values else { return Err(self.wrong_type(name)) };
        if communicator.size() == 1 {
            return Ok(values.clone());
        }
        let (first, end) = ((through as usize - count) * width, through as usize * width);
        let read = File::open(&self.path)
            .and_then(|file| stored.read(&file, first..end))
            .map_err(|e| FileError::new(&self.path, format!("`{STATE}/{name}` cannot be read ({e})")));
        let bits = agree(communicator, read)?;
        let own_sum = checksum(first, bits.iter().copied());
        let mut found = 0_u64;
        communicator.all_reduce_into(&own_sum, &mut found, SystemOperation::sum());
        match found == stored.checksum {
            true => Ok(bits.into_iter().map(f64::from_bits).collect()),
            false => Err(FileError::new(&self.path, format!("the checksum of `{STATE}/{name}` is wrong"))),
        }
    }

    /// Whether there is an array of rows of this name.
    pub fn has(&self, name: &str) -> bool {
        self.arrays.iter().any(|rows| rows.stored.name == name)
    }

    /// Whether there is an array on a grid of this name.
    pub fn has_grid(&self, name: &str) -> bool {
        self.grids.iter().any(|grid| grid.stored.name == name)
    }

    /// A block of an array on a grid, `width` values per place, x fastest; any rank may ask for any block.
    ///
    /// It is read from the file again, by this rank alone: let the ranks [`agree`] on the outcome.
    ///
    /// # Errors
    /// An array that the checkpoint lacks or that has another shape, or a file that cannot be read any more.
    pub fn grid(&self, name: &str, width: usize, block: &GridBlock) -> Result<Vec<f64>, FileError> {
        let grid = self.grids.iter().find(|grid| grid.stored.name == name).ok_or_else(|| self.lacks(name))?;
        if (grid.all, grid.width) != (block.all, width) {
            let problem = format!(
                "`{name}` has {:?} places (x, y, z) of {} values, this run {:?} of {width}: it is of another grid",
                grid.all, grid.width, block.all
            );
            return Err(FileError::new(&self.path, problem));
        }
        File::open(&self.path)
            .and_then(|file| grid.values(&file, block))
            .map_err(|e| FileError::new(&self.path, format!("`{GRIDS}/{name}` cannot be read ({e})")))
    }

    fn lacks(&self, name: &str) -> FileError {
        FileError::new(&self.path, format!("lacks the array `{name}`: it is of another version"))
    }

    fn rows(&self, name: &str) -> Result<&Rows, FileError> {
        self.arrays.iter().find(|rows| rows.stored.name == name).ok_or_else(|| self.lacks(name))
    }

    fn wrong_type(&self, name: &str) -> FileError {
        FileError::new(&self.path, format!("`{name}` has values of another type: it is of another version"))
    }
}

/// What no text contains.
const END: &str = "\0";

/// What rank 0 reads with HDF5 and tells the others.
#[derive(Default)]
struct Index {
    /// Names and texts of the metadata, each with [`END`] after it.
    texts: String,
    /// Where the arrays are, a line for each.
    lines: String,
}

impl Index {
    fn read(path: &Path) -> Result<Self, String> {
        let file = hdf5::File::open(path).map_err(|e| format!("HDF5 cannot read it ({e})"))?;
        let mut texts = String::new();
        for name in names(&file, GROUP)? {
            let text =
                read_text(&file, &name).map_err(|e| format!("`{GROUP}/{name}` cannot be read ({e})"))?;
            [&name, &text].into_iter().for_each(|word| texts.extend([word, END]));
        }
        let lines = Stored::all(&file)?.iter().map(|stored| stored.line() + "\n").collect();
        Ok(Self { texts, lines })
    }
}

fn read_text(file: &hdf5::File, name: &str) -> hdf5::Result<String> {
    let dataset = file.dataset(&format!("{GROUP}/{name}"))?;
    let mut bytes = vec![0; dataset.size()];
    read_rows(&dataset, 0, 1, &mut bytes)?;
    let text = String::from_utf8(bytes).ok().filter(|text| !text.contains(END));
    text.ok_or_else(|| "it is no text".into())
}

/// The metadata of texts that were packed.
fn unpack(texts: &str) -> Metadata {
    let words: Vec<&str> = texts.split_terminator(END).collect();
    words.chunks_exact(2).map(|pair| (pair[0].to_string(), pair[1].to_string())).collect()
}

/// A rank's share of all arrays, which lie where the lines say.
fn read_shares(
    path: &Path,
    lines: &str,
    share: (usize, usize),
) -> Result<(Vec<Rows>, Vec<StoredGrid>), String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let (mut arrays, mut grids) = (Vec::new(), Vec::new());
    for stored in lines.lines().filter_map(Stored::of_line) {
        let failed =
            |problem: String| format!("`{}/{}` cannot be read ({problem})", stored.group, stored.name);
        match stored.group == STATE {
            true => arrays.push(Rows::read(&file, &stored, share).map_err(failed)?),
            false => grids.push(StoredGrid::read(&file, &stored, share).map_err(failed)?),
        }
    }
    Ok((arrays, grids))
}

impl Rows {
    fn read(file: &File, stored: &Stored, (rank, size): (usize, usize)) -> Result<Self, String> {
        let (rows, width) = match stored.shape[..] {
            [rows] => (rows, 1),
            [rows, width] => (rows, width),
            _ => return Err("it has neither one nor two dimensions".into()),
        };
        let (first, end) = (rows * rank / size, rows * (rank + 1) / size);
        let bits = stored.read(file, first * width..end * width).map_err(|e| e.to_string())?;
        let values = match stored.is_real {
            true => Values::Real(bits.into_iter().map(f64::from_bits).collect()),
            false => Values::Integer(bits.into_iter().map(u64::cast_signed).collect()),
        };
        Ok(Self { stored: stored.clone(), rows, width, first, values })
    }
}
