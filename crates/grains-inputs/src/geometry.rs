//! Meshes.

use crate::Folders;
use grains_geometry::{
    ClosedMesh, ConvexHull, DecompositionOptions, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WELD_TOLERANCE,
    WallMesh, parse_obj, parse_stl,
};

/// Triangles of meshes that are cut into convex parts: cutting takes milliseconds.
const FEW: usize = 16;

/// The content of a mesh file, STL as well as OBJ, up to the wall and the body that it makes.
pub fn mesh(bytes: &[u8], _: &Folders) -> bool {
    let stl = parse_stl(bytes).is_ok_and(|mesh| used(&mesh));
    let obj = parse_obj(&String::from_utf8_lossy(bytes)).is_ok_and(|mesh| used(&mesh));
    stl || obj
}

/// A mesh as wall, as solid, and as body.
fn used(mesh: &TriMesh) -> bool {
    let Ok((mesh, _)) = mesh.welded(WELD_TOLERANCE) else { return false };
    let _ = mesh.report();
    if let Ok(wall) = WallMesh::new(&mesh, SMOOTH_ANGLE) {
        let _ = wall.report();
        let (lower, upper) = mesh.extents();
        let centre = (lower + upper) / 2.0;
        wall.for_each_in_box(&lower, &upper, |t| {
            let _ = wall.closest_within(t, &centre, mesh.diagonal());
        });
    }
    if mesh.vertices.len() <= 4 * FEW {
        let _ = ConvexHull::new(&mesh.vertices);
    }
    let Ok(closed) = ClosedMesh::new(mesh.clone()) else { return false };
    let _ = closed.signed_distance(&Vec3::zeros());
    if mesh.triangles.len() <= FEW {
        let options = DecompositionOptions { max_parts: 2, resolution: 16, cache: None };
        let _ = Shape::of_mesh(&mesh, 1.0, &options, 0.02);
    }
    true
}
