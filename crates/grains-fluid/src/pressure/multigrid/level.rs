//! One grid of the hierarchy: its operator, its fields and the smoother.

use super::leaders::Leaders;
use super::transfer::Transfer;
use crate::pressure::operator::{PressureOperator, dot};
use crate::{CellPartition, Centre, Field, Grid, Halo};
use grains_domain::Transport;
use multiversion::multiversion;

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
            set_residual(
                &self.operator,
                self.before.data(),
                (start, &self.rhs.data()[start..start + n]),
                out,
            );
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
            let (rhs, weight) = (&self.rhs.data()[own.clone()], &self.weight.data()[own.clone()]);
            let x = &mut self.solution.data_mut()[own];
            product += smooth_row(&self.operator, self.before.data(), (start, rhs, weight), x);
        }
        product
    }
}

/// A row of the residual after a Jacobi step from zero.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn set_residual(operator: &PressureOperator, x: &[f64], (start, rhs): (usize, &[f64]), out: &mut [f64]) {
    let n = operator.layout().cells[0];
    let neighbours = operator.neighbours(x, start);
    let (rhs, out) = (&rhs[..n], &mut out[..n]);
    for i in 0..n {
        // The diagonal times the step from zero is the damped right-hand side.
        out[i] = (1.0 - DAMPING) * rhs[i] + neighbours.sum(i);
    }
}

/// A row after a Jacobi step from x, and Σ rhs · solution over it.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn smooth_row(
    operator: &PressureOperator,
    x: &[f64],
    (start, rhs, weight): (usize, &[f64], &[f64]),
    out: &mut [f64],
) -> f64 {
    let n = operator.layout().cells[0];
    let neighbours = operator.neighbours(x, start);
    let (before, rhs, weight, out) = (&x[start..start + n], &rhs[..n], &weight[..n], &mut out[..n]);
    for i in 0..n {
        out[i] = (1.0 - DAMPING) * before[i] + weight[i] * (rhs[i] + neighbours.sum(i));
    }
    dot(out, rhs)
}
