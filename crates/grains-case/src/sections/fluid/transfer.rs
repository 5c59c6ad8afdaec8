//! `particles` of `[[fluid.scalar]]`: what particles smaller than the cells exchange with a scalar.

use super::{Context, Fluid};
use crate::check::Checker;
use grains_coupling::TransferLaw;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// A first-order reaction in particles, which are catalysts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// Rate k (1/s): per volume of the particle, k times the concentration inside.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// Effective diffusivity in the particle (m²/s), which hinders the reaction; not if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-14, 1e-3]))]
    pub diffusivity: Option<f64>,
    /// Heat that is released in the particle per amount that reacts (J/mol, J/kg); negative of what takes heat up.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub heat: f64,
}

/// Particles that take a concentration up, or give it off: it is uniform in each, and K times that outside in equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uptake {
    /// Partition coefficient K (-): concentration in particles over that of the fluid in equilibrium.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub partition: f64,
    /// Concentration in particles when they are inserted (1/m³).
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub initial: f64,
}

/// Liquid in particles that evaporates into a concentration (kg/m³) of its vapour.
///
/// At the surface the vapour has the saturation concentration c = p M/(R T), ln(p/p0) = L M/R (1/T0 − 1/T) (Clausius and Clapeyron),
/// as long as there is liquid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Evaporation {
    /// Latent heat L (J/kg), which particles lose; 2.26e6 of water.
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e4, 1e7]))]
    pub latent_heat: f64,
    /// Molar mass M (kg/mol), 0.018 of water.
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-3, 1]))]
    pub molar_mass: f64,
    /// Temperature T0 (K) at which it boils at `pressure`, 373.15 of water at 101325 Pa; near the temperatures of the case, as L is taken
    /// for constant.
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [10, 4000]))]
    pub boiling_point: f64,
    /// Pressure p0 (Pa) at which it boils at that temperature.
    #[serde(default = "atmosphere")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1, 1e7]))]
    pub pressure: f64,
    /// Liquid in particles when they are inserted (kg per m³ of the particle).
    #[schemars(extend("minimum" = 0, "x-plausible" = [0.0, 1500]))]
    pub initial: f64,
}

/// Gas constant (J/(mol K)).
const GAS_CONSTANT: f64 = 8.314_462_618;

fn atmosphere() -> f64 {
    101_325.0
}

impl Evaporation {
    /// Saturation concentration (kg/m³) of the vapour at a temperature (K).
    pub fn saturation(&self, temperature: f64) -> f64 {
        let exponent = self.latent_heat * self.molar_mass / GAS_CONSTANT;
        let pressure = self.pressure * (exponent * (1.0 / self.boiling_point - 1.0 / temperature)).exp();
        pressure * self.molar_mass / (GAS_CONSTANT * temperature)
    }
}

/// What particles smaller than the cells exchange with a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticleTransfer {
    /// Law of the Nusselt or Sherwood number.
    pub law: TransferLaw,
    /// What becomes of a concentration in the particles; a temperature is exchanged with that of the particles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reaction: Option<Reaction>,
    /// Instead of a reaction: a concentration that is taken up and given off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uptake: Option<Uptake>,
    /// Instead of a reaction: liquid that evaporates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaporation: Option<Evaporation>,
}

impl ParticleTransfer {
    /// Amount per volume (1/m³) in particles that are inserted, if they keep some of it.
    pub fn initial(&self) -> Option<f64> {
        self.uptake.map(|uptake| uptake.initial).or(self.evaporation.map(|evaporation| evaporation.initial))
    }
}

/// Checks what is exchanged with a temperature, or with a concentration.
pub(super) fn check(
    transfer: &ParticleTransfer,
    path: &str,
    (is_temperature, fluid, context): (bool, &Fluid, &Context<'_>),
    checker: &mut Checker,
) {
    let mut refuse = |key: &str, message: String| checker.error(&format!("{path}{key}"), message);
    if fluid.coupling.is_none() || !context.has_particles {
        let message = "without effect: no particles smaller than the cells; add [[insert]] and [fluid.coupling], or remove it";
        refuse("", message.into());
    }
    let ways = [
        ("reaction", transfer.reaction.is_some()),
        ("uptake", transfer.uptake.is_some()),
        ("evaporation", transfer.evaporation.is_some()),
    ];
    let stated: Vec<&str> =
        ways.into_iter().filter(|(_, is_stated)| *is_stated).map(|(way, _)| way).collect();
    match (is_temperature, &stated[..]) {
        (true, [way, ..]) => refuse(
            &format!(".{way}"),
            "a temperature neither reacts nor dissolves nor evaporates; state that of a concentration, with its heat".into(),
        ),
        (true, []) if !context.has_heat => {
            refuse("", "particles have no temperature to exchange; add [heat] with their temperature (K)".into());
        }
        (false, []) => refuse(
            "",
            "what becomes of the concentration in particles is not stated; add reaction, uptake or evaporation".into(),
        ),
        (false, [first, second, ..]) => refuse(
            &format!(".{second}"),
            format!("excludes {first}; state what becomes of the concentration once"),
        ),
        (false, [way]) if !context.has_heat => {
            let heat = transfer.reaction.is_some_and(|reaction| reaction.heat != 0.0);
            if heat || transfer.evaporation.is_some() {
                let key = if heat { ".reaction.heat".into() } else { format!(".{way}") };
                refuse(&key, "particles have no temperature; add [heat], or remove it".into());
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steam tables: 0.598 kg/m³ at 100 °C, 0.0510 at 40 °C, 0.0173 at 20 °C.
    #[test]
    fn water_vapour_saturates_as_in_steam_tables() {
        let at = |boiling_point: f64, pressure: f64, latent_heat: f64| Evaporation {
            latent_heat,
            molar_mass: 0.018,
            boiling_point,
            pressure,
            initial: 0.0,
        };
        let (boiling, cool) = (at(373.15, 101_325.0, 2.26e6), at(293.15, 2339.0, 2.45e6));
        for (water, temperature, wanted) in
            [(boiling, 373.15, 0.598), (cool, 293.15, 0.0173), (cool, 313.15, 0.0510)]
        {
            let found = water.saturation(temperature);
            assert!((found / wanted - 1.0).abs() < 0.02, "{temperature} K: {found} kg/m3");
        }
    }
}
