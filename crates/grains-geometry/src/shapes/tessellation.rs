//! Surfaces of the shapes that are given by formulas, for output and pictures.

use crate::{TriMesh, Vec3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Sides of the prism drawn for a cylinder.
const CYLINDER_SIDES: u32 = 32;
/// Times the octahedron's triangles are quartered to draw a sphere.
const SPHERE_LEVELS: usize = 3;

/// Sphere from an octahedron whose triangles are quartered and pushed outwards.
pub(super) fn sphere_surface(radius: f64) -> TriMesh {
    let axis = |k: usize, s: f64| Vec3::from_fn(|i, _| if i == k { s } else { 0.0 });
    let mut vertices: Vec<Vec3> = (0..3).flat_map(|k| [axis(k, 1.0), axis(k, -1.0)]).collect();
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..SPHERE_LEVELS {
        let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        let quarter = |&[a, b, c]: &[u32; 3]| {
            let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        };
        triangles = triangles.iter().flat_map(quarter).collect();
    }
    TriMesh { vertices: vertices.iter().map(|v| v * radius).collect(), triangles }
}

/// Prism inscribed in the cylinder about z.
pub(super) fn cylinder_surface(radius: f64, height: f64) -> TriMesh {
    let n = CYLINDER_SIDES;
    let ring = |z: f64| {
        (0..n).map(move |i| {
            let (sine, cosine) = libm::sincos(TAU * f64::from(i) / f64::from(n));
            Vec3::new(radius * cosine, radius * sine, z)
        })
    };
    let mut vertices: Vec<Vec3> = ring(-height / 2.0).chain(ring(height / 2.0)).collect();
    vertices.extend([Vec3::new(0.0, 0.0, -height / 2.0), Vec3::new(0.0, 0.0, height / 2.0)]);
    let side = |i: u32| {
        let j = (i + 1) % n;
        [[i, j, n + j], [i, n + j, n + i], [j, i, 2 * n], [n + i, n + j, 2 * n + 1]]
    };
    TriMesh { vertices, triangles: (0..n).flat_map(side).collect() }
}

/// Surface of revolution about z through an outline: distances from the axis and heights (m), from one point of the axis
/// to another.
pub(super) fn revolved(outline: &[[f64; 2]]) -> TriMesh {
    let n = CYLINDER_SIDES;
    let [inner @ .., last] = &outline[1..] else { return TriMesh::default() };
    let ring = |&[radius, z]: &[f64; 2]| {
        (0..n).map(move |i| {
            let (sine, cosine) = libm::sincos(TAU * f64::from(i) / f64::from(n));
            Vec3::new(radius * cosine, radius * sine, z)
        })
    };
    let mut vertices: Vec<Vec3> = inner.iter().flat_map(ring).collect();
    let (low, rows) = (vertices.len() as u32, inner.len() as u32);
    vertices.extend([outline[0], *last].map(|[_, z]| Vec3::new(0.0, 0.0, z)));
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let top = (rows - 1) * n;
        triangles.extend([[j, i, low], [top + i, top + j, low + 1]]);
        for row in (0..top).step_by(n as usize) {
            let (a, b, c, d) = (row + i, row + j, row + n + i, row + n + j);
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    TriMesh { vertices, triangles }
}
