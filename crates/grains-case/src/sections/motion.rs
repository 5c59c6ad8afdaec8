//! `motion = { kind = ... }`: prescribed motion of a wall, or of the particles of an insertion.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::domain::Domain;
use crate::sections::motion_table::{self, TableRow};
use crate::vector::{dot, norm};

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
    /// By a load along an axis, against the particles the wall presses on: m dv/dt = load + contact forces − c v. For walls.
    Load {
        /// Direction in which the load pushes the wall (-), of any length.
        axis: [f64; 3],
        /// Load over the area (Pa); negative pulls.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pressure: Option<f64>,
        /// Area on which the pressure acts (m²); the face of the domain across the axis by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        area: Option<f64>,
        /// Load (N), instead of the pressure.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        force: Option<f64>,
        /// Mass of the wall (kg), which sets how fast it follows; its weight is part of the load.
        #[schemars(extend("exclusiveMinimum" = 0))]
        mass: f64,
        /// Damping c (kg/s) of its motion along the axis.
        #[serde(default)]
        #[schemars(extend("minimum" = 0))]
        damping: f64,
        /// Largest speed along the axis (m/s).
        #[serde(default = "super::infinity")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-infinite" = true))]
        max_speed: f64,
        /// Velocity across the axis (m/s), as of a plate that shears what it presses on.
        #[serde(default)]
        velocity: [f64; 3],
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
    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Translation { .. } => "translation",
            Self::Oscillation { .. } => "oscillation",
            Self::Rotation { .. } => "rotation",
            Self::Table { .. } => "a table of times",
            Self::Load { .. } => "a load",
        }
    }

    /// The interval (s) of motion.
    pub fn interval(&self) -> (f64, f64) {
        match self {
            Self::Translation { start, end, .. }
            | Self::Oscillation { start, end, .. }
            | Self::Rotation { start, end, .. }
            | Self::Load { start, end, .. } => (*start, *end),
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
            Self::Translation { .. } | Self::Oscillation { .. } | Self::Load { .. } => None,
        }
    }

    /// Load (N) along the axis of a wall that a load moves.
    pub fn load(&self) -> Option<f64> {
        match *self {
            Self::Load { force: Some(force), .. } => Some(force),
            Self::Load { pressure, area, .. } => Some(pressure? * area?),
            _ => None,
        }
    }

    /// Largest speed (m/s) of points up to an arm (m) from the axis, and the key that gives it.
    ///
    /// That of a load is known if it is limited. Between two rows of a table it is taken as 3/2 of the mean speed, as from rest to rest.
    pub fn speed(&self, arm: f64) -> (f64, &'static str) {
        match self {
            Self::Translation { velocity, .. } => (norm(*velocity), "velocity"),
            Self::Oscillation { amplitude, frequency, .. } => {
                (std::f64::consts::TAU * frequency * norm(*amplitude), "amplitude")
            }
            Self::Rotation { angular_velocity, .. } => (angular_velocity.abs() * arm, "angular_velocity"),
            Self::Load { velocity, max_speed, .. } if max_speed.is_finite() => {
                (libm::hypot(norm(*velocity), *max_speed), "max_speed")
            }
            Self::Load { velocity, .. } => (norm(*velocity), "velocity"),
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
            | Self::Rotation { start, end, .. }
            | Self::Load { start, end, .. } => {
                checker.ordered_times(&format!("{path}.end"), ("start", *start), *end);
            }
            Self::Table { path: file, times, displacements, angles, rows, .. } => {
                let lists = (&times[..], &displacements[..], &angles[..]);
                *rows = motion_table::check(path, file, lists, checker);
            }
        }
        match self {
            Self::Rotation { axis, .. } | Self::Load { axis, .. } => {
                *axis = checker.direction(&format!("{path}.axis"), *axis)
            }
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

    /// Checks what a load takes, and gives it the area of the face of the domain across its axis if it has none.
    pub(crate) fn check_load(
        &mut self,
        path: &str,
        (domain, is_hard): (&Domain, bool),
        checker: &mut Checker,
    ) {
        let Self::Load { axis, pressure, area, force, velocity, .. } = self else { return };
        if is_hard {
            let message = "a load moves walls against contact forces, which hard collisions have not; take collisions.model = \"soft\"";
            checker.error(&format!("{path}.kind"), message.into());
        }
        if pressure.is_some() == force.is_some() {
            let message = "give the load as either pressure (Pa) or force (N)";
            checker.error(
                &format!("{path}.{}", if force.is_some() { "force" } else { "pressure" }),
                message.into(),
            );
        }
        if force.is_some() && area.is_some() {
            checker
                .error(&format!("{path}.area"), "is that of a pressure; remove it, or give pressure".into());
        }
        let along = (0..3).find(|&a| axis[a].abs() == 1.0);
        if let (Some(_), None) = (&pressure, &area) {
            let [x, y, z] = domain.extents();
            match along {
                Some(a) => *area = Some([y * z, z * x, x * y][a]),
                None => {
                    let message = "missing key; an axis that is not one of the domain's goes with no face of it: give the area (m²)";
                    checker.error(&format!("{path}.area"), message.into());
                }
            }
        }
        if dot(*velocity, *axis).abs() > 1e-9 * norm(*velocity) {
            let message = "has a part along the axis, where the load moves the wall; remove that part";
            checker.error(&format!("{path}.velocity"), message.into());
        }
    }

    /// Refuses what particles cannot do, which have no common axis but that of a rotation.
    pub(crate) fn check_of_particles(&self, path: &str, checker: &mut Checker) {
        if let Self::Load { .. } = self {
            let message = "a load moves walls alone; take another kind of motion for particles";
            checker.error(&format!("{path}.kind"), message.into());
        }
        if let Self::Table { rows, .. } = self
            && rows.iter().any(|row| row.angle != 0.0)
        {
            let message = "particles are displaced by a table and do not turn; remove the angles, or take kind = \"rotation\"";
            checker.error(&format!("{path}.angles"), message.into());
        }
    }
}
