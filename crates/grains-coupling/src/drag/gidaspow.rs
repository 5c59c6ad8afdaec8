//! Gidaspow (1994): Ergun in the dense bed, Wen and Yu above it.

use super::{Flow, ergun, wen_yu};

/// Void fraction beyond which a bed counts as dilute (-).
const DILUTE: f64 = 0.8;

/// Ergun for ε ≤ 0.8, Wen and Yu for ε > 0.8; the force jumps there, as published.
pub(super) fn resistance(flow: &Flow) -> f64 {
    if flow.void_fraction > DILUTE { wen_yu::resistance(flow) } else { ergun::resistance(flow) }
}
