//! Loads of bonds.

use super::kind::BondKind;
use super::list::ListedBond;
use crate::catalogue::Catalogue;
use crate::contacts::{ContactLoads, LoadQuanta};
use crate::error::{StepError, vector};
use crate::particles::{Body, Particles};
use grains_contact::{BondedPair, reduced_mass};

/// What a pass over the bonds reads, and what it finds.
pub(crate) struct BondPass<'a> {
    pub(crate) kinds: &'a [BondKind],
    pub(crate) catalogue: &'a Catalogue,
    pub(crate) quanta: LoadQuanta,
    /// Time step (s), and the one before it.
    pub(crate) dt: f64,
    pub(crate) dt_before: f64,
    /// Ends of owned particles whose bond broke.
    pub(crate) broken: u64,
    pub(crate) error: Option<StepError>,
}

/// Adds the loads of bonds; those that break bear none from this step on.
pub(crate) fn add_forces(particles: &mut Particles, bonds: &mut [ListedBond], pass: &mut BondPass) {
    for bond in bonds.iter_mut().filter(|bond| !bond.is_broken) {
        let bodies = bond.ends.map(|end| &particles.bodies[end as usize]);
        // Two of prescribed motion exert nothing on each other.
        if bodies.iter().all(|body| body.is_prescribed()) {
            continue;
        }
        let kind = &pass.kinds[usize::from(bond.kind)];
        let pair = bonded_pair(bodies, pass.catalogue);
        let first = bond.state.length;
        match kind.between(bodies).load_after(&mut bond.state, &pair, [pass.dt_before, pass.dt]) {
            Some(load) => {
                if pair.distance > kind.longest_stretch() * first {
                    pass.error = pass.error.take().or_else(|| Some(overstretched(particles, bond, &pair)));
                }
                let torques = load.torques.map(|torque| pass.quanta.torque(&torque));
                let force = pass.quanta.force(&load.force);
                ContactLoads { force, torques }.add_to(particles, bond.ends);
            }
            None => {
                bond.is_broken = true;
                pass.broken += bond.owned_ends(particles.owned);
            }
        }
    }
}

/// Two bodies as their bond sees them.
#[inline(always)]
pub(super) fn bonded_pair([a, b]: [&Body; 2], catalogue: &Catalogue) -> BondedPair {
    let between = b.position - a.position;
    let distance = between.norm();
    BondedPair {
        normal: between * (1.0 / distance),
        distance,
        velocity: b.velocity - a.velocity,
        spins: [a.angular_velocity, b.angular_velocity],
        mass: reduced_mass(a.contact_mass(), b.contact_mass()),
        inverse_inertia: catalogue.largest_inverse_inertia([a, b]),
    }
}

/// Half the shortest period (s) of a bond between bodies as they are.
pub(crate) fn half_period(kind: &BondKind, bodies: [&Body; 2], catalogue: &Catalogue) -> f64 {
    let BondedPair { distance, mass, inverse_inertia, .. } = bonded_pair(bodies, catalogue);
    kind.between(bodies).half_period(distance, mass, inverse_inertia)
}

#[cold]
fn overstretched(particles: &Particles, bond: &ListedBond, pair: &BondedPair) -> StepError {
    let [id, other] = bond.ends.map(|end| particles.ids[end as usize]);
    let place = vector(&particles.bodies[bond.ends[0] as usize].position);
    StepError::Overstretched { id, other, length: pair.distance, first: bond.state.length, place }
}
