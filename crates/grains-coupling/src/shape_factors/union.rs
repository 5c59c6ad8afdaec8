//! The surface of several convex parts together.

use crate::CouplingError;
use crate::shape_factors::facets::vector_area;
use crate::shape_factors::sharp::SharpPart;
use grains_geometry::{Part, Shape, Vec3};

/// Points tested lie this far off the surface (relative to the size of the shape).
const OFF: f64 = 1e-6;
/// Triangles are cut until their longest edge is below this (relative to the size of the shape).
const COARSE: f64 = 0.06;
/// How often a triangle partly hidden is cut further.
const DEPTH: u32 = 5;

/// Surface (m²) of the union of a shape's parts, to some 1e-3 of it where parts overlap, exact where none do.
///
/// Each part counts by the share of its surface that is not in another part. Of faces of two parts that lie in one
/// plane and look the same way, that of the first part counts. A shape cut from a mesh has the surface of the mesh.
pub(super) fn surface(shape: &Shape) -> Result<f64, CouplingError> {
    if shape.report.decomposition.is_some() {
        let mesh = &shape.surface;
        return Ok((0..mesh.triangles.len()).map(|t| vector_area(&mesh.corners(t)).norm()).sum());
    }
    let size = 2.0 * shape.bounding_radius;
    let mut total = 0.0;
    for (own, part) in shape.parts.iter().enumerate() {
        let sharp = SharpPart::of(part)?;
        let mesh = sharp.mesh()?;
        let (mut seen, mut whole) = (0.0, 0.0);
        for t in 0..mesh.triangles.len() {
            let corners = mesh.corners(t).map(|p| part.rotation * p + part.center);
            let area = vector_area(&corners);
            let normal = area.try_normalize(0.0).unwrap_or_default();
            let sight = Sight { parts: &shape.parts, own, off: normal * (OFF * size), size };
            whole += area.norm();
            seen += sight.visible_area(&corners, DEPTH);
        }
        total += sharp.surface()? * (seen / whole);
    }
    Ok(total)
}

/// What hides points of one face.
struct Sight<'a> {
    parts: &'a [Part],
    own: usize,
    /// A small step outwards (m).
    off: Vec3,
    size: f64,
}

impl Sight<'_> {
    /// Visible area of a triangle (m²): all or nothing where its corners and middle agree, else that of its quarters.
    fn visible_area(&self, corners: &[Vec3; 3], depth: u32) -> f64 {
        let [a, b, c] = corners;
        let longest = (a - b).norm().max((b - c).norm()).max((c - a).norm());
        let middle = (a + b + c) / 3.0;
        let is_visible = self.is_visible(&middle);
        let is_small = longest <= COARSE * self.size;
        // Corners a little inwards, where the edges of the own part do not decide.
        let agree = || corners.iter().all(|p| self.is_visible(&(p + (middle - p) * 1e-3)) == is_visible);
        if is_small && (depth == 0 || agree()) {
            return if is_visible { vector_area(corners).norm() } else { 0.0 };
        }
        let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
        let deeper = if is_small { depth - 1 } else { depth };
        let quarters = [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]];
        quarters.iter().map(|quarter| self.visible_area(quarter, deeper)).sum()
    }

    fn is_visible(&self, point: &Vec3) -> bool {
        let holds = |part: &Part, p: &Vec3| {
            let off = p - part.center;
            off.norm_squared() <= part.bounding_radius * part.bounding_radius * 3.1
                && part.contains(&part.rotation.tr_mul(&off))
        };
        let (outside, inside) = (point + self.off, point - self.off);
        self.parts.iter().enumerate().all(|(k, part)| {
            k == self.own || !(holds(part, &outside) || (k < self.own && holds(part, &inside)))
        })
    }
}
