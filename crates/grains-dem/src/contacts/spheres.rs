//! Contacts between spheres: the closed form, once per rank and pair.
//!
//! Pairs are taken in blocks. Those of a block that touch are picked, without a branch that the processor could guess
//! wrong; what the law needs of them is laid side by side; their forces are found, several at a time in the lanes of
//! the processor; and these are added to the loads. All of a block stays in the first-level cache.

use super::lanes::{BLOCK, Columns, set, vector_at, whole_lanes};
use super::load_quanta::LoadLattice;
use super::pass_statistics::Tally;
use crate::catalogue::ContactTable;
use crate::error::{StepError, vector};
use crate::particles::{Body, Particles};
use grains_contact::{Contact, PreparedLaw, reduced_mass};
use grains_geometry::Vec3;
use multiversion::multiversion;

/// Two spheres near each other and the tangential spring between them (m), as seen from `a`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SpherePair {
    /// An owned sphere.
    pub(crate) a: u32,
    /// Another, owned or clone.
    pub(crate) b: u32,
    pub(crate) spring: Vec3,
}

/// Adds the loads of all contacts between spheres.
///
/// The arithmetic is antisymmetric in the two bodies, operation by operation, so it does not matter
/// which of them this rank takes for the first; and it is the same in lanes of any width.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
pub(crate) fn add_forces(
    particles: &mut Particles,
    pairs: &mut [SpherePair],
    contacts: &ContactTable,
    lattice: &LoadLattice,
    dt: f64,
    tally: &mut Tally,
) {
    let mut touching = Touching::default();
    let mut run = Run::default();
    let mut rest = pairs;
    while !rest.is_empty() {
        let (block, after) = rest.split_at_mut(BLOCK.min(rest.len()));
        rest = after;
        // Those of the next block are on their way while this one is worked on.
        let next = if particles.len() > IN_CACHE { &rest[..BLOCK.min(rest.len())] } else { &[] };
        for pair in next {
            let other = pair.b as usize;
            prefetch(&particles.bodies, other);
            prefetch(&particles.loads, other);
        }
        touching.pick(block, &particles.bodies);
        while touching.len > 0 {
            let law = run.take(&mut touching, block, &particles.bodies, contacts);
            run.evaluate(&law, lattice, dt);
            run.give(block, particles, tally);
        }
    }
}

/// Particles up to which they come fast enough unasked (2 % slower if asked for; 100,000 are 15 % faster).
const IN_CACHE: usize = 30_000;

/// Asks the memory for an item that will soon be needed; nothing happens if there is none.
#[inline(always)]
fn prefetch<T>(items: &[T], i: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(item) = items.get(i) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(item).cast::<i8>();
        // SAFETY: a prefetch reads nothing; both addresses are of the item.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch(first, _MM_HINT_T0);
            _mm_prefetch(first.add(size_of::<T>() - 1), _MM_HINT_T0);
        }
    }
}

/// The pairs of a block that touch.
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
    /// Picks the pairs that touch; those that do not forget their spring.
    #[inline(always)]
    fn pick(&mut self, block: &mut [SpherePair], bodies: &[Body]) {
        let (mut apart, mut ending) = ([0_u32; BLOCK], 0);
        self.len = 0;
        for (k, pair) in block.iter().enumerate() {
            let (body, other) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
            let radii = body.radius + other.radius;
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
            block[k as usize].spring = Vec3::zeros();
        }
    }
}

/// Contacts of a block under one law, side by side: what the law needs, and what it answers.
struct Run {
    len: usize,
    /// Index in the block.
    pair: [u32; BLOCK],
    /// Centre of the second sphere from that of the first (m), and its square (m²).
    between: Columns<4>,
    /// Velocities (m/s) and masses (kg).
    velocities: [Columns<4>; 2],
    /// Angular velocities (rad/s) and radii (m).
    spins: [Columns<4>; 2],
    /// Tangential springs (m), before and after.
    springs: Columns<3>,
    /// Force on the first sphere (N).
    forces: Columns<3>,
    /// Torques (N m).
    torques: [Columns<3>; 2],
    /// Overlap over the smaller radius (-).
    depth: [f64; BLOCK],
}

impl Default for Run {
    fn default() -> Self {
        let (three, four) = ([[0.0; BLOCK]; 3], [[0.0; BLOCK]; 4]);
        Self {
            len: 0,
            pair: [0; BLOCK],
            between: four,
            velocities: [four; 2],
            spins: [four; 2],
            springs: three,
            forces: three,
            torques: [three; 2],
            depth: [0.0; BLOCK],
        }
    }
}

impl Run {
    /// Takes from the contacts of a block those of the same two materials as the first of them; returns their law.
    #[inline(always)]
    fn take(
        &mut self,
        touching: &mut Touching,
        block: &[SpherePair],
        bodies: &[Body],
        contacts: &ContactTable,
    ) -> PreparedLaw {
        let materials = |pair: &SpherePair| {
            let [a, b] = [pair.a, pair.b].map(|i| bodies[i as usize].kind.material);
            (a.min(b), a.max(b))
        };
        let wanted = materials(&block[touching.pair[0] as usize]);
        let mut left = 0;
        self.len = 0;
        for k in 0..touching.len.min(BLOCK) {
            let (index, between) = (touching.pair[k], touching.between[k]);
            let pair = &block[index as usize];
            if materials(pair) != wanted {
                (touching.pair[left], touching.between[left]) = (index, between);
                left += 1;
                continue;
            }
            let at = self.len;
            self.pair[at] = index;
            set(&mut self.between, at, between);
            set(&mut self.springs, at, pair.spring.into());
            for (side, i) in [pair.a, pair.b].into_iter().enumerate() {
                let body = &bodies[i as usize];
                let Body { velocity: v, angular_velocity: w, radius, .. } = body;
                set(&mut self.velocities[side], at, [v.x, v.y, v.z, body.mass_felt()]);
                set(&mut self.spins[side], at, [w.x, w.y, w.z, *radius]);
            }
            self.len += 1;
        }
        touching.len = left;
        *contacts.prepared(wanted.0, wanted.1)
    }

    /// Forces and torques of all contacts.
    #[inline(always)]
    fn evaluate(&mut self, law: &PreparedLaw, lattice: &LoadLattice, dt: f64) {
        let Self { between, velocities, spins, springs, forces, torques, depth, .. } = self;
        for k in whole_lanes(self.len) {
            let [mass, other_mass] = [0, 1].map(|side| velocities[side][3][k]);
            let [radius, other_radius] = [0, 1].map(|side| spins[side][3][k]);
            let [v, other_v] = [0, 1].map(|side| vector_at(&velocities[side], k));
            let [w, other_w] = [0, 1].map(|side| vector_at(&spins[side], k));
            let distance = between[3][k].sqrt();
            let overlap = radius + other_radius - distance;
            let normal = vector_at(between, k) * (1.0 / distance);
            let (arm, other_arm) = (radius - 0.5 * overlap, other_radius - 0.5 * overlap);
            let velocity = (other_v - v) - (w * arm + other_w * other_arm).cross(&normal);
            let contact = Contact { normal, overlap, velocity };
            let coefficients = law.at(reduced_mass(mass, other_mass));
            let mut spring = vector_at(springs, k);
            let force = lattice.force(&coefficients.force(&contact, &mut spring, dt));
            let moment = normal.cross(&force);
            let mut torque = lattice.torque(&(moment * arm));
            let mut other_torque = lattice.torque(&(moment * other_arm));
            if law.resists_rolling() {
                let effective = arm * other_arm / (arm + other_arm);
                let rolling = coefficients.rolling_torque(&contact, &(w - other_w), effective);
                let rolling = lattice.torque(&rolling);
                torque += rolling;
                other_torque -= rolling;
            }
            set(springs, k, spring.into());
            set(forces, k, force.into());
            set(&mut torques[0], k, torque.into());
            set(&mut torques[1], k, other_torque.into());
            depth[k] = overlap / radius.min(other_radius);
        }
    }

    /// Adds the loads to the particles and gives the pairs their springs back.
    #[inline(always)]
    fn give(&self, block: &mut [SpherePair], particles: &mut Particles, tally: &mut Tally) {
        for k in 0..self.len.min(BLOCK) {
            let pair = &mut block[self.pair[k] as usize];
            let (i, j) = (pair.a as usize, pair.b as usize);
            pair.spring = vector_at(&self.springs, k);
            let force = vector_at(&self.forces, k);
            let load = &mut particles.loads[i];
            load.force += force;
            load.torque += vector_at(&self.torques[0], k);
            if let Some(load) = particles.loads.get_mut(j) {
                load.force -= force;
                load.torque += vector_at(&self.torques[1], k);
            }
            if tally.note(self.depth[k]) {
                tally.error = Some(too_deep(tally, particles, [i, j], self.depth[k]));
            }
        }
    }
}

#[cold]
fn too_deep(tally: &Tally, particles: &Particles, pair: [usize; 2], depth: f64) -> StepError {
    let ids = pair.map(|i| particles.ids[i]);
    let [body, other] = pair.map(|i| &particles.bodies[i]);
    StepError::Overlap {
        id: ids[0].min(ids[1]),
        other: format!("particle {}", ids[0].max(ids[1])),
        overlap: depth * body.radius.min(other.radius),
        percent: 100.0 * depth,
        limit: 100.0 * tally.limit(),
        place: vector(&body.position),
    }
}
