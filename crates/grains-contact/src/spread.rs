//! Contacts spread over an area or a line, and contacts that share one pair of bodies.

use crate::law::{begins, share_at_end, share_in_contact};
use crate::{Coefficients, Contact};
use nalgebra::{Matrix3, Vector3};

type Vec3 = Vector3<f64>;
type Mat3 = Matrix3<f64>;

/// How far a contact reaches about its centre c, with the weights w_i of its corners, Σ w_i = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// First moment of the overlap, Σ w_i δ_i r_i (m²), r_i = x_i − c.
    pub moment: Vec3,
    /// Second moment Σ w_i (r_i × n)(r_i × n)ᵀ (m²).
    pub second: Mat3,
}

/// What a pair of bodies does with several contacts at once (thesis 3.2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharing {
    /// Model A: forces add up, with the damping corrected for the number N of contacts, γ = γ1/√N
    /// (eq. 3.35 as corrected, errata R16-13); N contacts are N times as stiff.
    Sum,
    /// Model B: the mean of the forces (eq. 3.36), as stiff as one contact whatever N.
    #[default]
    Mean,
}

impl Coefficients {
    /// Coefficients of each of `count` contacts of one pair of bodies.
    #[inline(always)]
    pub fn shared(&self, count: usize, sharing: Sharing) -> Self {
        let n = count as f64;
        match sharing {
            _ if count == 1 => *self,
            // The tangential dashpot of a spring is a share of the normal one; a memoryless one has its own rate.
            Sharing::Sum => {
                let damping = 1.0 / n.sqrt();
                let tangential = if self.tangential_stiffness > 0.0 { damping } else { 1.0 };
                Self {
                    dashpot: self.dashpot * damping,
                    tangential_dashpot: self.tangential_dashpot * tangential,
                    mass: self.mass / n,
                    ..*self
                }
            }
            Sharing::Mean => Self {
                stiffness: self.stiffness / n,
                dashpot: self.dashpot / n,
                tangential_stiffness: self.tangential_stiffness / n,
                tangential_dashpot: self.tangential_dashpot / n,
                mass: self.mass / n,
                ..*self
            },
        }
    }

    /// Torque on body 1 about the centre of a spread contact, beside that of its force (N m).
    ///
    /// With Δω = ω2 − ω1 (`spin`, rad/s): −kn M × n + 2 γn m S Δω from the normal forces at the corners, and a
    /// spring against twisting, (kt ψ + 2 γt m Δω·n) ρ² n with ρ² = tr S, at most μ kn δ ρ. `twist` is ψ half a
    /// step on (rad), as for the spring of [`Coefficients::force`], zero when the contact begins.
    pub fn spread_torque(
        &self,
        contact: &Contact,
        spread: &Spread,
        spin: &Vec3,
        twist: &mut f64,
        dt: f64,
    ) -> Vec3 {
        let Contact { normal, overlap, velocity } = *contact;
        let opening = velocity.dot(&normal);
        let share = share_in_contact(overlap, opening, dt);
        let tilting =
            spread.second * spin * (self.dashpot * share) - spread.moment.cross(&normal) * self.stiffness;
        let (turning, radius2) = (spin.dot(&normal), spread.second.trace());
        let limit = self.friction * self.stiffness * overlap * radius2.sqrt();
        let on_cone = |torque: f64| (torque.abs() > limit).then(|| limit.copysign(torque));
        if self.tangential_stiffness == 0.0 {
            let viscous = self.tangential_dashpot * turning * radius2;
            return tilting + normal * on_cone(viscous).unwrap_or(viscous * share);
        }
        let dashpot = self.tangential_dashpot + self.step_dashpot(dt);
        let viscous = dashpot * turning * radius2;
        let stiffness = self.tangential_stiffness * radius2;
        let begins = begins(share, opening) && *twist == 0.0;
        let relaxation = dashpot / self.tangential_stiffness;
        let since = if begins { (share - 0.5) * dt - relaxation } else { 0.5 * dt };
        let wound = *twist + turning * since;
        let sticking = stiffness * wound + viscous;
        let (torque, wound) = match on_cone(sticking) {
            Some(torque) if stiffness > 0.0 => (torque, (torque - viscous) / stiffness),
            _ => (sticking * share_at_end(share, opening), wound),
        };
        *twist = wound + turning * (0.5 * dt);
        tilting + normal * torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ContactLaw, Tangential};

    /// Four corners at (±a, ±b) as four contacts of a quarter of the stiffness each.
    #[test]
    fn a_spread_contact_adds_up_its_corners() {
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
            let corner = Contact { normal, overlap: overlaps[k], velocity: velocity + spin.cross(&r) };
            let at = law.force(&corner, &mut Vec3::zeros(), 1e-9) * shares[k];
            force += normal * at.z;
            torque += r.cross(&(normal * at.z));
        }
        let contact = Contact { normal, overlap, velocity };
        let whole = law.force(&contact, &mut Vec3::zeros(), 1e-9);
        assert!((whole.z - force.z).abs() < 1e-12 * force.norm());
        let got = law.spread_torque(&contact, &Spread { moment, second }, &spin, &mut 0.0, 1e-9);
        assert!((got - torque).norm() < 1e-12 * torque.norm(), "{got} {torque}");
    }

    #[test]
    fn twisting_is_resisted_up_to_the_friction_of_the_corners() {
        let tangential = Tangential::Spring { stiffness_ratio: 0.5, damping_ratio: 0.0 };
        let law = ContactLaw::new(1e5, 1.0, 0.4, tangential).coefficients(0.01);
        let spread =
            Spread { moment: Vec3::zeros(), second: Mat3::from_diagonal(&Vec3::new(4e-6, 5e-6, 0.0)) };
        let contact = Contact { normal: Vec3::z(), overlap: 1e-5, velocity: Vec3::zeros() };
        let mut twist = 0.0;
        let torque = law.spread_torque(&contact, &spread, &Vec3::new(0.0, 0.0, 1e-3), &mut twist, 1e-3);
        assert!((torque.z - 5e4 * 1e-6 * 9e-6).abs() < 1e-18 && twist == 1e-6);
        let limit = 0.4 * 1e5 * 1e-5 * 3e-3;
        let torque = law.spread_torque(&contact, &spread, &Vec3::new(0.0, 0.0, 100.0), &mut twist, 1e-3);
        assert!((torque.z - limit).abs() < 1e-15 && (twist - limit / (5e4 * 9e-6)).abs() < 1e-15);
    }

    #[test]
    fn shared_contacts_keep_the_restitution_in_both_models() {
        let tangential = Tangential::Spring { stiffness_ratio: 0.5, damping_ratio: 0.5 };
        let one = ContactLaw::new(1e5, 0.6, 0.3, tangential).coefficients(0.01);
        for n in [2, 7] {
            let sum = one.shared(n, Sharing::Sum);
            // Damping ratio γ/ω0 of n equal contacts together.
            let ratio = |c: &Coefficients, n: f64| n * c.dashpot / (n * c.stiffness).sqrt();
            assert!((ratio(&sum, n as f64) / ratio(&one, 1.0) - 1.0).abs() < 1e-14);
            let mean = one.shared(n, Sharing::Mean);
            assert!((mean.stiffness * n as f64 / one.stiffness - 1.0).abs() < 1e-15);
            assert!((ratio(&mean, n as f64) / ratio(&one, 1.0) - 1.0).abs() < 1e-14);
        }
    }
}
