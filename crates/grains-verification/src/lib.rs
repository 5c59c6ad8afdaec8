//! Contact laws against closed forms and published cases.
//!
//! Each case runs the solver itself, two bodies or one on a plane, and compares what comes out with what must. The program
//! prints the table, `grains-mpi verify`, and the test of this crate asserts it.

mod adhesion;
mod bridges;
mod impact;
mod plasticity;
mod rolling;
mod scene;
mod sliding;
mod twisting;

use std::fmt;

/// One quantity of a law.
#[derive(Clone, Debug)]
pub struct Row {
    /// The law.
    pub law: &'static str,
    /// What is compared, and where.
    pub quantity: String,
    /// Unit; "-" of a ratio.
    pub unit: &'static str,
    /// What the solver gives.
    pub found: f64,
    /// What it must give.
    pub exact: f64,
    /// Largest difference, as a share of `scale`.
    pub tolerance: f64,
    /// What differences are measured by: the exact value, or what it is small beside.
    pub scale: f64,
}

impl Row {
    fn new(law: &'static str, quantity: impl Into<String>, unit: &'static str, values: [f64; 2]) -> Self {
        let [found, exact] = values;
        Self { law, quantity: quantity.into(), unit, found, exact, tolerance: 5e-3, scale: exact.abs() }
    }

    /// The same with this tolerance.
    fn within(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same with differences measured by a scale, where the exact value is zero or nearly.
    fn of_scale(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// Difference over the scale (-).
    pub fn error(&self) -> f64 {
        (self.found - self.exact).abs() / self.scale
    }

    /// Whether it is as close as it should be.
    pub fn is_right(&self) -> bool {
        self.error() <= self.tolerance
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { law, quantity, unit, found, exact, tolerance, .. } = self;
        let verdict = if self.is_right() { "" } else { "  WRONG" };
        write!(
            f,
            "{law:<16} {quantity:<58} {unit:<6} {found:>12.5e} {exact:>12.5e} {:>9.1e} {tolerance:>8.0e}{verdict}",
            self.error()
        )
    }
}

/// The heading of a table of rows.
pub fn heading() -> String {
    format!(
        "{:<16} {:<58} {:<6} {:>12} {:>12} {:>9} {:>8}",
        "law", "quantity", "unit", "found", "exact", "error", "allowed"
    )
}

/// All cases of all laws.
pub fn all() -> Vec<Row> {
    [
        impact::rows(),
        sliding::rows(),
        adhesion::rows(),
        plasticity::rows(),
        rolling::rows(),
        twisting::rows(),
        bridges::rows(),
    ]
    .concat()
}
