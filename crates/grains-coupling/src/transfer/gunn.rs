//! Gunn (1978): fixed and fluidised beds.

use super::Passing;

/// Nu = (7 − 10 ε + 5 ε²)(1 + 0.7 Re^0.2 Pr^⅓) + (1.33 − 2.4 ε + 1.2 ε²) Re^0.7 Pr^⅓.
pub(super) fn nusselt(passing: &Passing) -> f64 {
    passing.in_the_form_of_gunn([0.7, -2.4, 1.2])
}
