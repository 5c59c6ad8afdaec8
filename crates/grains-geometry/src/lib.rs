//! Shapes of particles and walls, their mass properties, and the distance between them.
//!
//! A particle is one or more convex [`Part`]s. Each part is handled as a *core* swept by a ball whose
//! radius is its *crust* (Rakotonirina 2016, ch. 3, section 2.5): a sphere is the point core with its
//! radius for crust; a box, cylinder or polyhedron is shrunk by a thin crust so that touching bodies
//! have separate cores and the distance of the cores gives overlap, contact point and normal
//! (eqs 3.14-3.16). No tolerance in this crate is absolute: bodies may measure a micrometre or a metre.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod area;
pub mod bvh;
mod closed_mesh;
mod closed_surface;
mod closest_surface;
pub mod contact_patch;
mod convex;
pub mod core;
mod decomposition;
mod depth_norm;
pub mod discrete;
pub mod epa;
mod error;
pub mod gjk;
mod glued;
pub mod hull;
pub mod lanes;
pub mod mass;
pub mod mesh;
pub mod mesh_file;
pub mod obb;
pub mod placement;
mod powers;
mod report;
mod revolution;
pub mod shape;
mod shapes;
mod solid;
pub mod superellipsoid;
pub mod surface;
mod table;
mod turn;

/// Vector of three f64.
pub type Vec3 = nalgebra::Vector3<f64>;
/// 3 x 3 matrix of f64.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// Unit quaternion, body to world.
pub type Rotation = nalgebra::UnitQuaternion<f64>;

pub use bvh::{Aabb, Bvh};
pub use closed_mesh::ClosedMesh;
pub use closed_surface::{ClosedSurface, SignedDistance};
pub use closest_surface::ClosestSurface;
pub use contact_patch::{ContactPatch, Nearest, TouchesInAPoint};
pub use convex::cone::Cone;
pub use convex::polyhedron::Polyhedron;
pub use core::Core;
pub use decomposition::{ConvexParts, DecompositionOptions, catches_panics};
pub use depth_norm::DepthNorm;
pub use discrete::{DiscreteContact, DiscreteSurface, Spacing};
pub use error::{GjkError, ShapeError};
pub use gjk::Simplex;
pub use glued::Component;
pub use hull::{ConvexHull, Face, HullError};
pub use mass::union::MassReport;
pub use mass::{MassProperties, principal_axes, sphere_equivalent_diameter};
pub use mesh::{MeshError, MeshReport, TriMesh, WELD_TOLERANCE, WeldReport};
pub use mesh_file::{
    ImportedMesh, MeshFileError, ParseError, parse_mesh, parse_obj, parse_stl, read_mesh, write_stl,
    write_stl_ascii,
};
pub use placement::Placement;
pub use report::{DecompositionReport, MassSource, ShapeReport};
pub use revolution::Revolution;
pub use shape::{Part, PartFrame, Shape};
pub use shapes::{Lobes, RegularSolid, SphereArrangement};
pub use solid::SolidError;
pub use superellipsoid::Superellipsoid;
pub use surface::{Facet, OverFacet, SMOOTH_ANGLE, TriangleContact, WallMesh, WallReport};
pub use turn::{rotation_about, rotation_by, rotation_onto, rotation_vector};
