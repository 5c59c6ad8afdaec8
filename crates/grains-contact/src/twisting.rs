//! Resistance to twisting: to relative rotation about the normal.

use crate::encounter::Encounter;
use crate::law::Coefficients;

/// How a contact resists twisting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Twisting {
    /// Not at all.
    #[default]
    None,
    /// By the tangential spring, dashpot and slider over the circle of contact (Marshall 2009).
    Marshall,
}

impl Coefficients {
    /// Torque about the normal on body 1 against its twisting (N m): kt a²/2 ψ + ct a²/2 ω, at most (2/3) a μ N; ω is the
    /// spin ω1 − ω2 about the normal n, the torque is that times −n.
    ///
    /// `angle` is ψ (rad) half a step on, zero before a contact.
    #[inline(always)]
    pub(crate) fn twisting_torque(&self, encounter: &Encounter, angle: &mut f64, dt: f64) -> f64 {
        let twisting = encounter.spin.dot(&encounter.normal);
        let radius = self.response.contact_radius;
        let half_square = 0.5 * radius * radius;
        let limit = 2.0 / 3.0 * radius * self.friction * self.response.pressing;
        let stiffness = half_square * self.tangential_stiffness;
        let viscous = half_square * self.tangential_dashpot * twisting;
        let [before, after] = self.memory_factors(encounter.velocity.dot(&encounter.normal));
        let wound = *angle * before + twisting * (0.5 * dt);
        let sticking = stiffness * wound + viscous;
        let torque = sticking.max(-limit).min(limit);
        let slips = torque != sticking;
        let wound = if slips & self.has_spring { (torque - viscous) / stiffness } else { wound };
        let keeps = self.has_spring & self.response.is_contact;
        *angle = if keeps { wound * after + twisting * (0.5 * dt) } else { 0.0 };
        torque
    }
}
