//! What takes how long in the fluid of a run.

use super::FluidPhase;
use grains_fluid::Phase;

/// Seconds spent on this rank.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    /// In steps of the fluid.
    pub flow: f64,
    /// With the exchange with particles, and with bodies and walls in the fluid.
    pub exchange: f64,
    /// With the loads on particles, in each of their own steps.
    pub loads: f64,
    /// With the choice of the fluid's time step.
    pub choice: f64,
}

impl FluidPhase {
    /// Names of the parts of a step and the seconds spent in them.
    pub fn times(&self) -> Vec<(String, f64)> {
        let names =
            ["momentum", "diffusion", "divergence", "pressure", "correction", "boundaries", "scalars"];
        let seconds = Phase::ALL.map(|phase| self.flow.clock.seconds(phase));
        let of_flow = names.map(|name| ["fluid ", name].concat()).into_iter().zip(seconds);
        let Seconds { exchange, loads, choice, .. } = self.seconds;
        let others =
            [("fluid time step", choice), ("fluid and particles", exchange), ("loads by the fluid", loads)];
        of_flow.chain(others.map(|(name, seconds)| (name.to_string(), seconds))).collect()
    }
}
