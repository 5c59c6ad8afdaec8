//! Where the liquid of a run is.

/// Liquid in and out on one rank, in quanta, and ends of bridges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiquidLedger {
    /// On particles when they were inserted.
    pub inserted: u128,
    /// With particles that left through outlets: their films and their parts of bridges.
    pub left: u128,
    /// What broken bridges left on walls.
    pub onto_walls: u128,
    /// What bridges took from the films on walls.
    pub off_walls: u128,
    /// Ends of bridges that have formed; one with a wall has both here.
    pub formed: u128,
    /// Ends of bridges that have broken, or gone with a particle.
    pub broken: u128,
}

impl LiquidLedger {
    /// The counts as numbers.
    pub fn numbers(&self) -> [u128; 6] {
        [self.inserted, self.left, self.onto_walls, self.off_walls, self.formed, self.broken]
    }

    /// Adds what another ledger counts.
    pub fn add(&mut self, other: &Self) {
        let (own, other) = (self.numbers(), other.numbers());
        *self = Self::from_numbers(std::array::from_fn(|k| own[k] + other[k]));
    }

    /// The ledger of these counts.
    pub fn from_numbers([inserted, left, onto_walls, off_walls, formed, broken]: [u128; 6]) -> Self {
        Self { inserted, left, onto_walls, off_walls, formed, broken }
    }
}

/// Where the liquid is, over all ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Liquid {
    /// On particles (m³).
    pub films: f64,
    /// In bridges (m³).
    pub bridges: f64,
    /// Left on walls less taken from them (m³).
    pub walls: f64,
    /// On particles when they were inserted (m³).
    pub inserted: f64,
    /// Left with particles (m³).
    pub left: f64,
    /// Number of bridges.
    pub count: u64,
    /// Number of bridges that have broken.
    pub broken: u64,
}

/// A volume (m³) in quanta.
#[inline]
pub(crate) fn quanta(volume: f64, quantum: f64) -> u128 {
    u128::from((volume / quantum) as u64)
}
