//! `[heat]`: temperatures of particles.

use super::material::Material;
use super::{insert::Insert, wall::Wall};
use crate::check::Checker;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gas around the contacts of spheres and in narrow gaps between them (Rong and Horio 1999).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GasLens {
    /// Thermal conductivity of the gas (W/(m K)).
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-3, 10]))]
    pub conductivity: f64,
    /// Thickness of the layer around a sphere over its radius (-).
    #[serde(default = "thickness")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub thickness: f64,
    /// Smallest gap through which heat passes (m): the mean free path of the gas, or the roughness.
    #[serde(default = "smallest_gap")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-11, 1e-4]))]
    pub smallest_gap: f64,
    /// Whether the way through the spheres hinders the heat too (Cheng, Yu and Zulli 1999); without it they have one temperature up to
    /// their surface, as Rong and Horio take them, which overestimates where they conduct less than a thousand times as well.
    #[serde(default = "super::yes")]
    pub through_solid: bool,
}

fn thickness() -> f64 {
    0.2
}

fn smallest_gap() -> f64 {
    4e-10
}

/// Radiation between particles and their surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Radiation {
    /// Temperature of the surroundings (K).
    #[schemars(extend("minimum" = 0, "x-plausible" = [2, 4000]))]
    pub surroundings: f64,
}

/// Temperatures of particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Heat {
    /// Temperature of particles whose insertion states none (K).
    #[schemars(extend("minimum" = 0, "x-plausible" = [2, 4000]))]
    pub temperature: f64,
    /// Time steps from one evaluation of contacts, gas, walls and radiation to the next; as many as change no temperature by more than a
    /// hundredth of a difference, five at most, if absent (-).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1, "maximum" = 1000))]
    pub every: Option<u64>,
    /// Gas that conducts heat around contacts; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gas: Option<GasLens>,
    /// Radiation; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radiation: Option<Radiation>,
}

/// Checks that what states heat goes with `[heat]`, and that particles can have temperatures.
pub(crate) fn check(
    heat: Option<&Heat>,
    materials: &[Material],
    (inserts, walls): (&[Insert], &[Wall]),
    checker: &mut Checker,
) {
    let Some(heat) = heat else {
        let of_inserts = inserts.iter().position(|insert| insert.temperature.is_some());
        let of_walls = walls.iter().enumerate().find_map(|(k, wall)| Some((k, stated(wall)?)));
        let key = of_inserts
            .map(|k| format!("insert[{k}].temperature"))
            .or(of_walls.map(|(k, key)| format!("wall[{k}].{key}")));
        if let Some(key) = key {
            let message =
                "without effect: particles have no temperature; add [heat] with their temperature (K)";
            checker.error(&key, message.into());
        }
        return;
    };
    let is_of = |k: usize| inserts.iter().flat_map(|insert| &insert.particles).any(|part| part.material == k);
    for (k, material) in materials.iter().enumerate() {
        let path = |key: &str| format!("material[{k}].{key}");
        if is_of(k) && material.heat_capacity.is_none() {
            let message = "missing key; particles have temperatures ([heat]) and need the specific heat capacity (J/(kg K)) of their material";
            checker.error(&path("heat_capacity"), message.into());
        }
        if is_of(k) && heat.radiation.is_some() && material.emissivity.is_none() {
            let message = "missing key; particles radiate (heat.radiation) and need the emissivity (-) of their material";
            checker.error(&path("emissivity"), message.into());
        }
        if heat.radiation.is_none() && material.emissivity.is_some() {
            checker.warn(&path("emissivity"), "without effect: there is no [heat.radiation]".into());
        }
    }
    for (k, wall) in walls.iter().enumerate() {
        let Some(key) = stated(wall) else { continue };
        if wall.temperature.is_some() && wall.heating.is_some() {
            let message = "the temperature follows from the heat; give temperature (K) or heating (W)";
            checker.error(&format!("wall[{k}].heating"), message.into());
        }
        if materials.get(wall.material).is_some_and(|material| material.conductivity.is_none()) {
            let message = format!(
                "heat passes into particles through contacts, and material \"{}\" has no conductivity; add conductivity (W/(m K)) to that [[material]]",
                materials[wall.material].name
            );
            checker.error(&format!("wall[{k}].{key}"), message);
        }
    }
}

/// The key by which heat passes between a wall and particles.
fn stated(wall: &Wall) -> Option<&'static str> {
    let of_temperature = wall.temperature.map(|_| "temperature");
    of_temperature.or(wall.heating.map(|_| "heating"))
}
