//! How a yield stress is made a finite viscosity.

use super::{BadValue, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What replaces the infinite viscosity of unyielded fluid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Regularisation {
    /// Stresses that do not vanish at rest times 1 − exp(−m γ̇) (Papanastasiou 1987).
    Papanastasiou {
        /// Exponent m (s).
        #[schemars(extend("exclusiveMinimum" = 0))]
        exponent: f64,
    },
    /// The viscosity is cut off (O'Donovan and Tanner 1984).
    BiViscosity {
        /// Largest viscosity (Pa s).
        #[schemars(extend("exclusiveMinimum" = 0))]
        max_viscosity: f64,
    },
}

impl Regularisation {
    pub(super) fn check(&self) -> Result<(), BadValue> {
        match *self {
            Self::Papanastasiou { exponent } => positive("regularisation.exponent", exponent),
            Self::BiViscosity { max_viscosity } => positive("regularisation.max_viscosity", max_viscosity),
        }
    }

    /// μ (Pa s) at a rate γ̇ (1/s) of a stress τ(γ̇) (Pa) that does not vanish at rest, on top of a viscosity that is finite.
    #[inline(always)]
    pub(super) fn viscosity(&self, rate: f64, stress: f64, finite: f64) -> f64 {
        match *self {
            Self::Papanastasiou { exponent } => {
                // (1 − exp(−x))/x with x = m γ̇, whole also where x is of the size of rounding.
                let x = exponent * rate;
                let share = if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
                finite + exponent * stress * share
            }
            Self::BiViscosity { max_viscosity } => {
                // Without a division by 0.
                let sum = finite * rate + stress;
                if sum < max_viscosity * rate { sum / rate } else { max_viscosity }
            }
        }
    }
}
