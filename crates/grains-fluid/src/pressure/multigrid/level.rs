//! One grid of the hierarchy: its operator, its fields and the smoother.

use super::leaders::Leaders;
use super::transfer::Transfer;
use crate::pressure::operator::{PressureOperator, dot};
use crate::{CellPartition, Centre, Field, Grid, Halo};
use grains_domain::Transport;

/// Damping of the Jacobi steps.
const DAMPING: f64 = 0.85;

/// A grid with the fields of a cycle, all with a halo of one cell that is zero beyond the box.
///
/// The operator is taken with its sign turned: positive definite.
pub(crate) struct Level {
    pub grid: Grid,
    pub partition: CellPartition,
    pub operator: PressureOperator,
    pub halo: Halo,
    pub rhs: Field<Centre>,
    /// Result of the cycle.
    pub solution: Field<Centre>,
    /// Before the last step of the smoother.
    before: Field<Centre>,
    /// Damping over the diagonal.
    weight: Field<Centre>,
}

impl Level {
    /// Of a grid whose cells `leaders` share by a partition.
    pub fn new(grid: Grid, partition: CellPartition, leaders: Leaders) -> Self {
        let operator = PressureOperator::on(&grid, &partition, 1);
        let layout = operator.layout();
        let field = || Field::new(layout);
        Self {
            halo: Halo::new(&grid, &partition, layout)
                .renumbered(|rank| leaders.rank(partition.place_of(rank))),
            grid,
            partition,
            operator,
            rhs: field(),
            solution: field(),
            before: field(),
            weight: field(),
        }
    }

    /// Number of cells of all ranks.
    pub fn cells(&self) -> usize {
        self.grid.cells().iter().product()
    }

    /// To be called when the operator has changed.
    pub fn set_weights(&mut self) {
        let weights = self.weight.data_mut().iter_mut();
        for (weight, diagonal) in weights.zip(self.operator.diagonal.data()) {
            *weight = if *diagonal > 0.0 { DAMPING / diagonal } else { 0.0 };
        }
    }

    /// A Jacobi step from zero; what remains of the right-hand side becomes that of the coarse level.
    pub fn restriction_leg(
        &mut self,
        transfer: &mut Transfer,
        coarse: &mut Level,
        transport: &dyn Transport,
    ) {
        let n = self.operator.layout().cells[0];
        for start in self.operator.layout().rows() {
            let own = start..start + n;
            let (rhs, weight) = (&self.rhs.data()[own.clone()], &self.weight.data()[own.clone()]);
            let x = &mut self.before.data_mut()[own];
            for i in 0..n {
                x[i] = weight[i] * rhs[i];
            }
        }
        self.halo.fill(&mut [self.before.data_mut()], transport);
        let residual = |start: usize, out: &mut [f64]| {
            let neighbours = self.operator.neighbours(self.before.data(), start);
            let rhs = &self.rhs.data()[start..start + n];
            let out = &mut out[..n];
            for i in 0..n {
                // The diagonal times the step from zero is the damped right-hand side.
                out[i] = (1.0 - DAMPING) * rhs[i] + neighbours.sum(i);
            }
        };
        transfer.restrict(residual, &mut coarse.rhs);
        coarse.halo.add(&mut [coarse.rhs.data_mut()], transport);
    }

    /// Adds the correction of the coarse level, and a Jacobi step; returns Σ rhs · solution of the own cells.
    pub fn prolongation_leg(
        &mut self,
        transfer: &mut Transfer,
        coarse: &mut Level,
        transport: &dyn Transport,
    ) -> f64 {
        coarse.halo.fill(&mut [coarse.solution.data_mut()], transport);
        transfer.prolong(&coarse.solution, &mut self.before);
        self.halo.fill(&mut [self.before.data_mut()], transport);
        let n = self.operator.layout().cells[0];
        let mut product = 0.0;
        for start in self.operator.layout().rows() {
            let own = start..start + n;
            let neighbours = self.operator.neighbours(self.before.data(), start);
            let (rhs, weight) = (&self.rhs.data()[own.clone()], &self.weight.data()[own.clone()]);
            let before = &self.before.data()[own.clone()];
            let x = &mut self.solution.data_mut()[own];
            for i in 0..n {
                x[i] = (1.0 - DAMPING) * before[i] + weight[i] * (rhs[i] + neighbours.sum(i));
            }
            product += dot(x, rhs);
        }
        product
    }
}
