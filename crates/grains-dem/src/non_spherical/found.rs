//! Contacts found in a group of pairs.

use crate::catalogue::FaceContact;
use crate::narrow_phase::{PartContact, PlacedPart, contact_patch};
use grains_geometry::{ContactPatch, Simplex, Vec3};

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

    /// Takes the contact, its point from the centre of the first part, of two parts `between` (m) apart, the pair at `place` in its group.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        place: usize,
        mut contact: PartContact,
        [a, b]: [&PlacedPart; 2],
        between: &Vec3,
        faces: FaceContact,
    ) {
        let touches = contact.overlap > 0.0;
        let is_multi_point = touches && faces == FaceContact::MultiPoint && a.vertices.is_none();
        let footprint = is_multi_point
            .then(|| {
                let placement = a.placement(&b.rotation, b.scale, between);
                contact_patch(a, b.core, &placement, b.crust, &mut contact)
            })
            .flatten();
        self.push(place, contact, &a.offset, footprint);
    }

    /// Adds a contact, its point from the centre of the first part, which is at `offset` from the centre of mass of its particle (m).
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        place: usize,
        mut contact: PartContact,
        offset: &Vec3,
        footprint: Option<ContactPatch>,
    ) {
        contact.point += offset;
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
