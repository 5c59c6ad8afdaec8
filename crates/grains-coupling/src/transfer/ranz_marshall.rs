//! Ranz and Marshall (1952): a lone sphere.

use super::Passing;

/// Nu = 2 + 0.6 Re^½ Pr^⅓.
pub(super) fn nusselt(passing: &Passing) -> f64 {
    2.0 + 0.6 * passing.reynolds.sqrt() * passing.prandtl.cbrt()
}
