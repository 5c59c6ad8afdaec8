//! Heat that flows into a particle in a step.

use super::Thermal;
use crate::particles::Particles;

/// Heat that flows into a particle through contacts and gaps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HeatFlow {
    /// Sum of the flows (W), exact.
    pub(crate) power: f64,
    /// Sum of the conductances (W/K).
    pub(crate) conductance: f64,
}

impl HeatFlow {
    #[inline(always)]
    fn add(&mut self, power: f64, conductance: f64) {
        self.power += power;
        self.conductance += conductance;
    }
}

/// Lets heat flow between two particles, of which at least one is owned, through a conductance (W/K).
///
/// It is antisymmetric in the two, operation by operation.
#[inline(always)]
pub(super) fn between(particles: &mut Particles, [i, j]: [usize; 2], conductance: f64, thermal: &Thermal) {
    let [own, other] = [i, j].map(|k| particles.temperatures[k]);
    let power = thermal.quantum.round(conductance * (other - own));
    if let Some(flow) = particles.heat_flows.get_mut(i) {
        flow.add(power, conductance);
    }
    if let Some(flow) = particles.heat_flows.get_mut(j) {
        flow.add(-power, conductance);
    }
}

/// Lets heat flow from a wall of a temperature (K) into an owned particle; returns it (W).
#[inline(always)]
pub(super) fn from_wall(
    particles: &mut Particles,
    i: usize,
    (temperature, conductance): (f64, f64),
    thermal: &Thermal,
) -> f64 {
    let power = thermal.quantum.round(conductance * (temperature - particles.temperatures[i]));
    particles.heat_flows[i].add(power, conductance);
    power
}
