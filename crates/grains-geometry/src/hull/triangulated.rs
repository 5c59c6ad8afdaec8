//! Triangulated convex hull of points with exact orientation tests.

use crate::Vec3;
use robust::{Coord3D, orient3d};
use std::collections::BTreeSet;

/// Outward triangles of the convex hull, grown from a tetrahedron `start` of non-coplanar points.
///
/// Every point is added in turn: the triangles it sees are replaced by the cone over their rim. The
/// signs are exact, so coplanar and collinear points cannot break the surface; of points on a face,
/// any may serve as corners of its triangles. Cost: points times triangles.
pub(super) fn triangulated_hull(points: &[Vec3], start: [usize; 4]) -> Vec<[u32; 3]> {
    let [a, b, c, d] = start.map(|i| i as u32);
    let [a, b] = if sees(points, &[a, b, c], d) { [b, a] } else { [a, b] };
    let mut triangles = vec![[a, b, c], [b, a, d], [c, b, d], [a, c, d]];
    let mut rim = BTreeSet::new();
    for p in (0..points.len()).filter(|p| !start.contains(p)) {
        rim.clear();
        triangles.retain(|triangle| {
            let seen = sees(points, triangle, p as u32);
            if seen {
                rim.extend((0..3).map(|k| (triangle[k], triangle[(k + 1) % 3])));
            }
            !seen
        });
        let outer = rim.iter().filter(|&&(a, b)| !rim.contains(&(b, a)));
        triangles.extend(outer.map(|&(a, b)| [a, b, p as u32]));
    }
    triangles
}

/// Whether a point lies strictly on the outer side of a triangle.
fn sees(points: &[Vec3], triangle: &[u32; 3], point: u32) -> bool {
    let at = |i: u32| {
        let p = points[i as usize];
        Coord3D { x: p.x, y: p.y, z: p.z }
    };
    orient3d(at(triangle[0]), at(triangle[1]), at(triangle[2]), at(point)) < 0.0
}
