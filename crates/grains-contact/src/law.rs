//! The damped linear spring with Coulomb friction and rolling resistance.

use crate::encounter::Encounter;
use crate::rolling::{Rolling, RollingCoefficients};
use nalgebra::Vector3;

type Vec3 = Vector3<f64>;

/// Reduced mass of a pair of bodies, M1 M2/(M1 + M2) (kg); M1 against a wall.
#[inline(always)]
pub fn reduced_mass(mass_1: f64, mass_2: f64) -> f64 {
    mass_1 * mass_2 / (mass_1 + mass_2)
}

/// The coefficients of a law for one reduced mass, computed once for bodies of equal masses.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    pub(crate) stiffness: f64,
    /// 2 γn m (N s/m).
    pub(crate) dashpot: f64,
    pub(crate) tangential_stiffness: f64,
    /// 2 γt m (N s/m).
    pub(crate) tangential_dashpot: f64,
    /// Reduced mass over the number of contacts that share it (kg).
    pub(crate) mass: f64,
    pub(crate) friction: f64,
    pub(crate) rolling: RollingCoefficients,
    /// Whether friction is limited by the whole normal force, not by its elastic part.
    pub(crate) limits_by_total: bool,
}

/// How a contact resists sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tangential {
    /// Memoryless viscous force −2 γt m Urt, capped by friction (thesis eqs 3.20-3.21).
    Viscous {
        /// Rate γt (1/s).
        rate: f64,
    },
    /// Spring and dashpot, capped by friction (Wachs 2009, eqs 15-17).
    Spring {
        /// Tangential over normal stiffness kt/kn (-).
        stiffness_ratio: f64,
        /// Tangential over normal damping rate γt/γn (-).
        damping_ratio: f64,
    },
    /// Memoryless force −(kt τc + ηt) Urt: the displacement is taken for that of a whole contact at the
    /// present speed, τc Urt (Srinivasan 2019, eqs 3.43-3.47; errata S19-22, S19-23).
    ///
    /// τc is the contact time of the pair and ηt = 2 γ √(m kt), γ the damping ratio of the normal direction.
    /// Without a history there is no static friction. The cap is μ |Fn| with the dashpot in Fn (eq. 3.47), where
    /// the other laws take μ kn δ. The form with a history, eq. 3.42, is [`Tangential::Spring`] with a damping
    /// ratio √(kt/kn), but for that cap.
    ContactTime {
        /// Tangential over normal stiffness kt/kn (-).
        stiffness_ratio: f64,
    },
}

/// Contact law of one pair of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Normal stiffness kn (N/m).
    pub normal_stiffness: f64,
    /// Restitution en (-), in (0, 1].
    pub restitution: f64,
    /// Coulomb friction coefficient μ (-).
    pub friction: f64,
    /// Tangential resistance.
    pub tangential: Tangential,
    /// Resistance to rolling.
    pub rolling: Rolling,
    damping: f64,
}

impl ContactLaw {
    /// Law with the given stiffness (N/m), restitution, friction, and tangential resistance.
    pub fn new(normal_stiffness: f64, restitution: f64, friction: f64, tangential: Tangential) -> Self {
        let log = restitution.ln();
        let damping = -log / (std::f64::consts::PI.powi(2) + log * log).sqrt();
        Self { normal_stiffness, restitution, friction, tangential, rolling: Rolling::None, damping }
    }

    /// Law of bodies that do not deform: restitution and friction of their impulses, and no force.
    pub fn rigid(restitution: f64, friction: f64) -> Self {
        Self::new(0.0, restitution, friction, Tangential::Viscous { rate: 0.0 })
    }

    /// The same law with this resistance to rolling.
    pub fn with_rolling(self, rolling: Rolling) -> Self {
        Self { rolling, ..self }
    }

    /// Damping rate γn = −ω0 ln en/√(π² + ln² en) (1/s) for a reduced mass (kg); thesis eq. 3.27.
    pub fn damping_rate(&self, reduced_mass: f64) -> f64 {
        self.damping * (self.normal_stiffness / reduced_mass).sqrt()
    }

    /// Tangential damping rate γt (1/s) for a reduced mass (kg).
    pub fn tangential_rate(&self, reduced_mass: f64) -> f64 {
        match self.tangential {
            Tangential::Viscous { rate } => rate,
            Tangential::Spring { damping_ratio, .. } => damping_ratio * self.damping_rate(reduced_mass),
            Tangential::ContactTime { stiffness_ratio } => {
                0.5 * self.contact_time_dashpot(stiffness_ratio, reduced_mass) / reduced_mass
            }
        }
    }

    /// kt τc + 2 γ √(m kt) (N s/m), τc = π/√(kn (1 − γ²)/m) (Srinivasan 2019, eqs 3.43-3.45).
    fn contact_time_dashpot(&self, stiffness_ratio: f64, reduced_mass: f64) -> f64 {
        let root = (self.normal_stiffness * reduced_mass).sqrt();
        let contact = std::f64::consts::PI * stiffness_ratio / (1.0 - self.damping.powi(2)).sqrt();
        root * (contact + 2.0 * self.damping * stiffness_ratio.sqrt())
    }

    /// The law ready for any reduced mass.
    #[inline]
    pub fn prepared(&self) -> PreparedLaw {
        let root = self.normal_stiffness.sqrt();
        let dashpot = 2.0 * self.damping * root;
        let (stiffness_ratio, per_mass, per_root) = match self.tangential {
            Tangential::Viscous { rate } => (0.0, 2.0 * rate, 0.0),
            Tangential::Spring { stiffness_ratio, damping_ratio } => {
                (stiffness_ratio, 0.0, damping_ratio * dashpot)
            }
            Tangential::ContactTime { stiffness_ratio } => {
                (0.0, 0.0, self.contact_time_dashpot(stiffness_ratio, 1.0))
            }
        };
        PreparedLaw {
            stiffness: self.normal_stiffness,
            dashpot,
            tangential_stiffness: stiffness_ratio * self.normal_stiffness,
            per_mass,
            per_root,
            friction: self.friction,
            rolling: self.rolling.into(),
            limits_by_total: matches!(self.tangential, Tangential::ContactTime { .. }),
        }
    }

    /// Coefficients of the law for a reduced mass (kg): of bodies hit off their centres, the effective mass at the contact point,
    /// 1/(n·K n) with K their mobility there.
    #[inline]
    pub fn coefficients(&self, reduced_mass: f64) -> Coefficients {
        self.prepared().at(reduced_mass)
    }
}

/// A law whose coefficients for a mass take a root and no decision.
#[derive(Clone, Copy, Debug)]
pub struct PreparedLaw {
    stiffness: f64,
    /// Normal dashpot over √m.
    dashpot: f64,
    tangential_stiffness: f64,
    /// Tangential dashpot: over m, and over √m.
    per_mass: f64,
    per_root: f64,
    friction: f64,
    rolling: RollingCoefficients,
    limits_by_total: bool,
}

impl PreparedLaw {
    /// Coefficients for a reduced mass (kg).
    #[inline(always)]
    pub fn at(&self, reduced_mass: f64) -> Coefficients {
        let root = reduced_mass.sqrt();
        Coefficients {
            stiffness: self.stiffness,
            dashpot: self.dashpot * root,
            tangential_stiffness: self.tangential_stiffness,
            tangential_dashpot: self.per_mass * reduced_mass + self.per_root * root,
            mass: reduced_mass,
            friction: self.friction,
            rolling: self.rolling,
            limits_by_total: self.limits_by_total,
        }
    }

    /// Whether bodies resist rolling.
    #[inline(always)]
    pub fn resists_rolling(&self) -> bool {
        self.rolling.is_active()
    }

    /// Whether contacts keep the angle rolled.
    pub fn keeps_rolling_angle(&self) -> bool {
        self.rolling.keeps_angle()
    }
}

impl Coefficients {
    /// Force on body 1 (N): F1 = −(kn δ + 2 γn m dδ/dt) n + Ft, with |Ft| ≤ μ kn δ.
    ///
    /// The tangential displacement ξ (m) is turned into the contact plane, advanced with the slip Vrt, and shortened while
    /// the contact slides so that kt ξ + 2 γt m Vrt stays on the friction cone (Wachs 2009, eqs 15-17; errata W09-2).
    /// A contact that begins slides, as δ = 0: its ξ is −2 γt m Vrt/kt, and its force grows from nothing. One that
    /// sticks until it ends drops its force, weighted by the share of the step in which the bodies touch.
    ///
    /// `displacement` is ξ half a step on, ξ + Vrt dt/2, zero before a contact: with the slip half a step back it makes the
    /// trapezoidal rule, of second order in dt. Without a tangential stiffness the force is the memoryless one of
    /// thesis eqs 3.20-3.21 and ξ stays zero; [`Tangential::ContactTime`] caps it by the whole normal force.
    #[inline(always)]
    pub fn force(&self, encounter: &Encounter, displacement: &mut Vec3, dt: f64) -> Vec3 {
        let Encounter { normal, overlap, velocity, .. } = *encounter;
        let opening = velocity.dot(&normal);
        let elastic = self.stiffness * overlap;
        let share = share_in_contact(overlap, opening, dt);
        let along = self.dashpot * share * opening - elastic;
        let normal_force = normal * along;
        let sliding = velocity - normal * opening;
        let limit = self.friction * if self.limits_by_total { along.abs() } else { elastic };
        if self.tangential_stiffness == 0.0 {
            let viscous = sliding * self.tangential_dashpot;
            let (slides, on_cone) = on_cone(&viscous, limit);
            return normal_force + viscous * if slides { on_cone } else { share };
        }
        let (stiffness, compliance) = (self.tangential_stiffness, 1.0 / self.tangential_stiffness);
        let dashpot = self.tangential_dashpot + self.step_dashpot(dt);
        let viscous = sliding * dashpot;
        let is_new = (displacement.x == 0.0) & (displacement.y == 0.0) & (displacement.z == 0.0);
        let begins = begins(share, opening) & is_new;
        let since = if begins { (share - 0.5) * dt - dashpot * compliance } else { 0.5 * dt };
        let mut stretched = *displacement + sliding * since;
        stretched -= normal * stretched.dot(&normal);
        let sticking = stretched * stiffness + viscous;
        let (slides, on_cone) = on_cone(&sticking, limit);
        let force = sticking * if slides { on_cone } else { share_at_end(share, opening) };
        let stretched = if slides { (force - viscous) * compliance } else { stretched };
        *displacement = stretched + sliding * (0.5 * dt);
        normal_force + force
    }

    /// Dashpot (N s/m) that keeps the tangential springs stable: kt dt min((ωt dt)², 1/2), ωt² = 7/2 kt/m.
    ///
    /// Velocities at the time of the positions are extrapolated with the last acceleration; by the trapezoidal rule
    /// that feeds a spring ωt⁴ dt³/8 of its amplitude per second, and N² times that to one of N springs of a body. The
    /// dashpot takes it back for N up to 4. It is of third order in dt; half of kt dt is that of the rule of Euler.
    #[inline(always)]
    pub(crate) fn step_dashpot(&self, dt: f64) -> f64 {
        let stiff = self.tangential_stiffness * dt;
        stiff * (3.5 * stiff * dt / self.mass).min(0.5)
    }

    /// Whether bodies resist rolling.
    #[inline(always)]
    pub fn resists_rolling(&self) -> bool {
        self.rolling.is_active()
    }
}

/// Share of the step around this instant for which the bodies touch (-), from 1/2 to 3/2.
///
/// The dashpot force jumps when a contact begins or ends. The first and the last evaluation of a contact
/// stand for all of it since, or until, the overlap is zero; without this the restitution would depend
/// to first order in dt on where between two steps the bodies meet.
#[inline(always)]
pub(crate) fn share_in_contact(overlap: f64, opening: f64, dt: f64) -> f64 {
    let way = opening.abs() * dt;
    if overlap < way { 0.5 + overlap / way } else { 1.0 }
}

/// Whether a contact begins in this step: it is less than its share of it, less 1/2, old.
#[inline(always)]
pub(crate) fn begins(share: f64, opening: f64) -> bool {
    (opening < 0.0) & (share != 1.0)
}

/// The share of [`share_in_contact`] of a contact that ends, else 1.
#[inline(always)]
pub(crate) fn share_at_end(share: f64, opening: f64) -> f64 {
    if opening < 0.0 { 1.0 } else { share }
}

/// Whether a vector is longer than `limit`, and its share that is not.
#[inline(always)]
pub(crate) fn on_cone(vector: &Vec3, limit: f64) -> (bool, f64) {
    let square = vector.norm_squared();
    (square > limit * limit, limit / square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eqs 3.43-3.47 by hand: kn = 8 N/m, e = 0.98, m = 4.523893e-7 kg, whose Tc is 7.470850e-4 s (reference A1g).
    #[test]
    fn the_contact_time_stands_for_the_history() {
        let (kn, m, ratio) = (8.0, 4.523893e-7, 0.5);
        let law = ContactLaw::new(kn, 0.98, 0.3, Tangential::ContactTime { stiffness_ratio: ratio });
        let kt: f64 = ratio * kn;
        let dashpot = kt * 7.470850e-4 + 2.0 * law.damping * (m * kt).sqrt();
        assert!((2.0 * m * law.tangential_rate(m) / dashpot - 1.0).abs() < 1e-6);
        let coefficients = law.coefficients(m);
        let force = |overlap: f64, velocity: Vec3| {
            let encounter = Encounter { normal: Vec3::z(), overlap, velocity, spin: Vec3::zeros() };
            coefficients.force(&encounter, &mut Vec3::zeros(), 1e-9)
        };
        let slow = force(1e-5, Vec3::new(1e-4, 0.0, 0.0));
        assert!((slow - Vec3::new(1e-4 * dashpot, 0.0, -8e-5)).norm() < 1e-9 * 8e-5 + 1e-6 * slow.x);
        // Fast, the force is mu times the whole normal force, dashpot and all, on body 1 along V2 - V1.
        let fast = force(1e-5, Vec3::new(3.0, 4.0, -2.0));
        let whole = 8e-5 + 2.0 * law.damping * (kn * m).sqrt() * 2.0;
        assert!((fast - Vec3::new(0.18 * whole, 0.24 * whole, -whole)).norm() < 1e-12 * whole);
    }
}
