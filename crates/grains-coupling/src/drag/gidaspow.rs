//! Gidaspow (1994): Ergun in the dense bed, Wen and Yu above it.

use super::{ergun, wen_yu};

/// Void fraction beyond which a bed counts as dilute (-).
const DILUTE: f64 = 0.8;

/// Ergun for ε ≤ 0.8, Wen and Yu for ε > 0.8; the force jumps there, as published.
pub(super) fn resistance(reynolds: f64, void_fraction: f64) -> f64 {
    if void_fraction > DILUTE {
        wen_yu::resistance(reynolds, void_fraction)
    } else {
        ergun::resistance(reynolds, void_fraction)
    }
}
