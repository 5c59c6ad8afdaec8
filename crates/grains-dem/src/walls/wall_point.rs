//! The point in which a particle touches a wall.

use super::motion::WallState;
use super::surface_contact::SurfaceContact;
use crate::contacts::ContactPoint;
use crate::particles::Body;
use grains_contact::{Encounter, RollingContact};
use grains_geometry::Vec3;

/// The point in which a particle touches a wall.
pub(super) struct WallPoint {
    /// Unit normal into the wall (-).
    pub(super) normal: Vec3,
    /// Overlap (m).
    pub(super) overlap: f64,
    /// The point from the centre of mass of the particle (m).
    pub(super) arm: Vec3,
    /// Velocities of the particle's centre and of the wall at the point (m/s).
    pub(super) velocities: [Vec3; 2],
    /// Angular velocities of both (rad/s).
    pub(super) spins: [Vec3; 2],
    /// Largest inverse moment of inertia of the particle (1/(kg m²)).
    pub(super) inverse_inertia: f64,
}

impl WallPoint {
    /// A contact that was found, of a body whose image is at `center` (m).
    #[inline(always)]
    pub(super) fn of(
        (body, center): (&Body, &Vec3),
        state: &WallState,
        found: &SurfaceContact,
        inverse_inertia: f64,
    ) -> Self {
        let arm = state.to_world(&(found.point - state.to_wall(center)));
        Self {
            normal: state.to_world(&found.normal),
            overlap: found.overlap,
            arm,
            velocities: [body.velocity, state.velocity_at(&(center + arm))],
            spins: [body.angular_velocity, state.angular_velocity],
            inverse_inertia,
        }
    }
}

impl ContactPoint for WallPoint {
    #[inline(always)]
    fn encounter(&self) -> Encounter {
        let Self { normal, overlap, arm, velocities: [v, wall_v], spins: [w, wall_w], .. } = *self;
        Encounter { normal, overlap, velocity: wall_v - (v + w.cross(&arm)), spin: w - wall_w }
    }

    /// That on the wall, which is about the origin, is left out: the second torque is that of couples alone.
    #[inline(always)]
    fn torques(&self, force: &Vec3) -> [Vec3; 2] {
        [self.arm.cross(force), Vec3::zeros()]
    }

    #[inline(always)]
    fn rolling(&self) -> RollingContact {
        RollingContact { effective_radius: self.arm.norm(), inverse_inertia: self.inverse_inertia }
    }
}
