//! A fluid that is rigid below a stress and thins or thickens with the rate of shear beyond it.

use super::{BadValue, Regularisation, RheologyLaw, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// τ = τ_y + K γ̇ⁿ above the yield stress (Herschel and Bulkley 1926).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HerschelBulkley {
    /// Yield stress τ_y (Pa).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub yield_stress: f64,
    /// Consistency K (Pa sⁿ).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub consistency: f64,
    /// Index n (-).
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 4))]
    pub index: f64,
    /// What replaces the infinite viscosity of unyielded fluid; of thinning fluids it holds for all of the stress.
    pub regularisation: Regularisation,
}

impl RheologyLaw for HerschelBulkley {
    fn viscosity(&self, rate: f64) -> f64 {
        if self.index < 1.0 {
            let stress = self.yield_stress + self.consistency * rate.powf(self.index);
            self.regularisation.viscosity(rate, stress, 0.0)
        } else {
            let finite = self.consistency * rate.powf(self.index - 1.0);
            self.regularisation.viscosity(rate, self.yield_stress, finite)
        }
    }

    fn viscosity_at_rest(&self) -> f64 {
        match self.regularisation {
            Regularisation::BiViscosity { max_viscosity } => max_viscosity,
            // Of n < 1 the largest of x^(n − 1) (1 − exp(−x)) is below 1.
            Regularisation::Papanastasiou { exponent } if self.index < 1.0 => {
                exponent * self.yield_stress + self.consistency * exponent.powf(1.0 - self.index)
            }
            Regularisation::Papanastasiou { .. } => self.viscosity(0.0),
        }
    }

    fn smallest_viscosity(&self) -> f64 {
        if self.index == 1.0 { self.consistency } else { 0.0 }
    }

    fn reference_viscosity(&self) -> f64 {
        self.consistency
    }

    fn yield_stress(&self) -> f64 {
        self.yield_stress
    }

    fn check(&self) -> Result<(), BadValue> {
        positive("yield_stress", self.yield_stress)?;
        positive("consistency", self.consistency)?;
        positive("index", self.index)?;
        self.regularisation.check()
    }
}
