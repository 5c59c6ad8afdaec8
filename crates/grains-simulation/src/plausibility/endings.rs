//! Ends that come at once or never, and outputs finer than the steps.

use super::setting::{Remark, Setting};
use grains_case::Insert;
use grains_geometry::Vec3;

pub(super) fn stop_without_condition(s: &Setting) -> Vec<Remark> {
    let stop = &s.case.stop;
    if stop.after == 0.0 || stop.all_passed.is_some() || stop.kinetic_energy_below.is_some() {
        return Vec::new();
    }
    let message = "without effect: it says when a run may be ended, and nothing ends it; add stop.kinetic_energy_below (J) or stop.all_passed, or lower time.end";
    vec![("stop.after".into(), message.into())]
}

pub(super) fn stop_never_looked_at(s: &Setting) -> Vec<Remark> {
    let stop = &s.case.stop;
    let key = match (stop.all_passed, stop.kinetic_energy_below) {
        _ if s.case.output.series > 0.0 => return Vec::new(),
        (Some(_), _) => "stop.all_passed",
        (None, Some(_)) => "stop.kinetic_energy_below",
        (None, None) => return Vec::new(),
    };
    let message = "never looked at: that is done with every row of the time series, and output.series = 0 writes none; give output.series (s)";
    vec![(key.into(), message.into())]
}

/// Ends that wait for particles none of which moves freely.
pub(super) fn stop_without_moving_particles(s: &Setting) -> Vec<Remark> {
    let stop = &s.case.stop;
    if s.has_free_particles() || s.case.inserts.is_empty() || s.case.output.series == 0.0 {
        return Vec::new();
    }
    let is_fixed = !s.has_moving_particles();
    let (key, consequence) = match (stop.kinetic_energy_below, stop.all_passed) {
        (Some(_), _) if is_fixed => {
            ("kinetic_energy_below", "their energy is 0, and the run ends at stop.after")
        }
        (Some(_), _) => ("kinetic_energy_below", "their energy is that of the motions given"),
        (None, Some(_)) if is_fixed => ("all_passed", "none is to pass, and the run ends at stop.after"),
        _ => return Vec::new(),
    };
    let message = format!(
        "no particle moves by the forces on it: {consequence}; remove it, or let particles go with insert.motion = \"free\""
    );
    vec![(format!("stop.{key}"), message)]
}

/// A plane that all particles have behind them from the beginning.
pub(super) fn passed_already(s: &Setting) -> Vec<Remark> {
    let Some(plane) = s.case.stop.all_passed.map(|k| &s.case.flow_planes[k]) else { return Vec::new() };
    let (point, normal) = (Vec3::from(plane.point), Vec3::from(plane.normal));
    let is_beyond = |insert: &Insert| {
        insert.place.extents().is_some_and(|[lower, upper]| {
            let lowest: f64 = (0..3)
                .map(|a| (normal[a] * (lower[a] - point[a])).min(normal[a] * (upper[a] - point[a])))
                .sum();
            lowest >= 0.0
        })
    };
    if !s.has_moving_particles() || !s.case.inserts.iter().all(is_beyond) {
        return Vec::new();
    }
    let message = "all particles begin beyond this plane, on the side to which its normal points, and passages against it count negative: the run goes on to time.end; turn flow_plane.normal, or move flow_plane.point";
    vec![("stop.all_passed".into(), message.into())]
}

/// A limit above all energy that falls and impacts can give.
pub(super) fn energy_always_below(s: &Setting) -> Vec<Remark> {
    let Some(limit) = s.case.stop.kinetic_energy_below.filter(|_| s.case.stop.after > 0.0) else {
        return Vec::new();
    };
    let speed = s.case.time.impact_speed.max(s.fastest_insertion().0);
    let most = 0.5 * largest_mass(s) * speed * speed;
    if !s.has_moving_particles() || limit <= most {
        return Vec::new();
    }
    let message = format!(
        "above the {most:.1e} J that all particles have at {speed:.3} m/s (time.impact_speed): the run ends at stop.after = {} s, at rest or not; lower it",
        s.case.stop.after
    );
    vec![("stop.kinetic_energy_below".into(), message)]
}

/// Mass (kg) of all particles if each were the largest of its insertion; without bound for a file that is taken whole.
fn largest_mass(s: &Setting) -> f64 {
    let densities = s.case.materials.iter().filter_map(|material| material.density);
    let densest = densities.fold(0.0, f64::max);
    let of = |insert: &Insert| match insert.count {
        Some(count) => count as f64 * s.volumes(insert)[1] * densest,
        None => f64::INFINITY,
    };
    s.case.inserts.iter().map(of).sum()
}

/// Intervals of output shorter than a step.
pub(super) fn interval_below_step(s: &Setting) -> Vec<Remark> {
    let output = &s.case.output;
    let intervals = [
        ("particles", output.particles),
        ("series", output.series),
        ("checkpoint", output.checkpoint),
        ("surfaces", output.surfaces),
    ];
    let dt = s.steps[0];
    let short =
        intervals.into_iter().filter(|(_, interval)| *interval > 0.0 && *interval < dt * (1.0 - 1e-9));
    let remark = |(key, _)| {
        let message = format!(
            "shorter than a time step of {dt:.2e} s: written at every step, {:.1e} times; raise it (s)",
            s.case.time.end / dt
        );
        (format!("output.{key}"), message)
    };
    short.filter(|_| s.has_moving_particles()).map(remark).collect()
}
