//! The fastest flow that a case imposes: on its boundaries, by its drive, and at its start.

use super::walls;
use grains_case::{Boundary, BoundaryKind, Case, Drive, Expression, Face, FlowProfile, Fluid, Motion, Wall};
use grains_geometry::Vec3;
use std::f64::consts::TAU;

/// Samples per axis of a formula.
const SAMPLES: usize = 9;

/// A velocity, and what it asks of the time step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fastest {
    /// Speed (m/s).
    pub speed: f64,
    /// Σ |u|/Δx over the axes, at their narrowest cells (1/s).
    pub rate: f64,
}

/// The velocity that asks for the shortest step; formulas are sampled in space and time.
pub fn fastest(case: &Case, fluid: &Fluid) -> Fastest {
    fastest_at(case, fluid, &[0.0, 0.5 * case.time.end, case.time.end])
}

/// The same of some times (s).
pub fn fastest_at(case: &Case, fluid: &Fluid, times: &[f64]) -> Fastest {
    let inverse = [0, 1, 2].map(|a| match fluid.cells[a] {
        1 => 0.0,
        _ => 1.0 / fluid.cell_widths(&case.domain, a)[0],
    });
    let mut fastest = Fastest::default();
    let mut consider = |velocity: [f64; 3]| {
        let rate: f64 = (0..3).map(|a| velocity[a].abs() * inverse[a]).sum();
        if rate > fastest.rate && rate.is_finite() {
            fastest = Fastest { speed: velocity.iter().map(|u| u * u).sum::<f64>().sqrt(), rate };
        }
    };
    for face in Face::ALL.into_iter().filter(|face| !case.domain.periodic[face.axis()]) {
        let on_face = fluid.on_face(face);
        for i in on_face.whole.into_iter().chain(on_face.patches) {
            on_boundary((case, fluid), &fluid.boundary[i], times, &mut consider);
        }
    }
    if let Some(Drive::MeanVelocity { velocity, axes } | Drive::MeanFlux { velocity, axes }) = &fluid.drive {
        consider([0, 1, 2].map(|a| if axes[a] { velocity[a] } else { 0.0 }));
    }
    for (_, wall) in case.walls_of_fluid() {
        wall.motion.iter().for_each(|motion| of_motion(case, (wall, motion), &mut consider));
    }
    sample(&fluid.initial.velocity, [case.domain.lower, case.domain.upper], &[0.0], &mut consider);
    fastest
}

/// Bounds on the velocities of a wall: of an obstacle that turns by its reach, of others at the corners of the domain.
fn of_motion(case: &Case, (wall, motion): (&Wall, &Motion), consider: &mut impl FnMut([f64; 3])) {
    match motion {
        Motion::Translation { velocity, .. } => consider(*velocity),
        Motion::Oscillation { amplitude, frequency, .. } => consider(amplitude.map(|x| TAU * frequency * x)),
        Motion::Rotation { axis, angular_velocity, point, .. } => {
            let [wx, wy, wz] = axis.map(|x| x * angular_velocity);
            if let Some(reach) = reach((case, wall), point.as_ref(), axis) {
                // In turn along all directions across the axis.
                let speed = angular_velocity.abs() * reach;
                consider(axis.map(|n| speed * (0.5 * (1.0 - n * n).max(0.0)).sqrt()));
                return;
            }
            for corner in case.domain.corners() {
                let [x, y, z] = [0, 1, 2].map(|a| corner[a] - point.map_or(0.0, |point| point[a]));
                consider([wy * z - wz * y, wz * x - wx * z, wx * y - wy * x]);
            }
        }
        // Its direction is not known.
        Motion::Table { .. } => {
            let arm = case.domain.extents().map(|x| x * x).iter().sum::<f64>().sqrt();
            consider([motion.speed(arm).0; 3]);
        }
        Motion::Load { .. } => {}
    }
}

/// How far (m) an obstacle reaches from an axis that it turns about, given as a unit vector through a point (m); none of what
/// has no end or holds the fluid.
fn reach((case, wall): (&Case, &Wall), point: Option<&[f64; 3]>, axis: &[f64; 3]) -> Option<f64> {
    let [lower, upper] = walls::obstacle(wall, &case.meshes)?;
    let (point, axis) = (point.map_or_else(Vec3::zeros, |&point| Vec3::from(point)), Vec3::from(*axis));
    let corner = |k: usize| Vec3::from_fn(|a, _| if k >> a & 1 == 0 { lower[a] } else { upper[a] });
    Some((0..8).map(|k| (corner(k) - point).cross(&axis).norm()).fold(0.0, f64::max))
}

/// The velocities that a condition imposes.
fn on_boundary(
    (case, fluid): (&Case, &Fluid),
    boundary: &Boundary,
    times: &[f64],
    consider: &mut impl FnMut([f64; 3]),
) {
    let axis = boundary.face.axis();
    match &boundary.kind {
        BoundaryKind::Wall { velocity } => consider(*velocity),
        BoundaryKind::Inlet { velocity } => {
            let mut corners = boundary.part.patch().unwrap_or([case.domain.lower, case.domain.upper]);
            let end = if boundary.face.is_upper() { case.domain.upper } else { case.domain.lower };
            corners.iter_mut().for_each(|corner| corner[axis] = end[axis]);
            sample(velocity, corners, times, consider);
        }
        BoundaryKind::ParabolicInlet { mean } => {
            // A parabola peaks at 3/2 of its mean, along every axis on which there is one.
            let is_across = |a: &usize| {
                *a != axis
                    && fluid.cells[*a] > 1
                    && (boundary.part.patch().is_some() || !case.domain.periodic[*a])
            };
            let mut velocity = [0.0; 3];
            velocity[axis] = mean * 1.5_f64.powi((0..3).filter(is_across).count() as i32);
            consider(velocity);
        }
        BoundaryKind::FlowInlet { profile, .. } => {
            let Some((flow, factor)) = boundary.kind.flow(fluid.density) else { return };
            let extents = case.domain.extents();
            let whole = || (0..3).filter(|&a| a != axis).map(|a| extents[a]).product();
            let area: f64 = boundary.part.outline().map_or_else(whole, |outline| outline.area(axis));
            // The middle of a disc has twice the mean, that of a square 9/4.
            let peak = if *profile == FlowProfile::Parabolic { 2.25 } else { 1.0 };
            let Ok(formula) = flow.compile() else { return };
            for &time in times {
                let mut velocity = [0.0; 3];
                velocity[axis] = peak * factor * formula.at([0.0; 3], time) / area;
                consider(velocity);
            }
        }
        BoundaryKind::PressureInlet { .. } | BoundaryKind::Outlet { .. } | BoundaryKind::Symmetry => {}
    }
}

/// The values of a velocity on a lattice between two corners (m), edges included, at some times (s).
fn sample(
    velocity: &[Expression; 3],
    [lower, upper]: [[f64; 3]; 2],
    times: &[f64],
    consider: &mut impl FnMut([f64; 3]),
) {
    if let [Expression::Number(x), Expression::Number(y), Expression::Number(z)] = velocity {
        return consider([*x, *y, *z]);
    }
    let formulas: Vec<_> = velocity.iter().filter_map(|component| component.compile().ok()).collect();
    let [x, y, z] = &formulas[..] else { return };
    for sample in 0..SAMPLES.pow(3) {
        let place = [sample % SAMPLES, sample / SAMPLES % SAMPLES, sample / SAMPLES.pow(2)];
        let at = [0, 1, 2].map(|a| lower[a] + (upper[a] - lower[a]) * place[a] as f64 / (SAMPLES - 1) as f64);
        times.iter().for_each(|&time| consider([x, y, z].map(|formula| formula.at(at, time))));
    }
}
