//! `[output]`: what is written, where and how often.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;

/// Floating-point format of snapshots; checkpoints are always f64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 8 bytes per number.
    #[default]
    F64,
    /// 4 bytes per number, about 7 digits.
    F32,
}

/// A field of particle snapshots that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Field {
    /// Number of the material.
    Material,
    /// Touching particles.
    Coordination,
    /// Touching walls.
    WallContacts,
    /// Velocity (m/s).
    Velocity,
    /// Angular velocity (rad/s).
    AngularVelocity,
    /// Contact force (N).
    Force,
    /// Torque of the contacts (N m).
    Torque,
    /// Bonds that hold the particle.
    Bonds,
    /// Volume of the film on the particle (m³).
    Film,
    /// That with its parts of bridges (m³).
    Liquid,
    /// Temperature (K).
    Temperature,
    /// Force of the flow around a resolved particle (N), without buoyancy.
    FluidForce,
    /// Torque of that flow (N m).
    FluidTorque,
}

impl Field {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::Material,
        Self::Coordination,
        Self::WallContacts,
        Self::Velocity,
        Self::AngularVelocity,
        Self::Force,
        Self::Torque,
        Self::Bonds,
        Self::Film,
        Self::Liquid,
        Self::Temperature,
        Self::FluidForce,
        Self::FluidTorque,
    ];
}

/// What is written, where and how often.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Output")]
pub struct RawOutput {
    /// Folder of the results, relative to the working directory; "results/" and the name of the case file by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub directory: Option<PathBuf>,
    /// Time between particle snapshots (s), 0 for none; a hundredth of the run by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub particles: Option<f64>,
    /// Time between rows of the time series (s), 0 for none; a thousandth of the run by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub series: Option<f64>,
    /// Time between checkpoints (s), 0 for none but the last; a tenth of the run by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub checkpoint: Option<f64>,
    /// Time between outputs of the true surfaces of all particles (s), 0 for none.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub surfaces: f64,
    /// Floating-point format of snapshots: "f64" or "f32".
    #[serde(default)]
    pub precision: Precision,
    /// Whether snapshots are compressed.
    #[serde(default)]
    pub compress: bool,
    /// Fields of particle snapshots besides id, shape, radius, scale and orientation; all by default.
    #[serde(default = "all_fields")]
    pub fields: Vec<Field>,
    /// Number of checkpoints kept (-); older ones are removed.
    #[serde(default = "two")]
    #[schemars(extend("minimum" = 1))]
    pub keep_checkpoints: u64,
    /// Whether the run ends with `report.html`, a page about it; true by default.
    #[serde(default = "yes")]
    pub report: bool,
}

fn all_fields() -> Vec<Field> {
    Field::ALL.to_vec()
}

fn two() -> u64 {
    2
}

fn yes() -> bool {
    true
}

/// What is written, where and how often; a time of 0 means never.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Folder of the results, relative to the working directory.
    pub directory: PathBuf,
    /// Time between particle snapshots (s).
    pub particles: f64,
    /// Time between rows of the time series (s).
    pub series: f64,
    /// Time between checkpoints (s).
    pub checkpoint: f64,
    /// Time between outputs of true surfaces (s).
    pub surfaces: f64,
    /// Floating-point format of snapshots.
    pub precision: Precision,
    /// Whether snapshots are compressed.
    pub compress: bool,
    /// Fields of particle snapshots that can be left out and are not.
    pub fields: Vec<Field>,
    /// Number of checkpoints kept (-).
    pub keep_checkpoints: u64,
    /// Whether the run ends with a page about it.
    pub report: bool,
}

impl Output {
    /// The section as it would be written with every default spelt out.
    pub(crate) fn to_raw(&self) -> RawOutput {
        RawOutput {
            directory: Some(self.directory.clone()),
            particles: Some(self.particles),
            series: Some(self.series),
            checkpoint: Some(self.checkpoint),
            surfaces: self.surfaces,
            precision: self.precision,
            compress: self.compress,
            fields: self.fields.clone(),
            keep_checkpoints: self.keep_checkpoints,
            report: self.report,
        }
    }
}

impl RawOutput {
    /// Fills in the defaults for a run of `end` (s) of the case file `stem`.
    pub(crate) fn check(self, stem: &str, end: f64, checker: &mut Checker) -> Output {
        if self.directory.as_ref().is_some_and(|d| d.as_os_str().is_empty()) {
            checker.error("output.directory", "must not be empty; \".\" is the working directory".into());
        }
        let output = Output {
            directory: self.directory.unwrap_or_else(|| PathBuf::from("results").join(stem)),
            particles: self.particles.unwrap_or(end / 100.0),
            series: self.series.unwrap_or(end / 1000.0),
            checkpoint: self.checkpoint.unwrap_or(end / 10.0),
            surfaces: self.surfaces,
            precision: self.precision,
            compress: self.compress,
            fields: self.fields,
            keep_checkpoints: self.keep_checkpoints,
            report: self.report,
        };
        let intervals = [
            ("particles", output.particles),
            ("series", output.series),
            ("checkpoint", output.checkpoint),
            ("surfaces", output.surfaces),
        ];
        for (key, interval) in intervals {
            let path = format!("output.{key}");
            if interval > end {
                checker.warn(&path, format!("longer than the run ({end} s): only the ends are written"));
            } else if interval > 0.0 && end / interval > 1e6 {
                let times = end / interval;
                checker.warn(&path, format!("written {times:.0} times; is the interval in seconds?"));
            }
        }
        output
    }
}
