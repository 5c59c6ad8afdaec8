//! Geometric multigrid for coefficients that vary: the preconditioner of [`super::ConjugateGradients`].
//!
//! Cells are joined in pairs along the axes on which they are thin, every rank its own. Coarse conductances are
//! those of the fine faces side by side over the coarse distance. A cycle goes down once and up once, with a damped
//! Jacobi step before and after each correction, and with linear interpolation and its transpose: symmetric,
//! positive definite, and the same for any order of the cells. What is left in the end, [`AGGLOMERATED`] cells or one per
//! rank, is agglomerated on all ranks and coarsened further there, down to [`DENSE`] cells that are solved directly.

mod coarse_solve;
mod level;
mod transfer;

use super::PressureProblem;
use super::operator::PressureOperator;
use crate::{CellPartition, Centre, Faces, Field, Grid};
use coarse_solve::{Agglomerated, Dense};
use grains_domain::Transport;
use level::Level;
use transfer::{AxisPair, Transfer, paired, pairing};

/// Cells of all ranks that are few enough to be solved by every rank.
const AGGLOMERATED: usize = 1000;
/// Cells that are solved directly.
const DENSE: usize = 64;

enum CoarseSolve {
    Dense(Dense),
    Agglomerated(Box<Agglomerated>),
}

/// The hierarchy, built once; coefficients are set as often as they change.
pub(crate) struct Multigrid {
    /// From the grid of the equation to the coarsest.
    levels: Vec<Level>,
    /// From each level to the next.
    transfers: Vec<Transfer>,
    coarse_solve: CoarseSolve,
}

impl Multigrid {
    /// Hierarchy for a problem.
    pub fn new(problem: &PressureProblem) -> Self {
        Self::on(&problem.grid, &problem.partition, problem.is_singular(), problem.imposed)
    }

    fn on(grid: &Grid, partition: &CellPartition, is_singular: bool, imposed: [[bool; 2]; 3]) -> Self {
        let mut levels = vec![Level::new(grid.clone(), partition.clone())];
        let mut transfers = Vec::new();
        let least = if partition.size() > 1 { AGGLOMERATED } else { DENSE };
        while let Some((transfer, coarse)) = levels.last().and_then(|level| coarsened(level, least, imposed))
        {
            transfers.push(transfer);
            levels.push(coarse);
        }
        let last = &levels[levels.len() - 1];
        let coarse_solve = if partition.size() > 1 {
            CoarseSolve::Agglomerated(Box::new(Agglomerated::new(last, is_singular, imposed)))
        } else {
            let periodic = [0, 1, 2].map(|a| grid.axis(a).is_periodic());
            CoarseSolve::Dense(Dense::new(last.operator.layout(), periodic, is_singular))
        };
        Self { levels, transfers, coarse_solve }
    }

    fn finest(&self) -> &Level {
        &self.levels[0]
    }

    fn finest_mut(&mut self) -> &mut Level {
        &mut self.levels[0]
    }

    /// The operator of the equation.
    pub fn operator(&self) -> &PressureOperator {
        &self.levels[0].operator
    }

    /// Takes new coefficients; collective.
    pub fn set(&mut self, coefficients: &Faces, transport: &dyn Transport) {
        self.finest_mut().operator.set(coefficients);
        self.refresh(transport);
    }

    /// Carries the conductances of the finest level down to all others; collective.
    fn refresh(&mut self, transport: &dyn Transport) {
        for (l, transfer) in self.transfers.iter().enumerate() {
            let (fine, coarse) = self.levels.split_at_mut(l + 1);
            transfer.coarsen(&fine[l].operator, &mut coarse[0].operator);
        }
        self.levels.iter_mut().for_each(Level::set_weights);
        let last = &self.levels[self.levels.len() - 1];
        match &mut self.coarse_solve {
            CoarseSolve::Dense(dense) => dense.set(last),
            CoarseSolve::Agglomerated(agglomerated) => agglomerated.set(last, transport),
        }
    }

    /// One cycle for −div(c grad p) = `residual`, which is lent to it: `correction` becomes p. Returns the own part of
    /// Σ residual · correction; collective.
    pub fn apply(
        &mut self,
        residual: &mut Field<Centre>,
        correction: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> f64 {
        std::mem::swap(residual, &mut self.levels[0].rhs);
        std::mem::swap(correction, &mut self.levels[0].solution);
        let product = self.cycle(transport);
        std::mem::swap(residual, &mut self.levels[0].rhs);
        std::mem::swap(correction, &mut self.levels[0].solution);
        product
    }

    /// From the right-hand side of the finest level to its solution.
    fn cycle(&mut self, transport: &dyn Transport) -> f64 {
        let Self { levels, transfers, coarse_solve } = self;
        for (l, transfer) in transfers.iter_mut().enumerate() {
            let (fine, coarse) = levels.split_at_mut(l + 1);
            fine[l].restriction_leg(transfer, &mut coarse[0], transport);
        }
        let last = levels.len() - 1;
        match coarse_solve {
            CoarseSolve::Dense(dense) => dense.solve(&mut levels[last]),
            CoarseSolve::Agglomerated(agglomerated) => agglomerated.solve(&mut levels[last], transport),
        }
        let mut product = None;
        for (l, transfer) in transfers.iter_mut().enumerate().rev() {
            let (fine, coarse) = levels.split_at_mut(l + 1);
            product = Some(fine[l].prolongation_leg(transfer, &mut coarse[0], transport));
        }
        product.unwrap_or_else(|| levels[0].rhs.own().zip(levels[0].solution.own()).map(|(r, x)| r * x).sum())
    }
}

/// The next coarser level and the way to it; nothing if there are few cells or none to pair.
fn coarsened(level: &Level, least: usize, imposed: [[bool; 2]; 3]) -> Option<(Transfer, Level)> {
    let (grid, partition) = (&level.grid, &level.partition);
    let counts = [0, 1, 2].map(|a| partition.counts(a));
    let axes = [0, 1, 2].map(|a| grid.axis(a));
    let pairs = pairing(axes, counts.each_ref().map(|c| &c[..]));
    if level.cells() <= least || pairs == [false; 3] {
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
