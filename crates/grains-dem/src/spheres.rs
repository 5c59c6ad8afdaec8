//! Contacts between spheres: the closed form, once per rank and pair.

use crate::error::vector;
use crate::forces::{LoadLattice, Tally};
use crate::{Body, ContactTable, Load, Particles, StepError};
use grains_contact::{Coefficients, Contact, reduced_mass};
use grains_geometry::Vec3;

/// A neighbour of an owned sphere and the tangential spring between them (m).
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SpherePair {
    pub(crate) other: u32,
    pub(crate) spring: Vec3,
}

/// Half list: pairs of the owned sphere i are `pairs[first[i]..first[i + 1]]`.
#[derive(Clone, Debug, Default)]
pub(crate) struct SphereList {
    pub(crate) first: Vec<u32>,
    pub(crate) pairs: Vec<SpherePair>,
}

/// Adds the loads of all contacts between spheres.
///
/// The arithmetic is antisymmetric in the two bodies, operation by operation, so it does not matter
/// which of them this rank takes for the first.
pub(crate) fn add_forces(
    particles: &mut Particles,
    list: &mut SphereList,
    contacts: &ContactTable,
    lattice: &LoadLattice,
    dt: f64,
    tally: &mut Tally,
) {
    let owned = particles.owned;
    let bodies = &particles.bodies[..];
    let loads = &mut particles.loads[..owned];
    let mut known = KnownPair::default();
    for i in 0..owned {
        let body = &bodies[i];
        let mut sum = Load::default();
        let row = list.first[i] as usize..list.first[i + 1] as usize;
        for pair in &mut list.pairs[row] {
            let j = pair.other as usize;
            let other = &bodies[j];
            let separation = other.position - body.position;
            let radii = body.radius + other.radius;
            let square = separation.norm_squared();
            if square >= radii * radii {
                pair.spring = Vec3::zeros();
                continue;
            }
            let distance = square.sqrt();
            let overlap = radii - distance;
            let normal = separation * (1.0 / distance);
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
            sum.force += force;
            sum.torque += torque;
            if j < owned {
                loads[j].force -= force;
                loads[j].torque += other_torque;
            }
            if tally.note(overlap, body.radius.min(other.radius)) {
                tally.error = Some(too_deep(tally, particles.ids[i], particles.ids[j], overlap, body, other));
            }
        }
        loads[i].force += sum.force;
        loads[i].torque += sum.torque;
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
