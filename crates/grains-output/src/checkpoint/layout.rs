//! Where the arrays of a checkpoint lie in its file.
//!
//! Rank 0 asks HDF5 and tells the others. Each rank then reads its parts of them as plain bytes: were thousands of ranks to open the file
//! with HDF5, each would look through its structures.

use super::{GRIDS, STATE};
use hdf5::File;
use hdf5::datatype::ByteOrder;
use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;

/// Bytes of a value.
const VALUE: usize = 8;
/// Values read at once.
const BUFFER: usize = 1 << 17;

#[cfg(target_endian = "little")]
const NATIVE: ByteOrder = ByteOrder::LittleEndian;
#[cfg(target_endian = "big")]
const NATIVE: ByteOrder = ByteOrder::BigEndian;

/// An array of a checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stored {
    pub group: String,
    pub name: String,
    pub is_real: bool,
    /// Checksum of all values.
    pub checksum: u64,
    /// Byte of the file at which the values begin.
    first_byte: u64,
    /// Values along each dimension.
    pub shape: Vec<usize>,
}

impl Stored {
    /// All arrays of a file.
    pub fn all(file: &File) -> Result<Vec<Self>, String> {
        let mut all = Vec::new();
        for group in [STATE, GRIDS].into_iter().filter(|&group| group == STATE || file.link_exists(group)) {
            for name in names(file, group)? {
                let found = Self::find(file, group, &name);
                all.push(found.map_err(|e| format!("`{group}/{name}` cannot be read ({e})"))?);
            }
        }
        Ok(all)
    }

    fn find(file: &File, group: &str, name: &str) -> hdf5::Result<Self> {
        if name.contains(char::is_whitespace) {
            return Err("it is of another program".into());
        }
        let dataset = file.dataset(&format!("{group}/{name}"))?;
        let kind = dataset.dtype()?;
        let is_real = match kind.to_descriptor()? {
            TypeDescriptor::Float(FloatSize::U8) => true,
            TypeDescriptor::Integer(IntSize::U8) => false,
            _ => return Err("its values are neither f64 nor i64".into()),
        };
        if kind.byte_order() != NATIVE {
            return Err("it was written on a machine with another order of bytes".into());
        }
        let shape = dataset.shape();
        let first_byte = match (dataset.offset(), dataset.size()) {
            (Some(offset), _) => offset,
            (None, 0) => 0,
            (None, _) => return Err("it does not lie in one piece".into()),
        };
        let values = shape.iter().try_fold(1_u64, |product, &n| product.checked_mul(n as u64));
        let end = values.and_then(|n| n.checked_mul(VALUE as u64)?.checked_add(first_byte));
        if end.is_none_or(|end| end > file.size()) {
            return Err("it has more values than the file".into());
        }
        let checksum = dataset.attr("checksum")?.read_scalar::<u64>()?;
        Ok(Self { group: group.into(), name: name.into(), is_real, checksum, first_byte, shape })
    }

    /// A line that tells other ranks.
    pub fn line(&self) -> String {
        let Self { group, name, is_real, checksum, first_byte, shape } = self;
        let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
        format!("{group} {name} {is_real} {checksum} {first_byte} {}", shape.join(" "))
    }

    /// What a line tells.
    pub fn of_line(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        let mut next = || words.next();
        let (group, name) = (next()?.into(), next()?.into());
        let (is_real, checksum, first_byte) =
            (next()?.parse().ok()?, next()?.parse().ok()?, next()?.parse().ok()?);
        let shape = words.map(|word| word.parse().ok()).collect::<Option<_>>()?;
        Some(Self { group, name, is_real, checksum, first_byte, shape })
    }

    /// Reads values from the file; only this rank takes part.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn read(&self, file: &std::fs::File, values: Range<usize>) -> io::Result<Vec<u64>> {
        let mut found = Vec::with_capacity(values.len());
        let mut bytes = vec![0; VALUE * BUFFER.min(values.len())];
        for first in values.clone().step_by(BUFFER) {
            let bytes = &mut bytes[..VALUE * BUFFER.min(values.end - first)];
            file.read_exact_at(bytes, self.first_byte + (VALUE * first) as u64)?;
            let (words, _) = bytes.as_chunks::<VALUE>();
            found.extend(words.iter().map(|word| u64::from_ne_bytes(*word)));
        }
        Ok(found)
    }
}

/// Names in a group, in the order of the alphabet.
pub(super) fn names(file: &File, group: &str) -> Result<Vec<String>, String> {
    let names = file.group(group).and_then(|group| group.member_names());
    let mut names = names.map_err(|e| format!("the group `{group}` cannot be read ({e})"))?;
    names.sort();
    Ok(names)
}
