//! Sun, Tenneti and Subramaniam (2015): resolved flows through arrays of spheres, Re up to 100.

use super::Passing;

/// Nu = (−0.46 + 1.77 ε + 0.69 ε²)/ε³ + (1.37 − 2.4 ε + 1.2 ε²) Re^0.7 Pr^⅓.
pub(super) fn nusselt(passing: &Passing) -> f64 {
    let eps = passing.void_fraction;
    let still = (-0.46 + 1.77 * eps + 0.69 * eps * eps) / eps.powi(3);
    let moving = 1.37 - 2.4 * eps + 1.2 * eps * eps;
    still + moving * passing.reynolds.powf(0.7) * passing.prandtl.cbrt()
}
