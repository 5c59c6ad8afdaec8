//! Openings that no particle passes.

use super::setting::{Remark, Setting};
use grains_case::{Wall, WallKind};
use grains_geometry::Vec3;

/// Corners of the open surface of a wall about its axis: heights along it and radii (m); none if its ends are closed.
fn profile(kind: &WallKind) -> Option<(Vec3, Vec<[f64; 2]>)> {
    match kind {
        WallKind::Revolution { axis, profile, .. } => {
            let is_ring = profile.first() == profile.last();
            (!is_ring).then(|| (Vec3::from(*axis), profile.clone()))
        }
        WallKind::Cone { axis, bottom_radius, top_radius, height, caps: false, .. } => {
            Some((Vec3::from(*axis), vec![[0.0, *bottom_radius], [*height, *top_radius]]))
        }
        _ => None,
    }
}

/// Funnels whose narrowest section is smaller than a particle.
pub(super) fn narrow_funnels(s: &Setting) -> Vec<Remark> {
    /// Radii over that of a particle below which an end is meant to be closed (-).
    const CLOSED: f64 = 0.05;
    let (gravity, ball) = (Vec3::from(s.case.gravity), s.smallest_radius());
    let remark = |(i, wall): (usize, &Wall)| {
        let (axis, corners) = profile(&wall.kind)?;
        let by_radius = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
        let widest = corners.iter().max_by(by_radius)?;
        let narrowest = corners.iter().min_by(by_radius)?;
        // What points upwards is a roof.
        let is_below = gravity.dot(&axis) * (narrowest[0] - widest[0]) > 0.0;
        let (radius, is_wide) = (narrowest[1], widest[1] > ball);
        let message = format!(
            "its narrowest section has a radius of {radius:.3e} m, and the smallest particle holds a ball of {ball:.3e} m: nothing passes; widen it (m), or close it with a radius of 0"
        );
        let is_narrow = radius < ball && radius > CLOSED * ball;
        (is_below && is_wide && is_narrow).then(|| (format!("wall[{i}].kind"), message))
    };
    let is_bounded = |ball: f64| ball.is_finite() && s.has_moving_particles();
    s.case.walls.iter().enumerate().filter(|_| is_bounded(ball)).filter_map(remark).collect()
}
