//! Where the heat of the particles of a run comes from.

use std::ops::AddAssign;

/// A sum that keeps what rounding takes from it (Neumaier 1974).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    value: f64,
    lost: f64,
}

impl Sum {
    /// The sum.
    pub fn total(&self) -> f64 {
        self.value + self.lost
    }
}

impl From<f64> for Sum {
    fn from(value: f64) -> Self {
        Self { value, lost: 0.0 }
    }
}

impl AddAssign<f64> for Sum {
    fn add_assign(&mut self, x: f64) {
        let sum = self.value + x;
        let of_x = sum - self.value;
        self.lost += (self.value - (sum - of_x)) + (x - of_x);
        self.value = sum;
    }
}

/// Heat in and out of the particles of one rank (J), against particles at 0 K.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatLedger {
    /// In particles when they were inserted.
    pub inserted: Sum,
    /// In particles that left through outlets.
    pub left: Sum,
    /// From walls.
    pub walls: Sum,
    /// By radiation from the surroundings.
    pub radiation: Sum,
    /// Produced in particles.
    pub produced: Sum,
    /// From the fluid.
    pub fluid: Sum,
}

impl HeatLedger {
    /// The sums as numbers.
    pub fn numbers(&self) -> [f64; 6] {
        [self.inserted, self.left, self.walls, self.radiation, self.produced, self.fluid]
            .map(|sum| sum.total())
    }

    /// The ledger of these numbers.
    pub fn from_numbers(numbers: [f64; 6]) -> Self {
        let [inserted, left, walls, radiation, produced, fluid] = numbers.map(Sum::from);
        Self { inserted, left, walls, radiation, produced, fluid }
    }
}

/// The heat in the particles, over all ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heat {
    /// Mean temperature (K), weighted by heat capacity.
    pub mean: f64,
    /// Lowest and highest temperature (K).
    pub ends: [f64; 2],
    /// Σ m c T (J).
    pub content: f64,
    /// In and out (J), as of [`HeatLedger::numbers`].
    pub ledger: [f64; 6],
}

impl Heat {
    /// Heat (J) that nothing accounts for.
    pub fn unaccounted(&self) -> f64 {
        let [inserted, left, walls, radiation, produced, fluid] = self.ledger;
        self.content - (inserted - left + walls + radiation + produced + fluid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_many_small_terms_lose_nothing() {
        let mut sum = Sum::from(1e6);
        (0..1_000_000).for_each(|_| sum += 0.1);
        assert!((sum.total() - 1_100_000.0).abs() < 1e-9, "{}", sum.total());
    }
}
