//! The loads of one contact: its law evaluated and rounded, the same for all kinds of bodies.

use super::load_quanta::LoadQuanta;
use crate::particles::Particles;
use grains_contact::{Coefficients, Encounter, RollingContact, WoundAngles};
use grains_geometry::{Mat3, Vec3};

/// A point in which two bodies touch.
pub(crate) trait ContactPoint {
    /// What the contact law sees.
    fn encounter(&self) -> Encounter;

    /// Torques (N m) on both bodies about their centres of mass by a force (N) on the first and its opposite on the second.
    fn torques(&self, force: &Vec3) -> [Vec3; 2];

    /// How the bodies roll on each other.
    fn rolling(&self) -> RollingContact;
}

/// Loads of a contact, multiples of their quanta.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactLoads {
    /// Force on the first body (N); the second gets the opposite.
    pub(crate) force: Vec3,
    /// Torques on both bodies (N m).
    pub(crate) torques: [Vec3; 2],
}

impl ContactLoads {
    /// A force (N) on the first body at a point, and its torques.
    #[inline(always)]
    pub(crate) fn of(point: &impl ContactPoint, force: &Vec3, quanta: &LoadQuanta) -> Self {
        let force = quanta.force(force);
        Self { force, torques: point.torques(&force).map(|torque| quanta.torque(&torque)) }
    }

    /// Adds the resistance to rolling and twisting; the angles (rad) are advanced by `dt` (s).
    #[inline(always)]
    pub(crate) fn add_couple(
        &mut self,
        encounter: &Encounter,
        law: &Coefficients,
        (rolling, angles): (&RollingContact, &mut WoundAngles),
        quanta: &LoadQuanta,
        dt: f64,
    ) {
        self.add_torque(&law.couple(encounter, rolling, angles, dt), quanta);
    }

    /// Adds the torque of a contact patch of this second moment (m²) about its centre; its torsional angle (rad) is
    /// advanced by `dt` (s).
    pub(crate) fn add_patch(
        &mut self,
        encounter: &Encounter,
        law: &Coefficients,
        (second, torsional_angle): (&Mat3, &mut f64),
        quanta: &LoadQuanta,
        dt: f64,
    ) {
        self.add_torque(&law.patch_torque(encounter, second, torsional_angle, dt), quanta);
    }

    /// Adds a torque (N m) on the first body, and its opposite on the second.
    #[inline(always)]
    pub(crate) fn add_torque(&mut self, torque: &Vec3, quanta: &LoadQuanta) {
        let torque = quanta.torque(torque);
        self.torques[0] += torque;
        self.torques[1] -= torque;
    }

    /// Adds the loads to the sums of those of two particles that this rank owns.
    #[inline(always)]
    pub(crate) fn add_to(&self, particles: &mut Particles, [a, b]: [u32; 2]) {
        if let Some(load) = particles.loads.get_mut(a as usize) {
            load.force += self.force;
            load.torque += self.torques[0];
        }
        if let Some(load) = particles.loads.get_mut(b as usize) {
            load.force -= self.force;
            load.torque += self.torques[1];
        }
        if particles.virial.is_some() {
            self.add_to_virial(particles, [a, b].map(|i| i as usize));
        }
    }

    /// Adds F ⊗ (x_a − x_b); the other half of a contact with a clone is that of its owner.
    fn add_to_virial(&self, particles: &mut Particles, [a, b]: [usize; 2]) {
        let share = if a.max(b) < particles.owned { 1.0 } else { 0.5 };
        let between = particles.bodies[a].position - particles.bodies[b].position;
        if let Some(virial) = &mut particles.virial {
            *virial += self.force * between.transpose() * share;
        }
    }
}
