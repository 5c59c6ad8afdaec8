//! Geometric multigrid for coefficients that vary: the preconditioner of [`super::ConjugateGradients`].
//!
//! Cells are joined in pairs along the axes on which they are thin, every rank its own. Coarse conductances are
//! those of the fine faces side by side over the coarse distance. A cycle goes down once and up once, with a damped
//! Jacobi step before and after each correction, and with linear interpolation and its transpose: symmetric,
//! positive definite, and the same for any order of the cells. What is left in the end, [`AGGLOMERATED`] cells or one per
//! rank, is agglomerated on all ranks and coarsened further there, down to [`SOLVED_DIRECTLY`] cells that are solved by Cholesky.

mod agglomerated;
mod dense;
mod hierarchy;
mod level;
mod transfer;

use super::PressureProblem;
use super::operator::PressureOperator;
use crate::{Centre, Faces, Field};
use agglomerated::Agglomerated;
use dense::{Dense, SOLVED_DIRECTLY};
use grains_domain::Transport;
use hierarchy::Hierarchy;

/// Cells of all ranks that are few enough to be solved by every rank.
const AGGLOMERATED: usize = 1000;

/// How the coarsest level is solved.
enum CoarseSolve {
    Dense(Dense),
    Agglomerated(Box<Agglomerated>),
}

/// The hierarchy and the coarse solve, built once; coefficients are set as often as they change.
pub(crate) struct Multigrid {
    hierarchy: Hierarchy,
    coarse_solve: CoarseSolve,
}

impl Multigrid {
    /// Hierarchy for a problem.
    pub fn new(problem: &PressureProblem) -> Self {
        let (is_singular, imposed) = (problem.is_singular(), problem.imposed);
        let is_shared = problem.partition.size() > 1;
        let coarsest = if is_shared { AGGLOMERATED } else { SOLVED_DIRECTLY };
        let hierarchy = Hierarchy::new(&problem.grid, &problem.partition, coarsest, imposed);
        let last = hierarchy.coarsest();
        let coarse_solve = if is_shared {
            CoarseSolve::Agglomerated(Box::new(Agglomerated::new(last, is_singular, imposed)))
        } else {
            CoarseSolve::Dense(Dense::new(last, is_singular))
        };
        Self { hierarchy, coarse_solve }
    }

    /// The operator of the equation.
    pub fn operator(&self) -> &PressureOperator {
        &self.hierarchy.finest().operator
    }

    /// Takes new coefficients; collective.
    pub fn set(&mut self, coefficients: &Faces, transport: &dyn Transport) {
        self.hierarchy.finest_mut().operator.set(coefficients);
        self.hierarchy.refresh();
        match &mut self.coarse_solve {
            CoarseSolve::Dense(dense) => dense.set(self.hierarchy.coarsest()),
            CoarseSolve::Agglomerated(agglomerated) => {
                agglomerated.set(self.hierarchy.coarsest(), transport);
            }
        }
    }

    /// One cycle for −div(c grad p) = `residual`, which is borrowed by swapping: `correction` becomes p. Returns the own part
    /// of Σ residual · correction; collective.
    pub fn apply(
        &mut self,
        residual: &mut Field<Centre>,
        correction: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> f64 {
        let Self { hierarchy, coarse_solve } = self;
        std::mem::swap(residual, &mut hierarchy.finest_mut().rhs);
        std::mem::swap(correction, &mut hierarchy.finest_mut().solution);
        let product = hierarchy.cycle(transport, |coarsest| match coarse_solve {
            CoarseSolve::Dense(dense) => dense.solve(coarsest),
            CoarseSolve::Agglomerated(agglomerated) => agglomerated.solve(coarsest, transport),
        });
        std::mem::swap(residual, &mut hierarchy.finest_mut().rhs);
        std::mem::swap(correction, &mut hierarchy.finest_mut().solution);
        product
    }
}
