//! `[fluid.coupling]`: how particles and fluid act on each other.

use grains_coupling::{DragLaw, Kernel};
use grains_fluid::MixtureModel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Context;
use crate::check::Checker;

/// How particles and fluid act on each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Drag law.
    pub drag: DragLaw,
    /// Model of the pressure gradient: "A" or "B".
    #[serde(default)]
    pub model: MixtureModel,
    /// Kernel between particles and cells.
    #[serde(default)]
    pub kernel: Kernel,
    /// Void fraction of a cell below which the run ends (-).
    #[serde(default = "min_void_fraction")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub min_void_fraction: f64,
    /// Particle steps per step of the fluid (-), fewer where the Courant number would be passed; as many as it allows if
    /// absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1))]
    pub particle_steps: Option<u64>,
}

fn min_void_fraction() -> f64 {
    0.2
}

/// Particles need a coupling, and a coupling needs particles with soft collisions.
pub(super) fn check(coupling: Option<&Coupling>, context: &Context<'_>, checker: &mut Checker) {
    match (coupling, context.has_particles) {
        (None, true) => checker.error(
            "fluid.coupling",
            "missing table: there are particles in the fluid; add [fluid.coupling] with drag = \"beetstra\" or \
             another law if they are smaller than the cells, or [fluid.resolved] if the cells resolve them"
                .into(),
        ),
        (Some(_), false) => checker
            .warn("fluid.coupling", "without effect: there are no particles; add [[insert]] or remove it".into()),
        (Some(_), true) if context.is_hard => checker.error(
            "collisions.model",
            "drag acts in soft collisions only; take \"soft\", or remove [fluid]".into(),
        ),
        _ => {}
    }
}
