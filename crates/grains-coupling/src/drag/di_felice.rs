//! Di Felice (1994): the voidage function, and his law for spheres.

use super::Flow;

/// F = C_D Re/24 · ε^−χ with C_D = (0.63 + 4.8/√Re)² (Dallavalle 1948), whose limit at Re → 0 is 0.96 of Stokes.
pub(super) fn resistance(flow: &Flow) -> f64 {
    let root = 0.63 * flow.reynolds.sqrt() + 4.8;
    root * root / 24.0 * crowding(flow)
}

/// What the neighbours make of the drag of a lone particle at the superficial slip: ε^−χ with
/// χ = 3.7 − 0.65 exp(−(1.5 − log₁₀ Re)²/2).
pub(super) fn crowding(flow: &Flow) -> f64 {
    let off = 1.5 - flow.reynolds.log10();
    let exponent = 3.7 - 0.65 * (-0.5 * off * off).exp();
    flow.void_fraction.powf(-exponent)
}
