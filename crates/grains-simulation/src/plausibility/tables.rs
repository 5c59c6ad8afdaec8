//! What is odd about the numbers of particle files.

use super::setting::{LONG_DISPLACEMENT, Remark, Setting};
use crate::insertion::Extremes;
use grains_geometry::Vec3;

/// Insertions from files with the largest numbers of these, by their number in the case.
fn files<'a>(s: &'a Setting) -> impl Iterator<Item = (usize, Extremes)> + 'a {
    (0..s.case.inserts.len()).filter_map(|i| Some((i, s.insertions.file_extremes(i)?)))
}

fn key(insert: usize) -> String {
    format!("insert[{insert}].place.path")
}

/// Velocities far beyond those of falls, as where they are in mm/s.
pub(super) fn fast_rows(s: &Setting) -> Vec<Remark> {
    /// Speeds over that of a free fall through the domain.
    const USUAL: f64 = 100.0;
    let fall = (2.0 * Vec3::from(s.case.gravity).norm() * s.diagonal()).sqrt();
    let remark = |(i, extremes): (usize, Extremes)| {
        let (speed, line) = extremes.speed;
        let way = speed * s.steps[0] / s.smallest_radius();
        let consequence = if s.has_contacts && way > LONG_DISPLACEMENT {
            format!(
                "{way:.1} radii per time step ({:.2e} s): contacts begin deep or are missed; lower time.dt, or",
                s.steps[0]
            )
        } else if fall > 0.0 && speed > USUAL * fall {
            format!("{:.0} times the speed of a fall through the domain;", speed / fall)
        } else {
            return None;
        };
        let message = format!(
            "line {line} moves at {speed:.1} m/s, {consequence} mend the file, whose velocities are in m/s: {speed:.1} mm/s are {:.3e}",
            1e-3 * speed
        );
        Some((key(i), message))
    };
    files(s).filter(|(i, _)| !s.case.inserts[*i].is_prescribed()).filter_map(remark).collect()
}

/// Angular velocities that no step follows, as where they are in revolutions per minute.
pub(super) fn spinning_rows(s: &Setting) -> Vec<Remark> {
    /// Angle per step (rad) beyond which contacts of edges are passed by.
    const ANGLE: f64 = 0.5;
    let remark = |(i, extremes): (usize, Extremes)| {
        let (spin, line) = extremes.spin;
        let angle = spin * s.steps[0];
        let message = format!(
            "line {line} turns by {angle:.2} rad per time step ({:.2e} s): its turning is not followed; angular velocities of a file are in rad/s (a revolution per minute is 0.1047), or lower time.dt",
            s.steps[0]
        );
        (s.has_contacts && angle > ANGLE).then(|| (key(i), message))
    };
    files(s).filter(|(i, _)| !s.case.inserts[*i].is_prescribed()).filter_map(remark).collect()
}

/// Angles where quaternions are meant.
pub(super) fn angles_for_quaternions(s: &Setting) -> Vec<Remark> {
    /// Beyond this (-) no component of a quaternion is.
    const USUAL: f64 = 5.0;
    let remark = |(i, extremes): (usize, Extremes)| {
        let (component, line) = extremes.quaternion;
        let message = format!(
            "line {line} has a component of {component} among qw, qx, qy, qz, which are scaled to length 1: the particle is turned otherwise than by an angle of that size; a turn by an angle a about an axis n is cos(a/2), n sin(a/2): 90 degrees about z are 0.7071, 0, 0, 0.7071"
        );
        (component > USUAL).then(|| (key(i), message))
    };
    files(s).filter_map(remark).collect()
}

/// Temperatures where particles have none.
pub(super) fn temperatures_of_nothing(s: &Setting) -> Vec<Remark> {
    let has_scalars = s.case.fluid.as_ref().is_some_and(|fluid| !fluid.scalar.is_empty());
    if s.case.heat.is_some() || has_scalars {
        return Vec::new();
    }
    let message = "its column temperature is without effect: particles have no temperatures; add [heat] with a temperature (K), or remove the column";
    files(s).filter(|(_, e)| e.has_temperatures).map(|(i, _)| (key(i), message.to_string())).collect()
}

/// Files of no particle.
pub(super) fn files_without_rows(s: &Setting) -> Vec<Remark> {
    let is_empty = |(i, _): &(usize, Extremes)| s.insertions.count(*i) == 0;
    let message = "holds no particle, only a header: nothing is inserted; write one line per particle, or remove this [[insert]]";
    files(s).filter(is_empty).map(|(i, _)| (key(i), message.to_string())).collect()
}
