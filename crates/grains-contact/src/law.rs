//! The law of a contact: its normal direction, damping, Coulomb friction, and resistance to rolling and twisting.

use crate::attraction::Attraction;
use crate::encounter::Encounter;
use crate::normal::{Approach, Linear, Normal, NormalLaw, Response};
use crate::rolling::{Rolling, RollingCoefficients};
use crate::step_share::{begins, share_at_end, share_in_contact};
use crate::tangential::{Memory, Tangential, on_cone, power};
use crate::twisting::Twisting;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;

/// Reduced mass of a pair of bodies, M1 M2/(M1 + M2) (kg); M1 against a wall.
#[inline(always)]
pub fn reduced_mass(mass_1: f64, mass_2: f64) -> f64 {
    mass_1 * mass_2 / (mass_1 + mass_2)
}

/// The law of one contact as it is now.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    pub(crate) response: Response,
    /// 2 γn m (N s/m).
    pub(crate) dashpot: f64,
    /// Whether sliding stretches a spring, and its stiffness (N/m).
    pub(crate) has_spring: bool,
    pub(crate) tangential_stiffness: f64,
    /// 2 γt m (N s/m).
    pub(crate) tangential_dashpot: f64,
    /// Exponents of [`Memory::exponents`](crate::Memory).
    pub(crate) memory_exponents: [f64; 2],
    /// Reduced mass over the number of contacts that share it (kg).
    pub(crate) mass: f64,
    pub(crate) friction: f64,
    pub(crate) rolling: RollingCoefficients,
    pub(crate) twisting: Twisting,
    /// Whether friction is limited by the whole normal force, not by its elastic part.
    pub(crate) limits_by_total: bool,
}

/// How the normal direction loses energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Damping {
    /// So that bodies part with the restitution of the law, at any speed where they do not stick.
    #[default]
    Restitution,
    /// Viscoelastic bodies: the force A dF/dδ dδ/dt (Brilliantov et al. 1996). Restitution falls with the speed.
    Viscoelastic {
        /// Time A (s), which depends on the viscosities of the material.
        #[schemars(extend("minimum" = 0))]
        time: f64,
    },
}

/// Contact law of one pair of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Law of the normal direction.
    pub normal: Normal,
    /// Restitution en (-), in (0, 1].
    pub restitution: f64,
    /// Loss of energy in the normal direction.
    pub damping: Damping,
    /// Coulomb friction coefficient μ (-).
    pub friction: f64,
    /// Tangential resistance.
    pub tangential: Tangential,
    /// Resistance to rolling.
    pub rolling: Rolling,
    /// Resistance to twisting.
    pub twisting: Twisting,
    /// Pull over a gap.
    pub attraction: Attraction,
    /// −ln en/√(π² + ln² en).
    damping_ratio: f64,
}

impl ContactLaw {
    /// Law with the given normal direction, restitution, friction, and tangential resistance.
    pub fn new(normal: impl Into<Normal>, restitution: f64, friction: f64, tangential: Tangential) -> Self {
        let log = libm::log(restitution);
        Self {
            normal: normal.into(),
            restitution,
            damping: Damping::Restitution,
            friction,
            tangential,
            rolling: Rolling::None,
            twisting: Twisting::None,
            attraction: Attraction::None,
            damping_ratio: -log / (PI * PI + log * log).sqrt(),
        }
    }

    /// Law of a linear spring of this stiffness (N/m).
    pub fn linear(stiffness: f64, restitution: f64, friction: f64, tangential: Tangential) -> Self {
        Self::new(Linear { stiffness }, restitution, friction, tangential)
    }

    /// Law of bodies that do not deform: restitution and friction of their impulses, and no force.
    pub fn rigid(restitution: f64, friction: f64) -> Self {
        Self::linear(0.0, restitution, friction, Tangential::Viscous { rate: 0.0 })
    }

    /// The same law with this damping.
    pub fn with_damping(self, damping: Damping) -> Self {
        Self { damping, ..self }
    }

    /// The same law with this resistance to rolling.
    pub fn with_rolling(self, rolling: Rolling) -> Self {
        Self { rolling, ..self }
    }

    /// The same law with this resistance to twisting.
    pub fn with_twisting(self, twisting: Twisting) -> Self {
        Self { twisting, ..self }
    }

    /// The same law with this pull over a gap.
    pub fn with_attraction(self, attraction: Attraction) -> Self {
        Self { attraction, ..self }
    }

    /// Largest gap (m) at which bodies up to this effective radius (m) act on each other.
    pub fn reach(&self, radius: f64) -> f64 {
        self.normal.reach(radius).max(self.attraction.reach(radius))
    }

    /// Largest force (N) of bodies of this effective radius (m) up to an overlap (m).
    pub fn force_bound(&self, radius: f64, overlap: f64) -> f64 {
        self.normal.force_bound(radius, overlap) + self.attraction.force_bound(radius)
    }

    /// Damping rate γn = −ω0 ln en/√(π² + ln² en) (1/s) of bodies of a reduced mass (kg) at a stiffness dF/dδ = m ω0² (N/m);
    /// thesis eq. 3.27.
    pub fn damping_rate(&self, reduced_mass: f64, stiffness: f64) -> f64 {
        0.5 * self.prepared().dashpot(reduced_mass, stiffness) / reduced_mass
    }

    /// Tangential damping rate γt (1/s) of bodies of a reduced mass (kg) at a stiffness dF/dδ (N/m).
    pub fn tangential_rate(&self, reduced_mass: f64, stiffness: f64) -> f64 {
        0.5 * self.prepared().tangential_dashpot(reduced_mass, stiffness) / reduced_mass
    }

    /// π s/√(1 − γ²) + 2 γ √s (-), s = kt/kn: (kt τc + ηt)/√(kn m), with τc = π/√(kn (1 − γ²)/m) (Srinivasan 2019, eqs 3.43-3.45).
    fn contact_time_dashpot(&self, stiffness_ratio: f64) -> f64 {
        let damping = self.damping_ratio;
        PI * stiffness_ratio / (1.0 - damping * damping).sqrt() + 2.0 * damping * stiffness_ratio.sqrt()
    }

    /// The law ready for any contact.
    #[inline]
    pub fn prepared(&self) -> PreparedLaw {
        let factor = self.normal.damping();
        let (per_root, time) = match self.damping {
            Damping::Restitution => (factor * self.damping_ratio, 0.0),
            Damping::Viscoelastic { time } => (0.0, time),
        };
        // Tangential dashpots are shares of that of the restitution, also where the normal direction has none.
        let tangential_root = if factor > 0.0 { factor } else { Linear::DAMPING } * self.damping_ratio;
        let (stiffness_ratio, tangential_per_mass, tangential_per_root, memory) = match self.tangential {
            Tangential::Viscous { rate } => (0.0, 2.0 * rate, 0.0, Memory::Displacement),
            Tangential::Spring { stiffness_ratio, damping_ratio } => {
                (stiffness_ratio, 0.0, damping_ratio * tangential_root, Memory::Displacement)
            }
            Tangential::ContactTime { stiffness_ratio } => {
                (0.0, 0.0, self.contact_time_dashpot(stiffness_ratio), Memory::Displacement)
            }
            Tangential::Mindlin { stiffness_ratio, damping_ratio, memory } => {
                (stiffness_ratio, 0.0, damping_ratio * tangential_root, memory)
            }
        };
        PreparedLaw {
            normal: self.normal,
            per_root,
            time,
            stiffness_ratio,
            tangential_per_mass,
            tangential_per_root,
            memory_exponents: memory.exponents(),
            friction: self.friction,
            rolling: self.rolling.into(),
            twisting: self.twisting,
            attraction: self.attraction,
            limits_by_total: matches!(self.tangential, Tangential::ContactTime { .. }),
        }
    }
}

/// A law whose coefficients for a contact take a root and no decision.
#[derive(Clone, Copy, Debug)]
pub struct PreparedLaw {
    /// Law of the normal direction.
    pub normal: Normal,
    /// Normal dashpot over √(m dF/dδ) (-), and over dF/dδ (s).
    per_root: f64,
    time: f64,
    /// Tangential stiffness over dF/dδ (-).
    stiffness_ratio: f64,
    /// Tangential dashpot over m (1/s), and over √(m dF/dδ) (-).
    tangential_per_mass: f64,
    tangential_per_root: f64,
    memory_exponents: [f64; 2],
    friction: f64,
    rolling: RollingCoefficients,
    twisting: Twisting,
    /// Pull over a gap.
    pub attraction: Attraction,
    limits_by_total: bool,
}

impl PreparedLaw {
    /// Coefficients of a contact of bodies of a reduced mass (kg), the number it keeps advanced by the step.
    ///
    /// The reduced mass of bodies hit off their centres is the effective mass at the contact point, 1/(n·K n) with K their
    /// mobility there.
    #[inline(always)]
    pub fn at(&self, reduced_mass: f64, approach: &Approach, memory: &mut f64) -> Coefficients {
        let mut response = self.normal.respond(approach, memory);
        if self.attraction.is_active() {
            response = while_touching(response, approach, memory);
        }
        self.of_response(reduced_mass, response, self.memory_exponents)
    }

    /// The same under `normal`, the law's own, of bodies that `PULLS` says pull at each other over a gap or do not.
    #[inline(always)]
    pub fn under<L: NormalLaw, const PULLS: bool>(
        &self,
        normal: &L,
        reduced_mass: f64,
        approach: &Approach,
        memory: &mut f64,
    ) -> Coefficients {
        let exponents = if L::HERTZIAN { self.memory_exponents } else { [0.0; 2] };
        let mut response = normal.respond(approach, memory);
        if PULLS {
            response = while_touching(response, approach, memory);
        }
        self.of_response(reduced_mass, response, exponents)
    }

    /// What the law of the normal direction answers to bodies at rest, if they touch; `memory` is the number that their contact
    /// keeps.
    #[inline]
    pub fn at_rest(&self, approach: &Approach, mut memory: f64) -> Option<Response> {
        if approach.overlap <= 0.0
            && (self.attraction.is_active() || self.normal.reach(approach.radius) <= 0.0)
        {
            return None;
        }
        let response = self.normal.respond(approach, &mut memory);
        response.is_contact.then_some(response)
    }

    #[inline(always)]
    fn of_response(&self, reduced_mass: f64, response: Response, memory_exponents: [f64; 2]) -> Coefficients {
        Coefficients {
            dashpot: self.dashpot(reduced_mass, response.stiffness),
            has_spring: self.stiffness_ratio > 0.0,
            tangential_stiffness: self.stiffness_ratio * response.stiffness,
            tangential_dashpot: self.tangential_dashpot(reduced_mass, response.stiffness),
            memory_exponents,
            mass: reduced_mass,
            friction: self.friction,
            rolling: self.rolling,
            twisting: self.twisting,
            limits_by_total: self.limits_by_total,
            response,
        }
    }

    #[inline(always)]
    fn dashpot(&self, reduced_mass: f64, stiffness: f64) -> f64 {
        self.per_root * (reduced_mass * stiffness).sqrt() + self.time * stiffness
    }

    #[inline(always)]
    fn tangential_dashpot(&self, reduced_mass: f64, stiffness: f64) -> f64 {
        self.tangential_per_mass * reduced_mass + self.tangential_per_root * (reduced_mass * stiffness).sqrt()
    }

    /// Whether bodies resist rolling or twisting.
    #[inline(always)]
    pub fn has_couples(&self) -> bool {
        self.rolling.is_active() | (self.twisting != Twisting::None)
    }

    /// Whether forces depend on the effective radius.
    pub fn takes_radius(&self) -> bool {
        self.normal.is_hertzian() | (self.twisting != Twisting::None) | self.attraction.is_active()
    }

    /// Whether contacts keep more than their tangential displacement.
    pub fn keeps_more(&self) -> bool {
        self.normal.keeps_memory()
            || self.rolling.keeps_angle()
            || self.twisting != Twisting::None
            || self.attraction.keeps_volume()
    }
}

/// The response of bodies that pull at each other over a gap, where their law of contact does not act.
#[inline(always)]
fn while_touching(response: Response, approach: &Approach, memory: &mut f64) -> Response {
    let is_apart = approach.overlap <= 0.0;
    *memory = if is_apart { 0.0 } else { *memory };
    Response { is_contact: response.is_contact & !is_apart, ..response }
}

impl Coefficients {
    /// Force on body 1 (N): F1 = −(F(δ) + 2 γn m dδ/dt) n + Ft, with |Ft| at most μ times the elastic force, without attraction.
    ///
    /// The tangential displacement ξ (m) is turned into the contact plane, advanced with the slip Vrt, and shortened while
    /// the contact slides so that kt ξ + 2 γt m Vrt stays on the friction cone (Wachs 2009, eqs 15-17; errata W09-2).
    /// A contact that begins slides, as δ = 0: its ξ is −2 γt m Vrt/kt, and its force grows from nothing. One that
    /// sticks until it ends drops its force, weighted by the share of the step in which the bodies touch.
    ///
    /// `displacement` is ξ half a step on, ξ + Vrt dt/2, zero before a contact: with the slip half a step back it makes the
    /// trapezoidal rule, of second order in dt. Where the contact radius changes ξ follows it by [`Memory`](crate::Memory).
    /// Without a tangential stiffness the force is the memoryless one of thesis eqs 3.20-3.21 and ξ stays zero;
    /// [`Tangential::ContactTime`] caps it by the whole normal force.
    #[inline(always)]
    pub fn force(&self, encounter: &Encounter, displacement: &mut Vec3, dt: f64) -> Vec3 {
        let Encounter { normal, velocity, .. } = *encounter;
        let Response { is_contact, elastic, jump, pressing, margin, .. } = self.response;
        let opening = velocity.dot(&normal);
        let share = share_in_contact(margin, opening, dt);
        let along = self.dashpot * share * opening - (elastic + jump * (share - 1.0));
        let normal_force = normal * along;
        let sliding = velocity - normal * opening;
        let limit = self.friction * if self.limits_by_total { along.abs() } else { pressing };
        if !self.has_spring {
            let viscous = sliding * self.tangential_dashpot;
            let (slides, on_cone) = on_cone(&viscous, limit);
            let force = normal_force + viscous * if slides { on_cone } else { share };
            return if is_contact { force } else { Vec3::zeros() };
        }
        let (stiffness, compliance) = (self.tangential_stiffness, 1.0 / self.tangential_stiffness);
        let dashpot = self.tangential_dashpot + self.step_dashpot(dt);
        let viscous = sliding * dashpot;
        let is_new = (displacement.x == 0.0) & (displacement.y == 0.0) & (displacement.z == 0.0);
        let begins = begins(share, opening) & is_new;
        let since = if begins { (share - 0.5) * dt - dashpot * compliance } else { 0.5 * dt };
        let [before, after] = self.memory_factors(opening);
        let mut stretched = *displacement * before + sliding * since;
        stretched -= normal * stretched.dot(&normal);
        let sticking = stretched * stiffness + viscous;
        let (slides, on_cone) = on_cone(&sticking, limit);
        let force = sticking * if slides { on_cone } else { share_at_end(share, opening) };
        let stretched = if slides { (force - viscous) * compliance } else { stretched };
        *displacement = if is_contact { stretched * after + sliding * (0.5 * dt) } else { Vec3::zeros() };
        if is_contact { normal_force + force } else { Vec3::zeros() }
    }

    /// Factors of ξ over the half steps before and after.
    #[inline(always)]
    pub(crate) fn memory_factors(&self, opening: f64) -> [f64; 2] {
        let [approaching, parting] = self.memory_exponents;
        if (approaching == 0.0) & (parting == 0.0) {
            return [1.0; 2];
        }
        let exponent = if opening < 0.0 { approaching } else { parting };
        let Response { contact_radius: now, radii_around: [before, after], .. } = self.response;
        [power([before, now], exponent), power([now, after], exponent)]
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

    /// Whether bodies resist rolling or twisting.
    #[inline(always)]
    pub fn has_couples(&self) -> bool {
        self.rolling.is_active() | (self.twisting != Twisting::None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eqs 3.43-3.47 by hand: kn = 8 N/m, e = 0.98, m = 4.523893e-7 kg, whose Tc is 7.470850e-4 s (reference A1g).
    #[test]
    fn the_contact_time_stands_for_the_history() {
        let (kn, m, ratio) = (8.0, 4.523893e-7, 0.5);
        let law = ContactLaw::linear(kn, 0.98, 0.3, Tangential::ContactTime { stiffness_ratio: ratio });
        let kt: f64 = ratio * kn;
        let dashpot = kt * 7.470850e-4 + 2.0 * law.damping_ratio * (m * kt).sqrt();
        assert!((2.0 * m * law.tangential_rate(m, kn) / dashpot - 1.0).abs() < 1e-6);
        let force = |overlap: f64, velocity: Vec3| {
            let encounter = Encounter { normal: Vec3::z(), overlap, velocity, spin: Vec3::zeros() };
            let approach = Approach { overlap, opening: velocity.z, radius: 1e-3, dt: 1e-9 };
            let coefficients = law.prepared().at(m, &approach, &mut 0.0);
            coefficients.force(&encounter, &mut Vec3::zeros(), 1e-9)
        };
        let slow = force(1e-5, Vec3::new(1e-4, 0.0, 0.0));
        assert!((slow - Vec3::new(1e-4 * dashpot, 0.0, -8e-5)).norm() < 1e-9 * 8e-5 + 1e-6 * slow.x);
        // Fast, the force is mu times the whole normal force, dashpot and all, on body 1 along V2 - V1.
        let fast = force(1e-5, Vec3::new(3.0, 4.0, -2.0));
        let whole = 8e-5 + 2.0 * law.damping_ratio * (kn * m).sqrt() * 2.0;
        assert!((fast - Vec3::new(0.18 * whole, 0.24 * whole, -whole)).norm() < 1e-12 * whole);
    }
}
