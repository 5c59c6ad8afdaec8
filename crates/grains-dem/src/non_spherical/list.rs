//! All pairs of parts of a rank.

use super::batch::PointBatch;
use super::found::Contacts;
use super::pairs::{BodyPair, Memories};
use crate::contact_history::ContactMemory;
use crate::memory_use::heap_bytes;
use grains_geometry::Vec3;

/// All pairs of parts of a rank, those of two particles side by side.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyList {
    pub(crate) pairs: Vec<BodyPair>,
    pub(super) memories: Memories,
    pub(super) found: Contacts,
    pub(super) batch: Box<PointBatch>,
}

impl BodyList {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        heap_bytes(&self.pairs) + heap_bytes(&self.memories.items) + heap_bytes(&self.memories.free)
    }

    /// Forgets all pairs.
    pub(crate) fn clear(&mut self) {
        self.pairs.clear();
        self.memories.items.clear();
        self.memories.free.clear();
    }

    /// Adds a pair of parts whose centres are `between` (m) apart, with what it remembers if it touched.
    pub(crate) fn push(
        &mut self,
        [a, b]: [u32; 2],
        parts: [u16; 2],
        between: &Vec3,
        known: Option<ContactMemory>,
    ) {
        let mut pair =
            BodyPair { a, b, parts, axis: Vec3::zeros(), apart_until: 0.0, memory: BodyPair::APART };
        pair.part_by(between);
        if let Some(known) = known {
            *self.memories.of(&mut pair) = known;
        }
        self.pairs.push(pair);
    }

    /// Makes room for the memories of all pairs, so that no step has to.
    pub(crate) fn reserve(&mut self) {
        let Memories { items, free } = &mut self.memories;
        items.reserve(self.pairs.len() - items.len());
        free.reserve(self.pairs.len() - free.len());
    }

    /// The pairs that touched in the last step and what they remember.
    pub(crate) fn remembered(&self) -> impl Iterator<Item = (&BodyPair, &ContactMemory)> {
        let touching = self.pairs.iter().filter(|pair| pair.is_touching());
        touching.map(|pair| (pair, &self.memories.items[pair.memory as usize]))
    }
}
