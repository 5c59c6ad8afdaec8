//! `motion = { kind = ... }`: prescribed motion of a wall, or of the particles of an insertion.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;

/// Prescribed motion of a wall or of particles, which rest outside [start, end).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Motion {
    /// Constant velocity.
    Translation {
        /// Velocity (m/s).
        velocity: [f64; 3],
        /// Time at which the motion begins (s).
        #[serde(default)]
        start: f64,
        /// Time at which the motion ends (s).
        #[serde(default = "super::infinity")]
        #[schemars(extend("x-infinite" = true))]
        end: f64,
    },
    /// Displacement amplitude × (sin(2π frequency (t − start) + phase) − sin(phase)).
    Oscillation {
        /// Amplitude along each axis (m).
        amplitude: [f64; 3],
        /// Frequency (Hz).
        #[schemars(extend("exclusiveMinimum" = 0))]
        frequency: f64,
        /// Phase (rad).
        #[serde(default)]
        phase: f64,
        /// Time at which the motion begins (s).
        #[serde(default)]
        start: f64,
        /// Time at which the motion ends (s).
        #[serde(default = "super::infinity")]
        #[schemars(extend("x-infinite" = true))]
        end: f64,
    },
    /// Constant angular velocity about a fixed axis.
    Rotation {
        /// A point of the axis (m); particles may do without, and then turn each about its own centre.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        point: Option<[f64; 3]>,
        /// Direction of the axis (-), of any length; the turn is counter-clockwise about it.
        axis: [f64; 3],
        /// Angular velocity (rad/s).
        angular_velocity: f64,
        /// Time at which the motion begins (s).
        #[serde(default)]
        start: f64,
        /// Time at which the motion ends (s).
        #[serde(default = "super::infinity")]
        #[schemars(extend("x-infinite" = true))]
        end: f64,
    },
}

/// What the particles of an insertion do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ParticleMotion {
    /// They move by the forces on them.
    Free,
    /// They stay where they are inserted.
    Fixed,
    /// They move as a wall does, from where they are inserted.
    #[serde(untagged)]
    Prescribed(Motion),
}

impl ParticleMotion {
    /// Whether forces do not move them.
    pub fn is_prescribed(&self) -> bool {
        *self != Self::Free
    }
}

impl Motion {
    /// The interval (s) of motion.
    pub fn interval(&self) -> (f64, f64) {
        match self {
            Self::Translation { start, end, .. }
            | Self::Oscillation { start, end, .. }
            | Self::Rotation { start, end, .. } => (*start, *end),
        }
    }

    pub(crate) fn check(&mut self, path: &str, checker: &mut Checker) {
        let (start, end) = self.interval();
        checker.ordered_times(&format!("{path}.end"), ("start", start), end);
        if let Self::Rotation { axis, .. } = self {
            *axis = checker.direction(&format!("{path}.axis"), *axis);
        }
    }
}
