//! Hölzer and Sommerfeld (2008): a lone particle of any shape, as it lies in the flow.

use crate::ShapeFactors;

/// C_D Re/24 with
///
/// ```text
/// C_D = 8/(Re √Φ∥) + 16/(Re √Φ) + 3/(√Re Φ^¾) + 0.42 · 10^(0.4 (−log₁₀ Φ)^0.2) / Φ⊥
/// ```
///
/// Φ the sphericity, Φ⊥ the crosswise, Φ∥ the lengthwise sphericity; for a sphere Stokes' law at Re → 0.
pub(super) fn resistance(reynolds: f64, shape: &ShapeFactors) -> f64 {
    let ShapeFactors { sphericity, crosswise, lengthwise } = *shape;
    let root = sphericity.sqrt();
    let creeping = 8.0 / lengthwise.sqrt() + 16.0 / root;
    let between = 3.0 * reynolds.sqrt() / (root * root.sqrt());
    let newton = 0.42 * 10f64.powf(0.4 * (-sphericity.log10()).max(0.0).powf(0.2)) / crosswise;
    (creeping + between + newton * reynolds) / 24.0
}
