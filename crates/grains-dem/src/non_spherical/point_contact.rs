//! A contact of two bodies in a point, and the loads of it.

use crate::contacts::LoadLattice;
use crate::narrow_phase::PartContact;
use crate::particles::{Body, Load};
use grains_contact::{Coefficients, Contact};
use grains_geometry::Vec3;

/// Two bodies that touch in a point.
pub(super) struct Touch {
    /// Unit normal from the first to the second (-).
    pub normal: Vec3,
    /// Overlap (m).
    pub overlap: f64,
    /// The point from the centres of mass of the two (m).
    pub arms: [Vec3; 2],
    /// Their velocities (m/s).
    pub velocities: [Vec3; 2],
    /// Their angular velocities (rad/s).
    pub spins: [Vec3; 2],
}

impl Touch {
    /// A contact that was found, its point from the centre of mass of the first body.
    #[inline(always)]
    pub fn of([a, b]: [&Body; 2], found: &PartContact) -> Self {
        Self {
            normal: found.normal,
            overlap: found.overlap,
            arms: [found.point, found.point - (b.position - a.position)],
            velocities: [a.velocity, b.velocity],
            spins: [a.angular_velocity, b.angular_velocity],
        }
    }

    /// The contact as its law sees it: with the velocity of the second body at the point less that of the first.
    #[inline(always)]
    pub fn contact(&self) -> Contact {
        let [v, other_v] = self.velocities;
        let [w, other_w] = self.spins;
        let velocity = (other_v + other_w.cross(&self.arms[1])) - (v + w.cross(&self.arms[0]));
        Contact { normal: self.normal, overlap: self.overlap, velocity }
    }

    /// Loads on the two bodies, rolling resistance included.
    #[inline(always)]
    pub fn loads(&self, law: &Coefficients, spring: &mut Vec3, lattice: &LoadLattice, dt: f64) -> [Load; 2] {
        let (contact, [arm, other_arm]) = (self.contact(), &self.arms);
        let force = lattice.force(&law.force(&contact, spring, dt));
        let mut torque = lattice.torque(&arm.cross(&force));
        let mut other_torque = -lattice.torque(&other_arm.cross(&force));
        if law.resists_rolling() {
            let (length, other_length) = (arm.norm(), other_arm.norm());
            let effective = length * other_length / (length + other_length);
            let spin = self.spins[0] - self.spins[1];
            let rolling = lattice.torque(&law.rolling_torque(&contact, &spin, effective));
            torque += rolling;
            other_torque -= rolling;
        }
        [Load { force, torque }, Load { force: -force, torque: other_torque }]
    }
}
