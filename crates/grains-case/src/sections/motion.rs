//! `motion = { kind = ... }`: prescribed motion of a wall, or of the particles of an insertion.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::motion_table::{self, TableRow};
use crate::vector::norm;

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
    /// Displacements, and turns about a fixed axis, given at times; between them monotone cubics, so that the velocity is
    /// continuous, and at rest before the first and after the last.
    Table {
        /// CSV file with a header of the columns `time` (s), `x`, `y`, `z` (m) and, as needed, `angle` (rad), instead of the lists;
        /// relative to the folder of the case file.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        path: Option<PathBuf>,
        /// Times (s), ascending.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        times: Vec<f64>,
        /// Displacements (m) at these times from where the case puts the wall.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        displacements: Vec<[f64; 3]>,
        /// Angles (rad) turned at these times, counter-clockwise about the axis; for walls.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        angles: Vec<f64>,
        /// A point of the axis (m), which the displacement moves.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        point: Option<[f64; 3]>,
        /// Direction of the axis (-), of any length.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        axis: Option<[f64; 3]>,
        /// The rows of the file or of the lists.
        #[serde(skip)]
        rows: Vec<TableRow>,
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
    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Translation { .. } => "translation",
            Self::Oscillation { .. } => "oscillation",
            Self::Rotation { .. } => "rotation",
            Self::Table { .. } => "a table of times",
        }
    }

    /// The interval (s) of motion.
    pub fn interval(&self) -> (f64, f64) {
        match self {
            Self::Translation { start, end, .. }
            | Self::Oscillation { start, end, .. }
            | Self::Rotation { start, end, .. } => (*start, *end),
            Self::Table { rows, .. } => {
                let [first, last] = [rows.first(), rows.last()].map(|row| row.map_or(0.0, |row| row.time));
                (first, last)
            }
        }
    }

    /// The key of when it begins.
    pub fn start_key(&self) -> &'static str {
        if let Self::Table { .. } = self { "times" } else { "start" }
    }

    /// Point (m), if there is one, and direction of the axis about which it turns, if it does.
    pub fn axis(&self) -> Option<(Option<[f64; 3]>, [f64; 3])> {
        match self {
            Self::Rotation { point, axis, .. } => Some((*point, *axis)),
            Self::Table { point, axis, .. } => axis.map(|axis| (*point, axis)),
            Self::Translation { .. } | Self::Oscillation { .. } => None,
        }
    }

    /// Largest speed (m/s) of points up to an arm (m) from the axis, and the key that gives it.
    ///
    /// Between two rows of a table it is taken as 3/2 of the mean speed, as from rest to rest.
    pub fn speed(&self, arm: f64) -> (f64, &'static str) {
        match self {
            Self::Translation { velocity, .. } => (norm(*velocity), "velocity"),
            Self::Oscillation { amplitude, frequency, .. } => {
                (std::f64::consts::TAU * frequency * norm(*amplitude), "amplitude")
            }
            Self::Rotation { angular_velocity, .. } => (angular_velocity.abs() * arm, "angular_velocity"),
            Self::Table { rows, .. } => {
                let means = rows.windows(2).map(|pair| pair[0].mean_speed(&pair[1], arm));
                (1.5 * means.fold(0.0, f64::max), "times")
            }
        }
    }

    pub(crate) fn check(&mut self, path: &str, checker: &mut Checker) {
        match self {
            Self::Translation { start, end, .. }
            | Self::Oscillation { start, end, .. }
            | Self::Rotation { start, end, .. } => {
                checker.ordered_times(&format!("{path}.end"), ("start", *start), *end);
            }
            Self::Table { path: file, times, displacements, angles, rows, .. } => {
                let lists = (&times[..], &displacements[..], &angles[..]);
                *rows = motion_table::check(path, file, lists, checker);
            }
        }
        match self {
            Self::Rotation { axis, .. } => *axis = checker.direction(&format!("{path}.axis"), *axis),
            Self::Table { rows, point, axis, .. } => {
                if let Some(axis) = axis {
                    *axis = checker.direction(&format!("{path}.axis"), *axis);
                }
                if rows.iter().any(|row| row.angle != 0.0) && (axis.is_none() || point.is_none()) {
                    let key = if axis.is_none() { "axis" } else { "point" };
                    let message = "missing key; angles are about an axis through a point (m)";
                    checker.error(&format!("{path}.{key}"), message.into());
                }
            }
            Self::Translation { .. } | Self::Oscillation { .. } => {}
        }
    }

    /// Refuses what particles cannot do, which have no common axis but that of a rotation.
    pub(crate) fn check_of_particles(&self, path: &str, checker: &mut Checker) {
        if let Self::Table { rows, .. } = self
            && rows.iter().any(|row| row.angle != 0.0)
        {
            let message = "particles are displaced by a table and do not turn; remove the angles, or take kind = \"rotation\"";
            checker.error(&format!("{path}.angles"), message.into());
        }
    }
}
