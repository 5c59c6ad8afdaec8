//! Contacts between spheres: the closed form, once per rank and pair.
//!
//! Pairs are taken in blocks. What the law needs of those that touch is laid side by side; their forces are found, several
//! at a time in the lanes of the processor; and these are added to the loads. Pairs that touch are kept at the front of
//! their block. All of a block stays in the first-level cache.

use super::batch::{Batch, BatchedContact, ContactColumns};
use super::lanes::{BLOCK, Columns, set, vector_at};
use super::loads::ContactPoint;
use super::pass::{ContactPass, Overlapping, PassStatistics};
use crate::contact_history::LawHistory;
use crate::films::{Partner, end_bridge, follow_bridge};
use crate::particles::{Body, Particles};
use grains_contact::{Encounter, PreparedLaw, RollingContact, reduced_mass};
use grains_domain::prefetch;
use grains_geometry::Vec3;
use multiversion::multiversion;
use std::ops::Range;

/// Two spheres near each other and the tangential displacement between them (m), as seen from `a`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SpherePair {
    /// An owned sphere.
    pub(crate) a: u32,
    /// Another, owned or clone.
    pub(crate) b: u32,
    pub(crate) tangential_displacement: Vec3,
}

/// Adds the loads of all contacts between spheres.
///
/// The arithmetic is antisymmetric in the two bodies, operation by operation, so it does not matter
/// which of them this rank takes for the first; and it is the same in lanes of any width.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
pub(crate) fn add_forces(
    particles: &mut Particles,
    (pairs, histories): (&mut [SpherePair], &mut [LawHistory]),
    pass: &mut ContactPass,
) {
    let (quanta, dt) = (pass.quanta, pass.dt);
    let mut batch = Batch::<SphereColumns>::default();
    let (mut rest, mut rest_of_histories) = (pairs, histories);
    while !rest.is_empty() {
        let (block, after) = rest.split_at_mut(BLOCK.min(rest.len()));
        rest = after;
        let (histories, after) = rest_of_histories.split_at_mut(BLOCK.min(rest_of_histories.len()));
        rest_of_histories = after;
        // What the next block needs is on its way while this one is worked on.
        let next = &rest[..BLOCK.min(rest.len())];
        if particles.len() > IN_CACHE {
            for pair in next {
                let other = pair.b as usize;
                prefetch(&particles.bodies, other);
                prefetch(&particles.loads, other);
            }
        } else {
            (0..next.len()).step_by(2).for_each(|k| prefetch(next, k));
        }
        let mut places = 0..block.len();
        while let Some(law) = take(&mut batch, &mut places, (block, histories), particles, pass) {
            batch.evaluate(&law, &quanta, dt);
            give(&batch, (block, histories), particles, pass.statistics);
        }
    }
}

/// Particles up to which they come fast enough unasked (2 to 5 % slower if asked for; without, 100,000 take 1.5 times as long).
const IN_CACHE: usize = 30_000;

/// Two spheres, column by column.
struct SphereColumns {
    /// Centre of the second sphere from that of the first (m), and its square (m²).
    between: Columns<4>,
    /// Velocities (m/s) and masses (kg).
    velocities: [Columns<4>; 2],
    /// Angular velocities (rad/s) and radii (m).
    spins: [Columns<4>; 2],
}

impl Default for SphereColumns {
    fn default() -> Self {
        let four = [[0.0; BLOCK]; 4];
        Self { between: four, velocities: [four; 2], spins: [four; 2] }
    }
}

impl SphereColumns {
    #[inline(always)]
    fn set(&mut self, k: usize, between: [f64; 4], bodies: [&Body; 2]) {
        set(&mut self.between, k, between);
        for (side, body) in bodies.into_iter().enumerate() {
            let Body { velocity: v, angular_velocity: w, radius, .. } = body;
            set(&mut self.velocities[side], k, [v.x, v.y, v.z, body.contact_mass()]);
            set(&mut self.spins[side], k, [w.x, w.y, w.z, *radius]);
        }
    }
}

impl ContactColumns for SphereColumns {
    type Point = SpherePoint;

    #[inline(always)]
    fn contact(&self, k: usize) -> BatchedContact<SpherePoint> {
        let Self { between, velocities, spins } = self;
        let [mass, other_mass] = [0, 1].map(|side| velocities[side][3][k]);
        let [radius, other_radius] = [0, 1].map(|side| spins[side][3][k]);
        let distance = between[3][k].sqrt();
        let overlap = radius + other_radius - distance;
        let point = SpherePoint {
            normal: vector_at(between, k) * (1.0 / distance),
            overlap,
            arms: [radius - 0.5 * overlap, other_radius - 0.5 * overlap],
            velocities: [0, 1].map(|side| vector_at(&velocities[side], k)),
            spins: [0, 1].map(|side| vector_at(&spins[side], k)),
            inertias: [0.4 * mass * (radius * radius), 0.4 * other_mass * (other_radius * other_radius)],
        };
        let effective_mass = reduced_mass(mass, other_mass);
        let effective_radius = radius * other_radius / (radius + other_radius);
        BatchedContact { point, effective_mass, effective_radius, depth: overlap / radius.min(other_radius) }
    }
}

/// The point in which two spheres touch, midway in their overlap.
struct SpherePoint {
    normal: Vec3,
    overlap: f64,
    /// Distances of the point from both centres (m).
    arms: [f64; 2],
    velocities: [Vec3; 2],
    spins: [Vec3; 2],
    /// Moments of inertia (kg m²).
    inertias: [f64; 2],
}

impl ContactPoint for SpherePoint {
    #[inline(always)]
    fn encounter(&self) -> Encounter {
        let Self { normal, overlap, arms, velocities: [v, other_v], spins: [w, other_w], .. } = *self;
        let [arm, other_arm] = arms;
        let velocity = (other_v - v) - (w * arm + other_w * other_arm).cross(&normal);
        Encounter { normal, overlap, velocity, spin: w - other_w }
    }

    #[inline(always)]
    fn torques(&self, force: &Vec3) -> [Vec3; 2] {
        let moment = self.normal.cross(force);
        self.arms.map(|arm| moment * arm)
    }

    #[inline(always)]
    fn rolling(&self) -> RollingContact {
        let ([arm, other_arm], [inertia, other_inertia]) = (self.arms, self.inertias);
        RollingContact {
            effective_radius: arm * other_arm / (arm + other_arm),
            inverse_inertia: 1.0 / inertia + 1.0 / other_inertia,
        }
    }
}

/// Takes the pairs of a block at `places` that touch and have the two materials of the first of them; returns their law, none where
/// no pair touches.
///
/// Those taken are moved to the front and those apart, which lose their history, to the back; neither are at `places` any more.
/// So the next step finds them in this order, and the processor guesses which touch.
#[inline(always)]
fn take(
    batch: &mut Batch<SphereColumns>,
    places: &mut Range<usize>,
    (block, histories): (&mut [SpherePair], &mut [LawHistory]),
    particles: &mut Particles,
    pass: &mut ContactPass,
) -> Option<PreparedLaw> {
    batch.len = 0;
    while let Some(last) = places.clone().last()
        && between(&block[last], &particles.bodies, pass).is_none()
    {
        places.end = last;
        set_apart(last, (block, histories), particles, pass);
    }
    let (mut wanted, mut law, mut is_wet) = ((0, 0), None, false);
    let mut k = places.start;
    while k < places.end {
        let Some(between) = between(&block[k], &particles.bodies, pass) else {
            places.end -= 1;
            swap(k, places.end, (block, histories));
            set_apart(places.end, (block, histories), particles, pass);
            continue;
        };
        let pair = &block[k];
        let bodies = [pair.a, pair.b].map(|i| &particles.bodies[i as usize]);
        let materials = bodies.map(|body| body.kind.material);
        let materials = (materials[0].min(materials[1]), materials[0].max(materials[1]));
        if law.is_none() {
            let of_both = pass.catalogue.contacts.prepared(materials.0, materials.1);
            (wanted, law) = (materials, Some(*of_both));
            is_wet = particles.is_wet() && of_both.attraction.fed_by_films().is_some();
        }
        if materials == wanted {
            batch.columns.set(batch.len, between, bodies);
            batch.push(places.start as u32, &pair.tangential_displacement);
            swap(k, places.start, (block, histories));
            if let Some(history) = histories.get_mut(places.start) {
                if let (true, Some(law)) = (is_wet, &law) {
                    let pair = &block[places.start];
                    batch.set_films(follow(&mut history.bridge, pair, between[3], law, particles, pass));
                }
                batch.set_law_history(history);
            }
            places.start += 1;
        }
        k += 1;
    }
    law
}

/// Centre of the second sphere of a pair from that of the first (m), and its square (m²); none where they are out of reach.
#[inline(always)]
fn between(pair: &SpherePair, bodies: &[Body], pass: &ContactPass) -> Option<[f64; 4]> {
    let (body, other) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
    let reach = pass.catalogue.contacts.reach_between(body.kind.material, other.kind.material);
    let radii = body.radius + other.radius + reach;
    let between = other.position - body.position;
    let square = between.norm_squared();
    (square < radii * radii).then_some([between.x, between.y, between.z, square])
}

/// Swaps two pairs with their histories.
#[inline(always)]
fn swap(k: usize, other: usize, (block, histories): (&mut [SpherePair], &mut [LawHistory])) {
    if k != other {
        block.swap(k, other);
        if !histories.is_empty() {
            histories.swap(k, other);
        }
    }
}

/// Forgets the contact of a pair that is out of reach.
#[inline(always)]
fn set_apart(
    k: usize,
    (block, histories): (&mut [SpherePair], &mut [LawHistory]),
    particles: &mut Particles,
    pass: &mut ContactPass,
) {
    block[k].tangential_displacement = Vec3::zeros();
    if let Some(history) = histories.get_mut(k) {
        end(history, &block[k], particles, pass);
    }
}

/// Ends the history of a pair out of reach.
#[inline]
fn end(history: &mut LawHistory, pair: &SpherePair, particles: &mut Particles, pass: &mut ContactPass) {
    if history.bridge != 0.0 && particles.is_wet() {
        let (contacts, [a, b]) = (&pass.catalogue.contacts, [pair.a, pair.b].map(|i| i as usize));
        let [m, n] = [a, b].map(|i| particles.bodies[i].kind.material);
        let law = contacts.prepared(m, n);
        end_bridge(particles, (a, Partner::Particle(b)), (law, contacts), (&mut history.bridge, pass.liquid));
    }
    *history = LawHistory::default();
}

/// Lets the bridge of two spheres, whose centres have this square of a distance (m²), form or break; returns the thicknesses of
/// their films (m).
#[inline(never)]
fn follow(
    bridge: &mut f64,
    pair: &SpherePair,
    square: f64,
    law: &PreparedLaw,
    particles: &mut Particles,
    pass: &mut ContactPass,
) -> f64 {
    let [a, b] = [pair.a, pair.b].map(|i| i as usize);
    let radii = [a, b].map(|i| particles.bodies[i].radius);
    let gap = square.sqrt() - (radii[0] + radii[1]);
    let contacts = &pass.catalogue.contacts;
    follow_bridge(
        particles,
        (a, Partner::Particle(b)),
        (law, contacts),
        (gap, radii, radii),
        (bridge, pass.liquid),
    )
}

/// Adds the loads to the particles and gives the pairs their tangential displacements back.
#[inline(always)]
fn give(
    batch: &Batch<SphereColumns>,
    (block, histories): (&mut [SpherePair], &mut [LawHistory]),
    particles: &mut Particles,
    statistics: &mut PassStatistics,
) {
    for k in 0..batch.len.min(BLOCK) {
        let place = batch.pair[k] as usize;
        let pair = &mut block[place];
        if let Some(history) = histories.get_mut(place) {
            *history = batch.law_history(k);
        }
        pair.tangential_displacement = batch.tangential_displacement(k);
        batch.loads(k).add_to(particles, [pair.a, pair.b]);
        statistics.note(batch.depth(k), || overlapping(particles, [pair.a, pair.b]));
    }
}

#[cold]
fn overlapping(particles: &Particles, pair: [u32; 2]) -> Overlapping {
    let ids = pair.map(|i| particles.ids[i as usize]);
    let [body, other] = pair.map(|i| &particles.bodies[i as usize]);
    Overlapping {
        id: ids[0].min(ids[1]),
        other: format!("particle {}", ids[0].max(ids[1])),
        radius: body.radius.min(other.radius),
        position: body.position,
    }
}
