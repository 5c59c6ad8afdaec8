//! Polygonal faces from the triangles of a convex hull.

use super::{COPLANAR, ConvexHull, Face};
use crate::Vec3;
use std::collections::BTreeMap;

/// Joins the triangles of each plane to a face; points of unit extent.
///
/// If planes are so close that joining would tear the surface, the triangles stay faces of their own.
pub(super) fn join_coplanar(points: &[Vec3], triangles: &[[u32; 3]]) -> ConvexHull {
    let joined = hull_of_groups(points, triangles, &plane_of_each(points, triangles));
    if is_closed(&joined) {
        return joined;
    }
    let separate: Vec<usize> = (0..triangles.len()).collect();
    hull_of_groups(points, triangles, &separate)
}

/// Number of the plane each triangle lies in. Planes are set up by the largest triangles first, so
/// that slivers between nearly collinear points never define one.
fn plane_of_each(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<usize> {
    let corners = |t: usize| triangles[t].map(|i| points[i as usize]);
    let areas: Vec<f64> = (0..triangles.len()).map(|t| vector_area(&corners(t)).norm()).collect();
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&a, &b| areas[b].total_cmp(&areas[a]));
    let mut planes: Vec<(Vec3, f64)> = Vec::new();
    let mut plane_of = vec![0; triangles.len()];
    for t in order {
        let p = corners(t);
        let holds = |(n, d): &(Vec3, f64)| p.iter().all(|x| (n.dot(x) - d).abs() <= COPLANAR);
        plane_of[t] = planes.iter().position(holds).unwrap_or_else(|| {
            let normal = vector_area(&p).try_normalize(0.0).unwrap_or_default();
            planes.push((normal, normal.dot(&p[0])));
            planes.len() - 1
        });
    }
    plane_of
}

/// Faces bounded by the edges between groups; a vertex of fewer than three groups is no corner.
fn hull_of_groups(points: &[Vec3], triangles: &[[u32; 3]], group: &[usize]) -> ConvexHull {
    let mut owner: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (t, &g) in triangles.iter().zip(group) {
        owner.extend((0..3).map(|k| ((t[k], t[(k + 1) % 3]), g)));
    }
    // The next vertex around each group, along edges whose other side is another group.
    let count = group.iter().max().map_or(0, |g| g + 1);
    let mut next: Vec<BTreeMap<u32, u32>> = vec![BTreeMap::new(); count];
    let mut groups_at = vec![0; points.len()];
    for (&(a, b), &g) in &owner {
        if owner.get(&(b, a)) != Some(&g) {
            next[g].insert(a, b);
            groups_at[a as usize] += 1;
        }
    }
    let mut renumbered = vec![0; points.len()];
    let mut vertices = Vec::new();
    for (i, point) in points.iter().enumerate().filter(|(i, _)| groups_at[*i] >= 3) {
        renumbered[i] = vertices.len() as u32;
        vertices.push(*point);
    }
    let corners_of = |rim: &BTreeMap<u32, u32>| -> Vec<u32> {
        let corners = walk(rim).into_iter().filter(|&v| groups_at[v as usize] >= 3);
        corners.map(|v| renumbered[v as usize]).collect()
    };
    let faces = next.iter().map(corners_of).filter_map(|rim| face(&vertices, rim)).collect();
    ConvexHull { vertices, faces }
}

/// The vertices of a closed chain, from the lowest.
fn walk(next: &BTreeMap<u32, u32>) -> Vec<u32> {
    let Some(&start) = next.keys().next() else { return Vec::new() };
    let follow = |v: &u32| next.get(v).copied().filter(|&v| v != start);
    std::iter::successors(Some(start), follow).take(next.len()).collect()
}

/// A face and its plane from its corners.
fn face(vertices: &[Vec3], rim: Vec<u32>) -> Option<Face> {
    if rim.len() < 3 {
        return None;
    }
    let corners: Vec<Vec3> = rim.iter().map(|&v| vertices[v as usize]).collect();
    let mean = corners.iter().sum::<Vec3>() / corners.len() as f64;
    let normal = vector_area(&corners).try_normalize(0.0)?;
    Some(Face { vertices: rim, normal, offset: normal.dot(&mean) })
}

/// Twice the vector area of a polygon.
fn vector_area(corners: &[Vec3]) -> Vec3 {
    corners[1..].windows(2).map(|w| (w[0] - corners[0]).cross(&(w[1] - w[0]))).sum()
}

/// Whether every edge is shared by two faces in opposite senses, and V - E + F = 2.
fn is_closed(hull: &ConvexHull) -> bool {
    let mut edges: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for face in &hull.faces {
        for (k, &a) in face.vertices.iter().enumerate() {
            let b = face.vertices[(k + 1) % face.vertices.len()];
            *edges.entry((a, b)).or_default() += 1;
        }
    }
    let paired = edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1));
    paired && hull.vertices.len() + hull.faces.len() == edges.len() / 2 + 2
}
