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
#[schemars(rename = "Time")]
pub struct RawTime {
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
    /// Largest impact speed expected (m/s); overlaps are estimated with it. By default √(v² + 2 g h) with the
    /// insertion's speed v and its height h above the bottom of the domain, or the speed of a wall; 1 m/s in a fluid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-6, 1000]))]
    pub impact_speed: Option<f64>,
}

/// Duration of the run and its time step, with every default filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct Time {
    /// Simulated time at which the run ends (s).
    pub end: f64,
    /// Time step (s), or how it is chosen.
    pub dt: TimeStep,
    /// Steps per contact duration T_c/dt (-) that "auto" aims at.
    pub steps_per_contact: f64,
    /// Whether a run may start with T_c/dt below 5.
    pub accept_coarse_dt: bool,
    /// Largest impact speed expected (m/s).
    pub impact_speed: f64,
}

fn automatic() -> TimeStep {
    TimeStep::Auto
}

fn twenty() -> f64 {
    20.0
}

impl Time {
    /// The section as it would be written with every default spelt out.
    pub(crate) fn to_raw(&self) -> RawTime {
        RawTime {
            end: self.end,
            dt: self.dt,
            steps_per_contact: self.steps_per_contact,
            accept_coarse_dt: self.accept_coarse_dt,
            impact_speed: Some(self.impact_speed),
        }
    }
}

impl RawTime {
    /// Fills in an impact speed (m/s) that is not given.
    pub(crate) fn check(self, fastest_impact: f64, checker: &mut Checker) -> Time {
        if let TimeStep::Seconds(dt) = self.dt
            && dt > self.end
        {
            checker.error(
                "time.dt",
                format!("longer than the whole run ({} s); take \"auto\" or a smaller step", self.end),
            );
        }
        Time {
            end: self.end,
            dt: self.dt,
            steps_per_contact: self.steps_per_contact,
            accept_coarse_dt: self.accept_coarse_dt,
            impact_speed: self.impact_speed.unwrap_or(fastest_impact),
        }
    }
}
