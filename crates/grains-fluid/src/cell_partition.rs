//! Partition of the cells: which rank owns which, by the decomposition of the particles.

use crate::grid::AXES;
use crate::{Grid, SetupError};
use grains_domain::Decomposition;

/// Ranges of cells per rank and axis, and the own place among the ranks (x fastest).
#[derive(Clone, Debug, PartialEq)]
pub struct CellPartition {
    /// Ranks per axis.
    pub ranks: [usize; 3],
    /// Own place in the grid of ranks.
    pub coordinates: [usize; 3],
    /// First cell of every subdomain per axis, and the number of cells at the end: ranks + 1 numbers.
    pub starts: [Vec<usize>; 3],
}

impl CellPartition {
    /// All cells on one rank.
    pub fn serial(grid: &Grid) -> Self {
        Self { ranks: [1; 3], coordinates: [0; 3], starts: grid.cells().map(|n| vec![0, n]) }
    }

    /// A rank owns the cells whose centres lie in its subdomain.
    pub fn new(grid: &Grid, decomposition: &Decomposition) -> Result<Self, SetupError> {
        let global = &decomposition.global;
        let mut starts: [Vec<usize>; 3] = Default::default();
        for a in 0..3 {
            let (axis, n) = (grid.axis(a), grid.axis(a).cells());
            let ends = [axis.nodes()[0], axis.nodes()[n]];
            let slack = 1e-9 * global.length(a);
            let same_ends =
                (ends[0] - global.lower[a]).abs() < slack && (ends[1] - global.upper[a]).abs() < slack;
            if !same_ends || axis.is_periodic() != global.periodic[a] {
                let domain = [global.lower[a], global.upper[a]];
                return Err(SetupError::OtherBox { axis: AXES[a], grid: ends, domain });
            }
            let cuts = &decomposition.cuts[a];
            let inner = &cuts[1..cuts.len() - 1];
            starts[a].push(0);
            // Centres ascend: the first at or beyond a cut begins the next subdomain.
            let mut cell = 0;
            for &cut in inner {
                while cell < n && axis.centre(cell as isize) < cut {
                    cell += 1;
                }
                starts[a].push(cell);
            }
            starts[a].push(n);
        }
        Ok(Self { ranks: decomposition.ranks, coordinates: decomposition.coordinates, starts })
    }

    /// Cells of every subdomain along an axis: what PETSc's DMDA takes as lx, ly or lz.
    pub fn counts(&self, axis: usize) -> Vec<usize> {
        self.starts[axis].windows(2).map(|w| w[1] - w[0]).collect()
    }

    /// Own cells per axis.
    pub fn cells(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.starts[a][self.coordinates[a] + 1] - self.starts[a][self.coordinates[a]])
    }

    /// First own cell per axis.
    pub fn first(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.starts[a][self.coordinates[a]])
    }

    /// Number of ranks.
    pub fn size(&self) -> usize {
        self.ranks.iter().product()
    }

    /// Whether several ranks share an axis.
    pub fn is_split(&self, axis: usize) -> bool {
        self.ranks[axis] > 1
    }

    /// Rank at a place in the grid of ranks.
    pub fn rank_at(&self, place: [usize; 3]) -> usize {
        (place[2] * self.ranks[1] + place[1]) * self.ranks[0] + place[0]
    }

    /// Place of a rank in the grid of ranks.
    pub fn place_of(&self, rank: usize) -> [usize; 3] {
        let [nx, ny, _] = self.ranks;
        [rank % nx, rank / nx % ny, rank / (nx * ny)]
    }

    /// Ranks of the own row along an axis, in order.
    pub fn row(&self, axis: usize) -> Vec<usize> {
        let mut place = self.coordinates;
        (0..self.ranks[axis])
            .map(|c| {
                place[axis] = c;
                self.rank_at(place)
            })
            .collect()
    }

    /// Ranks below and above along an axis, which may be the own one; none beyond an end that is not periodic.
    pub fn neighbours(&self, axis: usize, periodic: bool) -> [Option<usize>; 2] {
        let (row, at) = (self.row(axis), self.coordinates[axis]);
        let last = row.len() - 1;
        let low = if at > 0 { Some(row[at - 1]) } else { periodic.then_some(row[last]) };
        let high = if at < last { Some(row[at + 1]) } else { periodic.then_some(row[0]) };
        [low, high]
    }

    /// Whether the own subdomain touches the lower and upper face of the box along an axis.
    pub fn touches(&self, axis: usize) -> [bool; 2] {
        [self.coordinates[axis] == 0, self.coordinates[axis] + 1 == self.ranks[axis]]
    }

    /// Every subdomain must be as wide as the halo where its axis is shared.
    pub fn check(&self, halo: usize) -> Result<(), SetupError> {
        if halo < 2 {
            return Err(SetupError::NarrowHalo { halo });
        }
        for (a, axis) in AXES.into_iter().enumerate().filter(|&(a, _)| self.is_split(a)) {
            if let Some((column, &cells)) = self.counts(a).iter().enumerate().find(|&(_, &n)| n < halo) {
                return Err(SetupError::TooFewCells { axis, column, cells, halo });
            }
        }
        Ok(())
    }
}
