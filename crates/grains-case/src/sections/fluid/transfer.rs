//! `particles` of `[[fluid.scalar]]`: what particles exchange with a scalar.

use super::{Context, Expression, Fluid, check_formula};
use crate::check::Checker;
use grains_coupling::TransferLaw;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

fn is_false(x: &bool) -> bool {
    !x
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

fn is_one(x: &f64) -> bool {
    *x == 1.0
}

fn one() -> f64 {
    1.0
}

/// A reaction in particles, which are catalysts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// Rate k (1/s of first order, else (1/m³)^(1−n)/s): per volume of the particle k cⁿ of the concentration c inside.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// Order n (-); 1 in particles smaller than the cells.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 0, "maximum" = 5))]
    pub order: f64,
    /// Effective diffusivity in a particle smaller than the cells (m²/s), which hinders the reaction; not if absent. In resolved particles
    /// that of `inside` does.
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
        let pressure = self.pressure * libm::exp(exponent * (1.0 / self.boiling_point - 1.0 / temperature));
        pressure * self.molar_mass / (GAS_CONSTANT * temperature)
    }
}

/// Resolved particles that a scalar diffuses in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inside {
    /// Effective diffusivity of a concentration in the particle (m²/s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-14, 1]))]
    pub diffusivity: Option<f64>,
    /// Partition coefficient K (-): concentration inside over that outside at the surface; 1 if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub partition: Option<f64>,
    /// Thermal conductivity of the particle (W/(m K)).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-3, 500]))]
    pub conductivity: Option<f64>,
    /// Heat capacity of a volume of the particle (J/(m³ K)).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e4, 1e7]))]
    pub volumetric_heat_capacity: Option<f64>,
}

/// What particles exchange with a scalar: smaller than the cells by a law; resolved ones by what holds at their surface, or inside.
/// Resolved particles of which nothing is stated are insulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticleTransfer {
    /// Law of the Nusselt or Sherwood number of particles smaller than the cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<TransferLaw>,
    /// Value on the surface of resolved particles (K, mol/m³), a number or a formula in x, y, z, t. With `inside` it is that of all
    /// fluid too: there is no film.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<Expression>,
    /// Flux from resolved particles into the fluid (W/m², mol/(m² s)), a number or a formula in x, y, z, t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flux: Option<Expression>,
    /// Whether each resolved particle has one temperature, that of `[heat]`.
    #[serde(default, skip_serializing_if = "is_false")]
    pub uniform: bool,
    /// Diffusion inside resolved particles, which do not move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<Inside>,
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
    if !context.has_particles {
        let message = "without effect: there are no particles; add [[insert]], or remove it";
        return checker.error(path, message.into());
    }
    if fluid.resolved.is_some() {
        return check_resolved(transfer, path, (is_temperature, context), checker);
    }
    let mut refuse = |key: &str, message: String| checker.error(&format!("{path}{key}"), message);
    if fluid.coupling.is_none() {
        let message =
            "without effect: the fluid does not see the particles; add [fluid.coupling] or [fluid.resolved]";
        return refuse("", message.into());
    }
    let of_resolved = [
        ("value", transfer.value.is_some()),
        ("flux", transfer.flux.is_some()),
        ("uniform", transfer.uniform),
        ("inside", transfer.inside.is_some()),
    ];
    if let Some((key, _)) = of_resolved.iter().find(|(_, is_stated)| *is_stated) {
        let message = "only for particles that the cells resolve; state a `law` for those smaller, or take [fluid.resolved]";
        return refuse(&format!(".{key}"), message.into());
    }
    if transfer.law.is_none() {
        return refuse(
            ".law",
            "missing: how particles smaller than the cells exchange; \"gunn\" suits beds".into(),
        );
    }
    if transfer.reaction.is_some_and(|reaction| reaction.order != 1.0) {
        let message =
            "particles smaller than the cells react in first order only; take 1, or [fluid.resolved]";
        return refuse(".reaction.order", message.into());
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

/// Checks what holds on resolved particles, or in them.
fn check_resolved(
    transfer: &ParticleTransfer,
    path: &str,
    (is_temperature, context): (bool, &Context<'_>),
    checker: &mut Checker,
) {
    for (key, value) in [("value", &transfer.value), ("flux", &transfer.flux)] {
        if let Some(value) = value {
            check_formula(value, &format!("{path}.{key}"), context.domain, checker);
        }
    }
    let mut refuse = |key: &str, message: &str| checker.error(&format!("{path}{key}"), message.into());
    let of_smaller = [
        ("law", transfer.law.is_some()),
        ("uptake", transfer.uptake.is_some()),
        ("evaporation", transfer.evaporation.is_some()),
    ];
    if let Some((key, _)) = of_smaller.iter().find(|(_, is_stated)| *is_stated) {
        let message = "only for particles smaller than the cells; the flow about resolved ones needs no law: state value, flux, \
                       uniform or inside";
        return refuse(&format!(".{key}"), message);
    }
    let ways = [
        ("value", transfer.value.is_some()),
        ("flux", transfer.flux.is_some()),
        ("uniform", transfer.uniform),
        ("inside", transfer.inside.is_some()),
    ];
    let stated: Vec<&str> =
        ways.into_iter().filter(|(_, is_stated)| *is_stated).map(|(way, _)| way).collect();
    if let (["value", "inside"], Some(Expression::Formula(_))) = (&stated[..], &transfer.value) {
        return refuse(".value", "with `inside` a number, which all surfaces have; write one, or remove it");
    }
    if let [first, second, ..] = stated[..]
        && stated != ["value", "inside"]
    {
        let message = format!("excludes {first}; state what holds on the particles once");
        return refuse(&format!(".{second}"), &message);
    }
    if stated.is_empty() && transfer.reaction.is_none() {
        return refuse(
            "",
            "states nothing; add value, flux, uniform or inside, or remove it: particles then are insulated",
        );
    }
    if transfer.uniform && !is_temperature {
        return refuse(
            ".uniform",
            "only temperatures are kept by particles; state value, flux or inside for a concentration",
        );
    }
    if transfer.uniform && !context.has_heat {
        return refuse(".uniform", "particles have no temperature; add [heat] with that at the start (K)");
    }
    let is_still = context.particles_are_fixed;
    if (transfer.flux.is_some() || transfer.inside.is_some()) && !is_still {
        let key = if transfer.flux.is_some() { ".flux" } else { ".inside" };
        return refuse(
            key,
            "only for particles that stay where they are; take motion = \"fixed\", or state value or uniform",
        );
    }
    if let Some(inside) = &transfer.inside {
        let of_heat = [
            ("conductivity", inside.conductivity.is_some()),
            ("volumetric_heat_capacity", inside.volumetric_heat_capacity.is_some()),
        ];
        let of_mass =
            [("diffusivity", inside.diffusivity.is_some()), ("partition", inside.partition.is_some())];
        let (needed, others) =
            if is_temperature { (&of_heat[..], &of_mass[..]) } else { (&of_mass[..1], &of_heat[..]) };
        if let Some((key, _)) = needed.iter().find(|(_, is_stated)| !is_stated) {
            let what = if is_temperature { "a temperature" } else { "a concentration" };
            return refuse(
                &format!(".inside.{key}"),
                &format!("missing: {what} diffuses inside by it; state it"),
            );
        }
        if let Some((key, _)) = others.iter().find(|(_, is_stated)| *is_stated) {
            let of = if is_temperature { "concentrations" } else { "temperatures" };
            return refuse(&format!(".inside.{key}"), &format!("only for {of}; remove it"));
        }
    }
    let Some(reaction) = &transfer.reaction else { return };
    if is_temperature {
        return refuse(".reaction", "a temperature does not react; state that of a concentration");
    }
    if transfer.inside.is_none() {
        return refuse(
            ".reaction",
            "reacts inside particles; state how it comes there: inside = { diffusivity = ... }",
        );
    }
    if reaction.diffusivity.is_some() {
        return refuse(
            ".reaction.diffusivity",
            "of resolved particles it is inside.diffusivity; move it there",
        );
    }
    if reaction.heat != 0.0 {
        refuse(".reaction.heat", "resolved particles take no heat of reactions yet; remove it");
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
