//! Checksums of the steps of a file of snapshots.
//!
//! ```text
//! /checksums   [steps][1 + arrays]: of where and when the step is, then of each array
//!              attributes `arrays`: their names; `texts`: checksum of the metadata
//! ```
//!
//! The checksum of an array is that of a checkpoint over the values as stored: ranks add up theirs. A file of a
//! version that wrote none is read without.

use crate::checkpoint::{checksum, checksum_of_bytes};
use crate::collective::{Participants, read_rows, write_rows};
use crate::fields::{Data, Precision};
use crate::growing::{STEPS_PER_CHUNK, grow, resize};
use crate::metadata::{Metadata, text, utf8};
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File};

const NAME: &str = "checksums";

/// The open dataset of a file that is written.
pub(crate) struct Digests(Dataset);

impl Digests {
    /// Begins the checksums of a new file; all ranks take part.
    pub fn create(file: &File, arrays: &[String], metadata: &Metadata) -> hdf5::Result<Self> {
        let width = 1 + arrays.len();
        let dataset = grow::<u64>(file, NAME, &[width], &[STEPS_PER_CHUNK, width], false)?;
        dataset.new_attr::<VarLenUnicode>().create("arrays")?.write_scalar(&text(&arrays.join(","))?)?;
        dataset.new_attr::<u64>().create("texts")?.write_scalar(&of_texts(metadata))?;
        Ok(Self(dataset))
    }

    /// Those of a file that is continued, if it has any.
    pub fn open(file: &File) -> hdf5::Result<Option<Self>> {
        if file.link_exists(NAME) { Ok(Some(Self(file.dataset(NAME)?))) } else { Ok(None) }
    }

    /// Makes room for a number of steps; all ranks take part.
    pub fn resize(&self, steps: usize) -> hdf5::Result<()> {
        resize(&self.0, steps)
    }

    /// Writes those of a step; rank 0 alone does.
    pub fn write(&self, step: usize, row: &[u64]) -> hdf5::Result<()> {
        write_rows(&self.0, step, row.len(), row, Participants::ThisRank)
    }
}

/// The checksums of a file that is read; those of its steps, metadata and names were right when it was opened.
pub(crate) struct Stored {
    arrays: Vec<String>,
    rows: Vec<u64>,
}

impl Stored {
    /// Reads and compares what is no array: the names of the fields, the metadata, and `places`, a checksum per step.
    ///
    /// # Errors
    /// What differs.
    pub fn read(
        file: &File,
        fields: &[String],
        metadata: &Metadata,
        places: &[u64],
    ) -> hdf5::Result<Option<Self>> {
        if !file.link_exists(NAME) {
            return Ok(None);
        }
        let dataset = file.dataset(NAME)?;
        let names = dataset.attr("arrays")?.read_scalar::<VarLenUnicode>()?;
        let names = utf8(names.as_bytes())?;
        let arrays: Vec<String> = names.split(',').map(String::from).collect();
        if fields.iter().any(|field| !arrays.contains(field)) || fields.len() > arrays.len() {
            return Err(wrong("the names of the fields"));
        }
        // Points are an array, but no field.
        let is_stored = |array: &&String| *array == "Points" || fields.contains(array);
        if arrays.iter().filter(is_stored).count() != arrays.len() {
            return Err(wrong("the names of the fields"));
        }
        if dataset.attr("texts")?.read_scalar::<u64>()? != of_texts(metadata) {
            return Err(wrong("the metadata"));
        }
        let width = 1 + arrays.len();
        if dataset.ndim() != 2 || dataset.shape()[1] != width || dataset.shape()[0] < places.len() {
            return Err("it has fewer checksums than steps".into());
        }
        // A crash may leave room for a step without one; a step that is whole must not be overlooked.
        if dataset.shape()[0] > places.len() + 1 {
            return Err(wrong("the number of steps"));
        }
        let mut rows = vec![0_u64; places.len() * width];
        read_rows(&dataset, 0, width, &mut rows)?;
        match places.iter().zip(rows.chunks(width)).position(|(place, row)| *place != row[0]) {
            Some(step) => Err(wrong(&format!("time and size of step {step}"))),
            None => Ok(Some(Self { arrays, rows })),
        }
    }

    /// Compares the checksum of an array of a step with the one found.
    ///
    /// # Errors
    /// Another.
    pub fn compare(&self, step: usize, array: &str, found: u64) -> hdf5::Result<()> {
        let column = self.arrays.iter().position(|name| name == array);
        match column.and_then(|k| self.rows.get(step * (1 + self.arrays.len()) + 1 + k)) {
            Some(expected) if *expected == found => Ok(()),
            _ => Err(wrong(&format!("`{array}` of step {step}"))),
        }
    }
}

fn wrong(what: &str) -> hdf5::Error {
    format!("the checksum of {what} is wrong").as_str().into()
}

fn of_texts(metadata: &Metadata) -> u64 {
    let line = |(name, value): &(String, String)| format!("{name}\0{}\0", value.replace('\0', " "));
    let mut lines: Vec<String> = metadata.iter().map(line).collect();
    lines.sort();
    checksum_of_bytes(lines.concat().as_bytes())
}

/// Of real numbers as stored, from place `first` on.
pub(crate) fn of_reals(first: usize, values: &[f64], precision: Precision) -> u64 {
    match precision {
        Precision::F64 => checksum(first, values.iter().map(|&x| bits(x))),
        Precision::F32 => checksum(first, values.iter().map(|&x| bits(f64::from(x as f32)))),
    }
}

/// Of whole numbers from place `first` on.
pub(crate) fn of_integers(first: usize, values: &[i64]) -> u64 {
    checksum(first, values.iter().map(|&k| k as u64))
}

/// Of this rank's values of an array as stored, from place `first` on.
pub(crate) fn of_data(first: usize, data: &Data, precision: Precision) -> u64 {
    match data {
        Data::Real(values) => of_reals(first, values, precision),
        Data::Integer(values) => of_integers(first, values),
    }
}

/// What is no number has many forms, which conversions change.
fn bits(x: f64) -> u64 {
    if x.is_nan() { u64::MAX } else { x.to_bits() }
}

/// A number type of an array that is read.
pub(crate) trait Digested: hdf5::H5Type + Default + Clone {
    /// Checksum of values from place `first` on.
    fn digest(first: usize, values: &[Self]) -> u64;
}

impl Digested for f64 {
    fn digest(first: usize, values: &[Self]) -> u64 {
        of_reals(first, values, Precision::F64)
    }
}

impl Digested for i64 {
    fn digest(first: usize, values: &[Self]) -> u64 {
        of_integers(first, values)
    }
}
