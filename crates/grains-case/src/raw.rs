//! A case as its file says it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sections::bond::Bond;
use crate::sections::collisions::Collisions;
use crate::sections::contact::Contact;
use crate::sections::contact_points::ContactPoints;
use crate::sections::domain::Domain;
use crate::sections::fluid::Fluid;
use crate::sections::heat::Heat;
use crate::sections::insert::Insert;
use crate::sections::material::Material;
use crate::sections::output::{Field, RawOutput};
use crate::sections::run::{FlowPlane, Limits, Neighbours, Stop};
use crate::sections::shape::Shape;
use crate::sections::time::RawTime;
use crate::sections::wall::Wall;

/// A case as written in the file, with keys and ranges checked but names unresolved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "grains-mpi case file", rename = "Case")]
#[schemars(extend(
    "if" = {"not": {"required": ["fluid"]}},
    "then" = {"required": ["material", "shape", "insert"]}
))]
pub struct RawCase {
    /// Name of the case; the name of the file by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Seed (-): random numbers depend on it and on the particle's id alone.
    #[serde(default = "first_seed")]
    #[schemars(extend("minimum" = 0))]
    pub seed: u64,
    /// Acceleration of gravity (m/s²).
    #[serde(default = "downwards")]
    pub gravity: [f64; 3],
    /// The box of the computation.
    pub domain: Domain,
    /// Duration and time step.
    pub time: RawTime,
    /// Materials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub material: Vec<Material>,
    /// Soft or hard collisions.
    #[serde(default)]
    pub collisions: Collisions,
    /// Contact laws, one per pair of materials that can meet.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contact: Vec<Contact<String>>,
    /// Beams between particles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bond: Vec<Bond<String>>,
    /// How faces and composites touch.
    #[serde(default)]
    pub contact_points: ContactPoints,
    /// Forms of particles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shape: Vec<Shape>,
    /// Particles to insert.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub insert: Vec<Insert<String>>,
    /// Walls.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wall: Vec<Wall<String>>,
    /// Planes through which particles are counted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flow_plane: Vec<FlowPlane>,
    /// Temperatures of particles, if they have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heat: Option<Heat>,
    /// The fluid, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<Fluid>,
    /// What is written, where and how often.
    #[serde(default = "default_output")]
    pub output: RawOutput,
    /// Limits beyond which the run ends with an error.
    #[serde(default)]
    pub limits: Limits,
    /// What ends the run before its time.
    #[serde(default)]
    pub stop: Stop<String>,
    /// Neighbour list.
    #[serde(default)]
    pub neighbours: Neighbours,
}

fn first_seed() -> u64 {
    1
}

fn downwards() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

fn default_output() -> RawOutput {
    RawOutput { keep_checkpoints: 2, fields: Field::ALL.to_vec(), ..RawOutput::default() }
}
