//! Constructors of the shapes.

mod capsule;
mod cone;
mod cross;
mod lobes;
mod polyhedron;
mod regular;
mod round;
mod slices;
mod sphere_cylinder;
mod superellipsoid;
mod tessellation;

pub use lobes::Lobes;
pub(crate) use polyhedron::polyhedron_part_of;
pub use regular::RegularSolid;
pub use sphere_cylinder::SphereArrangement;
