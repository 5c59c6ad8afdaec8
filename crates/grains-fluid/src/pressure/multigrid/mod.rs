//! Geometric multigrid for coefficients that vary: the preconditioner of [`super::ConjugateGradients`].
//!
//! Cells are joined in pairs along the axes on which they are thin, every rank its own. Coarse conductances are
//! those of the fine faces side by side over the coarse distance. A cycle goes down once and up once, with a damped
//! Jacobi step before and after each correction, and with linear interpolation and its transpose: symmetric,
//! positive definite, and the same for any order of the cells. As soon as the cells of eight ranks are few, the first of the
//! eight takes them all and goes on with other such ranks, and so forth. Ranks that gave their cells away wait for the
//! correction. The first rank alone has the last levels and solves the coarsest by Cholesky.

mod agglomerated;
mod dense;
mod hierarchy;
mod leaders;
mod level;
mod transfer;

use super::PressureProblem;
use super::operator::PressureOperator;
use crate::{Centre, Faces, Field};
use grains_domain::Transport;
use hierarchy::Hierarchy;
use leaders::Leaders;

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

    /// The operator of the equation.
    pub fn operator(&self) -> &PressureOperator {
        &self.hierarchy.finest().operator
    }

    /// Takes new coefficients; collective.
    pub fn set(&mut self, coefficients: &Faces, transport: &dyn Transport) {
        self.hierarchy.finest_mut().operator.set(coefficients);
        self.hierarchy.refresh(transport);
    }

    /// One cycle for −div(c grad p) = `residual`, which is borrowed by swapping: `correction` becomes p. Returns the own part
    /// of Σ residual · correction; collective.
    pub fn apply(
        &mut self,
        residual: &mut Field<Centre>,
        correction: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> f64 {
        let hierarchy = &mut self.hierarchy;
        std::mem::swap(residual, &mut hierarchy.finest_mut().rhs);
        std::mem::swap(correction, &mut hierarchy.finest_mut().solution);
        let product = hierarchy.cycle(transport);
        std::mem::swap(residual, &mut hierarchy.finest_mut().rhs);
        std::mem::swap(correction, &mut hierarchy.finest_mut().solution);
        product
    }
}
