//! All pairs of parts of a rank.

use super::batch::PointBatch;
use super::found::Contacts;
use super::histories::Histories;
use super::pairs::PartPair;
use super::window::Window;
use crate::catalogue::Catalogue;
use crate::contact_history::{ContactHistory, LawHistory};
use crate::memory_use::{heap_bytes, make_room};
use crate::particles::Particles;
use grains_geometry::{Core, Vec3};

/// All pairs of parts of a rank, those of two particles side by side.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartPairList {
    pub(crate) pairs: Vec<PartPair>,
    pub(super) histories: Histories,
    pub(super) found: Contacts,
    pub(super) batch: Box<PointBatch>,
    pub(super) window: Box<Window>,
    /// Whether there has been a pair of parts whose distances are found together.
    pub(super) has_windows: bool,
}

impl PartPairList {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        heap_bytes(&self.pairs) + self.histories.bytes()
    }

    /// Forgets all pairs but the first ones; of others to come it is kept what laws keep, or not.
    pub(crate) fn truncate(&mut self, kept: usize, keep_laws: bool) {
        self.pairs.truncate(kept);
        self.histories.truncate(kept);
        self.histories.keep_laws = keep_laws;
    }

    /// Adds a pair of parts with these cores, with its history if it touched; a plane normal to `axis`, of any length, may separate them.
    pub(crate) fn push(
        &mut self,
        [a, b]: [u32; 2],
        (parts, cores): ([u16; 2], [&Core; 2]),
        axis: &Vec3,
        known: Option<&ContactHistory>,
    ) {
        let separated_until = if known.is_some() { PartPair::TOUCHING } else { 0.0 };
        let place = self.pairs.len() as u32;
        let mut pair = PartPair { a, b, parts, place, axis: Vec3::zeros(), separated_until };
        pair.separate_by(axis);
        self.has_windows |= Window::is_for(cores);
        self.histories.push(cores, known.unwrap_or(&ContactHistory::default()));
        make_room(&mut self.pairs, 1);
        self.pairs.push(pair);
    }

    /// The pairs that touched in the last step and what laws keep of them.
    pub(crate) fn with_laws(&self) -> impl Iterator<Item = (&PartPair, LawHistory)> {
        self.touching_from(0).map(|pair| (pair, self.histories.law(pair)))
    }

    /// The pairs that touched in the last step, from a place in the list on, and their histories.
    pub(crate) fn with_history_from(
        &self,
        first: usize,
        (particles, catalogue): (&Particles, &Catalogue),
    ) -> impl Iterator<Item = (&PartPair, ContactHistory)> {
        self.touching_from(first).map(move |pair| {
            let cores = cores(pair, particles, catalogue);
            (pair, self.histories.of(pair, cores))
        })
    }

    fn touching_from(&self, first: usize) -> impl Iterator<Item = &PartPair> {
        self.pairs[first..].iter().filter(|pair| pair.is_touching())
    }
}

/// Cores of the parts of a pair.
#[inline(always)]
pub(super) fn cores<'a>(pair: &PartPair, particles: &Particles, catalogue: &'a Catalogue) -> [&'a Core; 2] {
    let [a, b] = [pair.a, pair.b].map(|i| catalogue.shape(particles.bodies[i as usize].kind));
    [&a.parts[pair.parts[0] as usize].core, &b.parts[pair.parts[1] as usize].core]
}
