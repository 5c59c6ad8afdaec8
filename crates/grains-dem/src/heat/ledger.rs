//! Where the heat of the particles of a run comes from.

/// Heat in and out of the particles of one rank (J), against particles at 0 K.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatLedger {
    /// In particles when they were inserted.
    pub inserted: f64,
    /// In particles that left through outlets.
    pub left: f64,
    /// From walls.
    pub walls: f64,
    /// By radiation from the surroundings.
    pub radiation: f64,
    /// Produced in particles.
    pub produced: f64,
    /// From the fluid.
    pub fluid: f64,
}

impl HeatLedger {
    /// The sums as numbers.
    pub fn numbers(&self) -> [f64; 6] {
        [self.inserted, self.left, self.walls, self.radiation, self.produced, self.fluid]
    }

    /// The ledger of these numbers.
    pub fn from_numbers([inserted, left, walls, radiation, produced, fluid]: [f64; 6]) -> Self {
        Self { inserted, left, walls, radiation, produced, fluid }
    }

    /// Heat (J) that must be in the particles.
    pub fn content(&self) -> f64 {
        self.inserted - self.left + self.walls + self.radiation + self.produced + self.fluid
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
    /// In and out.
    pub ledger: HeatLedger,
}

impl Heat {
    /// Heat (J) that nothing accounts for.
    pub fn unaccounted(&self) -> f64 {
        self.content - self.ledger.content()
    }
}
