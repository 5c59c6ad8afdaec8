//! Contacts over an area or a line: torques beside that of the force at their centre.

use crate::law::{begins, share_at_end, share_in_contact};
use crate::{Coefficients, Encounter};
use nalgebra::{Matrix3, Vector3};

type Vec3 = Vector3<f64>;
type Mat3 = Matrix3<f64>;

/// Moments of a contact patch about its centre c, with the weights w_i of its corners, Σ w_i = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchMoments {
    /// First moment of the overlap, Σ w_i δ_i r_i (m²), r_i = x_i − c.
    pub moment: Vec3,
    /// Second moment Σ w_i (r_i × n)(r_i × n)ᵀ (m²).
    pub second: Mat3,
}

impl Coefficients {
    /// Torque on body 1 about the centre of a contact patch, beside that of its force (N m).
    ///
    /// With Δω = ω2 − ω1 (rad/s): −kn M × n + 2 γn m S Δω from the normal forces at the corners, and a torsional
    /// spring, (kt ψ + 2 γt m Δω·n) ρ² n with ρ² = tr S, at most μ kn δ ρ. `torsional_angle` is ψ half a step on
    /// (rad), as the displacement of [`Coefficients::force`], zero when the contact begins.
    pub fn patch_torque(
        &self,
        encounter: &Encounter,
        patch: &PatchMoments,
        torsional_angle: &mut f64,
        dt: f64,
    ) -> Vec3 {
        let Encounter { normal, overlap, velocity, spin } = *encounter;
        let spin = -spin;
        let opening = velocity.dot(&normal);
        let share = share_in_contact(overlap, opening, dt);
        let tilting =
            patch.second * spin * (self.dashpot * share) - patch.moment.cross(&normal) * self.stiffness;
        let (turning, radius2) = (spin.dot(&normal), patch.second.trace());
        let limit = self.friction * self.stiffness * overlap * radius2.sqrt();
        let on_cone = |torque: f64| (torque.abs() > limit).then(|| limit.copysign(torque));
        if self.tangential_stiffness == 0.0 {
            let viscous = self.tangential_dashpot * turning * radius2;
            return tilting + normal * on_cone(viscous).unwrap_or(viscous * share);
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
        tilting + normal * torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ContactLaw, Tangential};

    /// Four corners at (±a, ±b) as four contacts of a quarter of the stiffness each.
    #[test]
    fn a_contact_patch_adds_up_its_corners() {
        let tangential = Tangential::Spring { stiffness_ratio: 0.5, damping_ratio: 0.5 };
        let law = ContactLaw::new(1e5, 0.6, 1e3, tangential).coefficients(0.01);
        let normal = Vec3::z();
        let (velocity, spin) = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(4.0, 5.0, 0.0));
        let overlaps = [1e-4, 2e-4, 3e-4, 4e-4];
        let places =
            [[1.0, 2.0], [-1.0, 2.0], [-1.0, -2.0], [1.0, -2.0]].map(|[x, y]| Vec3::new(x, y, 0.0) * 1e-3);
        let total: f64 = overlaps.iter().sum();
        let shares = overlaps.map(|o| o / total);
        let center: Vec3 = places.iter().zip(shares).map(|(x, w)| x * w).sum();
        let overlap: f64 = overlaps.iter().zip(shares).map(|(o, w)| o * w).sum();
        let (mut moment, mut second) = (Vec3::zeros(), Mat3::zeros());
        let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
        for k in 0..4 {
            let r = places[k] - center;
            moment += r * (shares[k] * overlaps[k]);
            second += r.cross(&normal) * r.cross(&normal).transpose() * shares[k];
            // A step so short that every corner is in contact for all of it.
            let velocity = velocity + spin.cross(&r);
            let corner = Encounter { normal, overlap: overlaps[k], velocity, spin: -spin };
            let at = law.force(&corner, &mut Vec3::zeros(), 1e-9) * shares[k];
            force += normal * at.z;
            torque += r.cross(&(normal * at.z));
        }
        let encounter = Encounter { normal, overlap, velocity, spin: -spin };
        let whole = law.force(&encounter, &mut Vec3::zeros(), 1e-9);
        assert!((whole.z - force.z).abs() < 1e-12 * force.norm());
        let got = law.patch_torque(&encounter, &PatchMoments { moment, second }, &mut 0.0, 1e-9);
        assert!((got - torque).norm() < 1e-12 * torque.norm(), "{got} {torque}");
    }

    #[test]
    fn torsion_is_resisted_up_to_the_friction_of_the_corners() {
        let tangential = Tangential::Spring { stiffness_ratio: 0.5, damping_ratio: 0.0 };
        let law = ContactLaw::new(1e5, 1.0, 0.4, tangential).coefficients(0.01);
        let second = Mat3::from_diagonal(&Vec3::new(4e-6, 5e-6, 0.0));
        let patch = PatchMoments { moment: Vec3::zeros(), second };
        let turning = |rate: f64| {
            let (velocity, spin) = (Vec3::zeros(), Vec3::new(0.0, 0.0, -rate));
            Encounter { normal: Vec3::z(), overlap: 1e-5, velocity, spin }
        };
        let mut angle = 0.0;
        let torque = law.patch_torque(&turning(1e-3), &patch, &mut angle, 1e-3);
        assert!((torque.z - 5e4 * 1e-6 * 9e-6).abs() < 1e-18 && angle == 1e-6);
        let limit = 0.4 * 1e5 * 1e-5 * 3e-3;
        let torque = law.patch_torque(&turning(100.0), &patch, &mut angle, 1e-3);
        assert!((torque.z - limit).abs() < 1e-15 && (angle - limit / (5e4 * 9e-6)).abs() < 1e-15);
    }
}
