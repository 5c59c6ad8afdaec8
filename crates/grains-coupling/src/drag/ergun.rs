//! Ergun (1952): packed beds of spheres.

use super::Flow;

/// From Δp/L = 150 μ (1−ε)² U/(ε³ d²) + 1.75 ρ (1−ε) U²/(ε³ d): F = (150 (1 − ε) + 1.75 Re) / (18 ε²).
pub(super) fn resistance(flow: &Flow) -> f64 {
    let Flow { reynolds, void_fraction, .. } = *flow;
    (150.0 * (1.0 - void_fraction) + 1.75 * reynolds) / (18.0 * void_fraction * void_fraction)
}
