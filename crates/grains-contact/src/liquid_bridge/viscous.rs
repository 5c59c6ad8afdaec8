//! Resistance of the liquid of a bridge to squeezing and shearing.

use std::f64::consts::PI;

/// Dashpots of a liquid between two spheres that nearly touch.
///
/// Both take R* = R1 R2/(R1 + R2), R1 against a wall, and not the R = 2 R* of the capillary force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BridgeViscosity {
    /// Viscosity μ (Pa s).
    pub viscosity: f64,
    /// Smallest gap over R*, the roughness ε (-), positive.
    pub min_gap: f64,
}

impl BridgeViscosity {
    /// Normal dashpot 6π μ R*/max(h/R*, ε) (N s/m), against the speed of approach or opening (Cox and Brenner 1967).
    #[inline(always)]
    pub fn normal_dashpot(&self, gap: f64, effective_radius: f64) -> f64 {
        let relative = (gap / effective_radius).max(self.min_gap);
        6.0 * PI * self.viscosity * effective_radius / relative
    }

    /// Tangential dashpot 6π μ R* (8/15 ln(R*/h) + 0.9588) (N s/m), h/R* at least ε (Goldman, Cox and Brenner 1967).
    ///
    /// The asymptote holds up to h = R*; wider gaps have its value there. LIGGGHTS takes ε for h/R* at any gap.
    #[inline]
    pub fn tangential_dashpot(&self, gap: f64, effective_radius: f64) -> f64 {
        let relative = (gap / effective_radius).max(self.min_gap).min(1.0);
        6.0 * PI * self.viscosity * effective_radius * (0.9588 - 8.0 / 15.0 * libm::log(relative))
    }
}
