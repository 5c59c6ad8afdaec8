//! The wall-adapting local eddy viscosity.

use super::{BadValue, TurbulenceModel, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ν_t = (C Δ)² (S:S)^{3/2}/((D:D)^{5/2} + (S:S)^{5/4}), S the traceless symmetric part of (∇u)² (Nicoud and Ducros 1999, eq. 13).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wale {
    /// C (-): 0.325 for flows along walls, 0.5 by isotropic turbulence.
    #[serde(default = "usual")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub constant: f64,
}

fn usual() -> f64 {
    0.325
}

impl TurbulenceModel for Wale {
    fn eddy_viscosity(&self, gradient: &[[f64; 3]; 3], width: f64, _: f64) -> f64 {
        let g = gradient;
        let square = |a: usize, b: usize| g[a][0] * g[0][b] + g[a][1] * g[1][b] + g[a][2] * g[2][b];
        let third = (square(0, 0) + square(1, 1) + square(2, 2)) / 3.0;
        let (mut eddies, mut strains) = (0.0, 0.0);
        for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
            let trace = if a == b { third } else { 0.0 };
            eddies += (0.5 * (square(a, b) + square(b, a)) - trace).powi(2);
            strains += (0.5 * (g[a][b] + g[b][a])).powi(2);
        }
        let sum = strains * strains * strains.sqrt() + eddies * eddies.sqrt().sqrt();
        if sum > 0.0 { (self.constant * width).powi(2) * eddies * eddies.sqrt() / sum } else { 0.0 }
    }

    fn check(&self) -> Result<(), BadValue> {
        positive("constant", self.constant)
    }
}
