//! `[fluid.output]` and `[[fluid.profile]]`: what is written of the fluid.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::domain::{Axis, Domain};

/// A field of the fluid's snapshots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FluidField {
    /// Velocity at the centres of the cells (m/s).
    Velocity,
    /// Pressure without its hydrostatic part (Pa).
    Pressure,
    /// Void fraction (-); only among particles.
    VoidFraction,
    /// Mean velocity of the particles (m/s); only among particles.
    SolidVelocity,
    /// Dynamic viscosity (Pa s); only where it varies.
    Viscosity,
    /// All scalars, by their names.
    Scalars,
}

impl FluidField {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Velocity,
        Self::Pressure,
        Self::VoidFraction,
        Self::SolidVelocity,
        Self::Viscosity,
        Self::Scalars,
    ];
}

/// Where the fields are written as tables, at every snapshot and as means over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ProfileKind {
    /// Points along a line, ends included.
    Line {
        /// First point (m).
        from: [f64; 3],
        /// Last point (m).
        to: [f64; 3],
        /// Number of points (-).
        #[schemars(extend("minimum" = 2, "maximum" = 1_000_000))]
        points: u64,
    },
    /// All cells that a plane cuts; mean pressure and flow rate also go to the time series.
    Plane {
        /// Axis the plane is normal to: "x", "y" or "z".
        axis: Axis,
        /// Its coordinate (m).
        at: f64,
    },
}

/// A line or plane with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Profile", extend("unevaluatedProperties" = false))]
pub struct Profile {
    /// Name, which also names its files.
    pub name: String,
    /// The line or plane.
    #[serde(flatten)]
    pub kind: ProfileKind,
}

impl Profile {
    fn check(&self, path: &str, domain: &Domain, checker: &mut Checker) {
        match &self.kind {
            ProfileKind::Line { from, to, .. } => {
                domain.must_hold(checker, &format!("{path}.from"), *from);
                domain.must_hold(checker, &format!("{path}.to"), *to);
                if from == to {
                    checker.error(&format!("{path}.to"), "the same point as `from`; a line needs two".into());
                }
            }
            ProfileKind::Plane { axis, at } => {
                let a = *axis as usize;
                let (lower, upper) = (domain.lower[a], domain.upper[a]);
                if domain.is_upright() && !(lower..=upper).contains(at) {
                    let axis = ["x", "y", "z"][a];
                    checker.error(
                        &format!("{path}.at"),
                        format!("outside the domain, {lower} to {upper} m along {axis}"),
                    );
                }
            }
        }
    }
}

/// Checks the names and places of all profiles.
pub(super) fn check_profiles(profiles: &[Profile], domain: &Domain, checker: &mut Checker) {
    checker.names("fluid.profile", profiles.iter().map(|p| p.name.clone()).collect());
    for (i, profile) in profiles.iter().enumerate() {
        profile.check(&format!("fluid.profile[{i}]"), domain, checker);
    }
}

/// What is written of the fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "FluidOutput")]
pub struct FluidOutput {
    /// Time between snapshots (s), 0 for none; that of the particles if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub interval: Option<f64>,
    /// Fields of the snapshots; all by default.
    #[serde(default = "all_fields")]
    pub fields: Vec<FluidField>,
    /// Time from which means over time are taken (s), a sample with every row of the time series; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub mean_from: Option<f64>,
    /// Ids (-) of resolved particles whose force and torque by the flow go to the time series, as `body_7_fx` to `body_7_tz`; those
    /// of all together are always there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<u64>,
}

impl Default for FluidOutput {
    fn default() -> Self {
        Self { interval: None, fields: all_fields(), mean_from: None, bodies: Vec::new() }
    }
}

fn all_fields() -> Vec<FluidField> {
    FluidField::ALL.to_vec()
}

impl FluidOutput {
    /// Fills in the interval of the particles' snapshots (s) and checks times against the end of the run (s).
    pub(super) fn check(&mut self, particles: f64, end: f64, checker: &mut Checker) {
        let interval = *self.interval.get_or_insert(particles);
        if interval > end && interval != particles {
            checker.warn(
                "fluid.output.interval",
                format!("longer than the run ({end} s): only the ends are written"),
            );
        }
        if self.mean_from.is_some_and(|from| from >= end) {
            checker.error(
                "fluid.output.mean_from",
                format!("not before the end of the run ({end} s), so there would be no means; lower it"),
            );
        }
    }
}
