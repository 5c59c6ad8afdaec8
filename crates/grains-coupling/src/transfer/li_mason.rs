//! Li and Mason (2000): particles in pipes.

use super::Passing;

/// With n = 3.5
///
/// ```text
/// Nu = 2 + 0.6 εⁿ Re^½ Pr^⅓                             Re ≤ 200
/// Nu = 2 + (0.5 Re^½ + 0.02 Re^0.8) εⁿ Pr^⅓      200 < Re ≤ 1500
/// Nu = 2 + 0.000045 εⁿ Re^1.8                          1500 < Re
/// ```
pub(super) fn nusselt(passing: &Passing) -> f64 {
    let Passing { reynolds, prandtl, void_fraction } = *passing;
    let crowding = void_fraction.powf(3.5);
    if reynolds <= 200.0 {
        2.0 + 0.6 * crowding * reynolds.sqrt() * prandtl.cbrt()
    } else if reynolds <= 1500.0 {
        2.0 + (0.5 * reynolds.sqrt() + 0.02 * reynolds.powf(0.8)) * crowding * prandtl.cbrt()
    } else {
        2.0 + 4.5e-5 * crowding * reynolds.powf(1.8)
    }
}
