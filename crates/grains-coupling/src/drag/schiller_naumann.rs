//! Schiller and Naumann (1933): a lone sphere.

use super::Flow;

/// From here on the drag coefficient is that of Newton (-).
const NEWTON: f64 = 1000.0;

/// The lone sphere at the interstitial slip, of Reynolds number Re/ε: F = f(Re/ε)/ε, so that the force is
/// 3π μ d f (u − v) at any void fraction. For suspensions so dilute that neighbours do not matter.
pub(super) fn resistance(flow: &Flow) -> f64 {
    let Flow { reynolds, void_fraction, .. } = *flow;
    lone_sphere(reynolds / void_fraction) / void_fraction
}

/// C_D Re/24 = 1 + 0.15 Re^0.687 up to Re = 1000, with C_D = 0.44 beyond.
pub(super) fn lone_sphere(reynolds: f64) -> f64 {
    if reynolds > NEWTON { 0.44 / 24.0 * reynolds } else { 1.0 + 0.15 * reynolds.powf(0.687) }
}
