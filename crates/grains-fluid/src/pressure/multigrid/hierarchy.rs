//! The grids of a cycle, from that of the equation to the coarsest.

use super::agglomerated::Agglomerated;
use super::dense::{Dense, SOLVED_DIRECTLY};
use super::leaders::{Leaders, grouping};
use super::level::Level;
use super::transfer::{AxisPair, Transfer, paired, pairing};
use crate::{CellPartition, Grid};
use grains_domain::Transport;

/// The levels of a multigrid and the transfers between them.
pub(crate) struct Hierarchy {
    /// From the grid of the equation to the last that these ranks have.
    levels: Vec<Level>,
    /// From each level to the next.
    transfers: Vec<Transfer>,
    coarse_solve: CoarseSolve,
}

/// How the last level is solved.
enum CoarseSolve {
    Dense(Dense),
    Agglomerated(Box<Agglomerated>),
}

impl Hierarchy {
    /// Coarsens a grid whose cells `leaders` have, until few enough cells are left for fewer ranks, or for a direct solution.
    pub fn new(
        grid: &Grid,
        partition: &CellPartition,
        leaders: Leaders,
        is_singular: bool,
        imposed: [[bool; 2]; 3],
    ) -> Self {
        let mut level = Level::new(grid.clone(), partition.clone(), leaders);
        let (mut levels, mut transfers) = (Vec::new(), Vec::new());
        let coarse_solve = loop {
            let group = grouping(&level);
            if group != [1; 3] {
                let agglomerated = Agglomerated::new(&level, leaders, group, is_singular, imposed);
                break CoarseSolve::Agglomerated(Box::new(agglomerated));
            }
            let Some((transfer, coarse)) = coarsened(&level, leaders, imposed) else {
                break CoarseSolve::Dense(Dense::new(&level, is_singular));
            };
            transfers.push(transfer);
            levels.push(std::mem::replace(&mut level, coarse));
        };
        levels.push(level);
        Self { levels, transfers, coarse_solve }
    }

    /// The level of the equation.
    pub fn finest(&self) -> &Level {
        &self.levels[0]
    }

    /// The same, to be changed.
    pub fn finest_mut(&mut self) -> &mut Level {
        &mut self.levels[0]
    }

    /// Carries the conductances of the finest level down to all others; collective.
    pub fn refresh(&mut self, transport: &dyn Transport) {
        for (l, transfer) in self.transfers.iter().enumerate() {
            let (fine, coarse) = self.levels.split_at_mut(l + 1);
            transfer.coarsen(&fine[l].operator, &mut coarse[0].operator);
        }
        self.levels.iter_mut().for_each(Level::set_weights);
        let last = &self.levels[self.transfers.len()];
        match &mut self.coarse_solve {
            CoarseSolve::Dense(dense) => dense.set(last),
            CoarseSolve::Agglomerated(agglomerated) => agglomerated.set(last, transport),
        }
    }

    /// A V-cycle from the right-hand side of the finest level to its solution; returns the own part of Σ rhs · solution.
    /// Collective.
    pub fn cycle(&mut self, transport: &dyn Transport) -> f64 {
        let Self { levels, transfers, coarse_solve } = self;
        for (l, transfer) in transfers.iter_mut().enumerate() {
            let (fine, coarse) = levels.split_at_mut(l + 1);
            fine[l].restriction_leg(transfer, &mut coarse[0], transport);
        }
        let last = &mut levels[transfers.len()];
        match coarse_solve {
            CoarseSolve::Dense(dense) => dense.solve(last),
            CoarseSolve::Agglomerated(agglomerated) => agglomerated.solve(last, transport),
        }
        let mut product = None;
        for (l, transfer) in transfers.iter_mut().enumerate().rev() {
            let (fine, coarse) = levels.split_at_mut(l + 1);
            product = Some(fine[l].prolongation_leg(transfer, &mut coarse[0], transport));
        }
        product.unwrap_or_else(|| {
            let pairs = levels[0].rhs.own().zip(levels[0].solution.own());
            pairs.map(|(r, x)| f64::from(r) * f64::from(x)).sum()
        })
    }
}

/// The next coarser level and the way to it; nothing if there are few cells or none to pair.
fn coarsened(level: &Level, leaders: Leaders, imposed: [[bool; 2]; 3]) -> Option<(Transfer, Level)> {
    let (grid, partition) = (&level.grid, &level.partition);
    let counts = [0, 1, 2].map(|a| partition.counts(a));
    let axes = [0, 1, 2].map(|a| grid.axis(a));
    let pairs = pairing(axes, counts.each_ref().map(|c| &c[..]));
    if level.cells() <= SOLVED_DIRECTLY || pairs == [false; 3] {
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
    Some((transfer, Level::new(coarse_grid, coarse_partition, leaders)))
}
