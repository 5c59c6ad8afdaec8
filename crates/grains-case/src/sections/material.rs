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
    /// Young's modulus E (Pa), of Hertzian contacts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e4, 2e12]))]
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio ν (-), of Hertzian contacts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0, "maximum" = 0.5))]
    pub poissons_ratio: Option<f64>,
    /// Surface energy γ (J/m²), of adhesive contacts: a contact of the material with itself has the work of adhesion 2 γ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-6, 5]))]
    pub surface_energy: Option<f64>,
}
