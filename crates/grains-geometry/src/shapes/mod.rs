//! Constructors of the shapes.

mod polyhedron;
mod regular;
mod round;
mod tessellation;

pub use regular::RegularSolid;
