//! The pressure equation div(c grad p) = f, integrated over cells.

mod conjugate_gradients;
mod fast;
mod modal_tridiagonal;
mod multigrid;
mod operator;
mod pencil_transpose;
mod single_operator;
mod transform;

pub use conjugate_gradients::{ConjugateGradients, Preconditioner};
pub use fast::FastSolver;
pub use operator::PressureOperator;

use crate::boundary::{Condition, open_faces};
use crate::{Boundaries, CellPartition, Centre, Faces, Field, Grid, Side, SolveError};
use grains_domain::Transport;

/// How a pressure equation was solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Iterations; a direct solver counts one.
    pub iterations: usize,
    /// Norm of the residual over that of the right-hand side; zero for a direct solver, which does not look.
    pub residual: f64,
}

/// What a solver is built for: it does not change during a run.
#[derive(Clone, Debug)]
pub struct PressureProblem {
    /// Global grid.
    pub grid: Grid,
    /// Cells of the ranks.
    pub partition: CellPartition,
    /// Width of the halo of the fields (cells).
    pub halo: usize,
    /// Per axis, whether p = 0 is imposed somewhere on the lower and upper face of the box.
    pub imposed: [[bool; 2]; 3],
}

impl PressureProblem {
    /// The problem of a flow: pressure is imposed at outlets and pressure inlets.
    pub fn new(grid: &Grid, partition: &CellPartition, halo: usize, boundaries: &Boundaries) -> Self {
        let mut imposed = [[false; 2]; 3];
        for face in open_faces(grid) {
            imposed[face.axis][usize::from(face.side == Side::High)] =
                boundaries.on(face).any(Condition::imposes_pressure);
        }
        Self { grid: grid.clone(), partition: partition.clone(), halo, imposed }
    }

    /// Whether the pressure is determined only up to a constant.
    pub fn is_singular(&self) -> bool {
        self.imposed == [[false; 2]; 3]
    }
}

/// Solver of Σ_faces c A (p_neighbour − p)/d = f for every cell: conservative, symmetric, f in m³/s when p is in
/// Pa and c in m⁴/(N s).
///
/// A = face area, d = distance of centres. On the faces of the box c = 0 means no gradient; c > 0 means p = 0
/// imposed there, at d = half a cell. The lower boundary face of a subdomain lies in the halo (index −1), so the
/// halos of the coefficients must be filled. If nothing is imposed, the mean of p over the volume is zero, and
/// what f does not sum to zero is taken off evenly: callers who cannot know it to be rounding must look.
pub trait PressureSolver {
    /// Takes new coefficients c; collective.
    fn set_coefficients(&mut self, coefficients: &Faces, transport: &dyn Transport)
    -> Result<(), SolveError>;

    /// Solves for f = `rhs`; `pressure` holds a first guess and then the solution in the own cells (its halo is
    /// not touched); collective.
    fn solve(
        &mut self,
        rhs: &Field<Centre>,
        pressure: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> Result<SolveReport, SolveError>;
}
