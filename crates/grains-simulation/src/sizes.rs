//! Size distributions made ready to be drawn from: by number, as particles are counted, and by mass, as they are sieved.
//!
//! Mass goes with the cube of the size d for bodies of any shape. The density of a distribution by mass over that by number is
//! therefore d³ (Rumpf 1975): q_3(d) ∝ d³ q_0(d). Either follows from the one that is given, and nothing is drawn in vain.

mod classes;
mod formula;
#[cfg(test)]
mod tests;

use classes::Classes;
use formula::Formula;
pub use formula::kept;
use grains_case::{Basis, SizeDistribution};

/// Sizes of the particles of one component, by number and by mass.
#[derive(Clone, Debug)]
pub struct Sizes {
    by_number: Cumulative,
    by_mass: Cumulative,
    /// Fraction of the uncut distribution between the cut-offs (-), where there is an uncut one.
    pub kept: Option<f64>,
}

/// A cumulative distribution of sizes.
#[derive(Clone, Debug)]
enum Cumulative {
    /// Of classes, in each of which it has a closed form.
    Classes(Classes),
    /// Of a formula, tabulated.
    Formula(Formula),
}

impl Sizes {
    /// Those of a distribution.
    pub fn of(given: &SizeDistribution) -> Self {
        let weighted = |basis: Basis| match Formula::of(given, power(basis, given.basis())) {
            Some(formula) => Cumulative::Formula(formula),
            None => Cumulative::Classes(Classes::of(given.classes(), power(basis, given.basis()))),
        };
        Self { by_number: weighted(Basis::Number), by_mass: weighted(Basis::Mass), kept: kept(given) }
    }

    /// The size below which a fraction in [0, 1) of the particles is: the size of a particle that has drawn this number.
    pub fn quantile(&self, basis: Basis, fraction: f64) -> f64 {
        match self.of_basis(basis) {
            Cumulative::Classes(classes) => classes.quantile(fraction),
            Cumulative::Formula(formula) => formula.quantile(fraction),
        }
    }

    /// Mean size: the arithmetic one by number, that of De Brouckere by mass.
    pub fn mean(&self, basis: Basis) -> f64 {
        match self.of_basis(basis) {
            Cumulative::Classes(classes) => classes.mean,
            Cumulative::Formula(formula) => formula.mean,
        }
    }

    fn of_basis(&self, basis: Basis) -> &Cumulative {
        match basis {
            Basis::Number => &self.by_number,
            Basis::Mass => &self.by_mass,
        }
    }
}

/// Power of the size by which the density of one distribution exceeds that of another.
fn power(wanted: Basis, given: Basis) -> i32 {
    match (wanted, given) {
        (Basis::Number, Basis::Mass) => -3,
        (Basis::Mass, Basis::Number) => 3,
        _ => 0,
    }
}
