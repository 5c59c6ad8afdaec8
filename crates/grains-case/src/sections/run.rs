//! `[limits]`, `[stop]`, `[neighbours]` and `[[flow_plane]]`: how a run is watched and ended.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checker, Names};
use crate::sections::domain::Domain;

/// A plane through which particles are counted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlowPlane {
    /// Name, which also heads its columns in the time series.
    pub name: String,
    /// A point of the plane (m).
    pub point: [f64; 3],
    /// Direction in which crossings count (-), of any length.
    pub normal: [f64; 3],
}

/// Scales the directions of the planes to unit length.
pub(crate) fn check_flow_planes(
    mut planes: Vec<FlowPlane>,
    domain: &Domain,
    checker: &mut Checker,
) -> Vec<FlowPlane> {
    const MAX: usize = 32;
    if planes.len() > MAX {
        checker.error(
            &format!("flow_plane[{MAX}]"),
            format!("at most {MAX} planes are counted; leave some out"),
        );
    }
    for (i, plane) in planes.iter_mut().enumerate() {
        let path = format!("flow_plane[{i}].normal");
        plane.normal = checker.direction(&path, plane.normal);
        let is_oblique =
            |a: usize| domain.periodic[a] && (1e-12..1.0 - 1e-12).contains(&plane.normal[a].abs());
        if (0..3).any(is_oblique) {
            checker.error(&path, "oblique to a periodic axis: such a plane has no single image; lay it along or across the axis".into());
        }
    }
    planes
}

/// Limits beyond which a run ends with an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest overlap (-), as a fraction of the smaller body's inscribed radius.
    #[serde(default = "fifth")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub overlap: f64,
}

fn fifth() -> f64 {
    0.2
}

impl Default for Limits {
    fn default() -> Self {
        Self { overlap: fifth() }
    }
}

/// What ends a run before its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Stop")]
pub struct Stop<Name = usize> {
    /// Flow plane: the run ends when every particle has passed it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub all_passed: Option<Name>,
    /// Kinetic energy of all particles (J): the run ends when it falls below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub kinetic_energy_below: Option<f64>,
    /// Time before which the run is not ended (s).
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub after: f64,
}

impl<Name> Default for Stop<Name> {
    fn default() -> Self {
        Self { all_passed: None, kinetic_energy_below: None, after: 0.0 }
    }
}

impl<Name> Stop<Name> {
    /// The same condition with its flow plane named otherwise.
    pub(crate) fn rename<Other>(self, name: impl FnOnce(Name) -> Other) -> Stop<Other> {
        let Self { all_passed, kinetic_energy_below, after } = self;
        Stop { all_passed: all_passed.map(name), kinetic_energy_below, after }
    }
}

impl Stop<String> {
    pub(crate) fn check(self, names: &Names, end: f64, checker: &mut Checker) -> Stop {
        if self.after >= end {
            checker.warn("stop.after", format!("not before the end of the run ({end} s): no effect"));
        }
        self.rename(|name| checker.reference("stop.all_passed", &name, "flow_plane", &names.flow_planes))
    }
}

/// The neighbour list; the defaults suit nearly every case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Neighbours {
    /// Distance beyond contact up to which neighbours are listed (m); chosen by the program if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub skin: Option<f64>,
    /// Steps that a list is meant to last (-); chosen by the program if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1))]
    pub horizon: Option<u64>,
}
