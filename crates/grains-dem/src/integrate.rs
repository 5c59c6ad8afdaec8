//! The second-order leap-frog (thesis eq. 3.13) with rotation.
//!
//! Velocities live half a step between positions. Contact forces need them at the positions' time; the
//! stored velocity is extrapolated by half a step with the last acceleration, which keeps the damped
//! contact second order in dt, where the lagged velocity of most codes is first order.

use crate::catalogue::Catalogue;
use crate::particles::{Load, Particles};
use crate::prescribed::Course;
use crate::rotation::{FreeRotors, angular_velocity};
use crate::tunnelling;
use crate::verlet::{Reference, VerletLists};
use grains_domain::GlobalBox;
use grains_geometry::Vec3;

/// What changes all velocities alike.
#[derive(Clone, Copy, Debug)]
pub struct StepParameters {
    /// Gravity (m/s²).
    pub gravity: Vec3,
    /// Time step (s).
    pub dt: f64,
}

/// Velocity half a step before a particle is placed with `velocity` (m/s): it has flown freely until then.
pub fn half_step_back(velocity: Vec3, parameters: &StepParameters) -> Vec3 {
    velocity - parameters.gravity * (0.5 * parameters.dt)
}

/// Velocity v(t − Δt'/2) that goes with the velocity v(t) and v(t − Δt/2) under the same acceleration, of `ratio` Δt'/Δt; any
/// that the leap-frog kicks, as angular momenta.
pub fn other_half_step(now: Vec3, half: Vec3, ratio: f64) -> Vec3 {
    now - (now - half) * ratio
}

/// Kicks and drifts all owned particles and empties their loads; returns whether the lists are stale.
pub(crate) fn advance(
    particles: &mut Particles,
    neighbours: &VerletLists,
    catalogue: &Catalogue,
    (global, courses): (&GlobalBox, &[Course]),
    parameters: &StepParameters,
    largest_force: f64,
) -> Advance {
    let mut outcome = Advance { is_stale: false, overloaded: None, fast: Vec::new() };
    let (all_spheres, positions) = (catalogue.all_spheres(), &global.quantum);
    let (half, dt) = (0.5 * parameters.dt, parameters.dt);
    let mut turning = Turning::default();
    for i in 0..particles.owned {
        let load = std::mem::take(&mut particles.loads[i]);
        let body = &mut particles.bodies[i];
        if load.force.amax() > largest_force {
            outcome.overloaded = Some((i, load.force.norm()));
        }
        if body.is_prescribed() {
            move_prescribed(particles, i, (global, courses), catalogue, dt, &mut outcome.fast);
            outcome.is_stale |= !is_within_allowance(particles, neighbours, i);
            continue;
        }
        let acceleration = load.force * (1.0 / body.mass) + parameters.gravity;
        let velocity = particles.half_velocity[i] + acceleration * dt;
        particles.half_velocity[i] = velocity;
        body.velocity = velocity + acceleration * half;
        let before = body.position;
        // Only the displacement is rounded: the position stays on the quanta.
        body.position += (velocity * dt).map(|d| positions.round(d));
        if all_spheres || catalogue.shape(body.kind).is_sphere() {
            // I = 2/5 M R²
            let acceleration = load.torque * (2.5 / (body.mass * body.radius * body.radius));
            let spin = particles.half_spin[i] + acceleration * dt;
            particles.half_spin[i] = spin;
            body.angular_velocity = spin + acceleration * half;
            if velocity.norm_squared() * (dt * dt) > body.radius * body.radius {
                outcome.fast.push(i);
            }
            if !all_spheres {
                particles.path_length[i] += (body.position - before).norm();
            }
        } else {
            turning.push(i, before, load);
            if turning.is_full() {
                outcome.is_stale |= turning.turn(particles, neighbours, catalogue, dt, &mut outcome.fast);
            }
            continue;
        }
        outcome.is_stale |= !is_within_allowance(particles, neighbours, i);
    }
    outcome.is_stale |= turning.turn(particles, neighbours, catalogue, dt, &mut outcome.fast);
    outcome
}

/// Leads a particle of prescribed motion through the step.
#[cold]
fn move_prescribed(
    particles: &mut Particles,
    i: usize,
    (global, courses): (&GlobalBox, &[Course]),
    catalogue: &Catalogue,
    dt: f64,
    fast: &mut Vec<usize>,
) {
    let body = &mut particles.bodies[i];
    let course = &courses[usize::from(body.prescribed) - 1];
    let before = body.position;
    let after = course.advance(body, global, dt);
    (body.position, body.velocity) = (after.position, after.velocity);
    body.angular_velocity = after.angular_velocity;
    let [velocity, spin] = after.mean;
    (particles.half_velocity[i], particles.half_spin[i]) = (velocity, spin);
    if !catalogue.shape(body.kind).is_sphere() {
        let inertia = catalogue.inertia(body);
        if course.turns() {
            let orientation = course.turned(&particles.orientations[i]);
            particles.turn_to(i, &before, orientation);
        } else {
            particles.path_length[i] += (after.position - before).norm();
        }
        let frame = &particles.frames[i];
        particles.half_spin[i] = frame * inertia.component_mul(&frame.tr_mul(&spin));
        if tunnelling::is_fast(catalogue, &particles.bodies[i], dt) {
            fast.push(i);
        }
        return;
    }
    if !catalogue.all_spheres() {
        particles.path_length[i] += (after.position - before).norm();
    }
    // A sphere is where it is, however it turns.
    if velocity.norm() * dt > particles.bodies[i].radius {
        fast.push(i);
    }
}

/// What a pass over the particles found.
pub(crate) struct Advance {
    /// Whether some particle went beyond its allowance.
    pub(crate) is_stale: bool,
    /// A particle under a force (N) that the sums cannot hold.
    pub(crate) overloaded: Option<(usize, f64)>,
    /// Particles that went farther than they are thick by half.
    pub(crate) fast: Vec<usize>,
}

/// Bodies turned together.
const TOGETHER: usize = 8;

/// Bodies that have moved and are still to be turned: the particle, the position (m) it came from, its load.
#[derive(Default)]
struct Turning {
    count: usize,
    waiting: [(usize, Vec3, Load); TOGETHER],
}

impl Turning {
    fn push(&mut self, i: usize, before: Vec3, load: Load) {
        self.waiting[self.count] = (i, before, load);
        self.count += 1;
    }

    fn is_full(&self) -> bool {
        self.count == TOGETHER
    }

    /// Turns them: L(t + dt/2) = L(t − dt/2) + T dt, then free rotation over dt. Returns whether one is out of its allowance.
    fn turn(
        &mut self,
        particles: &mut Particles,
        neighbours: &VerletLists,
        catalogue: &Catalogue,
        dt: f64,
        fast: &mut Vec<usize>,
    ) -> bool {
        let waiting = &self.waiting[..std::mem::take(&mut self.count)];
        let mut tops = FreeRotors::<TOGETHER>::default();
        let mut inertias = [Vec3::zeros(); TOGETHER];
        for (lane, (i, _, load)) in waiting.iter().enumerate() {
            let spin = &mut particles.half_spin[*i];
            *spin += load.torque * dt;
            inertias[lane] = catalogue.inertia(&particles.bodies[*i]);
            tops.set(lane, &particles.orientations[*i], &inertias[lane], spin, dt);
        }
        tops.rotate_freely();
        let mut is_stale = false;
        for (lane, (i, before, load)) in waiting.iter().enumerate() {
            let i = *i;
            particles.turn_to(i, before, tops.orientation(lane));
            let predicted = particles.half_spin[i] + load.torque * (0.5 * dt);
            particles.bodies[i].angular_velocity =
                angular_velocity(&particles.frames[i], &inertias[lane], &predicted);
            is_stale |= !is_within_allowance(particles, neighbours, i);
            if tunnelling::is_fast(catalogue, &particles.bodies[i], dt) {
                fast.push(i);
            }
        }
        is_stale
    }
}

/// Whether particle `i` has moved and turned less than its allowance; false if it is no longer a number.
#[inline(always)]
fn is_within_allowance(particles: &Particles, neighbours: &VerletLists, i: usize) -> bool {
    let Reference { position, allowance } = neighbours.references.places[i];
    let moved = particles.bodies[i].position - position;
    match neighbours.references.turned(particles, i) {
        None => moved.norm_squared() < allowance * allowance,
        Some(turned) => moved.norm() + turned < allowance,
    }
}
