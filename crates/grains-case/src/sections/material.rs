//! `[[material]]`: what bodies and walls are made of, and the liquid on them.

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
    /// Specific heat capacity (J/(kg K)), of particles with temperatures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [10, 10000]))]
    pub heat_capacity: Option<f64>,
    /// Thermal conductivity (W/(m K)); no heat passes through contacts of a material without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-3, 3000]))]
    pub conductivity: Option<f64>,
    /// Emissivity (-), of particles that radiate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0, "maximum" = 1))]
    pub emissivity: Option<f64>,
    /// Heat produced in particles (W/kg).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heat_source: Option<f64>,
    /// Liquid on bodies of the material, which bridges of contact.attraction.kind = "film_bridge" take and give back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub film: Option<Film>,
}

/// Liquid on bodies of a material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Film {
    /// One volume on every particle.
    Volume {
        /// That volume (m³).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-24, 1e-5]))]
        volume: f64,
    },
    /// A film of one thickness, on particles as on the sphere of their volume. The only kind that walls have; theirs is not used up.
    Thickness {
        /// That thickness (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-9, 1e-2]))]
        thickness: f64,
    },
    /// A share of the volume of the particle.
    Content {
        /// Volume of liquid over that of the particle (-).
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-plausible" = [1e-6, 0.5]))]
        content: f64,
    },
    /// A share of the mass of the particle.
    MassContent {
        /// Mass of liquid over that of the particle (-).
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-plausible" = [1e-6, 0.5]))]
        content: f64,
        /// Density of the liquid (kg/m³).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [500, 14000]))]
        liquid_density: f64,
    },
}

impl Film {
    /// Volume (m³) on a sphere of a radius (m) and a density (kg/m³).
    pub(crate) fn on_sphere(&self, radius: f64, density: f64) -> f64 {
        let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        match *self {
            Self::Volume { volume } => volume,
            Self::Thickness { thickness } => ball(radius + thickness) - ball(radius),
            Self::Content { content } => content * ball(radius),
            Self::MassContent { content, liquid_density } => {
                content * density / liquid_density * ball(radius)
            }
        }
    }
}

/// Refuses films that walls cannot have.
pub(crate) fn check_films(materials: &[Material], checker: &mut crate::check::Checker) {
    for (i, material) in materials.iter().enumerate() {
        let is_of_walls = material.density.is_none();
        if is_of_walls && material.film.is_some_and(|film| !matches!(film, Film::Thickness { .. })) {
            checker.error(
                &format!("material[{i}].film.kind"),
                "a material without density is of walls, whose film has a thickness: take \"thickness\""
                    .into(),
            );
        }
    }
}
