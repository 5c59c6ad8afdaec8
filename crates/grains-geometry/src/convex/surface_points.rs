//! Points spread evenly over surfaces, to integrate over them.

use crate::{TriMesh, Vec3};
use std::f64::consts::{PI, TAU};

/// The inverse of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A point of a surface with the area it stands for.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceElement {
    /// Point (m).
    pub point: Vec3,
    /// Outward unit normal (-).
    pub normal: Vec3,
    /// Area (m²).
    pub area: f64,
}

/// Points spread evenly over the unit square: no two in a row or column, so that straight seams cut off their share.
pub(crate) fn lattice(number: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..number).map(move |k| [(k as f64 + 0.5) / number as f64, (k as f64 * GOLDEN).fract()])
}

/// The square on the unit sphere, areas in proportion.
pub(crate) fn on_sphere([u, v]: [f64; 2]) -> Vec3 {
    let (z, (sine, cosine)) = (1.0 - 2.0 * u, libm::sincos(TAU * v));
    let ring = (1.0 - z * z).sqrt();
    Vec3::new(ring * cosine, ring * sine, z)
}

/// Point of the unit circle about z at a share of the turn.
pub(crate) fn on_circle(v: f64) -> Vec3 {
    Vec3::new(libm::cos(TAU * v), libm::sin(TAU * v), 0.0)
}

/// Elements of a frustum about z: radii at the heights of both ends (m), of which `number` points are about the share
/// of its area in `whole` (m²).
pub(crate) fn on_frustum(
    [low, high]: [f64; 2],
    [bottom, top]: [f64; 2],
    number: usize,
    mut visit: impl FnMut(SurfaceElement),
) {
    let slope = (top - bottom) / (high - low);
    let slant = (1.0 + slope * slope).sqrt();
    let side = PI * (bottom + top) * (high - low) * slant;
    let ends = [(low, bottom, -Vec3::z()), (high, top, Vec3::z())];
    let whole = side + PI * (bottom * bottom + top * top);
    let share = |area: f64| (number as f64 * area / whole).ceil();
    for [u, v] in lattice(share(side) as usize) {
        // Areas are in proportion to the radius: u is the share of the area below.
        let squared = bottom * bottom + u * (top * top - bottom * bottom);
        let radius = squared.max(0.0).sqrt();
        let t = u * (bottom + top) / (bottom + radius);
        let radial = on_circle(v);
        let normal = (radial - Vec3::z() * slope) / slant;
        let point = radial * radius + Vec3::z() * (low + (high - low) * t);
        visit(SurfaceElement { point, normal, area: side / share(side) });
    }
    for (z, radius, normal) in ends.into_iter().filter(|(_, radius, _)| *radius > 0.0) {
        let flat = PI * radius * radius;
        for [u, v] in lattice(share(flat) as usize) {
            let point = on_circle(v) * (radius * u.sqrt()) + Vec3::z() * z;
            visit(SurfaceElement { point, normal, area: flat / share(flat) });
        }
    }
}

/// Elements of the triangles of a closed mesh.
pub(crate) fn on_triangles(mesh: &TriMesh, number: usize, mut visit: impl FnMut(SurfaceElement)) {
    let whole = mesh.area();
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let (ab, ac) = (b - a, c - a);
        let cross = ab.cross(&ac);
        let area = 0.5 * cross.norm();
        let Some(normal) = cross.try_normalize(0.0) else { continue };
        let share = (number as f64 * area / whole).ceil();
        for [u, v] in lattice(share as usize) {
            // Half of the parallelogram, folded onto the other.
            let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            visit(SurfaceElement { point: a + ab * u + ac * v, normal, area: area / share });
        }
    }
}
