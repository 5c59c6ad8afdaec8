//! Surfaces of walls, from their description in the case.

use grains_case::{Meshes, Side, WallKind};
use grains_dem::{OpenTube, Surface};
use grains_geometry::{
    Core, Mat3, Revolution, Rotation, SMOOTH_ANGLE, TriMesh, Vec3, WallMesh, rotation_onto,
};
use std::sync::Arc;

/// Corners of the box around a finite wall (m).
pub type Extents = (Vec3, Vec3);

/// Builds the surfaces of a wall, and the box around them if they are finite.
///
/// # Errors
/// A mesh that cannot be read or used.
pub fn surfaces(kind: &WallKind, meshes: &Meshes) -> Result<(Vec<Surface>, Option<Extents>), String> {
    Ok(match kind {
        WallKind::Plane { point, normal } => {
            (vec![Surface::Plane { point: Vec3::from(*point), normal: Vec3::from(*normal) }], None)
        }
        WallKind::Box { lower, upper, side: Side::Inside } => {
            let corners = [Vec3::from(*lower), Vec3::from(*upper)];
            let face = |a: usize, k: usize| {
                let mut normal = Vec3::zeros();
                normal[a] = if k == 0 { 1.0 } else { -1.0 };
                Surface::Plane { point: corners[k], normal }
            };
            ((0..6).map(|f| face(f / 2, f % 2)).collect(), None)
        }
        WallKind::Box { lower, upper, side: Side::Outside } => {
            let (lower, upper) = (Vec3::from(*lower), Vec3::from(*upper));
            let half = (upper - lower) * 0.5;
            let solid = Surface::Solid {
                core: Core::Box(half),
                rotation: Mat3::identity(),
                center: (lower + upper) * 0.5,
                bounding_radius: half.norm(),
            };
            (vec![solid], Some((lower, upper)))
        }
        WallKind::Cylinder { center, axis, radius, height, side, caps } => {
            cylinder(Vec3::from(*center), Vec3::from(*axis), *radius, 0.5 * height, (*side, *caps))?
        }
        WallKind::Cone { .. }
        | WallKind::Revolution { .. }
        | WallKind::Mesh { .. }
        | WallKind::Polygons { .. } => {
            let triangles = triangles(kind, meshes)?;
            let wall = match meshes.wall(kind) {
                Some(wall) => wall,
                None => Arc::new(wall_mesh(&triangles)?),
            };
            (vec![Surface::Mesh(wall)], Some(triangles.extents()))
        }
    })
}

/// The mesh of a wall, for the ranks of a node to share; none of a wall that is no mesh, or of one that cannot be used.
pub fn mesh_to_share(kind: &WallKind, meshes: &Meshes) -> Option<WallMesh> {
    wall_mesh(&triangles(kind, meshes).ok()?).ok()
}

fn wall_mesh(triangles: &TriMesh) -> Result<WallMesh, String> {
    WallMesh::new(triangles, SMOOTH_ANGLE).map_err(|e| e.to_string())
}

/// The triangles of a wall that is a mesh.
fn triangles(kind: &WallKind, meshes: &Meshes) -> Result<TriMesh, String> {
    Ok(match kind {
        WallKind::Cone { facets, .. } | WallKind::Revolution { facets, .. } => {
            revolution(kind).ok_or("has no profile")?.mesh(*facets)
        }
        WallKind::Mesh { path, scale, translate } => {
            let mesh = meshes.mesh(path).map_err(|e| e.to_string())?;
            mesh.transformed(&Rotation::identity(), *scale, &Vec3::from(*translate))
        }
        WallKind::Polygons { vertices, faces } => {
            let vertices = vertices.iter().map(|v| Vec3::from(*v)).collect();
            let faces: Vec<Vec<usize>> =
                faces.iter().map(|f| f.iter().map(|&v| v as usize).collect()).collect();
            TriMesh::from_polygons(vertices, &faces).map_err(|e| e.to_string())?
        }
        _ => return Err("is no mesh".into()),
    })
}

/// The surface of revolution that a wall is; none of others.
pub fn revolution(kind: &WallKind) -> Option<Revolution> {
    match kind {
        WallKind::Cone { center, axis, bottom_radius, top_radius, height, caps, .. } => {
            let half = 0.5 * height;
            let side = [[-half, *bottom_radius], [half, *top_radius]];
            let has_cap = |[_, radius]: &[f64; 2]| *caps && *radius > 0.0;
            let on_axis = |[along, _]: [f64; 2]| [along, 0.0];
            let bottom = Some(on_axis(side[0])).filter(|_| has_cap(&side[0]));
            let top = Some(on_axis(side[1])).filter(|_| has_cap(&side[1]));
            let profile = bottom.into_iter().chain(side).chain(top).collect();
            Some(Revolution::new(Vec3::from(*center), Vec3::from(*axis), profile))
        }
        WallKind::Revolution { origin, axis, profile, .. } => {
            Some(Revolution::new(Vec3::from(*origin), Vec3::from(*axis), profile.clone()))
        }
        _ => None,
    }
}

fn cylinder(
    center: Vec3,
    axis: Vec3,
    radius: f64,
    half_length: f64,
    (side, caps): (Side, bool),
) -> Result<(Vec<Surface>, Option<Extents>), String> {
    let is_finite = half_length.is_finite();
    let reach = axis.map(|n| half_length * n.abs() + radius * (1.0 - n * n).max(0.0).sqrt());
    let extents = is_finite.then(|| (center - reach, center + reach));
    if is_finite && !caps {
        let tube = OpenTube { center, axis, radius, half_length };
        return Ok((vec![Surface::OpenTube(tube)], extents));
    }
    if side == Side::Outside {
        if !is_finite {
            return Err("the outside of a cylinder needs a height; give `height`".into());
        }
        let rotation = rotation_onto(&axis).to_rotation_matrix();
        let core = Core::Cylinder { radius, half_height: half_length };
        let bounding_radius = libm::hypot(half_length, radius);
        return Ok((
            vec![Surface::Solid { core, rotation: rotation.into_inner(), center, bounding_radius }],
            extents,
        ));
    }
    let mut surfaces = vec![Surface::Tube { center, axis, radius, half_length }];
    if is_finite {
        for sign in [-1.0, 1.0] {
            surfaces
                .push(Surface::Plane { point: center + axis * (sign * half_length), normal: -axis * sign });
        }
    }
    Ok((surfaces, extents))
}
