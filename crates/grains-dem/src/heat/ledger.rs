//! Where the heat of the particles of a run comes from.

use grains_domain::ExactSum;

/// Heat in and out of the particles of one rank (J), against particles at 0 K.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatLedger {
    /// In particles when they were inserted.
    pub inserted: ExactSum,
    /// In particles that left through outlets.
    pub left: ExactSum,
    /// From walls.
    pub walls: ExactSum,
    /// By radiation from the surroundings.
    pub radiation: ExactSum,
    /// Produced in particles.
    pub produced: ExactSum,
    /// From the fluid.
    pub fluid: ExactSum,
}

impl HeatLedger {
    /// The sums, in the order above.
    pub fn sums(&self) -> [ExactSum; 6] {
        [self.inserted, self.left, self.walls, self.radiation, self.produced, self.fluid]
    }

    /// The ledger of these sums.
    pub fn from_sums([inserted, left, walls, radiation, produced, fluid]: [ExactSum; 6]) -> Self {
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
    /// In and out (J), in the order of [`HeatLedger::sums`].
    pub ledger: [f64; 6],
}

impl Heat {
    /// Heat (J) that nothing accounts for.
    pub fn unaccounted(&self) -> f64 {
        let [inserted, left, walls, radiation, produced, fluid] = self.ledger;
        self.content - (inserted - left + walls + radiation + produced + fluid)
    }
}
