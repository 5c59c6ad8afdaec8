//! Contacts between spheres: the closed form, once per rank and pair.

use crate::error::vector;
use crate::forces::{LoadLattice, Tally};
use crate::{Body, ContactTable, Particles, StepError};
use grains_contact::{Coefficients, Contact, reduced_mass};
use grains_geometry::Vec3;

/// Two spheres near each other and the tangential spring between them (m), as seen from `a`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SpherePair {
    /// An owned sphere.
    pub(crate) a: u32,
    /// A sphere behind it in the arrays, owned or clone.
    pub(crate) b: u32,
    pub(crate) spring: Vec3,
}

/// Adds the loads of all contacts between spheres.
///
/// The arithmetic is antisymmetric in the two bodies, operation by operation, so it does not matter
/// which of them this rank takes for the first. Pairs are taken block by block: first those that touch are
/// picked, without a branch that the processor could guess wrong, then their forces are added.
pub(crate) fn add_forces(
    particles: &mut Particles,
    pairs: &mut [SpherePair],
    contacts: &ContactTable,
    lattice: &LoadLattice,
    dt: f64,
    tally: &mut Tally,
) {
    let owned = particles.owned;
    let bodies = &particles.bodies[..];
    let loads = &mut particles.loads[..owned];
    let mut known = KnownPair::default();
    let mut touching = Touching::default();
    for block in pairs.chunks_mut(BLOCK) {
        touching.pick(block, bodies);
        for k in 0..touching.len {
            let pair = &mut block[touching.pair[k] as usize];
            let (i, j) = (pair.a as usize, pair.b as usize);
            let (body, other) = (&bodies[i], &bodies[j]);
            let overlap = body.radius + other.radius - touching.distance[k];
            let normal = (other.position - body.position) * touching.inverse[k];
            let (arm, other_arm) = (body.radius - 0.5 * overlap, other.radius - 0.5 * overlap);
            let turning = body.angular_velocity * arm + other.angular_velocity * other_arm;
            let contact = Contact {
                normal,
                overlap,
                velocity: (other.velocity - body.velocity) - turning.cross(&normal),
            };
            let law = known.of(body, other, contacts);
            let force = lattice.force(&law.force(&contact, &mut pair.spring, dt));
            let moment = normal.cross(&force);
            let mut torque = lattice.torque(&(moment * arm));
            let mut other_torque = lattice.torque(&(moment * other_arm));
            if law.resists_rolling() {
                let spin = body.angular_velocity - other.angular_velocity;
                let rolling =
                    lattice.torque(&law.rolling_torque(&contact, &spin, arm * other_arm / (arm + other_arm)));
                torque += rolling;
                other_torque -= rolling;
            }
            loads[i].force += force;
            loads[i].torque += torque;
            if j < owned {
                loads[j].force -= force;
                loads[j].torque += other_torque;
            }
            if tally.note(overlap, body.radius.min(other.radius)) {
                tally.error = Some(too_deep(tally, particles.ids[i], particles.ids[j], overlap, body, other));
            }
        }
    }
}

/// Pairs taken at a time: what is known of them stays in the first-level cache.
const BLOCK: usize = 64;

/// The pairs of a block that touch.
struct Touching {
    len: usize,
    /// Index in the block.
    pair: [u32; BLOCK],
    /// Distance of the centres (m).
    distance: [f64; BLOCK],
    /// 1 / distance.
    inverse: [f64; BLOCK],
}

impl Default for Touching {
    fn default() -> Self {
        Self { len: 0, pair: [0; BLOCK], distance: [0.0; BLOCK], inverse: [0.0; BLOCK] }
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
            let square = (other.position - body.position).norm_squared();
            let touches = square < radii * radii;
            (self.pair[self.len], self.distance[self.len]) = (k as u32, square);
            apart[ending] = k as u32;
            self.len += usize::from(touches);
            ending += usize::from(!touches);
        }
        for &k in &apart[..ending] {
            block[k as usize].spring = Vec3::zeros();
        }
        for (distance, inverse) in self.distance[..self.len].iter_mut().zip(&mut self.inverse) {
            *distance = distance.sqrt();
            *inverse = 1.0 / *distance;
        }
    }
}

/// The coefficients of the last pair: bodies often come in few sizes, and a root and a division are slow.
#[derive(Default)]
struct KnownPair {
    masses: (f64, f64),
    materials: (u16, u16),
    coefficients: Option<Coefficients>,
}

impl KnownPair {
    #[inline(always)]
    fn of(&mut self, body: &Body, other: &Body, contacts: &ContactTable) -> Coefficients {
        let masses = (body.mass, other.mass);
        let materials = (body.kind.material, other.kind.material);
        match self.coefficients {
            Some(known) if masses == self.masses && materials == self.materials => known,
            _ => {
                let law = contacts.law(materials.0, materials.1);
                let coefficients = law.coefficients(reduced_mass(masses.0, masses.1));
                *self = Self { masses, materials, coefficients: Some(coefficients) };
                coefficients
            }
        }
    }
}

#[cold]
fn too_deep(tally: &Tally, id: u64, other_id: u64, overlap: f64, body: &Body, other: &Body) -> StepError {
    StepError::Overlap {
        id: id.min(other_id),
        other: format!("particle {}", id.max(other_id)),
        overlap,
        percent: 100.0 * overlap / body.radius.min(other.radius),
        limit: 100.0 * tally.limit(),
        place: vector(&body.position),
    }
}
