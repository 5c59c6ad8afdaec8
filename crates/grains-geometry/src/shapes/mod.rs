//! Constructors of the shapes.

mod polyhedron;
mod regular;
mod round;
mod superellipsoid;
mod tessellation;

pub use regular::RegularSolid;
