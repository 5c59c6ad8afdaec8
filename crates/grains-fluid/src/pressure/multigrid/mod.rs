//! Geometric multigrid for coefficients that vary: the preconditioner of [`super::ConjugateGradients`].
//!
//! Cells are joined in pairs along the axes on which they are thin, every rank its own. Coarse conductances are
//! those of the fine faces side by side over the coarse distance. A cycle goes down once and up once, with a damped
//! Jacobi step before and after each correction, and with linear interpolation and its transpose: symmetric,
//! positive definite, and the same for any order of the cells. A cell without an open face takes what coarser grids give
//! it, so that cells next to walls interpolate between sensible values. All but the coarsest has single precision.
//!
//! As soon as the cells of eight ranks are few, the first of the eight takes them all and goes on with other such ranks, and so
//! forth. Ranks that gave their cells away wait for the correction. The first rank alone has the last levels and solves the
//! coarsest by Cholesky.

mod agglomerated;
mod dense;
mod hierarchy;
mod leaders;
mod level;
mod transfer;

use super::PressureProblem;
use super::operator::PressureOperator;
use super::single_operator::Equation;
use grains_domain::Transport;
use hierarchy::Hierarchy;
use leaders::Leaders;
use level::Level;

/// The hierarchy, built once; coefficients are set as often as they change.
pub(crate) struct Multigrid {
    hierarchy: Hierarchy,
}

impl Multigrid {
    /// Hierarchy for a problem.
    pub fn new(problem: &PressureProblem) -> Self {
        let (is_singular, imposed) = (problem.is_singular(), problem.imposed);
        let leaders = Leaders::all(&problem.partition);
        Self { hierarchy: Hierarchy::new(&problem.grid, &problem.partition, leaders, is_singular, imposed) }
    }

    /// What a cycle solves and what it gives.
    pub fn equation(&mut self) -> Equation<'_> {
        let Level { operator, rhs, solution, .. } = self.hierarchy.finest_mut();
        Equation { operator, residual: rhs, correction: solution }
    }

    /// Takes the conductances of an operator, divided by a unit; collective.
    pub fn set(&mut self, operator: &PressureOperator, unit: f64, transport: &dyn Transport) {
        self.hierarchy.finest_mut().operator.set(operator, unit);
        self.hierarchy.refresh(transport);
    }

    /// One cycle; returns the own part of Σ r z. Collective.
    pub fn cycle(&mut self, transport: &dyn Transport) -> f64 {
        self.hierarchy.cycle(transport)
    }
}
