//! `[fluid.coupling]`: how particles and fluid act on each other.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Context;
use crate::check::Checker;

/// A drag law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Drag {
    /// Beetstra et al. (2007).
    Beetstra,
    /// Ergun (1952).
    Ergun,
    /// Wen and Yu (1966).
    WenYu,
    /// Ergun up to a void fraction of 0.8, Wen and Yu beyond.
    Gidaspow,
    /// Di Felice (1994).
    DiFelice,
    /// Schiller and Naumann (1933): a lone sphere.
    SchillerNaumann,
    /// Hölzer and Sommerfeld (2008): any shape, as it lies in the flow.
    HoelzerSommerfeld,
    /// Ganser (1993): any shape, as it lies in the flow.
    Ganser,
}

/// Who carries the pressure gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MixtureModel {
    /// Both phases.
    #[default]
    A,
    /// The fluid alone; drag is divided by the void fraction.
    B,
}

/// How a particle is spread over the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Kernel {
    /// A cube of the particle's volume, cut by the cells: for cells of three diameters and more.
    #[default]
    Cube,
    /// A smooth blob whose width does not depend on the cells.
    Smooth {
        /// Half width (diameters of the sphere of the particle's volume).
        #[serde(default = "usual_half_width")]
        #[schemars(extend("minimum" = 0.5, "maximum" = 20))]
        half_width: f64,
    },
}

/// How particles and fluid act on each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Drag law.
    pub drag: Drag,
    /// Model of the pressure gradient: "A" or "B".
    #[serde(default)]
    pub model: MixtureModel,
    /// Kernel between particles and cells.
    #[serde(default)]
    pub kernel: Kernel,
    /// Void fraction of a cell below which the run ends (-).
    #[serde(default = "least_void_fraction")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub least_void_fraction: f64,
    /// Particle steps per step of the fluid (-), fewer where the Courant number would be passed; as many as it allows if
    /// absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1))]
    pub particle_steps: Option<u64>,
}

/// Smooths like a cell of three diameters: ½ · 3 · √(7/3).
fn usual_half_width() -> f64 {
    2.291_287_847_477_92
}

fn least_void_fraction() -> f64 {
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
