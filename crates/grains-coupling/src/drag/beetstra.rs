//! Beetstra, van der Hoef and Kuipers (2007): spheres, from lattice-Boltzmann simulations.

use super::Flow;

/// Below this Reynolds number the inertial term, which falls as Re² and more, is under 1e-12 of the whole.
const CREEPING: f64 = 1e-9;

/// Thesis eq. 5.16 (errata R16-39): with φ = 1 − ε and Re of the superficial slip
///
/// ```text
/// F = 10 φ/ε² + ε² (1 + 1.5 √φ) + 0.413 Re/(24 ε²) · (1/ε + 3 ε φ + 8.4 Re^−0.343) / (1 + 10^(3φ) Re^−(1+4φ)/2)
/// ```
///
/// written so that no power of Re has a negative exponent. At φ → 0 it is 1 + …, though not Schiller and Naumann's.
pub(super) fn resistance(flow: &Flow) -> f64 {
    let (reynolds, eps, phi) = (flow.reynolds, flow.void_fraction, 1.0 - flow.void_fraction);
    let creeping = 10.0 * phi / (eps * eps) + eps * eps * (1.0 + 1.5 * phi.max(0.0).sqrt());
    if reynolds < CREEPING {
        return creeping;
    }
    let log = reynolds.ln();
    let power = |exponent: f64| (exponent * log).exp();
    let rise = power(0.5 + 2.0 * phi);
    let dense = 10f64.powf(3.0 * phi);
    let numerator = (1.0 / eps + 3.0 * eps * phi) * reynolds + 8.4 * power(1.0 - 0.343);
    creeping + 0.413 / (24.0 * eps * eps) * numerator * rise / (rise + dense)
}
