//! A fluid that thins or thickens with the rate of shear.

use super::{BadValue, RheologyLaw, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// τ = K γ̇ⁿ; of thinning fluids the viscosity is cut off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerLaw {
    /// Consistency K (Pa sⁿ).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub consistency: f64,
    /// Index n (-): below 1 the fluid thins, above it thickens.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 4))]
    pub index: f64,
    /// Largest viscosity (Pa s); needed of thinning fluids, whose viscosity at rest is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_viscosity: Option<f64>,
}

impl RheologyLaw for PowerLaw {
    fn viscosity(&self, rate: f64) -> f64 {
        let viscosity = self.consistency * rate.powf(self.index - 1.0);
        self.max_viscosity.map_or(viscosity, |max| viscosity.min(max))
    }

    fn viscosity_at_rest(&self) -> f64 {
        self.viscosity(0.0)
    }

    fn smallest_viscosity(&self) -> f64 {
        if self.index == 1.0 { self.viscosity(1.0) } else { 0.0 }
    }

    fn reference_viscosity(&self) -> f64 {
        self.consistency
    }

    fn yield_stress(&self) -> f64 {
        0.0
    }

    fn check(&self) -> Result<(), BadValue> {
        positive("consistency", self.consistency)?;
        positive("index", self.index)?;
        match self.max_viscosity {
            Some(max) => positive("max_viscosity", max),
            None if self.index < 1.0 => {
                Err(("max_viscosity", f64::INFINITY, "given of a fluid that thins (index below 1)"))
            }
            None => Ok(()),
        }
    }
}
