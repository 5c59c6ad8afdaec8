//! Two bodies that touch, as a contact law sees them.

use nalgebra::Vector3;

type Vec3 = Vector3<f64>;

/// Kinematics of a contact at its point; the normal points from body 1 to body 2.
#[derive(Clone, Copy, Debug)]
pub struct Encounter {
    /// Unit normal from body 1 to body 2 (-).
    pub normal: Vec3,
    /// Overlap δ (m), positive in contact.
    pub overlap: f64,
    /// Relative velocity V2 − V1 at the contact point (m/s).
    pub velocity: Vec3,
    /// Relative angular velocity ω1 − ω2 (rad/s).
    pub spin: Vec3,
}
