//! Closed forms for the point core against all but polyhedra and superellipsoids.

use super::nearest::on_triangle;
use super::{MEETING, Separation};
use crate::{Core, Placement, Vec3};

/// The answer if one of the cores is a point and the other has a closed form.
#[inline]
pub(super) fn closed_form(a: &Core, b: &Core, placement: &Placement, cutoff: f64) -> Option<Separation> {
    if let Core::Point = b {
        let point = &placement.translation;
        let v = -offset(a, point)?;
        return Some(classify(v, point - v, point.amax(), cutoff));
    }
    if let Core::Point = a {
        let inverse = placement.inverse();
        let v = placement.matrix * offset(b, &inverse.translation)?;
        return Some(classify(v, Vec3::zeros(), placement.translation.amax(), cutoff));
    }
    None
}

/// From `point` to the nearest point of the core, zero inside; `None` for those without a closed form.
#[inline]
fn offset(core: &Core, point: &Vec3) -> Option<Vec3> {
    match core {
        Core::Point => Some(-point),
        Core::Box(half) => Some(point.zip_map(half, |x, h| x.clamp(-h, h)) - point),
        Core::Cylinder { radius, half_height } => {
            let radial = point.xy().norm();
            let inward = if radial > *radius { radius / radial - 1.0 } else { 0.0 };
            let axial = point.z.clamp(-half_height, *half_height) - point.z;
            Some(Vec3::new(point.x * inward, point.y * inward, axial))
        }
        Core::Triangle([p, q, r]) => Some(on_triangle(&(p - point), &(q - point), &(r - point)).point),
        Core::Polyhedron(_) | Core::Superellipsoid(_) => None,
    }
}

#[inline]
fn classify(v: Vec3, point_a: Vec3, size: f64, cutoff: f64) -> Separation {
    let distance = v.norm();
    if distance > cutoff {
        return Separation::Beyond { axis: v };
    }
    if distance <= MEETING * size {
        return Separation::Meeting;
    }
    Separation::Apart { distance, normal: v / distance, point_a, point_b: point_a + v }
}
