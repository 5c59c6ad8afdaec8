//! Repairs that make a mesh conforming: triangles given twice are dropped, and triangles are split at
//! vertices of others that lie on their edges (T-junctions).
//!
//! Unsplit, the long edge would look open and catch every sphere rolling over the junction.

use crate::Vec3;
use crate::bvh::{Aabb, Bvh};
use crate::mesh::{TriMesh, ordered};
use std::collections::{BTreeMap, BTreeSet};

/// A triangle is split along one edge a pass, and has three.
const MAX_PASSES: usize = 16;

/// Keeps the first of triangles with the same three vertices, whatever their sense; how many were dropped.
pub(super) fn drop_duplicates(mesh: &mut TriMesh) -> usize {
    let before = mesh.triangles.len();
    let mut seen = BTreeSet::new();
    mesh.triangles.retain(|t| {
        let mut key = *t;
        key.sort_unstable();
        seen.insert(key)
    });
    before - mesh.triangles.len()
}

/// Splits triangles until no vertex is closer than `distance` (m) to an open edge it does not belong
/// to; how many triangles this added.
pub(super) fn split_at_vertices(mesh: &mut TriMesh, distance: f64) -> usize {
    let before = mesh.triangles.len();
    for _ in 0..MAX_PASSES {
        if !split_pass(mesh, distance) {
            break;
        }
    }
    mesh.triangles.len() - before
}

/// Splits every triangle along one of its open edges with vertices on it; whether any was.
fn split_pass(mesh: &mut TriMesh, distance: f64) -> bool {
    let open = open_edges(mesh);
    let ends: BTreeSet<u32> =
        open.iter().flat_map(|&(t, k)| [mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]]).collect();
    let ends: Vec<u32> = ends.into_iter().collect();
    let boxes: Vec<Aabb> = ends.iter().map(|&v| Aabb::around([&mesh.vertices[v as usize]])).collect();
    let tree = Bvh::new(&boxes);
    let mut done = BTreeSet::new();
    for (t, k) in open {
        if done.contains(&t) {
            continue;
        }
        let [a, b, apex] = [0, 1, 2].map(|i| mesh.triangles[t][(k + i) % 3]);
        let chain = vertices_on_edge(mesh, [a, b], distance, |lower, upper, found| {
            tree.for_each_in_box(lower, upper, |i| found.push(ends[i as usize]));
        });
        if chain.is_empty() {
            continue;
        }
        done.insert(t);
        let corners: Vec<u32> = [a].into_iter().chain(chain).chain([b]).collect();
        mesh.triangles[t] = [corners[0], corners[1], apex];
        mesh.triangles.extend(corners[1..].windows(2).map(|w| [w[0], w[1], apex]));
    }
    !done.is_empty()
}

/// Edges of a single triangle, as (triangle, edge), in the order of the triangles.
fn open_edges(mesh: &TriMesh) -> Vec<(usize, usize)> {
    let mut uses: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let sides = |t: &[u32; 3]| [0, 1, 2].map(|k| ordered(t[k], t[(k + 1) % 3]));
    mesh.triangles.iter().flat_map(sides).for_each(|edge| *uses.entry(edge).or_default() += 1);
    let is_open = |(t, k): &(usize, usize)| uses[&sides(&mesh.triangles[*t])[*k]] == 1;
    (0..mesh.triangles.len()).flat_map(|t| (0..3).map(move |k| (t, k))).filter(is_open).collect()
}

/// Vertices strictly between the ends of an edge and closer than `distance` to it, in order along it.
fn vertices_on_edge(
    mesh: &TriMesh,
    ends: [u32; 2],
    distance: f64,
    find: impl Fn(&Vec3, &Vec3, &mut Vec<u32>),
) -> Vec<u32> {
    let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
    let length = (b - a).norm();
    let direction = (b - a) / length;
    let bounds = Aabb::around([&a, &b]);
    let mut found = Vec::new();
    find(&bounds.lower.add_scalar(-distance), &bounds.upper.add_scalar(distance), &mut found);
    let along = |v: u32| (mesh.vertices[v as usize] - a).dot(&direction);
    found.retain(|&v| {
        let off = mesh.vertices[v as usize] - a - direction * along(v);
        !ends.contains(&v) && along(v) > distance && along(v) < length - distance && off.norm() <= distance
    });
    found.sort_by(|&v, &w| along(v).total_cmp(&along(w)));
    found
}
