//! How many steps of the particles a step of the fluid takes: as many as its limits allow, never more.

use super::max_dt::max_dt;
use crate::error::RunError;
use grains_case::{Case, Fluid, TimeStep};
use grains_comm::MpiTransport;
use grains_dem::Dem;
use grains_domain::Transport;
use grains_fluid::{Flow, FlowLimits};

/// What a step may be longer than its limit by (-): rounding.
const ROUNDING: f64 = 1e-9;

/// CFL number of scalars that a steady flow carries (-): their advection is explicit.
const CFL_OF_SCALARS: f64 = 0.5;

/// The rule by which spans are chosen.
#[derive(Clone, Debug)]
pub struct SpanRule {
    /// CFL number, explicit diffusion, and the longest step.
    limits: FlowLimits,
    /// Particle steps per step of the fluid, if the case says how many.
    given: Option<u64>,
    /// Longest step that the case asks for by a number (s).
    longest_given: f64,
    /// Longest step (s) in which a steady flow settles.
    pub longest_settling: f64,
    /// CFL number of scalars that a steady flow carries (-).
    cfl_of_scalars: f64,
    /// The key of the CFL number.
    cfl_key: &'static str,
    /// The time step as the case gives it.
    key: String,
    /// Whether the run was told that it does not get the particle steps given.
    is_told: bool,
}

impl SpanRule {
    /// The rule of a case.
    pub fn new(case: &Case, fluid: &Fluid) -> Self {
        let ticks = match case.time.dt {
            TimeStep::Seconds(_) if case.inserts.is_empty() || case.holds_particles() => Some(1),
            _ => None,
        };
        let given = fluid.coupling.as_ref().map_or(ticks, |coupling| coupling.particle_steps);
        let longest_given = fluid.max_dt.unwrap_or(f64::INFINITY);
        let longest = if given.is_some() { longest_given } else { max_dt(case, fluid).step };
        let cfl_key = if fluid.steady.is_some() { "fluid.steady.cfl" } else { "fluid.cfl" };
        let limits =
            FlowLimits { cfl: fluid.largest_cfl(), growth: f64::INFINITY, ..FlowLimits::new(longest) };
        let key = match case.time.dt {
            TimeStep::Seconds(_) => "time.dt".into(),
            TimeStep::Auto => "time.dt = \"auto\"".into(),
        };
        let longest_settling = f64::INFINITY;
        let cfl_of_scalars = CFL_OF_SCALARS.min(limits.cfl);
        Self { limits, given, longest_given, longest_settling, cfl_of_scalars, cfl_key, key, is_told: false }
    }

    /// Keeps to what scalars allow that a steady flow carries.
    pub fn carry_scalars(&mut self) {
        self.limits.cfl = self.cfl_of_scalars;
        self.longest_settling = f64::INFINITY;
    }

    /// Particle steps of the coming step of the fluid: what its limits allow; if the case does not say how many, a fifth more
    /// than the last one at most; in equal parts up to the next event; collective.
    ///
    /// # Errors
    /// A single step of the particles that is too long for the fluid, with the one that would do.
    pub fn choose(
        &mut self,
        (dem, flow): (&Dem, &Flow),
        last: u64,
        event: u64,
        transport: &MpiTransport,
    ) -> Result<u64, RunError> {
        let dt = dem.setup.parameters.dt;
        let stable = self.limits.stable_step(flow, transport);
        // Velocities that are no numbers are for the step to tell of.
        if stable > 0.0 && dt > (1.0 + ROUNDING) * stable.min(self.longest_given) {
            return Err(self.too_long(dem, stable));
        }
        let longest = self.limits.longest.min(self.longest_settling);
        let allowed = ((stable.min(longest) / dt) as u64).max(1);
        let wanted = self.given.unwrap_or_else(|| match flow.state.last_dt > 0.0 {
            true => last + (last / 5).max(1),
            false => u64::MAX,
        });
        let left = event.saturating_sub(dem.step).max(1);
        let parts = |max: u64| left.div_ceil(left.div_ceil(max));
        let mut span = parts(allowed.min(wanted));
        while !self.limits.holds_ahead(flow, span as f64 * dt, transport) {
            if span == 1 {
                return Err(self.too_long(dem, 0.5 * dt));
            }
            span = parts((span / 2).max(1));
        }
        if let Some(given) = self.given.filter(|&given| span < given.min(left) && !self.is_told) {
            self.is_told = true;
            if transport.rank() == 0 {
                log::warn!(
                    "t = {:.6e} s: {given} particle steps (fluid.coupling.particle_steps) would pass \
                     fluid.cfl = {}: the fluid takes {span} now, and as many as that allows from here on",
                    dem.time(),
                    self.limits.cfl
                );
            }
        }
        Ok(span)
    }

    /// Tells that one step of the particles is longer than what the fluid allows (s).
    fn too_long(&self, dem: &Dem, stable: f64) -> RunError {
        let dt = dem.setup.parameters.dt;
        let message = if stable > self.longest_given {
            format!(
                "longer than fluid.max_dt = {:.3e} s; raise that, or take time.dt of at most it",
                self.longest_given
            )
        } else {
            let max = stable.min(self.longest_given);
            format!(
                "longer than the {max:.3e} s that {} = {} allows in the fastest flow, which would be {:.3} in one such step; \
                 take time.dt = {:.1e}, half of it, or raise {}, up to {}",
                self.cfl_key,
                self.limits.cfl,
                self.limits.cfl * dt / max,
                0.5 * max,
                self.cfl_key,
                if self.cfl_key == "fluid.cfl" { 1 } else { 20 }
            )
        };
        RunError::unphysical(format!("t = {:.6e} s: {} is {dt:.3e} s, {message}", dem.time(), self.key))
    }
}
