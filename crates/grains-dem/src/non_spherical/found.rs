//! Contacts found in a group of pairs.

use crate::narrow_phase::PartContact;
use grains_geometry::{ContactPatch, Simplex};

/// Contacts of the pairs of two particles.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    pub(super) items: Vec<Found>,
    /// Where those of them touch that do not in a point.
    footprints: Vec<ContactPatch>,
    /// Room for the simplex of the query of a pair.
    pub(super) simplex: Simplex,
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
