//! Whether there is room for what is inserted, and whether steps and lists of neighbours suit it.

use super::setting::{Remark, Setting};
use grains_case::{Component, Insert, Motion, Place, Wall, WallKind, Window};
use grains_geometry::Vec3;

/// Share of space (-) above which equal bodies find no room, whatever their arrangement.
const DENSEST: f64 = 0.75;

pub(super) fn domain_too_full(s: &Setting) -> Vec<Remark> {
    let extents = s.domain().extents();
    let room: f64 = extents.iter().product();
    let is_certain = s.domain().outlets.is_empty() && s.has_moving_particles();
    let inserts = s.case.inserts.iter();
    let volume: f64 = inserts.map(|insert| insert.count.unwrap_or(0) as f64 * s.volumes(insert)[0]).sum();
    if !is_certain || volume <= DENSEST * room {
        return Vec::new();
    }
    let most = |(k, insert): (usize, &Insert)| (insert.count.unwrap_or(0), k);
    let (_, k) = s.case.inserts.iter().enumerate().map(most).max().unwrap_or_default();
    let message = format!(
        "all particles together take {volume:.3e} m3 at least, {:.0} % of the domain, and none leave: there is no room for the last; lower the count, or enlarge the domain",
        100.0 * volume / room
    );
    vec![(format!("insert[{k}].count"), message)]
}

/// Batches too large for their window, which are found out when their time comes.
pub(super) fn crowded_batches(s: &Setting) -> Vec<Remark> {
    let remark = |(i, insert): (usize, &Insert)| {
        let Place::Window { window: Window::Box { lower, upper }, retry: None, .. } = &insert.place else {
            return None;
        };
        let batch = insert.batch.or(insert.count)?;
        let volume = s.volumes(insert)[0];
        let reach = |c: &Component| s.catalogue.shapes[c.shape].bounding_radius * c.scale.largest();
        let reach = insert.particles.iter().map(reach).fold(0.0, f64::max);
        let room: f64 = (0..3).map(|a| upper[a] - lower[a] + 2.0 * reach).product();
        let share = batch as f64 * volume / room;
        let message = format!(
            "{batch} particles take {:.0} % of the window and what they reach beyond it: the run ends when this batch comes; lower it, enlarge the window, or give place.retry (s) to wait for room",
            100.0 * share
        );
        let key = if insert.batch == insert.count { "count" } else { "batch" };
        (share > DENSEST).then(|| (format!("insert[{i}].{key}"), message))
    };
    s.case.inserts.iter().enumerate().filter(|(_, insert)| insert.start > 0.0).filter_map(remark).collect()
}

pub(super) fn fast_spin(s: &Setting) -> Vec<Remark> {
    /// Angle per step (rad) beyond which contacts of edges are passed by.
    const ANGLE: f64 = 0.5;
    let remark = |(i, insert): (usize, &Insert)| {
        let angle = Vec3::from(insert.angular_velocity).norm() * s.steps[0];
        let message = format!(
            "particles turn by {angle:.2} rad per time step ({:.2e} s): their turning is not followed; the unit is rad/s (a revolution per minute is 0.1047), or lower time.dt",
            s.steps[0]
        );
        (angle > ANGLE && !insert.is_prescribed()).then(|| (format!("insert[{i}].angular_velocity"), message))
    };
    s.case.inserts.iter().enumerate().filter(|_| s.has_contacts).filter_map(remark).collect()
}

pub(super) fn wide_skin(s: &Setting) -> Vec<Remark> {
    /// Largest diameters (-).
    const USUAL: f64 = 5.0;
    let diameter = s.diameters()[1];
    let Some(skin) = s.case.neighbours.skin.filter(|skin| *skin > USUAL * diameter && s.count() > 1) else {
        return Vec::new();
    };
    let message = format!(
        "{:.0} diameters of the largest particle: lists hold hundreds of neighbours that never touch, and steps take that much longer; the unit is m, and a tenth of a diameter is usual, or leave it out",
        skin / diameter
    );
    vec![("neighbours.skin".into(), message)]
}

/// Planes that move through the whole domain, particles before them.
pub(super) fn sweeping_planes(s: &Setting) -> Vec<Remark> {
    let [lower, upper] = s.corners();
    let remark = |(i, wall): (usize, &Wall)| {
        let (WallKind::Plane { point, normal }, Some(Motion::Translation { velocity, start, end })) =
            (&wall.kind, &wall.motion)
        else {
            return None;
        };
        let (normal, velocity) = (Vec3::from(*normal), Vec3::from(*velocity));
        let speed = velocity.dot(&normal);
        let far = Vec3::from_fn(|a, _| if normal[a] > 0.0 { upper[a] } else { lower[a] });
        let swept = start.max(wall.from) + normal.dot(&(far - Vec3::from(*point))) / speed;
        let last = end.min(wall.until).min(s.case.time.end);
        let message = format!(
            "the plane has moved through the whole domain at t = {swept:.3} s, and presses its particles out; end the motion before (wall.motion.end, s), change the sign, or take motion kind \"load\""
        );
        (speed > 0.0 && swept < last).then(|| (format!("wall[{i}].motion.velocity"), message))
    };
    let planes = s.case.walls.iter().enumerate().filter(|_| s.has_moving_particles());
    planes.filter_map(remark).collect()
}
