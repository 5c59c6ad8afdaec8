//! Surface of a composite, for output.

use crate::{Part, Rotation, TriMesh, Vec3};

/// Points tested lie this far outside the surface (relative to the size of the composite), so that a
/// seam between two parts is hidden but a face they share outside is not.
const OUTSIDE: f64 = 1e-6;
/// Points tested lie this much off the corners towards the middle of their triangle, where the
/// polygons drawn for round bodies do not betray themselves.
const INWARDS: f64 = 1e-3;

/// The surfaces of the components together, less the triangles hidden in other parts; all in
/// the frame of the composite.
pub(super) fn union(surfaces: &[(&TriMesh, (Rotation, Vec3))], parts: &[Part], size: f64) -> TriMesh {
    let mut all = TriMesh::default();
    for (k, (surface, (rotation, position))) in surfaces.iter().enumerate() {
        let placed = surface.transformed(rotation, 1.0, position);
        let first = all.vertices.len() as u32;
        let mut number = vec![None; placed.vertices.len()];
        for t in (0..placed.triangles.len()).filter(|&t| !is_hidden(&placed.corners(t), k, parts, size)) {
            let triangle = placed.triangles[t].map(|v| {
                *number[v as usize].get_or_insert_with(|| {
                    all.vertices.push(placed.vertices[v as usize]);
                    all.vertices.len() as u32 - 1
                })
            });
            debug_assert!(triangle.iter().all(|&v| v >= first));
            all.triangles.push(triangle);
        }
    }
    all
}

/// Whether a triangle of part `own` lies wholly in another part.
fn is_hidden(corners: &[Vec3; 3], own: usize, parts: &[Part], size: f64) -> bool {
    let [a, b, c] = corners;
    let outwards = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default() * (OUTSIDE * size);
    let middle = (a + b + c) / 3.0;
    let points = corners.map(|p| p + (middle - p) * INWARDS + outwards);
    let holds = |part: &Part| points.iter().all(|p| part.contains(&part.rotation.tr_mul(&(p - part.center))));
    parts.iter().enumerate().any(|(k, part)| k != own && holds(part))
}
