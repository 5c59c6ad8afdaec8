//! `[fluid.resolved]`: particles that the grid resolves.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Context, Fluid};
use crate::check::Checker;

/// What particles do in the flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// They move with the flow and collide.
    #[default]
    Free,
    /// They stay where they are inserted.
    Fixed,
}

/// How velocities just inside a particle follow those in the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Extrapolation {
    /// By a parabola through the surface: second order.
    #[default]
    Quadratic,
    /// By a straight line through the surface.
    Linear,
    /// Not at all: they are those of the particle.
    Rigid,
}

/// Particles whose surfaces the grid resolves: no drag law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resolved {
    /// "free" or "fixed".
    #[serde(default)]
    pub motion: Motion,
    /// How velocities just inside a particle follow those in the fluid.
    #[serde(default)]
    pub extrapolation: Extrapolation,
    /// Share of the particles' last force on the fluid in its momentum equation (-).
    #[serde(default = "crate::sections::one")]
    #[schemars(extend("minimum" = 0, "maximum" = 1))]
    pub explicit_forcing: f64,
    /// Largest ν Δt/Δx² of a step of the fluid (-).
    #[serde(default = "crate::sections::one")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 100))]
    pub diffusion_number: f64,
}

/// Particles need cells of one width, and collisions that are soft.
pub(super) fn check(fluid: &Fluid, context: &Context<'_>, checker: &mut Checker) {
    if fluid.resolved.is_none() {
        return;
    }
    let key = "fluid.resolved";
    if fluid.coupling.is_some() {
        let message = "particles are either resolved or coupled by a drag law; remove [fluid.resolved] or [fluid.coupling]";
        checker.error(key, message.into());
    }
    if !context.has_particles {
        checker.warn(key, "without effect: there are no particles; add [[insert]] or remove it".into());
    }
    if context.is_hard {
        checker.error("collisions.model", "resolved particles collide softly only; take \"soft\"".into());
    }
    if fluid.refinement.iter().any(|&r| r > 0.0) {
        let message =
            "particles can be resolved on equal cells only; set it to 0, or remove [fluid.resolved]";
        checker.error("fluid.refinement", message.into());
    }
}
