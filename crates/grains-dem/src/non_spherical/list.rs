//! All pairs of parts of a rank.

use super::batch::PointBatch;
use super::found::Contacts;
use super::pairs::{Histories, PartPair};
use crate::contact_history::ContactHistory;
use crate::memory_use::heap_bytes;
use grains_geometry::Vec3;

/// All pairs of parts of a rank, those of two particles side by side.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartPairList {
    pub(crate) pairs: Vec<PartPair>,
    pub(super) histories: Histories,
    pub(super) found: Contacts,
    pub(super) batch: Box<PointBatch>,
}

impl PartPairList {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        heap_bytes(&self.pairs) + heap_bytes(&self.histories.items) + heap_bytes(&self.histories.free)
    }

    /// Forgets all pairs but the first ones.
    pub(crate) fn truncate(&mut self, kept: usize) {
        self.pairs[kept..].iter_mut().for_each(|pair| self.histories.forget(pair));
        self.pairs.truncate(kept);
        if kept == 0 {
            self.histories.items.clear();
            self.histories.free.clear();
        }
    }

    /// Adds a pair of parts whose centres are `between` (m) apart, with its history if it touched.
    pub(crate) fn push(
        &mut self,
        [a, b]: [u32; 2],
        parts: [u16; 2],
        between: &Vec3,
        known: Option<ContactHistory>,
    ) {
        let mut pair =
            PartPair { a, b, parts, axis: Vec3::zeros(), separated_until: 0.0, history: PartPair::APART };
        pair.separate_by(between);
        if let Some(known) = known {
            *self.histories.of(&mut pair) = known;
        }
        self.pairs.push(pair);
    }

    /// Makes room for the histories of all pairs, so that no step has to.
    pub(crate) fn reserve(&mut self) {
        let Histories { items, free } = &mut self.histories;
        // There may be more histories than pairs once pairs with clones were forgotten.
        items.reserve(self.pairs.len().saturating_sub(items.len()));
        free.reserve(items.len().max(self.pairs.len()) - free.len());
    }

    /// The pairs that touched in the last step and their histories.
    pub(crate) fn with_history(&self) -> impl Iterator<Item = (&PartPair, &ContactHistory)> {
        self.with_history_from(0)
    }

    /// Those of them from a place in the list on.
    pub(crate) fn with_history_from(
        &self,
        first: usize,
    ) -> impl Iterator<Item = (&PartPair, &ContactHistory)> {
        let touching = self.pairs[first..].iter().filter(|pair| pair.is_touching());
        touching.map(|pair| (pair, &self.histories.items[pair.history as usize]))
    }
}
