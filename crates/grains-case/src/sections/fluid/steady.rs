//! `[fluid] steady`: the steady flow past what does not move, by pseudo-steps.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BoundaryKind, Fluid, ResolvedMethod};
use crate::check::Checker;
use crate::sections::fluid::Context;
use crate::sections::insert::Insert;
use grains_fluid::Diffusion;

/// How the steady flow is found; time then is pseudo-time, and the run ends when the flow has settled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Steady {
    /// What forces, pressure drop, or flow rate under a given gradient may still change by, over themselves (-).
    #[serde(default = "usual_tolerance")]
    #[schemars(extend("minimum" = 1e-9, "maximum" = 0.1))]
    pub tolerance: f64,
    /// Number of steps that are combined (-); each takes some 32 bytes a cell.
    #[serde(default = "usual_history")]
    #[schemars(extend("minimum" = 1, "maximum" = 20))]
    pub history: u64,
    /// Largest Courant number of a pseudo-step (-), in which advection is implicit.
    #[serde(default = "usual_cfl")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 20))]
    pub cfl: f64,
}

fn usual_tolerance() -> f64 {
    1e-4
}

fn usual_history() -> u64 {
    3
}

fn usual_cfl() -> f64 {
    3.0
}

/// A steady flow needs all that bounds it to stay as it is.
pub(super) fn check(fluid: &Fluid, context: &Context<'_>, inserts: &[Insert], checker: &mut Checker) {
    if fluid.steady.is_none() {
        return;
    }
    let mut refuse = |message: &str| checker.error("fluid.steady", message.into());
    if fluid.coupling.is_some() {
        refuse("flows averaged over particles are marched in time only; remove it, or take [fluid.resolved]");
    } else if context.has_particles && !inserts.iter().all(Insert::is_fixed) {
        refuse("particles move, so that no flow past them is steady; remove it, or take motion = \"fixed\"");
    }
    if context.has_particles && context.has_heat {
        refuse(
            "particles change their temperatures in time, so that nothing is steady; remove it, or [heat], and state a value or flux of the \
             particles",
        );
    }
    if context.walls_move {
        refuse("walls of the fluid move, so that no flow is steady; remove it, or the motion of the walls");
    }
    if fluid.resolved.as_ref().is_some_and(|resolved| resolved.method == ResolvedMethod::Multiplier) {
        refuse("multipliers are marched in time only; take fluid.resolved.method = \"direct\"");
    }
    if fluid.rheology.is_some() || fluid.turbulence.is_some() {
        refuse(
            "pseudo-steps know a constant viscosity only; remove it, or fluid.rheology and fluid.turbulence",
        );
    }
    if fluid.diffusion == Diffusion::Explicit {
        refuse("pseudo-steps are too long for explicit diffusion; take fluid.diffusion = \"implicit\"");
    }
    let is_unsteady = fluid.boundary.iter().any(|boundary| match &boundary.kind {
        BoundaryKind::Inlet { velocity } => {
            velocity.iter().any(|v| v.compile().is_ok_and(|formula| formula.is_unsteady()))
        }
        kind => kind.flow(1.0).is_some_and(|(flow, _)| flow.compile().is_ok_and(|f| f.is_unsteady())),
    });
    if is_unsteady {
        refuse("the velocity or flow of an inlet changes with t; write it without t, or remove fluid.steady");
    }
    let has_fan = |kind: &BoundaryKind| matches!(kind, BoundaryKind::PressureInlet { fan: Some(_), .. });
    if fluid.boundary.iter().any(|boundary| has_fan(&boundary.kind)) {
        refuse(
            "pseudo-steps do not follow the curve of a fan; state a pressure or a flow, or remove fluid.steady",
        );
    }
    if fluid.output.mean_from.is_some() {
        refuse("means over pseudo-time mean nothing; remove fluid.output.mean_from");
    }
}
