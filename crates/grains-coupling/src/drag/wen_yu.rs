//! Wen and Yu (1966): dilute suspensions of spheres.

use super::Flow;
use super::schiller_naumann::lone_sphere;

/// F = C_D Re/24 · ε^−3.65 with the lone sphere's C_D at the superficial slip; per volume this is
/// ¾ C_D ε (1−ε) ρ |u−v|/d · ε^−2.65 (Gidaspow 1994).
pub(super) fn resistance(flow: &Flow) -> f64 {
    let Flow { reynolds, void_fraction, .. } = *flow;
    lone_sphere(reynolds) * void_fraction.powf(-3.65)
}
