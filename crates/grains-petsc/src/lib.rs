//! PETSc as a solver of the fluid's pressure equation: [`PetscSolver`] is a [`grains_fluid::PressureSolver`].
//!
//! The fluid's arrays have halos and velocities on upper faces; PETSc gets the own cells, x fastest, and all faces of
//! them. Ranks own the same cells on both sides: those of the particles' subdomains.

mod arrays;
mod solver;

pub use petsc_rs::{Options, Settings};
pub use solver::{PetscSolver, Preconditioning};
