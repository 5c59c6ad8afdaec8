//! Koch and Hill (2001): spheres, from lattice-Boltzmann simulations of random arrays.

use super::Flow;

/// Solid fraction from which on the creeping drag is Carman's (-).
const PACKED: f64 = 0.4;

/// Koch and Hill, Annu. Rev. Fluid Mech. 33 (2001) 619, as van Buijtenen et al. (2011) write it: with φ = 1 − ε and Re of the
/// superficial slip and the diameter
///
/// ```text
/// F = ε (F₀ + ½ F₃ Re),     F₃ = 0.0673 + 0.212 φ + 0.0232/ε⁵
/// F₀ = (1 + 3 √(φ/2) + 135/64 φ ln φ + 16.14 φ) / (1 + 0.681 φ − 8.48 φ² + 8.16 φ³)     φ < 0.4
/// F₀ = 10 φ/ε³                                                                           φ ≥ 0.4
/// ```
///
/// F₀ jumps by 1 % at φ = 0.4, as published; above it F is 10 φ/ε² at Re → 0, Carman's 180 μ φ² U/(ε³ d²) for a bed. At φ → 0 it is
/// 1 + 0.045 Re, Stokes' law without slip. The simulations reach close packing, φ = 0.64, and Re of order 100; the range in which F
/// first rises with Re² instead of Re is left out, as in most uses of the law.
pub(super) fn resistance(flow: &Flow) -> f64 {
    let (eps, phi) = (flow.void_fraction, (1.0 - flow.void_fraction).max(0.0));
    let inertial = 0.0673 + 0.212 * phi + 0.0232 / eps.powi(5);
    eps * (creeping(eps, phi) + 0.5 * inertial * flow.reynolds)
}

/// F₀ (-).
fn creeping(eps: f64, phi: f64) -> f64 {
    if phi >= PACKED {
        return 10.0 * phi / eps.powi(3);
    }
    let logarithmic = if phi > 0.0 { 135.0 / 64.0 * phi * phi.ln() } else { 0.0 };
    (1.0 + 3.0 * (0.5 * phi).sqrt() + logarithmic + 16.14 * phi)
        / (1.0 + phi * (0.681 + phi * (-8.48 + phi * 8.16)))
}
