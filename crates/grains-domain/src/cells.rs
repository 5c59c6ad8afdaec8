//! The linked cells of one subdomain with its layer of clone cells (thesis fig. 5.1).

use crate::Decomposition;

/// What a cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellTag {
    /// Own particles that no neighbour sees.
    Interior,
    /// Own particles that neighbours see, with the sides the cell touches.
    Buffer {
        /// Sides towards lower coordinates.
        low: [bool; 3],
        /// Sides towards higher coordinates.
        high: [bool; 3],
    },
    /// Clones of particles of neighbours.
    Clone,
}

/// Cells at least one interaction range wide: the subdomain's own and one layer around them.
#[derive(Clone, Debug)]
pub struct CellGrid {
    /// Cells per axis, clone layers included.
    pub counts: [usize; 3],
    lower: [f64; 3],
    inverse_width: [f64; 3],
}

impl CellGrid {
    /// Grid over a subdomain for an interaction range (m).
    pub fn new(decomposition: &Decomposition, range: f64) -> Self {
        let (lower, upper) = (decomposition.lower(), decomposition.upper());
        let own: [usize; 3] = std::array::from_fn(|a| (((upper[a] - lower[a]) / range) as usize).max(1));
        Self {
            counts: own.map(|n| n + 2),
            lower,
            inverse_width: std::array::from_fn(|a| own[a] as f64 / (upper[a] - lower[a])),
        }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// Whether the grid has no cell (it always has).
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Per-axis place of a position; outside positions go to the nearest clone cell.
    #[inline]
    pub fn place(&self, position: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|a| {
            let at = ((position[a] - self.lower[a]) * self.inverse_width[a]).floor() + 1.0;
            at.clamp(0.0, (self.counts[a] - 1) as f64) as usize
        })
    }

    /// Place of a particle owned by this subdomain: never a clone cell, however the border rounds.
    #[inline]
    pub fn own_place(&self, position: [f64; 3]) -> [usize; 3] {
        let place = self.place(position);
        std::array::from_fn(|a| place[a].clamp(1, self.counts[a] - 2))
    }

    /// Number of a cell, x fastest.
    #[inline]
    pub fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.counts[1] + place[1]) * self.counts[0] + place[0]
    }

    /// Tag of a cell.
    pub fn tag(&self, place: [usize; 3]) -> CellTag {
        if (0..3).any(|a| place[a] == 0 || place[a] == self.counts[a] - 1) {
            return CellTag::Clone;
        }
        let low = place.map(|p| p == 1);
        let high = std::array::from_fn(|a| place[a] == self.counts[a] - 2);
        if low == [false; 3] && high == [false; 3] {
            CellTag::Interior
        } else {
            CellTag::Buffer { low, high }
        }
    }
}
