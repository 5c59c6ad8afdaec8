//! What a pass over the contacts notes: the largest overlap and the first failure.

use crate::error::StepError;

/// Tally of one pass over the contacts.
#[derive(Clone, Debug)]
pub(crate) struct Tally {
    /// Contacts whose shrunken cores met, resolved by the exact penetration routine.
    pub(crate) cores_met: u64,
    /// Largest overlap over the inscribed radius (-).
    deepest: f64,
    limit: f64,
    /// An error met.
    pub(crate) error: Option<StepError>,
}

impl Tally {
    /// Empty tally; `limit` is the largest admissible overlap over the inscribed radius.
    pub(crate) fn new(limit: f64) -> Self {
        Self { cores_met: 0, deepest: 0.0, limit, error: None }
    }

    /// Notes an overlap over the inscribed radius (-); returns whether it is the deepest yet and beyond the limit.
    #[inline(always)]
    pub(crate) fn note(&mut self, depth: f64) -> bool {
        if depth > self.deepest {
            self.deepest = depth;
            return depth > self.limit;
        }
        false
    }

    /// Largest overlap over radius (-).
    pub(crate) fn largest_overlap(&self) -> f64 {
        self.deepest
    }

    /// The limit (-).
    pub(crate) fn limit(&self) -> f64 {
        self.limit
    }
}
