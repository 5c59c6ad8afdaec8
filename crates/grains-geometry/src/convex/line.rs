//! Stretches of a line p + s d inside simple bodies, as intervals of s.

use crate::Vec3;

/// All of a line.
pub(crate) const WHOLE_LINE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Where |p + s d|² <= r², for |p|², p·d and |d|².
pub(crate) fn within_ball(pp: f64, pd: f64, dd: f64, radius: f64) -> Option<(f64, f64)> {
    if dd < f64::EPSILON * f64::EPSILON {
        return (pp <= radius * radius).then_some(WHOLE_LINE);
    }
    let root = pd * pd - dd * (pp - radius * radius);
    (root >= 0.0).then(|| ((-pd - root.sqrt()) / dd, (-pd + root.sqrt()) / dd))
}

/// The part of a stretch where |p + s d| <= half.
pub(crate) fn within_slab(stretch: (f64, f64), p: f64, d: f64, half: f64) -> Option<(f64, f64)> {
    below(below(stretch, d, half - p)?, -d, half + p)
}

/// The part of a stretch where s d <= room.
pub(crate) fn below((near, far): (f64, f64), d: f64, room: f64) -> Option<(f64, f64)> {
    let stretch = if d > f64::EPSILON {
        (near, far.min(room / d))
    } else if d < -f64::EPSILON {
        (near.max(room / d), far)
    } else if room >= 0.0 {
        (near, far)
    } else {
        return None;
    };
    (stretch.0 <= stretch.1).then_some(stretch)
}

/// Smallest s >= 0 at which |p + s d| = r, for |p| <= r.
pub(crate) fn leave_ball(point: &Vec3, direction: &Vec3, radius: f64) -> f64 {
    let squared = direction.norm_squared();
    if squared <= 0.0 {
        return f64::INFINITY;
    }
    let along = point.dot(direction);
    let room = (radius * radius - point.norm_squared()).max(0.0);
    let root = (along * along + squared * room).sqrt();
    // The form without cancellation.
    if along > 0.0 { room / (along + root) } else { (root - along) / squared }
}

/// Smallest s >= 0 at which a gap is closed at a speed.
pub(crate) fn closed_after(gap: f64, speed: f64) -> f64 {
    if speed > 0.0 { gap / speed } else { f64::INFINITY }
}
