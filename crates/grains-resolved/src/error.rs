//! What is refused.

use thiserror::Error;

/// Why bodies cannot be resolved.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SetupError {
    /// Cells that differ in width.
    #[error(
        "the cells differ in width along {axis}, but bodies can be resolved on equal cells only: set fluid.refinement to 0"
    )]
    NotUniform {
        /// Axis name.
        axis: char,
    },
}

/// Why the constraint on the fluid inside the bodies cannot be met.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ConstraintError {
    /// Multipliers that were not found.
    #[error(
        "the multipliers of the bodies are not found within {iterations} iterations: residual {residual:.2e} of the velocities to be imposed; raise fluid.resolved.iterations or fluid.resolved.tolerance, or set the points further apart (fluid.resolved.point_spacing, up to 3)"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Residual over that at the start (-).
        residual: f64,
    },
}
