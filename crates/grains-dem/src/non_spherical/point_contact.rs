//! The point in which two particles touch that are not both spheres.

use crate::contacts::ContactPoint;
use crate::narrow_phase::PartContact;
use crate::particles::Body;
use grains_contact::{Encounter, RollingContact};
use grains_geometry::Vec3;

/// Two bodies that touch in a point.
pub(super) struct PartPoint {
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
    /// Sum of their largest inverse moments of inertia (1/(kg m²)).
    pub inverse_inertia: f64,
}

/// From the centres of mass of two bodies to where they touch (m), which is given from that of the first.
#[inline(always)]
pub(super) fn arms([a, b]: [&Body; 2], found: &PartContact) -> [Vec3; 2] {
    [found.point, found.point - (b.position - a.position)]
}

impl PartPoint {
    /// A contact that was found, its point from the centre of mass of the first body.
    #[inline(always)]
    pub fn of([a, b]: [&Body; 2], found: &PartContact, inverse_inertia: f64) -> Self {
        Self {
            normal: found.normal,
            overlap: found.overlap,
            arms: arms([a, b], found),
            velocities: [a.velocity, b.velocity],
            spins: [a.angular_velocity, b.angular_velocity],
            inverse_inertia,
        }
    }
}

impl ContactPoint for PartPoint {
    #[inline(always)]
    fn encounter(&self) -> Encounter {
        let Self { normal, overlap, arms, velocities: [v, other_v], spins: [w, other_w], .. } = *self;
        let [arm, other_arm] = arms;
        let velocity = (other_v + other_w.cross(&other_arm)) - (v + w.cross(&arm));
        Encounter { normal, overlap, velocity, spin: w - other_w }
    }

    #[inline(always)]
    fn torques(&self, force: &Vec3) -> [Vec3; 2] {
        let [arm, other_arm] = &self.arms;
        [arm.cross(force), -other_arm.cross(force)]
    }

    #[inline(always)]
    fn rolling(&self) -> RollingContact {
        let [length, other_length] = self.arms.map(|arm| arm.norm());
        let effective_radius = length * other_length / (length + other_length);
        RollingContact { effective_radius, inverse_inertia: self.inverse_inertia }
    }
}
