//! The grids of a cycle, from that of the equation to the coarsest.

use super::level::Level;
use super::transfer::{AxisPair, Transfer, paired, pairing};
use crate::{CellPartition, Grid};
use grains_domain::Transport;

/// The levels of a multigrid and the transfers between them.
pub(crate) struct Hierarchy {
    /// From the grid of the equation to the coarsest.
    levels: Vec<Level>,
    /// From each level to the next.
    transfers: Vec<Transfer>,
}

impl Hierarchy {
    /// Coarsens a grid until at most `coarsest` cells are left, or none can be paired.
    pub fn new(grid: &Grid, partition: &CellPartition, coarsest: usize, imposed: [[bool; 2]; 3]) -> Self {
        let mut levels = vec![Level::new(grid.clone(), partition.clone())];
        let mut transfers = Vec::new();
        while let Some((transfer, coarse)) =
            levels.last().and_then(|level| coarsened(level, coarsest, imposed))
        {
            transfers.push(transfer);
            levels.push(coarse);
        }
        Self { levels, transfers }
    }

    /// The level of the equation.
    pub fn finest(&self) -> &Level {
        &self.levels[0]
    }

    /// The same, to be changed.
    pub fn finest_mut(&mut self) -> &mut Level {
        &mut self.levels[0]
    }

    /// The last level.
    pub fn coarsest(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// Carries the conductances of the finest level down to all others.
    pub fn refresh(&mut self) {
        for (l, transfer) in self.transfers.iter().enumerate() {
            let (fine, coarse) = self.levels.split_at_mut(l + 1);
            transfer.coarsen(&fine[l].operator, &mut coarse[0].operator);
        }
        self.levels.iter_mut().for_each(Level::set_weights);
    }

    /// A V-cycle from the right-hand side of the finest level to its solution, with `solve` on the coarsest; returns the own
    /// part of Σ rhs · solution. Collective.
    pub fn cycle(&mut self, transport: &dyn Transport, solve: impl FnOnce(&mut Level)) -> f64 {
        let Self { levels, transfers } = self;
        for (l, transfer) in transfers.iter_mut().enumerate() {
            let (fine, coarse) = levels.split_at_mut(l + 1);
            fine[l].restriction_leg(transfer, &mut coarse[0], transport);
        }
        let last = levels.len() - 1;
        solve(&mut levels[last]);
        let mut product = None;
        for (l, transfer) in transfers.iter_mut().enumerate().rev() {
            let (fine, coarse) = levels.split_at_mut(l + 1);
            product = Some(fine[l].prolongation_leg(transfer, &mut coarse[0], transport));
        }
        product.unwrap_or_else(|| levels[0].rhs.own().zip(levels[0].solution.own()).map(|(r, x)| r * x).sum())
    }
}

/// The next coarser level and the way to it; nothing if there are few cells or none to pair.
fn coarsened(level: &Level, coarsest: usize, imposed: [[bool; 2]; 3]) -> Option<(Transfer, Level)> {
    let (grid, partition) = (&level.grid, &level.partition);
    let counts = [0, 1, 2].map(|a| partition.counts(a));
    let axes = [0, 1, 2].map(|a| grid.axis(a));
    let pairs = pairing(axes, counts.each_ref().map(|c| &c[..]));
    if level.cells() <= coarsest || pairs == [false; 3] {
        return None;
    }
    let mut coarse_partition = partition.clone();
    let coarse_axes = [0, 1, 2].map(|a| {
        if !pairs[a] {
            return axes[a].clone();
        }
        let (axis, starts) = paired(axes[a], &partition.starts[a]);
        coarse_partition.starts[a] = starts;
        axis
    });
    let own = |o: &CellPartition, a: usize| [o.first()[a], o.cells()[a]];
    let transfer = Transfer::new([0, 1, 2].map(|a| AxisPair {
        fine: axes[a],
        coarse: &coarse_axes[a],
        fine_own: own(partition, a),
        coarse_own: own(&coarse_partition, a),
        imposed: imposed[a],
    }));
    // Nodes of the fine grid, so the coarse ones ascend too.
    let coarse_grid = Grid::new(coarse_axes).ok()?;
    Some((transfer, Level::new(coarse_grid, coarse_partition)))
}
