//! Convex shapes, from their description in the case.

use grains_case::{Meshes, ShapeKind, Solid, VertexSpacing};
use grains_geometry::{RegularSolid, Shape, ShapeError, Spacing, Vec3};

/// Builds a convex shape.
pub fn convex(kind: &ShapeKind, crust: f64, meshes: &Meshes) -> Result<Shape, ShapeError> {
    match kind {
        ShapeKind::Sphere { radius } => Shape::sphere(*radius),
        ShapeKind::Box { edges } => Shape::cuboid(Vec3::from(*edges), crust),
        ShapeKind::Cylinder { radius, height } => Shape::cylinder(*radius, *height, crust),
        ShapeKind::Capsule { radius, length } => Shape::capsule(*radius, *length),
        ShapeKind::Cone { bottom_radius, top_radius, height } => {
            Shape::cone([*bottom_radius, *top_radius], *height, crust)
        }
        ShapeKind::Regular { solid, circumradius } => Shape::regular(regular(*solid), *circumradius, crust),
        ShapeKind::Superellipsoid { semi_axes, eps, surface_vertices } => {
            let shape = Shape::superellipsoid(Vec3::from(*semi_axes), *eps, crust);
            match surface_vertices {
                Some(v) => {
                    shape.and_then(|s| s.with_surface_vertices(v.per_direction as usize, spacing(v.spacing)))
                }
                None => shape,
            }
        }
        ShapeKind::Hull { vertices } => {
            let vertices: Vec<Vec3> = vertices.iter().map(|v| Vec3::from(*v)).collect();
            Shape::hull(&vertices, crust)
        }
        ShapeKind::HullFile { path, scale } => Shape::hull_of_mesh(&*meshes.mesh(path)?, *scale, crust),
        // What remains is composite, and composites are not glued again.
        _ => Err(ShapeError::NoComponents),
    }
}

fn spacing(spacing: VertexSpacing) -> Spacing {
    match spacing {
        VertexSpacing::Linear => Spacing::Linear,
        VertexSpacing::Exponential => Spacing::Exponential,
    }
}

fn regular(solid: Solid) -> RegularSolid {
    match solid {
        Solid::Tetrahedron => RegularSolid::Tetrahedron,
        Solid::Cube => RegularSolid::Cube,
        Solid::Octahedron => RegularSolid::Octahedron,
        Solid::Dodecahedron => RegularSolid::Dodecahedron,
        Solid::Icosahedron => RegularSolid::Icosahedron,
    }
}
