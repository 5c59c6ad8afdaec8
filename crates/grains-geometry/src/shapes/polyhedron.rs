//! Convex polyhedra.

use crate::error::{check_length, crust_thickness};
use crate::mass::MassProperties;
use crate::mass::union::principal_moments;
use crate::{
    ConvexHull, Core, Face, HullError, MassSource, Mat3, Part, PartFrame, Rotation, Shape, ShapeError,
    ShapeReport, TriMesh, Vec3,
};
use nalgebra::Rotation3;

/// Corners of a core closer than this to a face's plane lie on it (relative to the size of the body).
const ON_FACE: f64 = 1e-9;
/// A box must be smaller by this much than the one along the principal axes to be preferred.
const CLEARLY_SMALLER: f64 = 1.0 - 1e-6;
/// Polyhedra of more faces are boxed along their principal axes: they are round enough.
const MAX_BOX_FACES: usize = 200;

impl Shape {
    /// Convex hull of the given vertices (m).
    ///
    /// Errors: fewer than four vertices, coincident, coplanar or infinite ones; crust out of (0, 0.5].
    pub fn hull(vertices: &[Vec3], crust_fraction: f64) -> Result<Self, ShapeError> {
        let user = ConvexHull::new(vertices)?;
        let mass = MassProperties::of_closed_mesh(&user.triangles());
        let (axes, inertia) = principal_moments(&mass)?;
        let hull = in_body_frame(&user, &axes, &mass.center);
        let inscribed_radius = hull.depth_of(&Vec3::zeros());
        let crust = crust_thickness(crust_fraction, inscribed_radius)?;
        let (part, farthest) = eroded_part(&hull, crust)?;
        let rotation = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        Ok(Shape {
            name: "polyhedron".to_string(),
            parts: vec![part],
            volume: mass.volume,
            inertia,
            bounding_radius: farthest + crust,
            inscribed_radius,
            user_to_body: (rotation, mass.center),
            discrete: None,
            surface: hull.triangles(),
            report: ShapeReport { mass: MassSource::ClosedMesh, decomposition: None },
        })
    }

    /// Convex hull of the vertices of a mesh multiplied by `scale` (m per unit of the mesh).
    pub fn hull_of_mesh(mesh: &TriMesh, scale: f64, crust_fraction: f64) -> Result<Self, ShapeError> {
        check_length("scale", scale)?;
        let vertices: Vec<Vec3> = mesh.vertices.iter().map(|v| v * scale).collect();
        Shape::hull(&vertices, crust_fraction)
    }
}

/// The part of a hull in its body frame under a crust (m).
pub(crate) fn polyhedron_part_of(hull: &ConvexHull, crust: f64) -> Result<Part, HullError> {
    Ok(eroded_part(hull, crust)?.0)
}

/// The same, and the largest distance of its core from the origin (m).
fn eroded_part(hull: &ConvexHull, crust: f64) -> Result<(Part, f64), HullError> {
    let core = hull.eroded_vertices(&Vec3::zeros(), crust)?;
    let farthest = core.iter().map(|v| v.norm()).fold(0.0, f64::max);
    Ok((polyhedron_part(hull, &core, crust), farthest))
}

/// The hull in its body frame: `x_body = axesᵀ (x - center)`.
fn in_body_frame(user: &ConvexHull, axes: &Mat3, center: &Vec3) -> ConvexHull {
    let mut hull = user.clone();
    for vertex in &mut hull.vertices {
        *vertex = axes.tr_mul(&(*vertex - center));
    }
    for face in &mut hull.faces {
        face.offset -= face.normal.dot(center);
        face.normal = axes.tr_mul(&face.normal);
    }
    hull
}

/// The part, in the frame of the smallest box among those along the principal axes and those along a
/// face and one of its edges.
fn polyhedron_part(hull: &ConvexHull, core: &[Vec3], crust: f64) -> Part {
    let rotation = box_axes(hull, core, crust);
    let (lower, upper) = box_along(&rotation, core);
    let (middle, half) = ((lower + upper) / 2.0, (upper - lower) / 2.0);
    let vertices: Vec<Vec3> = core.iter().map(|v| rotation.tr_mul(v) - middle).collect();
    let farthest = vertices.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let center = rotation * middle;
    let planes =
        hull.faces.iter().map(|f| (rotation.tr_mul(&f.normal), f.offset - crust - f.normal.dot(&center)));
    let faces = planes.filter_map(|(normal, offset)| face_of(&vertices, normal, offset)).collect();
    Part {
        core: Core::polyhedron_with_faces(vertices, faces),
        crust,
        center,
        rotation,
        frame: PartFrame::of(&center, &rotation),
        half_extents: half.add_scalar(crust),
        bounding_radius: farthest + crust,
    }
}

/// The face on a plane normal·x = offset, its corners counter-clockwise; `None` if erosion has rounded
/// it away.
fn face_of(vertices: &[Vec3], normal: Vec3, offset: f64) -> Option<Face> {
    let size = vertices.iter().map(Vec3::amax).fold(0.0, f64::max);
    let is_on = |v: &Vec3| (normal.dot(v) - offset).abs() <= ON_FACE * size;
    let mut corners: Vec<u32> =
        (0..vertices.len() as u32).filter(|&k| is_on(&vertices[k as usize])).collect();
    if corners.len() < 3 {
        return None;
    }
    let middle = corners.iter().map(|&k| vertices[k as usize]).sum::<Vec3>() / corners.len() as f64;
    let across = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
    let angle = |k: &u32| {
        let off = vertices[*k as usize] - middle;
        libm::atan2(normal.cross(&across).dot(&off), across.dot(&off))
    };
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    Some(Face { vertices: corners, normal, offset })
}

/// Axes (columns) of the smallest box among the candidates.
fn box_axes(hull: &ConvexHull, core: &[Vec3], crust: f64) -> Mat3 {
    let volume = |axes: &Mat3| {
        let (lower, upper) = box_along(axes, core);
        (upper - lower).add_scalar(2.0 * crust).product()
    };
    let mut best = (Mat3::identity(), volume(&Mat3::identity()));
    if hull.faces.len() > MAX_BOX_FACES {
        return best.0;
    }
    for face in &hull.faces {
        for (k, &a) in face.vertices.iter().enumerate() {
            let b = face.vertices[(k + 1) % face.vertices.len()];
            let along = (hull.vertices[b as usize] - hull.vertices[a as usize]).normalize();
            let axes = Mat3::from_columns(&[along, face.normal.cross(&along), face.normal]);
            let candidate = volume(&axes);
            if candidate < best.1 * CLEARLY_SMALLER {
                best = (axes, candidate);
            }
        }
    }
    best.0
}

/// Lower and upper corner, in the given axes, of the box around the points (m).
fn box_along(axes: &Mat3, points: &[Vec3]) -> (Vec3, Vec3) {
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    points.iter().map(|p| axes.tr_mul(p)).fold(start, |(lower, upper), p| (lower.inf(&p), upper.sup(&p)))
}
