//! Elastic beams that bond two bodies (Potyondy and Cundall 2004).
//!
//! The beam joins the centres of both bodies and has a circular section. Spheres need no orientation: the bond keeps what their
//! rotations make of its own. Its direction d, the normal n when it was made, turns with the mean ω = (ω1 + ω2)/2 of both;
//! its turn θ collects ω2 − ω1 and turns likewise. With the length l, l0 at first, the energy is
//!
//! ```text
//! U = 1/2 Kn (l − l0)² + 1/2 Ks l0² |n − d|² + 1/2 Kb |θ|² + 1/2 (Kt − Kb) (θ·d)²
//! ```
//!
//! Length and shear come from positions, so they do not drift; forces and torques are those of U, and balance. Codes that sum
//! shear forces step by step turn them with n, and must turn them about n as well; here d and θ turn with ω, lengths kept.
//!
//! θ is an angle of small relative rotation; the whole may turn as far as it likes.

mod rotation;
mod section;
mod strength;

pub use section::{BeamShear, Section, Stiffness};
pub use strength::{Strength, Stress};

use nalgebra::Vector3;
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;

/// Two bonded bodies, as their beam sees them; a wall is a body of infinite mass at the nearest point of its surface.
#[derive(Clone, Copy, Debug)]
pub struct BondedPair {
    /// Unit normal n from the centre of body 1 to that of body 2 (-).
    pub normal: Vec3,
    /// Distance l of the centres (m).
    pub distance: f64,
    /// Relative velocity V2 − V1 of the centres (m/s).
    pub velocity: Vec3,
    /// Angular velocities ω1 and ω2 (rad/s).
    pub spins: [Vec3; 2],
    /// Reduced mass (kg).
    pub mass: f64,
    /// Sum of the inverse moments of inertia (1/(kg m²)).
    pub inverse_inertia: f64,
}

/// Constants of a bond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond {
    /// Section and moduli.
    pub section: Section,
    /// Share ζ of critical damping of each spring with the pair's own mass and inertia (-).
    pub damping: f64,
    /// Stresses at which it breaks.
    pub strength: Strength,
}

/// What a bond keeps from one step to the next, as seen from body 1: seven numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondState {
    /// Length l0 when it was made (m).
    pub length: f64,
    /// Direction d (-), half a step on.
    pub direction: Vec3,
    /// Relative rotation θ of body 2 to body 1 (rad), half a step on.
    pub turn: Vec3,
}

/// What a bond does to its bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondLoad {
    /// Force on body 1 (N); body 2 gets the opposite.
    pub force: Vec3,
    /// Torques on bodies 1 and 2 about their centres (N m). With the force they add up to no moment.
    pub torques: [Vec3; 2],
}

impl BondState {
    /// Numbers that a bond keeps.
    pub const NUMBERS: usize = 7;

    /// State of a bond without stress between bodies as they are, before the first [`Bond::load`] of steps of `dt` (s).
    pub fn new(pair: &BondedPair, dt: f64) -> Self {
        let [one, two] = pair.spins;
        let back = rotation::by((one + two) * (-0.25 * dt));
        Self {
            length: pair.distance,
            direction: back.turned(&pair.normal),
            turn: back.turned(&((two - one) * (-0.5 * dt))),
        }
    }

    /// The same bond as seen from body 2.
    pub fn reversed(&self) -> Self {
        Self { direction: -self.direction, turn: -self.turn, ..*self }
    }
}

impl From<[f64; BondState::NUMBERS]> for BondState {
    fn from([length, dx, dy, dz, x, y, z]: [f64; BondState::NUMBERS]) -> Self {
        Self { length, direction: Vec3::new(dx, dy, dz), turn: Vec3::new(x, y, z) }
    }
}

impl From<BondState> for [f64; BondState::NUMBERS] {
    fn from(BondState { length, direction, turn }: BondState) -> Self {
        [length, direction.x, direction.y, direction.z, turn.x, turn.y, turn.z]
    }
}

impl Bond {
    /// Force and torques at this instant, and the state half a step `dt` (s) on; nothing if the bond breaks.
    ///
    /// Force on body 1: (Kn (l − l0) + cn dl/dt) n + T, with T = (Ks l0² P(n − d) + cs l0² q)/l, q = P V/l − ω × n and
    /// P = I − n nᵀ. Torques: l n × T/2 ± M, with M = Kb θ + (Kt − Kb)(θ·d) d + the same of dashpots with ω2 − ω1. Dashpots
    /// are 2ζ √(K m), m the mass or inertia that the spring moves.
    #[inline]
    pub fn load(&self, state: &mut BondState, pair: &BondedPair, dt: f64) -> Option<BondLoad> {
        self.load_after(state, pair, [dt; 2])
    }

    /// The same where the step `before` (s), after which the state was left, was another.
    #[inline]
    pub fn load_after(
        &self,
        state: &mut BondState,
        pair: &BondedPair,
        [before, dt]: [f64; 2],
    ) -> Option<BondLoad> {
        let BondedPair { normal, distance, velocity, spins: [one, two], .. } = *pair;
        let rest = state.length;
        let turning = two - one;
        let half_step = rotation::by((one + two) * (0.25 * before));
        let direction = half_step.turned(&state.direction);
        let turn = half_step.turned(&state.turn) + turning * (0.5 * before);
        let half_step = rotation::by((one + two) * (0.25 * dt));
        let stiffness = self.section.stiffness(rest);
        let dashpots = self.dashpots(&stiffness, pair, rest, dt);

        let opening = velocity.dot(&normal);
        let swing = (velocity - normal * opening) / distance - ((one + two) * 0.5).cross(&normal);
        let lean = normal * direction.dot(&normal) - direction;
        let lever = rest * rest / distance;
        let tension = stiffness.axial * (distance - rest);
        let shear = lean * (stiffness.shear * lever);
        let moment = along_and_across(&turn, &direction, stiffness.torsion, stiffness.bending);
        if self.strength.is_exceeded(&self.section.stress(tension, &shear, &moment, &direction)) {
            return None;
        }

        let shear = shear + swing * (dashpots.shear * lever);
        let moment = moment + along_and_across(&turning, &direction, dashpots.torsion, dashpots.bending);
        let arm = normal.cross(&shear) * (0.5 * distance);
        state.direction = half_step.turned(&direction);
        state.turn = half_step.turned(&(turn + turning * (0.5 * dt)));
        Some(BondLoad {
            force: normal * (tension + dashpots.axial * opening) + shear,
            torques: [arm + moment, arm - moment],
        })
    }

    /// Half the shortest period (s), π √(m/K), of any spring of a bond of this length (m) between bodies of this reduced mass
    /// (kg) and sum of inverse moments of inertia (1/(kg m²)).
    pub fn half_period(&self, length: f64, mass: f64, inverse_inertia: f64) -> f64 {
        let Stiffness { axial, shear, bending, torsion } = self.section.stiffness(length);
        let rates = [
            axial / mass,
            shear * sheared(length, mass, inverse_inertia),
            bending.max(torsion) * inverse_inertia,
        ];
        PI / rates.into_iter().fold(0.0, f64::max).sqrt()
    }

    /// Elastic energy U (J) at the instant half a step `dt` (s) after that of the state.
    pub fn energy(&self, state: &BondState, pair: &BondedPair, dt: f64) -> f64 {
        let [one, two] = pair.spins;
        let half_step = rotation::by((one + two) * (0.25 * dt));
        let direction = half_step.turned(&state.direction);
        let turn = half_step.turned(&state.turn) + (two - one) * (0.5 * dt);
        let Stiffness { axial, shear, bending, torsion } = self.section.stiffness(state.length);
        let moment = along_and_across(&turn, &direction, torsion, bending);
        let (stretch, lean) = (pair.distance - state.length, (pair.normal - direction) * state.length);
        0.5 * (axial * stretch * stretch + shear * lean.norm_squared() + moment.dot(&turn))
    }

    /// Dashpots (N s/m, N m s) of the springs.
    ///
    /// Those of springs that collect velocities have K dt min(3 K dt²/m, 1/2) more, of third order in dt: velocities at the time
    /// of positions are extrapolated, which feeds N springs of a body N² ω⁴ dt³/8 of their amplitude per second, and this takes
    /// it back for N up to 12.
    #[inline(always)]
    fn dashpots(&self, stiffness: &Stiffness, pair: &BondedPair, rest: f64, dt: f64) -> Stiffness {
        let damped = |stiffness: f64, mass: f64| 2.0 * self.damping * (stiffness * mass).sqrt();
        let steady = |stiffness: f64, mass: f64| {
            let stiff = stiffness * dt;
            damped(stiffness, mass) + stiff * (3.0 * stiff * dt / mass).min(0.5)
        };
        let inertia = 1.0 / pair.inverse_inertia;
        let sheared = 1.0 / sheared(rest, pair.mass, pair.inverse_inertia);
        Stiffness {
            axial: damped(stiffness.axial, pair.mass),
            shear: steady(stiffness.shear, sheared),
            bending: steady(stiffness.bending, inertia),
            torsion: steady(stiffness.torsion, inertia),
        }
    }
}

/// Inverse of the mass (1/kg) that the shear spring of a bond of this length (m) moves.
#[inline(always)]
fn sheared(length: f64, mass: f64, inverse_inertia: f64) -> f64 {
    1.0 / mass + 0.25 * length * length * inverse_inertia
}

/// The vector with its part along an axis scaled by one factor, and that across by another.
#[inline(always)]
fn along_and_across(vector: &Vec3, axis: &Vec3, along: f64, across: f64) -> Vec3 {
    vector * across + axis * ((along - across) * vector.dot(axis))
}
