//! The point core against those that know their nearest point to a point.

use super::{MEETING, Separation};
use crate::{Core, Placement, Vec3};

/// The answer if one of the cores is a point and the other has a closed form.
#[inline]
pub(super) fn closed_form(a: &Core, b: &Core, placement: &Placement, cutoff: f64) -> Option<Separation> {
    if let Core::Point = b {
        let point = &placement.translation;
        let v = -a.offset_from(point)?;
        return Some(classify(v, point - v, point.amax(), cutoff));
    }
    if let Core::Point = a {
        let inverse = placement.inverse();
        let v = placement.matrix * b.offset_from(&inverse.translation)?;
        return Some(classify(v, Vec3::zeros(), placement.translation.amax(), cutoff));
    }
    None
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
