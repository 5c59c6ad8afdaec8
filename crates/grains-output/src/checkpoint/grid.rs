//! Arrays on Cartesian grids in a checkpoint: ranks write blocks and may read others.

use super::dataset::{FAILED, create_checked};
use super::{GRIDS, checksum};
use crate::collective::{Participants, read_part, write_part};
use crate::error::{FileError, Shared};
use crate::grid::GridBlock;
use crate::growing::unit;
use hdf5::{Dataset, File, Group};
use mpi::collective::SystemOperation;
use mpi::traits::{Communicator, CommunicatorCollectives};

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
    pub name: String,
    /// Places along x, y, z.
    pub all: [usize; 3],
    pub width: usize,
    pub expected: u64,
    /// This rank's part of the checksum.
    pub own: u64,
}

/// Shape of the dataset of an array.
fn shape([x, y, z]: [usize; 3], width: usize) -> Vec<usize> {
    [z, y, x].into_iter().chain((width > 1).then_some(width)).collect()
}

/// This rank's part of the checksum, by the places of the values in the whole array.
fn checksum_of_block(block: &GridBlock, width: usize, values: &[f64]) -> u64 {
    let rows = values.chunks((block.own[0] * width).max(1));
    block.rows().zip(rows).fold(0_u64, |sum, (first, row)| {
        sum.wrapping_add(checksum(first * width, row.iter().map(|x| x.to_bits())))
    })
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
    let own = checksum_of_block(block, width, values);
    communicator.all_reduce_into(&own, &mut sum, SystemOperation::sum());
    let shape = shape(block.all, width);
    let dataset = shared.written_or(FAILED, create_checked::<f64>(group, name, &shape, sum))?;
    shared.written_or(FAILED, unit(&dataset, array.unit))?;
    let who = Participants::writing(communicator.size(), false);
    shared.written_or(FAILED, write_part(&dataset, &block.part(&[], width), values, who))
}

/// Reads a rank's even share of an array for the checksum; only this rank takes part.
pub(super) fn read_checksum(file: &File, name: &str, share: (usize, usize)) -> hdf5::Result<StoredGrid> {
    let dataset = file.dataset(&format!("{GRIDS}/{name}"))?;
    let expected = dataset.attr("checksum")?.read_scalar::<u64>()?;
    let (all, width) = match dataset.shape()[..] {
        [z, y, x] => ([x, y, z], 1),
        [z, y, x, width] => ([x, y, z], width),
        _ => return Err("it has neither three nor four dimensions".into()),
    };
    let block = GridBlock::share(all, share);
    let own = checksum_of_block(&block, width, &read_values(&dataset, &block, width)?);
    Ok(StoredGrid { name: name.to_string(), all, width, expected, own })
}

/// Reads a block of an array; only this rank takes part.
pub(super) fn read_block(file: &File, name: &str, block: &GridBlock, width: usize) -> hdf5::Result<Vec<f64>> {
    read_values(&file.dataset(&format!("{GRIDS}/{name}"))?, block, width)
}

fn read_values(dataset: &Dataset, block: &GridBlock, width: usize) -> hdf5::Result<Vec<f64>> {
    let mut values = vec![0.0; block.count() * width];
    read_part(dataset, &block.part(&[], width), &mut values)?;
    Ok(values)
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
            checksum_of_block(block, width, &places.map(value).collect::<Vec<_>>())
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
