//! The way to a steady flow: pseudo-steps, their acceleration, and when it has settled.

use grains_case::Steady as Given;
use grains_comm::MpiTransport;
use grains_dem::Dem;
use grains_domain::Transport;
use grains_fluid::{Anderson, Flow, Scalars};
use grains_geometry::Vec3;
use grains_resolved::{FlowLink, Resolved};
use std::collections::VecDeque;

/// Steps over which changes are compared with those before.
const WINDOW: usize = 6;
/// Ratio of these changes from which nothing is known of the limit (-).
const SLOWEST: f64 = 0.95;
/// Share of the time in which resistance stops the flow that a step takes (-): longer ones leave the pressure behind.
const SHARE: f64 = 0.5;
/// Smallest diffusion number ν Δτ/Δx² by that rule (-).
const LEAST: f64 = 0.2;
/// Ratio of wanted to present longest step from which that is changed (-).
const CHANGED: f64 = 1.25;

/// What is unsettled, over itself: forces on bodies and walls, pressure gradients, mean velocities.
pub type Unsettled = [f64; 3];

/// Names of the columns of what is unsettled.
pub const COLUMNS: [(&str, &str); 3] =
    [("unsettled_force", "-"), ("unsettled_gradient", "-"), ("unsettled_velocity", "-")];
/// That of scalars.
pub const OF_SCALARS: (&str, &str) = ("unsettled_scalars", "-");

/// The search for a steady flow.
pub struct Steady {
    given: Given,
    acceleration: Anderson,
    /// Forces (N), pressure gradients (Pa/m) and mean velocities (m/s) of the last steps, the newest last.
    known: VecDeque<[Vec<f64>; 3]>,
    /// What may still change of each.
    pub unsettled: Unsettled,
    /// Contents of the scalars over their ranges (-), and rates at which each comes in and reacts, of the last steps.
    known_scalars: Vec<VecDeque<[Vec<f64>; 3]>>,
    /// What may still change of these, at most; none without scalars.
    pub unsettled_scalars: Option<f64>,
    /// Longest step (s) that pressure and velocity settle in.
    pub longest: f64,
}

impl Steady {
    /// The search that a case asks for; steps of the flow are pseudo-steps from here on.
    pub fn new(given: Given, flow: &mut Flow) -> Self {
        flow.seek_steady();
        Self {
            given,
            acceleration: Anderson::new(given.history as usize),
            known: VecDeque::new(),
            unsettled: [f64::INFINITY; 3],
            known_scalars: vec![VecDeque::new(); flow.scalars.as_ref().map_or(0, |s| s.all.len())],
            unsettled_scalars: flow.scalars.as_ref().map(|_| f64::INFINITY),
            longest: f64::INFINITY,
        }
    }

    /// Whether nothing changes by more than the tolerance any more.
    pub fn is_settled(&self) -> bool {
        self.is_flow_settled() && self.unsettled_scalars.is_none_or(|x| x < self.given.tolerance)
    }

    /// Whether the flow does not: scalars are carried by it from then on.
    pub fn is_flow_settled(&self) -> bool {
        self.unsettled.iter().all(|&x| x < self.given.tolerance)
    }

    /// Whether the scalars still wait for their first step.
    pub fn has_no_step_of_scalars(&self) -> bool {
        self.known_scalars.iter().all(VecDeque::is_empty)
    }

    /// Looks at what a step `dt` (s) of the scalars led to; collective.
    pub fn end_of_scalars(&mut self, flow: &Flow, dt: f64, transport: &MpiTransport) {
        let Some(scalars) = &flow.scalars else { return };
        let mut largest = 0.0_f64;
        for (number, known) in self.known_scalars.iter_mut().enumerate() {
            known.push_back(measured_scalar(scalars, number, dt, transport));
            if known.len() > 2 * WINDOW + 1 {
                known.pop_front();
            }
            largest = unsettled(known.make_contiguous()).into_iter().fold(largest, f64::max);
        }
        self.unsettled_scalars = Some(largest);
    }

    /// Notes the state before a pseudo-step (s).
    pub fn begin(&mut self, flow: &mut Flow, dt: f64) {
        self.acceleration.begin(flow, dt);
    }

    /// Looks at what a pseudo-step (s) led to, and accelerates unless it has settled; collective.
    pub fn end(
        &mut self,
        (dem, resolved): (&Dem, Option<&Resolved>),
        flow: &mut Flow,
        dt: f64,
        transport: &MpiTransport,
    ) {
        let now = measured((dem, resolved), flow, transport);
        self.limit(&now, flow);
        self.known.push_back(now);
        if self.known.len() > 2 * WINDOW + 1 {
            self.known.pop_front();
        }
        self.unsettled = unsettled(self.known.make_contiguous());
        if !self.is_settled() {
            self.acceleration.combine(flow, dt, transport);
        }
    }

    /// Forgets the steps that are combined: no further ones follow, and what is written needs the room.
    pub fn forget_steps(&mut self) {
        self.acceleration = Anderson::new(self.given.history as usize);
    }

    /// Longest step for the resistance that the flow meets, U/(|∇p|/ρ) of which is the time in which that would stop it.
    fn limit(&mut self, [forces, gradients, velocities]: &[Vec<f64>; 3], flow: &Flow) {
        let setup = &flow.setup;
        let volume = setup.grid.volume();
        let of_forces = Vec3::from_fn(|a, _| forces.iter().skip(a).step_by(3).sum::<f64>()).norm() / volume;
        let resistance = norm(gradients).max(of_forces) / setup.density;
        let axes = (0..3).filter(|&a| setup.grid.is_active(a));
        let width = axes.map(|a| setup.grid.axis(a).width(0)).fold(f64::INFINITY, f64::min);
        let least = LEAST * width * width * setup.density / setup.viscosity;
        let wanted = (SHARE * norm(velocities) / resistance).max(least);
        if wanted.is_finite() && !(self.longest / CHANGED..=self.longest * CHANGED).contains(&wanted) {
            self.longest = wanted;
        }
    }
}

/// Forces on all bodies together and on each wall (N), mean pressure gradients (Pa/m), mean velocities (m/s).
fn measured(
    (dem, resolved): (&Dem, Option<&Resolved>),
    flow: &Flow,
    transport: &MpiTransport,
) -> [Vec<f64>; 3] {
    let own = &dem.particles.cargo[..dem.particles.owned.min(dem.particles.cargo.len())];
    let force: Vec3 = own.iter().map(|cargo| FlowLink::read(cargo).force).sum();
    let mut forces = vec![force.x, force.y, force.z];
    transport.sum(&mut forces);
    let on_walls = resolved.iter().flat_map(|resolved| &resolved.on_walls);
    forces.extend(on_walls.flat_map(|on_wall| on_wall.force.iter().copied().collect::<Vec<f64>>()));
    let grid = &flow.setup.grid;
    let gradient = |axis: usize| match grid.axis(axis).is_periodic() || !grid.is_active(axis) {
        true => flow.state.force[axis],
        false => {
            let ends = [0, grid.axis(axis).cells() - 1].map(|cell| flow.mean_pressure(axis, cell, transport));
            (ends[0] - ends[1]) / grid.axis(axis).length()
        }
    };
    let velocity = |axis: usize| if grid.is_active(axis) { flow.mean_velocity(axis, transport) } else { 0.0 };
    [forces, (0..3).map(gradient).collect(), (0..3).map(velocity).collect()]
}

/// Mean of a scalar over its range (-), and the rates at which it reacts and comes from bodies and walls (unit m³/s).
fn measured_scalar(scalars: &Scalars, number: usize, dt: f64, transport: &MpiTransport) -> [Vec<f64>; 3] {
    let ([content, of_unit], [least, largest]) = scalars.sums(number);
    let scalar = &scalars.all[number];
    let bodies = scalars.solids.as_ref().map_or(0, |solids| solids.bodies).min(scalar.gained.len());
    let (of_bodies, of_walls) = scalar.gained.split_at(bodies);
    let rate = |amounts: &[f64]| amounts.iter().sum::<f64>() / dt;
    let mut sums = [content, of_unit, rate(of_bodies), rate(of_walls), rate(&scalar.reacted)];
    transport.sum(&mut sums);
    let mut ends = [-least, largest];
    transport.max(&mut ends);
    let range = ends[1] + ends[0];
    let mean = if range > 0.0 { (sums[0] / sums[1] + ends[0]) / range } else { 0.0 };
    [vec![mean], sums[2..].to_vec(), Vec::new()]
}

/// What each quantity may still change by, over itself: as much as in the last steps, or the rest of the geometric series of this
/// and the change in as many steps before.
fn unsettled(known: &[[Vec<f64>; 3]]) -> Unsettled {
    std::array::from_fn(|k| {
        let Some(now) = known.last().filter(|_| known.len() > 2 * WINDOW) else { return f64::INFINITY };
        let change = |end: usize| {
            let last = &known[end][k];
            let apart = known[end - WINDOW..end].iter().map(|q| distance(&q[k], last));
            apart.fold(0.0, f64::max)
        };
        let [before, last] = [known.len() - 1 - WINDOW, known.len() - 1].map(change);
        if last == 0.0 {
            return 0.0;
        }
        let ratio = (last / before).min(SLOWEST);
        last / norm(&now[k]) * (ratio / (1.0 - ratio)).max(1.0)
    })
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::{WINDOW, unsettled};

    /// What is said to be left of a geometric series is never less than what is.
    #[test]
    fn the_rest_of_a_series_is_within_what_is_unsettled() {
        for ratio in [0.3_f64, 0.7, 0.9, -0.9, 0.97] {
            let value = |n: usize| 2.0 + ratio.powi(n as i32);
            let known: Vec<_> = (0..60).map(|n| [vec![value(n)], vec![0.0], vec![1.0]]).collect();
            for end in 2 * WINDOW + 1..60 {
                let [left, nothing, constant] = unsettled(&known[..end]);
                assert!(left >= 0.99 * (value(end - 1) - 2.0).abs() / 3.0, "{ratio} {end}: {left}");
                assert_eq!([nothing, constant], [0.0; 2]);
            }
        }
        assert!(unsettled(&[const { [Vec::new(), Vec::new(), Vec::new()] }; WINDOW])[0].is_infinite());
    }
}
