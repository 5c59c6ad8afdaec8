//! A particle as its contacts see it.

use grains_geometry::Vec3;

/// Shape and material of a particle, as indices into the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Kind {
    /// Shape number.
    pub shape: u16,
    /// Material number.
    pub material: u16,
}

/// What a contact needs to know of a particle: one and a half cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Body {
    /// Centre of mass (m), on the position quanta.
    pub position: Vec3,
    /// Radius of the bounding sphere (m); of a sphere, its radius.
    pub radius: f64,
    /// Velocity (m/s) at the time of `position`.
    pub velocity: Vec3,
    /// Mass (kg).
    pub mass: f64,
    /// Angular velocity (rad/s) at the time of `position`.
    pub angular_velocity: Vec3,
    /// Shape and material.
    pub kind: Kind,
    /// Number of what prescribes its motion, from 1 in [`crate::DemSetup::prescribed`]; 0 for one that moves freely.
    pub prescribed: u16,
}

/// Sum of the contact forces (N) and torques (N m) on a particle.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Load {
    /// Force (N).
    pub force: Vec3,
    /// Torque about the centre of mass (N m).
    pub torque: Vec3,
}

/// Numbers of a coupling that travel with a particle.
pub const CARGO_LENGTH: usize = 18;

/// What a coupling with something else, such as a fluid, lets a particle carry.
pub type Cargo = [f64; CARGO_LENGTH];

/// Mass (kg) of a body of prescribed motion in a contact: the reduced mass with any other is exactly that of the other one.
const PRESCRIBED_MASS: f64 = f64::from_bits((1023 + 300) << 52);

impl Body {
    /// Whether its motion is prescribed.
    #[inline(always)]
    pub fn is_prescribed(&self) -> bool {
        self.prescribed != 0
    }

    /// Mass (kg) in a contact: unbounded if the motion is prescribed.
    #[inline(always)]
    pub fn contact_mass(&self) -> f64 {
        if self.is_prescribed() { PRESCRIBED_MASS } else { self.mass }
    }
}
