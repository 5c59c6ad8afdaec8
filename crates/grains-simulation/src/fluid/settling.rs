//! A run that looks for a steady flow: the scalars that settle once it is found, and what it says of both.

use super::FluidPhase;
use super::steady::Steady;
use crate::error::{RunError, agreed};
use grains_comm::MpiTransport;
use grains_dem::Dem;

impl FluidPhase {
    /// Frees what no step needs any more when there are no further ones.
    pub fn forget_steps(&mut self) {
        self.steady.iter_mut().for_each(Steady::forget_steps);
    }

    /// Whether a steady flow is looked for and found.
    pub fn is_settled(&self) -> bool {
        self.steady.as_ref().is_some_and(Steady::is_settled)
    }

    /// What is still unsettled of a steady flow that is looked for, and the steps so far.
    pub fn told_of_steady(&self) -> Option<String> {
        let steady = self.steady.as_ref()?;
        let [force, gradient, velocity] = steady.unsettled;
        let scalars = steady.unsettled_scalars.map_or(String::new(), |x| format!(", scalars to {x:.1e}"));
        let how = if steady.is_settled() { "settled" } else { "not settled" };
        let remedy = if steady.is_settled() { "" } else { "; raise time.end or fluid.steady.tolerance" };
        Some(format!(
            "steady flow {how} after {} steps: forces to {force:.1e}, gradients to {gradient:.1e}, mean velocities to \
             {velocity:.1e}{scalars}{remedy}",
            self.flow.state.step
        ))
    }

    /// Carries the scalars alone by a steady flow that was found.
    pub(super) fn step_scalars(
        &mut self,
        dem: &mut Dem,
        dt: f64,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let begun = std::time::Instant::now();
        let failed =
            |e: grains_fluid::StepError| RunError::unphysical(format!("t = {:.6e} s: {e}", dem.time()));
        if self.steady.as_ref().is_some_and(Steady::has_no_step_of_scalars) {
            let paced = self.flow.settle_scalars_from(dt, transport);
            agreed(transport, paced.map_err(failed))?;
        }
        let outcome = self.flow.step_scalars(dt, transport);
        agreed(transport, outcome.map_err(failed))?;
        if let Some(resolved) = &mut self.resolved {
            resolved.after_scalars(dem, &mut self.flow, dt, transport);
        }
        if let Some(steady) = &mut self.steady {
            steady.end_of_scalars(&self.flow, dt, transport);
        }
        self.report.dt = dt;
        self.seconds.flow += begun.elapsed().as_secs_f64();
        self.steps += 1;
        Ok(())
    }
}
