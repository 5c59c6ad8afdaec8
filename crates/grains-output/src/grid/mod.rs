//! Cartesian grids of cells that ranks share by blocks.

mod arrays;
mod file;
mod read;
mod xdmf;

pub use file::GridFile;
pub use read::GridSnapshotFile;

use crate::collective::Part;
use crate::error::{FileError, agree};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::CommunicatorCollectives;
use std::ops::Range;
use std::path::Path;

/// This rank's block of an array on a Cartesian grid: of cells, or of the faces normal to an axis.
///
/// Values of a block come x fastest, then y, then z, without halo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridBlock {
    /// Places of the whole array along x, y, z.
    pub all: [usize; 3],
    /// First place of the block along x, y, z.
    pub first: [usize; 3],
    /// Places of the block along x, y, z; a rank without any has 0 along some axis.
    pub own: [usize; 3],
}

impl GridBlock {
    /// Number of places of the block.
    pub fn count(&self) -> usize {
        self.own.iter().product()
    }

    /// Where the value of a place of the whole array lies in the block.
    pub fn index(&self, place: [usize; 3]) -> usize {
        let [x, y, z]: [usize; 3] = std::array::from_fn(|a| place[a] - self.first[a]);
        (z * self.own[1] + y) * self.own[0] + x
    }

    /// The part of a dataset `[..before][z][y][x]`, and `[width]` if several values lie at a place.
    pub(crate) fn part(&self, before: &[usize], width: usize) -> Part {
        let list = |before: &mut dyn Iterator<Item = u64>, axes: [usize; 3], last: u64| {
            let axes = axes.into_iter().rev().map(|n| n as u64);
            before.chain(axes).chain((width > 1).then_some(last)).collect()
        };
        let first = list(&mut before.iter().map(|&n| n as u64), self.first, 0);
        Part { first, count: list(&mut before.iter().map(|_| 1), self.own, width as u64) }
    }

    /// Places in the whole array of the rows along x, in the order of the block's values.
    pub(crate) fn rows(&self) -> impl Iterator<Item = usize> {
        let Self { all, first, own } = *self;
        let rows = if own[0] == 0 { 0 } else { own[1] };
        (0..own[2]).flat_map(move |k| {
            (0..rows).map(move |j| ((first[2] + k) * all[1] + first[1] + j) * all[0] + first[0])
        })
    }

    /// Places in the whole array that follow one another in it and in the block: rows along x, layers or all where these are whole.
    pub(crate) fn runs(&self) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        for first in self.rows() {
            match runs.last_mut().filter(|run| run.end == first) {
                Some(run) => run.end += self.own[0],
                None => runs.push(first..first + self.own[0]),
            }
        }
        runs
    }

    /// An even share of an array for a rank: layers of the axis with most places.
    pub(crate) fn share(all: [usize; 3], (rank, size): (usize, usize)) -> Self {
        let axis = (0..3).max_by_key(|&a| all[a]).unwrap_or(0);
        let (mut first, mut own) = ([0; 3], all);
        first[axis] = all[axis] * rank / size;
        own[axis] = all[axis] * (rank + 1) / size - first[axis];
        Self { all, first, own }
    }

    /// Refuses blocks that reach beyond the array, or that together have too few or too many places; all
    /// ranks take part.
    ///
    /// # Errors
    /// The block, or the number of places.
    pub(crate) fn check(
        &self,
        what: &str,
        path: &Path,
        communicator: &SimpleCommunicator,
    ) -> Result<(), FileError> {
        let Self { all, first, own } = self;
        let is_inside = (0..3).all(|a| first[a].checked_add(own[a]).is_some_and(|end| end <= all[a]));
        let inside = if is_inside {
            Ok(())
        } else {
            Err(format!("{what}: the block of {own:?} from {first:?} reaches beyond the grid of {all:?}"))
        };
        agree(communicator, inside.map_err(|problem| FileError::new(path, problem)))?;
        let (mut sum, wanted) = (0_u64, all.iter().product::<usize>() as u64);
        communicator.all_reduce_into(&(self.count() as u64), &mut sum, SystemOperation::sum());
        let tiled = if sum == wanted {
            Ok(())
        } else {
            let problem = format!("{what}: the blocks have {sum} places, the grid of {all:?} has {wanted}");
            Err(FileError::new(path, problem))
        };
        agree(communicator, tiled)
    }
}

/// A Cartesian grid of cells and this rank's block of them.
#[derive(Clone, Debug, PartialEq)]
pub struct GridGeometry {
    /// Coordinates (m) of the nodes along x, y, z: ascending, one more than cells.
    pub nodes: [Vec<f64>; 3],
    /// First own cell along x, y, z.
    pub first: [usize; 3],
    /// Number of own cells along x, y, z.
    pub own: [usize; 3],
}

/// Largest distance of the nodes of equal cells from where they should be (widths of a cell): more than the
/// rounding of nodes far from the origin, and too little to be seen.
const EQUAL: f64 = 1e-9;

impl GridGeometry {
    /// Number of cells along x, y, z.
    pub fn cells(&self) -> [usize; 3] {
        self.nodes.each_ref().map(|nodes| nodes.len().saturating_sub(1))
    }

    /// The own cells.
    pub fn block(&self) -> GridBlock {
        GridBlock { all: self.cells(), first: self.first, own: self.own }
    }

    /// Widths (m) of the cells along x, y, z if those of each axis are equal.
    pub fn spacing(&self) -> Option<[f64; 3]> {
        let mut widths = [0.0; 3];
        for (nodes, width) in self.nodes.iter().zip(&mut widths) {
            let [first, .., last] = nodes[..] else { return None };
            let mean = (last - first) / (nodes.len() - 1) as f64;
            let is_equal = |(k, x): (usize, &f64)| (x - first - mean * k as f64).abs() <= EQUAL * mean;
            if !nodes.iter().enumerate().all(is_equal) {
                return None;
            }
            *width = mean;
        }
        Some(widths)
    }

    /// Whether the nodes are those of another grid, but for rounding.
    pub(crate) fn has_nodes(&self, others: &[Vec<f64>; 3]) -> bool {
        self.nodes.iter().zip(others).all(|(own, other)| {
            let widths = own.windows(2).map(|pair| pair[1] - pair[0]);
            let slack = EQUAL * widths.fold(f64::INFINITY, f64::min);
            own.len() == other.len() && own.iter().zip(other).all(|(a, b)| (a - b).abs() <= slack)
        })
    }

    /// Refuses an axis without cells or with nodes that do not ascend, and blocks that do not make up the
    /// grid; all ranks take part.
    ///
    /// # Errors
    /// The axis, or the blocks.
    pub(crate) fn check(&self, path: &Path, communicator: &SimpleCommunicator) -> Result<(), FileError> {
        let ascends = |nodes: &&Vec<f64>| {
            nodes.len() > 1
                && nodes.windows(2).all(|pair| pair[0] < pair[1] && (pair[1] - pair[0]).is_finite())
        };
        let axes = match self.nodes.iter().zip(["x", "y", "z"]).find(|(nodes, _)| !ascends(nodes)) {
            Some((_, axis)) => Err(format!("the nodes of the grid along {axis} do not ascend")),
            None => Ok(()),
        };
        agree(communicator, axes.map_err(|problem| FileError::new(path, problem)))?;
        self.block().check("fields of cells", path, communicator)
    }
}

#[cfg(test)]
mod tests {
    use super::{GridBlock, GridGeometry};

    #[test]
    fn rows_and_parts_lie_where_c_order_puts_them() {
        let block = GridBlock { all: [5, 4, 3], first: [1, 2, 1], own: [3, 2, 2] };
        assert_eq!(block.rows().collect::<Vec<_>>(), [31, 36, 51, 56]);
        let part = block.part(&[7], 3);
        assert_eq!((part.first, part.count), (vec![7, 1, 2, 1, 0], vec![1, 2, 2, 3, 3]));
        assert_eq!(block.part(&[], 1).count, [2, 2, 3]);
        assert_eq!(GridBlock { own: [0, 2, 2], ..block }.rows().count(), 0);
    }

    #[test]
    fn shares_are_disjoint_layers_of_the_longest_axis() {
        for size in [1, 2, 3, 8, 50] {
            let shares: Vec<GridBlock> =
                (0..size).map(|rank| GridBlock::share([4, 7, 1], (rank, size))).collect();
            let mut rows: Vec<usize> = shares.iter().flat_map(GridBlock::rows).collect();
            rows.sort();
            assert_eq!(rows, (0..7).map(|j| 4 * j).collect::<Vec<_>>());
        }
    }

    #[test]
    fn cells_are_equal_also_far_from_the_origin_but_not_when_stretched() {
        let at = |lower: f64, cells: usize| (0..=cells).map(|k| lower + 1e-3 * k as f64).collect();
        let grid =
            GridGeometry { nodes: [at(0.0, 3), at(1e3, 100), at(-7.0, 1)], first: [0; 3], own: [3, 100, 1] };
        let spacing = grid.spacing();
        assert!(spacing.is_some_and(|h| h.iter().all(|h| (h - 1e-3).abs() < 1e-12)), "{spacing:?}");
        let mut stretched = grid.clone();
        stretched.nodes[1][50] += 1e-8;
        assert_eq!(stretched.spacing(), None);
        assert!(grid.has_nodes(&grid.nodes) && !stretched.has_nodes(&grid.nodes));
    }
}
