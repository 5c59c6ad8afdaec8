//! Ganser (1993): a particle of any shape, by two shape factors, crowded as by Di Felice.

use super::Flow;
use super::di_felice::crowding;
use crate::ShapeFactors;

/// F = C_D Re/24 · [`crowding`] with, for X = Re K₁ K₂,
///
/// ```text
/// C_D/K₂ = 24/X (1 + 0.1118 X^0.6567) + 0.4305/(1 + 3305/X)
/// 1/K₁ = d_n/(3 d) + 2/(3 √Φ),     K₂ = 10^(1.8148 (−log₁₀ Φ)^0.5743)
/// ```
///
/// Stokes' factor K₁ takes the diameter d_n = d/√Φ⊥ of the circle of the projected area; the walls of the vessel are
/// left out. For a sphere the published numbers lie up to 26 % below Schiller and Naumann's, at Re near 100.
pub(super) fn resistance(flow: &Flow) -> f64 {
    lone_particle(flow.reynolds, &flow.shape) * crowding(flow)
}

/// C_D Re/24 of a lone particle.
fn lone_particle(reynolds: f64, shape: &ShapeFactors) -> f64 {
    let stokes = 1.0 / (1.0 / (3.0 * shape.crosswise.sqrt()) + 2.0 / (3.0 * shape.sphericity.sqrt()));
    let newton = 10f64.powf(1.8148 * (-shape.sphericity.log10()).max(0.0).powf(0.5743));
    let x = reynolds * stokes * newton;
    (1.0 + 0.1118 * x.powf(0.6567)) / stokes + 0.4305 / 24.0 * newton * reynolds * x / (x + 3305.0)
}
