//! Eddies as long as a share of the cells.

use super::{BadValue, TurbulenceModel, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Constant of von Kármán (-).
const KARMAN: f64 = 0.41;

/// ν_t = ℓ² √(2 D:D), ℓ = min(C Δ, κ d), Δ³ the volume of the cell, d the distance from the closest wall without slip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Smagorinsky {
    /// C (-): 0.17 for isotropic turbulence (Lilly 1967), 0.1 for channels (Deardorff 1970).
    #[serde(default = "usual")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub constant: f64,
}

fn usual() -> f64 {
    0.1
}

impl TurbulenceModel for Smagorinsky {
    fn eddy_viscosity(&self, gradient: &[[f64; 3]; 3], width: f64, distance: f64) -> f64 {
        let pairs = (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
        let square: f64 = pairs.map(|(a, b)| 0.5 * (gradient[a][b] + gradient[b][a]).powi(2)).sum();
        (self.constant * width).min(KARMAN * distance).powi(2) * square.sqrt()
    }

    fn check(&self) -> Result<(), BadValue> {
        positive("constant", self.constant)
    }
}
