//! `[time]`: duration and time step.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;

/// How the time step is set.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// From the shortest contact: T_c / `steps_per_contact`; for hard collisions a step in which bodies at
    /// `impact_speed` go 2 % of the smallest radius. Without particles from the Courant number of the fluid.
    Auto,
    /// Fixed (s).
    #[serde(untagged)]
    Seconds(#[schemars(extend("exclusiveMinimum" = 0))] f64),
}

/// Duration of the run and its time step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// Simulated time at which the run ends (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end: f64,
    /// Time step (s), or "auto" for the step recommended by the shortest contact time; for a fluid alone by its Courant number.
    #[serde(default = "automatic")]
    pub dt: TimeStep,
    /// Steps per contact duration T_c/dt (-) that "auto" aims at.
    #[serde(default = "twenty")]
    #[schemars(extend("minimum" = 10, "x-plausible" = [10, 200]))]
    pub steps_per_contact: f64,
    /// Lets a run start with T_c/dt below 5, which is refused otherwise.
    #[serde(default)]
    pub accept_coarse_dt: bool,
    /// Largest impact speed expected (m/s); overlaps are estimated with it.
    #[serde(default = "super::one")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-6, 1000]))]
    pub impact_speed: f64,
}

fn automatic() -> TimeStep {
    TimeStep::Auto
}

fn twenty() -> f64 {
    20.0
}

impl Time {
    pub(crate) fn check(&self, checker: &mut Checker) {
        if let TimeStep::Seconds(dt) = self.dt
            && dt > self.end
        {
            checker.error(
                "time.dt",
                format!("longer than the whole run ({} s); take \"auto\" or a smaller step", self.end),
            );
        }
    }
}
