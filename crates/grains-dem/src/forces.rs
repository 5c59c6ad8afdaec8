//! What all contact loops share: exact sums, and the record of the worst overlap.

use crate::{ContactTable, StepError};
use grains_domain::Lattice;
use grains_geometry::Vec3;

/// How far contact loads may go before sums lose exactness, and how they are rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadLattice {
    force: Lattice,
    torque: Lattice,
    /// Largest admissible component of a force sum (N).
    pub(crate) largest_force: f64,
}

impl LoadLattice {
    /// Lattice for the stiffest contact at the overlap limit on the largest body, with a margin
    /// of some ten such contacts in one direction.
    ///
    /// `overlap` is the overlap limit over the radius. A lattice spacing changes a velocity by some
    /// 10⁻¹³ m/s per step, about what f64 itself does at metres per second.
    pub(crate) fn new(contacts: &ContactTable, largest_radius: f64, overlap: f64) -> Self {
        let stiffness = contacts.laws().map(|law| law.normal_stiffness).fold(f64::MIN_POSITIVE, f64::max);
        let largest = 32.0 * stiffness * overlap * largest_radius;
        let (force, torque) =
            (Lattice::for_sums_below(largest), Lattice::for_sums_below(largest * largest_radius));
        Self { force, torque, largest_force: 0.25 * largest }
    }

    /// The multiples to which forces (N) and torques (N m) are rounded.
    pub(crate) fn quanta(&self) -> [f64; 2] {
        [self.force.spacing(), self.torque.spacing()]
    }

    #[inline(always)]
    pub(crate) fn force(&self, f: &Vec3) -> Vec3 {
        Vec3::new(self.force.round(f.x), self.force.round(f.y), self.force.round(f.z))
    }

    #[inline(always)]
    pub(crate) fn torque(&self, t: &Vec3) -> Vec3 {
        Vec3::new(self.torque.round(t.x), self.torque.round(t.y), self.torque.round(t.z))
    }
}

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
