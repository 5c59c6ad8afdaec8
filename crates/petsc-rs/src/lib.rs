//! The pressure equation div(c grad p) = f on a Cartesian grid over many ranks, solved by PETSc.
//!
//! [`Petsc`] starts the library on a communicator, [`Grid`] says which rank owns which cells,
//! [`PressureMatrix`] holds the finite-volume operator and [`LinearSolver`] solves with it: conjugate
//! gradients preconditioned by a geometric multigrid (or PETSc's algebraic one, or a function of the
//! caller such as a fast transform).
//!
//! Arrays of cells hold the owned cells, x fastest; arrays of the faces normal to an axis hold one more
//! entry along that axis, so that cell i lies between faces i and i + 1. Ranks are numbered with x fastest:
//! a communicator of `MPI_Cart_create` must have been made with its axes in the order z, y, x.
//!
//! All functions that take a grid, a matrix or a solver are collective: every rank calls them, in the same
//! order. Unsafe code is confined to the module `ffi`.

mod axis;
mod error;
mod ffi;
mod grid;
mod levels;
mod multigrid;
mod options;
mod petsc;
mod pressure;
mod solver;

pub use error::PetscError;
pub use ffi::Function;
pub use grid::{Block, Grid};
pub use options::Options;
pub use petsc::Petsc;
pub use pressure::{Boundary, PressureMatrix};
pub use solver::{LinearSolver, Preconditioner, Report, Settings};
