//! `viscosity`, `rheology` and `turbulence` of `[fluid]`: what makes the viscosity, and what they cannot be combined with.

use super::resolved::Method;
use super::{Context, Fluid};
use crate::check::Checker;
use grains_fluid::{BadValue, Diffusion, Turbulence};
use grains_resolved::Extrapolation;

impl Fluid {
    /// Largest dynamic viscosity (Pa s) at small rates: that of fluid that has not yielded.
    pub fn viscosity_at_rest(&self) -> f64 {
        let at_rest = self.rheology.map_or(0.0, |rheology| rheology.viscosity_at_rest());
        self.viscosity.max(at_rest)
    }
}

/// Checks the laws, and gives a fluid with a rheology the viscosity at a rate of 1/s without the yield stress.
pub(super) fn check(fluid: &mut Fluid, context: &Context<'_>, checker: &mut Checker) {
    let mut out_of_range = |law: &str, found: Result<(), BadValue>| {
        if let Err((key, value, range)) = found {
            checker.error(&format!("fluid.{law}.{key}"), format!("{value}: must be {range}"));
        }
    };
    fluid.rheology.iter().for_each(|rheology| out_of_range("rheology", rheology.check()));
    fluid.turbulence.iter().for_each(|turbulence| out_of_range("turbulence", turbulence.check()));
    match (&fluid.rheology, fluid.viscosity > 0.0) {
        (None, false) => {
            checker.error("fluid", "without a viscosity; add `viscosity`, or `rheology`".into());
        }
        // That of a resolved case is the one given below.
        (Some(rheology), true) if fluid.viscosity != rheology.reference_viscosity() => {
            let message = "the viscosity is that of fluid.rheology; remove one of them";
            checker.error("fluid.viscosity", message.into());
        }
        (Some(rheology), _) => fluid.viscosity = rheology.reference_viscosity(),
        (None, true) => {}
    }
    let law = match (&fluid.rheology, &fluid.turbulence) {
        (Some(_), Some(_)) => {
            let message =
                "models of eddies are those of Newtonian fluids; remove fluid.turbulence or fluid.rheology";
            return checker.error("fluid.turbulence", message.into());
        }
        (Some(_), None) => "fluid.rheology",
        (None, Some(_)) => "fluid.turbulence",
        (None, None) => return,
    };
    if fluid.diffusion == Diffusion::Explicit {
        let message = format!("the viscosity of {law} is treated implicitly only; take \"implicit\"");
        checker.error("fluid.diffusion", message);
    }
    if context.has_walls && fluid.coupling.is_some() {
        let message = "walls in a flow averaged over particles know a constant viscosity only; remove it, or the `fluid` of the walls";
        checker.error(law, message.into());
    }
    if fluid.rheology.is_some() {
        // Where nothing yields, forces along cubics would settle in very short steps only.
        if let Some(resolved) = fluid.resolved.as_mut().filter(|resolved| resolved.method == Method::Direct) {
            resolved.extrapolation.get_or_insert(Extrapolation::Quadratic);
        }
        if fluid.coupling.is_some() && context.has_particles {
            let message = "drag laws are those of Newtonian fluids; give a viscosity, or resolve the particles by \
                           [fluid.resolved]";
            checker.error(law, message.into());
        }
        if fluid.resolved.as_ref().is_some_and(|resolved| resolved.lubrication.is_some()) {
            let message = "films are those of Newtonian fluids; remove it, or give a viscosity";
            checker.error("fluid.resolved.lubrication", message.into());
        }
    }
    if fluid.turbulence.is_some() && fluid.cells.contains(&1) {
        checker
            .error(law, "eddies are three-dimensional; give every axis several cells, or remove it".into());
    }
    if matches!(fluid.turbulence, Some(Turbulence::Smagorinsky(_))) && fluid.resolved.is_some() {
        let message = "this model looks for walls on the faces of the domain only, not for particles and walls in the flow; take \"wale\"";
        checker.error(law, message.into());
    }
}
