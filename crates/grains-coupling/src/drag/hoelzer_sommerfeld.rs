//! Hölzer and Sommerfeld (2008): a particle of any shape, as it lies in the flow, crowded as by Di Felice.

use super::Flow;
use super::di_felice::crowding;
use crate::ShapeFactors;

/// F = C_D Re/24 · [`crowding`] with
///
/// ```text
/// C_D = 8/(Re √Φ∥) + 16/(Re √Φ) + 3/(√Re Φ^¾) + 0.42 · 10^(0.4 (−log₁₀ Φ)^0.2) / Φ⊥
/// ```
///
/// Φ the sphericity, Φ⊥ the crosswise, Φ∥ the lengthwise sphericity; for a sphere Stokes' law at Re → 0.
pub(super) fn resistance(flow: &Flow) -> f64 {
    lone_particle(flow.reynolds, &flow.shape) * crowding(flow)
}

/// C_D Re/24 of a lone particle.
fn lone_particle(reynolds: f64, shape: &ShapeFactors) -> f64 {
    let ShapeFactors { sphericity, crosswise, lengthwise } = *shape;
    let root = sphericity.sqrt();
    let creeping = 8.0 / lengthwise.sqrt() + 16.0 / root;
    let between = 3.0 * reynolds.sqrt() / (root * root.sqrt());
    let newton = 0.42 * 10f64.powf(0.4 * (-sphericity.log10()).max(0.0).powf(0.2)) / crosswise;
    (creeping + between + newton * reynolds) / 24.0
}
