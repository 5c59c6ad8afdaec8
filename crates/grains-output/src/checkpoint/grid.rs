//! Arrays on Cartesian grids in a checkpoint: ranks write blocks and may read others.

use super::checksum;
use super::dataset::{FAILED, create_checked};
use super::layout::Stored;
use crate::error::{FileError, Shared};
use crate::grid::GridBlock;
use crate::growing::unit;
use hdf5::Group;
use mpi::collective::SystemOperation;
use mpi::traits::CommunicatorCollectives;
use std::fs::File;
use std::io;

/// An array on a Cartesian grid, of cells or of the faces normal to an axis: each rank a block of it.
///
/// The file holds it as `[z][y][x]` or `[z][y][x][width]`, however many ranks write it.
#[derive(Clone, Debug, PartialEq)]
pub struct GridArray {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Values per place.
    pub width: usize,
    /// This rank's block; those of all ranks make up the array, none overlap.
    pub block: GridBlock,
    /// Values of the block, x fastest, without halo.
    pub values: Vec<f64>,
}

/// An array of a checkpoint that was read for its checksum.
#[derive(Clone, Debug)]
pub(super) struct StoredGrid {
    pub stored: Stored,
    /// Places along x, y, z.
    pub all: [usize; 3],
    /// Values per place.
    pub width: usize,
    /// This rank's part of the checksum.
    pub own: u64,
}

/// Shape of the dataset of an array.
fn shape([x, y, z]: [usize; 3], width: usize) -> Vec<usize> {
    [z, y, x].into_iter().chain((width > 1).then_some(width)).collect()
}

/// This rank's part of the checksum, by the places of the values in the whole array.
fn checksum_of_block(block: &GridBlock, width: usize, bits: impl Iterator<Item = u64>) -> u64 {
    let (row, mut bits) = (block.own[0] * width, bits);
    block.rows().fold(0_u64, |sum, first| sum.wrapping_add(checksum(first * width, bits.by_ref().take(row))))
}

/// Writes an array; all ranks take part.
pub(super) fn write_grid(shared: &Shared, group: &Group, array: &GridArray) -> Result<(), FileError> {
    let GridArray { name, block, values, .. } = array;
    let (communicator, width) = (&shared.communicator, array.width.max(1));
    block.check(name, &shared.path, communicator)?;
    let wanted = block.count() * width;
    shared.agree(if values.len() == wanted {
        Ok(())
    } else {
        Err(format!("`{name}` has {} values, its block {wanted}", values.len()))
    })?;
    let mut sum = 0_u64;
    let own = checksum_of_block(block, width, values.iter().map(|x| x.to_bits()));
    communicator.all_reduce_into(&own, &mut sum, SystemOperation::sum());
    let shape = shape(block.all, width);
    let dataset = shared.written_or(FAILED, create_checked::<f64>(group, name, &shape, sum))?;
    shared.written_or(FAILED, unit(&dataset, array.unit))?;
    shared.written_or(FAILED, shared.write_block(&dataset, &block.part(&[], width), values))
}

impl StoredGrid {
    /// Reads a rank's even share of an array for the checksum; only this rank takes part.
    pub fn read(file: &File, stored: &Stored, share: (usize, usize)) -> Result<Self, String> {
        let (all, width) = match stored.shape[..] {
            [z, y, x] => ([x, y, z], 1),
            [z, y, x, width] => ([x, y, z], width),
            _ => return Err("it has neither three nor four dimensions".into()),
        };
        let mut grid = Self { stored: stored.clone(), all, width, own: 0 };
        let block = GridBlock::share(all, share);
        let bits = grid.bits(file, &block).map_err(|e| e.to_string())?;
        grid.own = checksum_of_block(&block, width, bits.into_iter());
        Ok(grid)
    }

    /// Values of a block, read by this rank alone.
    pub fn values(&self, file: &File, block: &GridBlock) -> io::Result<Vec<f64>> {
        Ok(self.bits(file, block)?.into_iter().map(f64::from_bits).collect())
    }

    fn bits(&self, file: &File, block: &GridBlock) -> io::Result<Vec<u64>> {
        let mut bits = Vec::with_capacity(block.count() * self.width);
        for run in block.runs() {
            bits.extend(self.stored.read(file, run.start * self.width..run.end * self.width)?);
        }
        Ok(bits)
    }
}

#[cfg(test)]
mod tests {
    use super::{GridBlock, checksum, checksum_of_block};

    #[test]
    fn the_checksum_of_a_grid_does_not_depend_on_its_blocks() {
        let all = [5, 4, 3];
        let value = |place: usize| (place as f64).sqrt();
        let of = |block: &GridBlock, width| {
            let places = block.rows().flat_map(|row| row * width..(row + block.own[0]) * width);
            checksum_of_block(block, width, places.map(|place| value(place).to_bits()))
        };
        for width in [1, 3] {
            let whole = checksum(0, (0..60 * width).map(|place| value(place).to_bits()));
            let mut sum = 0_u64;
            for (x, nx) in [(0, 2), (2, 3)] {
                for (y, ny) in [(0, 3), (3, 0), (3, 1)] {
                    for (z, nz) in [(0, 1), (1, 2)] {
                        sum = sum
                            .wrapping_add(of(&GridBlock { all, first: [x, y, z], own: [nx, ny, nz] }, width));
                    }
                }
            }
            assert_eq!(sum, whole);
        }
    }
}
