//! One grid of the hierarchy: its operator, its fields and the smoother.

use super::leaders::Leaders;
use super::transfer::Transfer;
use crate::pressure::single_operator::{SingleOperator, dot};
use crate::{CellPartition, Centre, Field, Grid, Halo};
use grains_domain::Transport;
use multiversion::multiversion;

/// Damping of the Jacobi steps.
const DAMPING: f64 = 0.85;

/// A grid with the fields of a cycle, all in single precision with a halo of one cell that is zero beyond the box.
///
/// The operator is taken with its sign turned: positive definite.
pub(crate) struct Level {
    pub grid: Grid,
    pub partition: CellPartition,
    pub operator: SingleOperator,
    pub halo: Halo,
    pub rhs: Field<Centre, f32>,
    /// Result of the cycle.
    pub solution: Field<Centre, f32>,
    /// Before the last step of the smoother.
    before: Field<Centre, f32>,
    /// Damping over the diagonal.
    weight: Field<Centre, f32>,
}

impl Level {
    /// Of a grid whose cells `leaders` share by a partition.
    pub fn new(grid: Grid, partition: CellPartition, leaders: Leaders) -> Self {
        let operator = SingleOperator::new(partition.cells());
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
        let layout = self.operator.layout();
        for place in layout.rows().flat_map(|start| start..start + layout.cells[0]) {
            let diagonal = self.operator.diagonal(place);
            self.weight.data_mut()[place] = if diagonal > 0.0 { (DAMPING / diagonal) as f32 } else { 0.0 };
        }
    }

    /// A Jacobi step from zero; what remains of the right-hand side becomes that of the coarse level.
    pub fn restriction_leg(
        &mut self,
        transfer: &mut Transfer,
        coarse: &mut Level,
        transport: &dyn Transport,
    ) {
        step_from_zero(self.weight.data(), self.rhs.data(), self.before.data_mut());
        self.halo.fill(&mut [self.before.data_mut()], transport);
        restrict_residual(self, transfer, &mut coarse.rhs);
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
        prolong(transfer, &coarse.solution, &mut self.before);
        self.halo.fill(&mut [self.before.data_mut()], transport);
        smooth(self)
    }
}

/// A Jacobi step from zero; weights are zero in the halo.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn step_from_zero(weight: &[f32], rhs: &[f32], x: &mut [f32]) {
    x.iter_mut().zip(weight).zip(rhs).for_each(|((x, weight), rhs)| *x = weight * rhs);
}

/// Restricts the residual after a Jacobi step.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn restrict_residual(level: &Level, transfer: &mut Transfer, coarse: &mut Field<Centre, f32>) {
    let residual = |start: usize, out: &mut [f32]| {
        let row = level.operator.row(level.before.data(), start);
        let rhs = &level.rhs.data()[start..start + out.len()];
        row.for_each(out, |i, _, flux| rhs[i] + flux);
    };
    transfer.restrict(residual, coarse);
}

/// Adds the interpolation of a coarse field, halo filled, to a fine one.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn prolong(transfer: &mut Transfer, coarse: &Field<Centre, f32>, fine: &mut Field<Centre, f32>) {
    transfer.prolong(coarse, fine);
}

/// A Jacobi step from `before`; returns Σ rhs · solution of the own cells.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn smooth(level: &mut Level) -> f64 {
    let n = level.operator.layout().cells[0];
    let mut product = 0.0;
    for start in level.operator.layout().rows() {
        let own = start..start + n;
        let (rhs, weight) = (&level.rhs.data()[own.clone()], &level.weight.data()[own.clone()]);
        let row = level.operator.row(level.before.data(), start);
        let x = &mut level.solution.data_mut()[own];
        row.for_each(x, |i, before, flux| before + weight[i] * (rhs[i] + flux));
        product += dot(x, rhs);
    }
    product
}
