//! Pairs of parts that may touch, and what those that touch remember.

use super::PartContact;
use super::run::Run;
use crate::dem::bytes;
use crate::memory::ContactMemory;
use grains_geometry::{ContactPatch, Vec3};

/// A pair of parts that may touch; `a` is the particle of lower id.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyPair {
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) parts: [u16; 2],
    /// Unit normal of a plane that parted the two when they were last asked; it changes the time of the answer, not
    /// the answer.
    pub(crate) axis: Vec3,
    /// Way the two bodies may go together, counted from when the lists were built (m): until then they are apart.
    pub(super) apart_until: f64,
    /// Place of its memory, or [`BodyPair::APART`]: a pair remembers only while it touches step after step.
    memory: u32,
}

impl BodyPair {
    const APART: u32 = u32::MAX;

    /// Whether two pairs are of the same two particles.
    pub(super) fn is_of_same_bodies(&self, other: &Self) -> bool {
        (self.a, self.b) == (other.a, other.b)
    }

    /// Whether the pair touched in the last step.
    pub(super) fn is_touching(&self) -> bool {
        self.memory != Self::APART
    }

    /// Leaves the two, which have `gone` so far (m) and are `gap` (m) apart, alone until that can be closed.
    pub(super) fn stay_apart(&mut self, gone: f64, gap: f64) {
        // The share covers the rounding of the sums.
        self.apart_until = gone + 0.999 * gap;
    }

    /// Takes a plane of this normal, of any length, to part the two from the next step on.
    pub(super) fn part_by(&mut self, normal: &Vec3) {
        self.axis = normal * (1.0 / normal.norm());
    }
}

/// All pairs of parts of a rank, those of two particles side by side.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyList {
    pub(crate) pairs: Vec<BodyPair>,
    pub(super) memories: Memories,
    pub(super) found: Contacts,
    pub(super) run: Box<Run>,
}

/// Contacts of the pairs of two particles.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    pub(super) items: Vec<Found>,
    /// Where those of them touch that do not in a point.
    footprints: Vec<ContactPatch>,
}

/// A contact of a pair of a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Place of the pair in its group.
    pub(super) place: usize,
    pub(super) contact: PartContact,
    footprint: Option<u32>,
}

impl Contacts {
    pub(super) fn clear(&mut self) {
        self.items.clear();
        self.footprints.clear();
    }

    /// Adds a contact of the pair at `place` in its group.
    #[inline(always)]
    pub(super) fn push(&mut self, place: usize, contact: PartContact, footprint: Option<ContactPatch>) {
        let footprint = footprint.map(|footprint| {
            self.footprints.push(footprint);
            self.footprints.len() as u32 - 1
        });
        self.items.push(Found { place, contact, footprint });
    }

    /// Where a contact is that is not a point.
    #[inline(always)]
    pub(super) fn footprint(&self, found: &Found) -> Option<&ContactPatch> {
        found.footprint.map(|k| &self.footprints[k as usize])
    }
}

/// Memories of the pairs that touch; pairs apart, the most, stay small.
#[derive(Clone, Debug, Default)]
pub(super) struct Memories {
    items: Vec<ContactMemory>,
    free: Vec<u32>,
}

impl Memories {
    /// What a pair remembers; a new memory if it did not touch.
    #[inline]
    pub(super) fn of(&mut self, pair: &mut BodyPair) -> &mut ContactMemory {
        if pair.memory == BodyPair::APART {
            pair.memory = self.free.pop().unwrap_or_else(|| {
                self.items.push(ContactMemory::default());
                self.items.len() as u32 - 1
            });
            self.items[pair.memory as usize] = ContactMemory::default();
            pair.apart_until = 0.0;
        }
        &mut self.items[pair.memory as usize]
    }

    /// Forgets a pair that is apart.
    pub(super) fn forget(&mut self, pair: &mut BodyPair) {
        if pair.memory != BodyPair::APART {
            self.free.push(pair.memory);
            pair.memory = BodyPair::APART;
        }
    }
}

impl BodyList {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        bytes(&self.pairs) + bytes(&self.memories.items) + bytes(&self.memories.free)
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
