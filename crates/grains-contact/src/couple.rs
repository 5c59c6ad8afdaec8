//! Couples against rolling and twisting.

use crate::encounter::Encounter;
use crate::law::Coefficients;
use crate::normal::Response;
use crate::tangential::on_cone;
use crate::twisting::Twisting;
use nalgebra::Vector3;

type Vec3 = Vector3<f64>;

/// How two bodies roll on each other.
#[derive(Clone, Copy, Debug)]
pub struct RollingContact {
    /// R1 R2/(R1 + R2) of the distances R of the contact point from the centres (m); R1 against a wall.
    pub effective_radius: f64,
    /// Sum of the largest inverse moments of inertia of both bodies (1/(kg m²)); that of body 1 against a wall.
    pub inverse_inertia: f64,
}

/// What couples keep of a contact, as seen from body 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WoundAngles {
    /// Angle rolled (rad), half a step on; zero before a contact.
    pub rolling: Vec3,
    /// Angle twisted about the normal (rad), half a step on; zero before a contact.
    pub twisting: f64,
}

impl Coefficients {
    /// Couple on body 1 (N m) of the resistance to rolling and twisting; body 2 gets the opposite.
    #[inline(always)]
    pub fn couple(
        &self,
        encounter: &Encounter,
        at: &RollingContact,
        angles: &mut WoundAngles,
        dt: f64,
    ) -> Vec3 {
        let mut couple = Vec3::zeros();
        if self.rolling.is_active() {
            couple += self.rolling_torque(encounter, at, &mut angles.rolling, dt);
        }
        if self.twisting != Twisting::None {
            couple -= encounter.normal * self.twisting_torque(encounter, &mut angles.twisting, dt);
        }
        if self.response.is_contact { couple } else { Vec3::zeros() }
    }

    /// Rolling resistance on body 1 (N m): against the relative rotation ω1 − ω2 in the contact plane, at most μr R N.
    ///
    /// With a spring, M = −(kr θ + cr ω) with kr = ratio · (kn/m) I and cr = 2 ζ √(kr I), I the inverse of
    /// [`RollingContact::inverse_inertia`]: the spring has the same frequency for bodies of any shape, √ratio of that of the normal
    /// spring. For a sphere on a wall kr = 2/5 ratio kn R². Other rules give kr and cr by R², see [`Rolling`](crate::Rolling).
    /// `angle` is θ (rad) half a step on, zero before a contact; while the torque is at its limit θ is what gives it.
    #[inline(always)]
    fn rolling_torque(&self, encounter: &Encounter, at: &RollingContact, angle: &mut Vec3, dt: f64) -> Vec3 {
        let Encounter { normal, spin, .. } = *encounter;
        let rolling = spin - normal * spin.dot(&normal);
        let (rule, Response { stiffness, pressing, is_contact, .. }) = (&self.rolling, self.response);
        let (radius, square) = (at.effective_radius, at.effective_radius * at.effective_radius);
        let limit = rule.friction * radius * pressing;
        let dashpot = (rule.dashpot + rule.tangential_dashpot_share * self.tangential_dashpot) * square;
        if !rule.has_spring {
            let viscous = rolling * dashpot;
            let (slips, share) = on_cone(&viscous, limit);
            return -viscous * if slips { share } else { 1.0 };
        }
        let inertia = 1.0 / at.inverse_inertia;
        let squared_frequency = rule.stiffness_ratio * stiffness / self.mass;
        let given = (rule.stiffness + rule.tangential_share * self.tangential_stiffness) * square;
        let stiffness = squared_frequency * inertia + given;
        let dashpot = 2.0 * rule.damping_ratio * inertia * squared_frequency.sqrt() + dashpot;
        let viscous = rolling * dashpot;
        let mut wound = *angle + rolling * (0.5 * dt);
        wound -= normal * wound.dot(&normal);
        let sticking = wound * stiffness + viscous;
        let (slips, share) = on_cone(&sticking, limit);
        let torque = sticking * if slips { share } else { 1.0 };
        let wound = if slips { (torque - viscous) * (1.0 / stiffness) } else { wound };
        *angle = if is_contact { wound + rolling * (0.5 * dt) } else { Vec3::zeros() };
        -torque
    }

    /// Torque about the normal on body 1 against its twisting (N m): kt a²/2 ψ + ct a²/2 ω, at most (2/3) a μ N; ω is the
    /// spin ω1 − ω2 about the normal n, the torque is that times −n.
    ///
    /// `angle` is ψ (rad) half a step on, zero before a contact.
    #[inline(always)]
    fn twisting_torque(&self, encounter: &Encounter, angle: &mut f64, dt: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Approach, ContactLaw, PreparedLaw, Rolling, Tangential};

    const RADIUS: f64 = 2e-3;
    const MASS: f64 = 5e-5;

    fn law(rolling: Rolling) -> PreparedLaw {
        let tangential = Tangential::Viscous { rate: 0.0 };
        ContactLaw::linear(1e4, 1.0, 0.5, tangential).with_rolling(rolling).prepared()
    }

    fn torque(law: &PreparedLaw, encounter: &Encounter, angles: &mut WoundAngles, dt: f64) -> Vec3 {
        let approach = Approach { overlap: encounter.overlap, opening: 0.0, radius: RADIUS, dt };
        law.at(MASS, &approach, &mut 0.0).couple(encounter, &at(), angles, dt)
    }

    fn at() -> RollingContact {
        RollingContact { effective_radius: RADIUS, inverse_inertia: 1.0 / (0.4 * MASS * RADIUS * RADIUS) }
    }

    fn turning(spin: Vec3) -> Encounter {
        Encounter { normal: Vec3::z(), overlap: 1e-5, velocity: Vec3::zeros(), spin }
    }

    #[test]
    fn the_torque_is_that_of_the_spring_and_then_of_its_limit() {
        let law = law(Rolling::Spring { friction: 0.1, stiffness_ratio: 0.5, damping_ratio: 0.0 });
        let stiffness = 0.5 * 0.4 * 1e4 * RADIUS * RADIUS;
        let (mut angle, dt) = (WoundAngles::default(), 1e-6);
        for step in 1..=10 {
            let torque = torque(&law, &turning(Vec3::new(1.0, 2.0, 7.0)), &mut angle, dt);
            let wanted = Vec3::new(1.0, 2.0, 0.0) * (-stiffness * (f64::from(step) - 0.5) * dt);
            assert!((torque - wanted).norm() < 1e-12 * wanted.norm(), "{torque} {wanted}");
        }
        let limit = 0.1 * RADIUS * 1e4 * 1e-5;
        for _ in 0..3 {
            let torque = torque(&law, &turning(Vec3::new(-3e3, 4e3, 0.0)), &mut angle, dt);
            let wanted = Vec3::new(0.6, -0.8, 0.0) * limit;
            assert!((torque - wanted).norm() < 0.3 * limit && (torque.norm() / limit - 1.0).abs() < 1e-12);
        }
    }

    /// A ball on a slope, without slipping: (7/5) m R² dω/dt = m g R sin β + M.
    #[test]
    fn a_ball_stands_below_the_coefficient_and_rolls_above() {
        let (gravity, dt) = (9.81, 2e-6);
        for (tangent, rolls) in [(0.05, false), (0.099, false), (0.101, true), (0.2, true)] {
            let (sin, cos) = {
                let a: f64 = f64::atan(tangent);
                (a.sin(), a.cos())
            };
            let law = law(Rolling::spring(0.1));
            let overlap = MASS * gravity * cos / 1e4;
            let (mut angle, mut omega, mut speeds) = (WoundAngles::default(), 0.0, Vec::new());
            for _ in 0..500_000 {
                let encounter = Encounter { overlap, ..turning(Vec3::new(omega, 0.0, 0.0)) };
                let torque = torque(&law, &encounter, &mut angle, dt).x;
                omega += dt * (MASS * gravity * RADIUS * sin + torque) / (1.4 * MASS * RADIUS * RADIUS);
                speeds.push(omega * RADIUS);
            }
            let rate = (speeds[499_999] - speeds[249_999]) / (250_000.0 * dt);
            let wanted = if rolls { 5.0 / 7.0 * gravity * (sin - 0.1 * cos) } else { 0.0 };
            assert!((rate - wanted).abs() < 1e-6 * gravity, "{tangent}: {rate} m/s2 for {wanted}");
            assert!(rolls || speeds[499_999].abs() < 1e-12, "{tangent}: {} m/s", speeds[499_999]);
        }
    }
}
