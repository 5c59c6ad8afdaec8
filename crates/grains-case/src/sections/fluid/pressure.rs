//! `[fluid.pressure]`: the solver of the pressure.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Fluid;
use crate::check::Checker;
use crate::sections::domain::{Domain, Face};

/// How the pressure equation is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PressureMethod {
    /// Fast transforms where the coefficients are constant, else conjugate gradients with multigrid.
    #[default]
    Auto,
    /// Fast transforms alone: one phase, and no face that is an outlet in part.
    Fast,
    /// Conjugate gradients with multigrid, of the program itself.
    ConjugateGradients,
    /// A preconditioned Krylov method of PETSc.
    Petsc,
}

/// The solver of the pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// Method: "auto", "fast", "conjugate_gradients" or "petsc".
    #[serde(default)]
    pub method: PressureMethod,
    /// Norm of the residual over that of the right-hand side at which an iterative solver stops (-).
    #[serde(default = "small")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.1, "x-plausible" = [1e-14, 1e-3]))]
    pub tolerance: f64,
    /// Iterations after which a solve has failed (-).
    #[serde(default = "many")]
    #[schemars(extend("minimum" = 1))]
    pub iterations: u64,
    /// Options for PETSc, as on its command line: "-ksp_type bcgs".
    #[serde(default)]
    pub options: String,
}

impl Default for Pressure {
    fn default() -> Self {
        Self { method: PressureMethod::Auto, tolerance: small(), iterations: many(), options: String::new() }
    }
}

fn small() -> f64 {
    1e-8
}

fn many() -> u64 {
    500
}

/// Refuses a method that cannot solve what the case asks for.
pub(super) fn check(fluid: &Fluid, domain: &Domain, checker: &mut Checker) {
    let Pressure { method, options, .. } = &fluid.pressure;
    if !options.trim().is_empty()
        && matches!(method, PressureMethod::Fast | PressureMethod::ConjugateGradients)
    {
        checker.warn(
            "fluid.pressure.options",
            "without effect: only PETSc reads options; take method = \"petsc\"".into(),
        );
    }
    if *method != PressureMethod::Fast {
        return;
    }
    let key = "fluid.pressure.method";
    if fluid.coupling.is_some() {
        checker.error(
            key,
            "fast transforms need constant coefficients, and among particles they vary; take \"auto\" or \"petsc\""
                .into(),
        );
    } else if let Some(face) = domain.open_faces().find(|face| is_outlet_in_part(fluid, *face)) {
        checker.error(
            key,
            format!(
                "fast transforms need faces that are outlets all over or not at all, {} is one in part; take \
                 \"auto\" or \"petsc\"",
                face.name()
            ),
        );
    }
}

fn is_outlet_in_part(fluid: &Fluid, face: Face) -> bool {
    let on_face = fluid.on_face(face);
    let is_outlet = |i: usize| fluid.boundary[i].kind.imposes_pressure();
    let is_whole = on_face.whole.is_some_and(is_outlet);
    on_face.patches.iter().any(|i| is_outlet(*i) != is_whole)
}
