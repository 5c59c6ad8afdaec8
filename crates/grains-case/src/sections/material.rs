//! `[[material]]`: what bodies and walls are made of.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A material of particles or walls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Name by which particles, walls and contacts refer to the material.
    pub name: String,
    /// Density (kg/m³); may be left out for a material of walls only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1, 30000]))]
    pub density: Option<f64>,
}
