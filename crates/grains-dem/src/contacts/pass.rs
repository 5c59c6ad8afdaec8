//! What a pass over the contacts needs beside the pairs, and what it notes.

use super::load_quanta::LoadQuanta;
use crate::catalogue::Catalogue;
use crate::error::{StepError, vector};
use crate::films::LiquidLedger;
use crate::heat::TouchingParts;
use grains_geometry::Vec3;

/// A pass over contacts that adds their loads.
pub(crate) struct ContactPass<'a> {
    pub(crate) catalogue: &'a Catalogue,
    pub(crate) quanta: LoadQuanta,
    /// Time step (s).
    pub(crate) dt: f64,
    pub(crate) statistics: &'a mut PassStatistics,
    /// What bridges take from walls and leave on them, and how many form and break.
    pub(crate) liquid: &'a mut LiquidLedger,
    /// Parts of bodies that touch, where heat flows between them.
    pub(crate) touching: Option<&'a mut Vec<TouchingParts>>,
}

/// What one pass over the contacts found.
#[derive(Clone, Debug)]
pub(crate) struct PassStatistics {
    /// Contacts whose cores overlap, resolved by the exact penetration routine.
    pub(crate) deep_penetrations: u64,
    /// Largest overlap over the inscribed radius (-).
    deepest: f64,
    limit: f64,
    /// An error met.
    pub(crate) error: Option<StepError>,
}

/// A contact as a message names it.
pub(crate) struct Overlapping {
    /// Identity of the particle.
    pub(crate) id: u64,
    /// The other body.
    pub(crate) other: String,
    /// Smaller inscribed radius (m).
    pub(crate) radius: f64,
    /// Position of the particle (m).
    pub(crate) position: Vec3,
}

impl PassStatistics {
    /// Empty statistics; `limit` is the largest admissible overlap over the inscribed radius.
    pub(crate) fn new(limit: f64) -> Self {
        Self { deep_penetrations: 0, deepest: 0.0, limit, error: None }
    }

    /// Notes an overlap over the inscribed radius (-); one beyond the limit is an error.
    #[inline(always)]
    pub(crate) fn note(&mut self, depth: f64, contact: impl FnOnce() -> Overlapping) {
        if depth > self.deepest {
            self.deepest = depth;
            if depth > self.limit {
                self.fail(depth, &contact());
            }
        }
    }

    #[cold]
    fn fail(&mut self, depth: f64, contact: &Overlapping) {
        self.error = Some(StepError::Overlap {
            id: contact.id,
            other: contact.other.clone(),
            overlap: depth * contact.radius,
            percent: 100.0 * depth,
            limit: 100.0 * self.limit,
            place: vector(&contact.position),
        });
    }

    /// Largest overlap over radius (-).
    pub(crate) fn max_overlap(&self) -> f64 {
        self.deepest
    }
}
