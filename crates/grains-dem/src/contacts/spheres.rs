//! Contacts between spheres: the closed form, once per rank and pair.
//!
//! Pairs are taken in blocks. Those of a block that touch are picked, without a branch that the processor could guess
//! wrong; what the law needs of them is laid side by side; their forces are found, several at a time in the lanes of
//! the processor; and these are added to the loads. All of a block stays in the first-level cache.

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
    let (contacts, quanta, dt) = (&pass.catalogue.contacts, pass.quanta, pass.dt);
    let reach = contacts.reach();
    let mut touching = Touching::default();
    let mut batch = Batch::<SphereColumns>::default();
    let (mut rest, mut rest_of_histories) = (pairs, histories);
    while !rest.is_empty() {
        let (block, after) = rest.split_at_mut(BLOCK.min(rest.len()));
        rest = after;
        let (histories, after) = rest_of_histories.split_at_mut(BLOCK.min(rest_of_histories.len()));
        rest_of_histories = after;
        // Those of the next block are on their way while this one is worked on.
        let next = if particles.len() > IN_CACHE { &rest[..BLOCK.min(rest.len())] } else { &[] };
        for pair in next {
            let other = pair.b as usize;
            prefetch(&particles.bodies, other);
            prefetch(&particles.loads, other);
        }
        touching.pick((block, histories), particles, pass, reach);
        while touching.len > 0 {
            let law = take(&mut batch, &mut touching, (block, histories), particles, pass);
            batch.evaluate(&law, &quanta, dt);
            give(&batch, (block, histories), particles, pass.statistics);
        }
    }
}

/// Particles up to which they come fast enough unasked (2 % slower if asked for; 100,000 are 15 % faster).
const IN_CACHE: usize = 30_000;

/// The pairs of a block that touch or are within reach.
struct Touching {
    len: usize,
    /// Index in the block.
    pair: [u32; BLOCK],
    /// Centre of the second sphere from that of the first (m), and its square (m²).
    between: [[f64; 4]; BLOCK],
}

impl Default for Touching {
    fn default() -> Self {
        Self { len: 0, pair: [0; BLOCK], between: [[0.0; 4]; BLOCK] }
    }
}

impl Touching {
    /// Picks the pairs that touch, or are within `reach` (m); others lose their history.
    #[inline(always)]
    fn pick(
        &mut self,
        (block, histories): (&mut [SpherePair], &mut [LawHistory]),
        particles: &mut Particles,
        pass: &mut ContactPass,
        reach: f64,
    ) {
        let bodies = &particles.bodies;
        let (mut apart, mut ending) = ([0_u32; BLOCK], 0);
        self.len = 0;
        for (k, pair) in block.iter().enumerate() {
            let (body, other) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
            let radii = body.radius + other.radius + reach;
            let between = other.position - body.position;
            let square = between.norm_squared();
            let touches = square < radii * radii;
            self.pair[self.len] = k as u32;
            self.between[self.len] = [between.x, between.y, between.z, square];
            apart[ending] = k as u32;
            self.len += usize::from(touches);
            ending += usize::from(!touches);
        }
        for &k in &apart[..ending] {
            block[k as usize].tangential_displacement = Vec3::zeros();
        }
        if !histories.is_empty() {
            for &k in &apart[..ending] {
                end(&mut histories[k as usize], &block[k as usize], particles, pass);
            }
        }
    }
}

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

/// Takes from the contacts of a block those of the same two materials as the first of them; returns their law.
#[inline(always)]
fn take(
    batch: &mut Batch<SphereColumns>,
    touching: &mut Touching,
    (block, histories): (&mut [SpherePair], &mut [LawHistory]),
    particles: &mut Particles,
    pass: &mut ContactPass,
) -> PreparedLaw {
    let contacts = &pass.catalogue.contacts;
    let materials = |pair: &SpherePair, bodies: &[Body]| {
        let [a, b] = [pair.a, pair.b].map(|i| bodies[i as usize].kind.material);
        (a.min(b), a.max(b))
    };
    let wanted = materials(&block[touching.pair[0] as usize], &particles.bodies);
    // What is within the reach of the run may be beyond that of these materials.
    let reach = contacts.reach_between(wanted.0, wanted.1);
    let law = *contacts.prepared(wanted.0, wanted.1);
    let is_wet = particles.is_wet() && law.attraction.fed_by_films().is_some();
    let is_shorter = reach < contacts.reach();
    let mut left = 0;
    batch.len = 0;
    for k in 0..touching.len.min(BLOCK) {
        let (index, between) = (touching.pair[k], touching.between[k]);
        let pair = &mut block[index as usize];
        let bodies = &particles.bodies;
        if materials(pair, bodies) != wanted {
            (touching.pair[left], touching.between[left]) = (index, between);
            left += 1;
            continue;
        }
        if is_shorter {
            let radii = bodies[pair.a as usize].radius + bodies[pair.b as usize].radius + reach;
            if between[3] >= radii * radii {
                pair.tangential_displacement = Vec3::zeros();
                if let Some(history) = histories.get_mut(index as usize) {
                    end(history, pair, particles, pass);
                }
                continue;
            }
        }
        batch.columns.set(batch.len, between, [pair.a, pair.b].map(|i| &bodies[i as usize]));
        batch.push(index, &pair.tangential_displacement);
        if let Some(history) = histories.get_mut(index as usize) {
            if is_wet {
                batch.set_films(follow(&mut history.bridge, pair, between[3], &law, particles, pass));
            }
            batch.set_law_history(history);
        }
    }
    touching.len = left;
    law
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
