//! Checkpoints: complete, checksummed, written aside and renamed.
//!
//! ```text
//! first 512 bytes      text: format, number of bytes and checksum of all that follows (HDF5's user block)
//! /grains-mpi/<name>   texts as bytes (UTF-8)
//! /state/<name>        arrays of f64 or i64, [rows] or [rows][width], attributes `checksum` and `unit`
//! /grids/<name>        arrays of f64, [z][y][x] or [z][y][x][width], with the same attributes; if there are any
//! ```
//!
//! The checksum of an array is the sum over its values of a hash of (place, bits) modulo 2⁶⁴: ranks add up
//! theirs, and the way the rows or blocks lie on ranks does not matter. It is of the values in memory: what goes wrong on the way
//! to the file is told as well.

mod dataset;
mod folder;
mod grid;
mod layout;
mod read;
mod seal;
mod write;

pub use folder::{abandon_later, checkpoints, latest_valid, remove_old};
pub use grid::GridArray;
pub use read::CheckpointFile;
pub use write::write_checkpoint;

/// Version of the layout above and of the arrays in it; a reader refuses others.
const FORMAT: u32 = 3;
const STATE: &str = "state";
const GRIDS: &str = "grids";

/// Values of an array on this rank.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floating point.
    Real(Vec<f64>),
    /// Whole numbers.
    Integer(Vec<i64>),
}

/// A distributed array: each rank its rows.
///
/// An array that is the same on all ranks has its rows on rank 0 and none elsewhere; a number is such an
/// array of one row.
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

    /// This rank's part of the checksum; `first` is the place of the first value in the whole array.
    fn checksum(&self, first: usize) -> u64 {
        match self {
            Values::Real(v) => checksum(first, v.iter().map(|x| x.to_bits())),
            Values::Integer(v) => checksum(first, v.iter().map(|&x| x as u64)),
        }
    }
}

/// Sum of hashes of (place, bits): it does not depend on which rank holds which rows.
pub(crate) fn checksum(first: usize, bits: impl Iterator<Item = u64>) -> u64 {
    bits.enumerate().fold(0_u64, |sum, (k, bits)| {
        // The finaliser of SplitMix64 (Steele, Lea & Flood 2014): every bit of the input moves every bit.
        let x = ((first + k) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ bits.rotate_left(17);
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        sum.wrapping_add(x ^ (x >> 31))
    })
}

/// Checksum of the content of a file or of a text.
pub fn checksum_of_bytes(bytes: &[u8]) -> u64 {
    checksum(bytes.len(), bytes.iter().map(|&byte| u64::from(byte)))
}

#[cfg(test)]
mod tests {
    use super::Values;

    #[test]
    fn the_checksum_depends_on_order_and_bits_but_not_on_the_distribution() {
        let values: Vec<f64> = (0..100).map(|k| (k as f64).sin()).collect();
        let whole = Values::Real(values.clone()).checksum(0);
        let parts =
            [0..33, 33..34, 34..100].map(|r| Values::Real(values[r.clone()].to_vec()).checksum(r.start));
        assert_eq!(whole, parts.into_iter().fold(0, u64::wrapping_add));
        let mut swapped = values.clone();
        swapped.swap(3, 4);
        assert_ne!(whole, Values::Real(swapped).checksum(0));
        let mut changed = values;
        changed[50] = f64::from_bits(changed[50].to_bits() ^ 1);
        assert_ne!(whole, Values::Real(changed).checksum(0));
        assert_ne!(Values::Real(vec![0.0]).checksum(0), Values::Real(vec![-0.0]).checksum(0));
    }
}
