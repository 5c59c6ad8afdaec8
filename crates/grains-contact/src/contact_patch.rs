//! Contacts over an area or a line: torques beside that of the force at their centre.

use crate::encounter::Encounter;
use crate::law::Coefficients;
use crate::step_share::{begins, share_at_end, share_in_contact};
use nalgebra::{Matrix3, Vector3};

type Vec3 = Vector3<f64>;
type Mat3 = Matrix3<f64>;

impl Coefficients {
    /// Torque on body 1 about the centre of a contact patch, beside that of its force (N m).
    ///
    /// With Δω = ω2 − ω1 (rad/s) and the second moment S = Σ w_i (r_i × n)(r_i × n)ᵀ (m²) of its corners about the centre,
    /// Σ w_i = 1: 2 γn m S Δω, which brakes rocking, and a torsional spring, (kt ψ + 2 γt m Δω·n) ρ² n with ρ² = tr S,
    /// at most μ N ρ. `torsional_angle` is ψ half a step on (rad), as the displacement of [`Coefficients::force`],
    /// zero when the contact begins.
    pub fn patch_torque(
        &self,
        encounter: &Encounter,
        second: &Mat3,
        torsional_angle: &mut f64,
        dt: f64,
    ) -> Vec3 {
        let Encounter { normal, velocity, spin, .. } = *encounter;
        let spin = -spin;
        let opening = velocity.dot(&normal);
        let share = share_in_contact(self.response.margin, opening, dt);
        let rocking = second * spin * (self.dashpot * share);
        let (turning, radius2) = (spin.dot(&normal), second.trace());
        let limit = self.friction * self.response.pressing * radius2.sqrt();
        let on_cone = |torque: f64| (torque.abs() > limit).then(|| limit.copysign(torque));
        if !self.has_spring {
            let viscous = self.tangential_dashpot * turning * radius2;
            return rocking + normal * on_cone(viscous).unwrap_or(viscous * share);
        }
        let dashpot = self.tangential_dashpot + self.step_dashpot(dt);
        let viscous = dashpot * turning * radius2;
        let stiffness = self.tangential_stiffness * radius2;
        let begins = begins(share, opening) && *torsional_angle == 0.0;
        let relaxation = dashpot / self.tangential_stiffness;
        let since = if begins { (share - 0.5) * dt - relaxation } else { 0.5 * dt };
        let wound = *torsional_angle + turning * since;
        let sticking = stiffness * wound + viscous;
        let (torque, wound) = match on_cone(sticking) {
            Some(torque) if stiffness > 0.0 => (torque, (torque - viscous) / stiffness),
            _ => (sticking * share_at_end(share, opening), wound),
        };
        *torsional_angle = wound + turning * (0.5 * dt);
        rocking + normal * torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Approach, ContactLaw, Tangential};

    #[test]
    fn torsion_is_resisted_up_to_the_friction_of_the_corners() {
        let tangential = Tangential::Spring { stiffness_ratio: 0.5, damping_ratio: 0.0 };
        let approach = Approach { overlap: 1e-5, opening: 0.0, radius: 1e-3, dt: 1e-3 };
        let law = ContactLaw::linear(1e5, 1.0, 0.4, tangential).prepared().at(0.01, &approach, &mut 0.0);
        let second = Mat3::from_diagonal(&Vec3::new(4e-6, 5e-6, 0.0));
        let turning = |rate: f64| {
            let (velocity, spin) = (Vec3::zeros(), Vec3::new(0.0, 0.0, -rate));
            Encounter { normal: Vec3::z(), overlap: 1e-5, velocity, spin }
        };
        let mut angle = 0.0;
        let torque = law.patch_torque(&turning(1e-3), &second, &mut angle, 1e-3);
        assert!((torque.z - 5e4 * 1e-6 * 9e-6).abs() < 1e-18 && angle == 1e-6);
        let limit = 0.4 * 1e5 * 1e-5 * 3e-3;
        let torque = law.patch_torque(&turning(100.0), &second, &mut angle, 1e-3);
        assert!((torque.z - limit).abs() < 1e-15 && (angle - limit / (5e4 * 9e-6)).abs() < 1e-15);
    }
}
