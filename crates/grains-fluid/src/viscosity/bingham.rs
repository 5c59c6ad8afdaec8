//! A fluid that is rigid below a stress and Newtonian beyond it.

use super::{BadValue, Regularisation, RheologyLaw, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// τ = τ_y + μ_p γ̇ above the yield stress (Bingham 1922).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bingham {
    /// Yield stress τ_y (Pa).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub yield_stress: f64,
    /// Plastic viscosity μ_p (Pa s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub plastic_viscosity: f64,
    /// What replaces the infinite viscosity of unyielded fluid.
    pub regularisation: Regularisation,
}

impl RheologyLaw for Bingham {
    fn viscosity(&self, rate: f64) -> f64 {
        self.regularisation.viscosity(rate, self.yield_stress, self.plastic_viscosity)
    }

    fn viscosity_at_rest(&self) -> f64 {
        self.viscosity(0.0)
    }

    fn smallest_viscosity(&self) -> f64 {
        self.plastic_viscosity
    }

    fn reference_viscosity(&self) -> f64 {
        self.plastic_viscosity
    }

    fn yield_stress(&self) -> f64 {
        self.yield_stress
    }

    fn check(&self) -> Result<(), BadValue> {
        positive("yield_stress", self.yield_stress)?;
        positive("plastic_viscosity", self.plastic_viscosity)?;
        self.regularisation.check()?;
        match self.regularisation {
            Regularisation::BiViscosity { max_viscosity } if max_viscosity <= self.plastic_viscosity => {
                Err(("regularisation.max_viscosity", max_viscosity, "above the plastic viscosity"))
            }
            _ => Ok(()),
        }
    }
}
