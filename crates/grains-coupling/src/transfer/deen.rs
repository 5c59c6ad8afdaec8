//! Deen, Peters, Padding and Kuipers (2014): resolved flows through arrays of spheres.

use super::Passing;

/// Nu = (7 − 10 ε + 5 ε²)(1 + 0.17 Re^0.2 Pr^⅓) + (1.33 − 2.31 ε + 1.16 ε²) Re^0.7 Pr^⅓.
pub(super) fn nusselt(passing: &Passing) -> f64 {
    passing.in_the_form_of_gunn([0.17, -2.31, 1.16])
}
