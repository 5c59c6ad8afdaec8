//! Pairs of parts that may touch, and the history of those that touch.

use crate::contact_history::{ContactHistory, LawHistory};
use grains_geometry::Vec3;

/// A pair of parts that may touch; `a` is the particle of lower id.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartPair {
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) parts: [u16; 2],
    /// Unit normal of a plane that separated the two when they were last checked; it changes the time of the answer, not
    /// the answer.
    pub(crate) axis: Vec3,
    /// Path length of both particles together since the lists were built (m) up to which they are separated.
    pub(super) separated_until: f64,
    /// Place of its history, or [`PartPair::APART`]: a pair has one only while it touches step after step.
    pub(super) history: u32,
}

impl PartPair {
    pub(super) const APART: u32 = u32::MAX;

    /// Whether two pairs are of the same two particles.
    pub(super) fn is_of_same_particles(&self, other: &Self) -> bool {
        (self.a, self.b) == (other.a, other.b)
    }

    /// Whether the pair touched in the last step.
    pub(super) fn is_touching(&self) -> bool {
        self.history != Self::APART
    }

    /// Leaves the two, which have `gone` so far (m) and are `gap` (m) apart, unchecked until that can be closed.
    pub(super) fn stay_apart(&mut self, gone: f64, gap: f64) {
        // The share covers the rounding of the sums.
        self.separated_until = gone + 0.999 * gap;
    }

    /// Takes a plane of this normal, of any length, to separate the two from the next step on.
    pub(super) fn separate_by(&mut self, normal: &Vec3) {
        self.axis = normal * (1.0 / normal.norm());
    }
}

/// Histories of the pairs that touch; pairs apart, the majority, stay small.
#[derive(Clone, Debug, Default)]
pub(super) struct Histories {
    pub(super) items: Vec<ContactHistory>,
    pub(super) free: Vec<u32>,
}

impl Histories {
    /// History of a pair; a new one if it did not touch.
    #[inline]
    pub(super) fn of(&mut self, pair: &mut PartPair) -> &mut ContactHistory {
        if pair.history == PartPair::APART {
            pair.history = self.free.pop().unwrap_or_else(|| {
                self.items.push(ContactHistory::default());
                self.items.len() as u32 - 1
            });
            self.items[pair.history as usize] = ContactHistory::default();
            pair.separated_until = 0.0;
        }
        &mut self.items[pair.history as usize]
    }

    /// What the law keeps of a pair, if it touched.
    pub(super) fn law_of(&self, pair: &PartPair) -> LawHistory {
        self.items.get(pair.history as usize).map_or_else(LawHistory::default, |history| history.law)
    }

    /// Forgets a pair that is apart.
    pub(super) fn forget(&mut self, pair: &mut PartPair) {
        if pair.history != PartPair::APART {
            self.free.push(pair.history);
            pair.history = PartPair::APART;
        }
    }
}
