//! Particles of prescribed motion: fixed ones, and ones that move as a wall does.
//!
//! They are known by their identities, so that nothing more travels with a particle. Their pose goes through each step as the
//! motion M(t) does,
//!
//! ```text
//!  x(t + Δt) = M(t + Δt) M⁻¹(t) x(t),    v, ω those of the motion at t + Δt
//! ```
//!
//! so that one that is inserted late, or whose motion changes at a restart, goes on from where it is. To all others they are
//! bodies of infinite mass; loads on them are summed, and move nothing. Two of them exert nothing on each other, nor does a wall.

use crate::particles::Body;
use crate::rotation::frame;
use crate::walls::Motion;
use grains_domain::GlobalBox;
use grains_geometry::{Mat3, Rotation, Vec3, rotation_vector};
use std::ops::Range;

/// What prescribes the motion of some particles.
#[derive(Clone, Debug, PartialEq)]
pub struct PrescribedMotion {
    /// Name of their insertion.
    pub name: String,
    /// Their identities.
    pub ids: Range<u64>,
    /// Their motion.
    pub motion: Motion,
    /// Whether each turns about its own centre instead of the axis of the motion.
    pub about_centres: bool,
}

/// The motion prescribed in one step.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    /// Way of translation (m), on the quantum of positions.
    way: Vec3,
    /// Turn, if there is one.
    turn: Option<(Rotation, Mat3)>,
    /// Velocity (m/s) and angular velocity (rad/s) at the end of the step.
    rates: [Vec3; 2],
    /// A point of the axis (m), a multiple of the quantum; none if each turns about its centre.
    pivot: Option<Vec3>,
}

/// Where a body of prescribed motion is after a step.
pub(crate) struct AfterStep {
    pub(crate) position: Vec3,
    pub(crate) velocity: Vec3,
    pub(crate) angular_velocity: Vec3,
    /// Mean velocity (m/s) and angular velocity (rad/s) in the step.
    pub(crate) mean: [Vec3; 2],
}

impl Course {
    /// The course between two times (s).
    pub(crate) fn new(prescribed: &PrescribedMotion, [from, to]: [f64; 2], global: &GlobalBox) -> Self {
        let snap = |x: Vec3| x.map(|x| global.quantum.snap(x));
        let (before, after) = (prescribed.motion.at(from), prescribed.motion.at(to));
        let (way, turn) = match prescribed.motion {
            Motion::Rotation { .. } => {
                let [old, new] = [from, to].map(|time| prescribed.motion.turned_at(time));
                let turn = (old != new).then(|| new * old.inverse());
                (Vec3::zeros(), turn.map(|turn| (turn, frame(&turn))))
            }
            // Differences of multiples of the quantum: ways add up to where the motion is, to the last bit.
            _ => (snap(after.translation) - snap(before.translation), None),
        };
        let pivot = (!prescribed.about_centres).then(|| snap(after.pivot));
        Self { way, turn, rates: [after.velocity, after.angular_velocity], pivot }
    }

    /// From the axis to a position (m), along periodic axes from its nearest image.
    fn arm(&self, position: &Vec3, global: &GlobalBox) -> Vec3 {
        let Some(pivot) = self.pivot else { return Vec3::zeros() };
        Vec3::from_fn(|a, _| {
            let arm = position[a] - pivot[a];
            let length = global.length(a);
            if global.periodic[a] { arm - length * (arm / length + 0.5).floor() } else { arm }
        })
    }

    /// Velocity (m/s) and angular velocity (rad/s) of a body at a position (m) at the end of the step.
    pub(crate) fn velocities(&self, position: &Vec3, global: &GlobalBox) -> [Vec3; 2] {
        let [velocity, spin] = self.rates;
        // Without rotation there is no axis that a body could be far from.
        let around = if spin == Vec3::zeros() { spin } else { spin.cross(&self.arm(position, global)) };
        [velocity + around, spin]
    }

    /// A body after the step of `dt` (s).
    pub(crate) fn advance(&self, body: &Body, global: &GlobalBox, dt: f64) -> AfterStep {
        let mut way = self.way;
        let mut spin = Vec3::zeros();
        if let Some((turn, matrix)) = &self.turn {
            let arm = self.arm(&body.position, global);
            way += (matrix * arm - arm).map(|x| global.quantum.snap(x));
            spin = rotation_vector(turn) / dt;
        }
        let position = body.position + way;
        let [velocity, angular_velocity] = self.velocities(&position, global);
        AfterStep { position, velocity, angular_velocity, mean: [way / dt, spin] }
    }

    /// An orientation after the step.
    pub(crate) fn turned(&self, orientation: &Rotation) -> Rotation {
        match &self.turn {
            Some((turn, _)) => Rotation::new_normalize((turn * orientation).into_inner()),
            None => *orientation,
        }
    }

    /// Whether bodies turn in the step.
    pub(crate) fn turns(&self) -> bool {
        self.turn.is_some()
    }
}
