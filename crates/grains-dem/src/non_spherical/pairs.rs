//! Pairs of parts that may touch.

use grains_geometry::Vec3;

/// A pair of parts that may touch; `a` is the particle of lower id.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartPair {
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) parts: [u16; 2],
    /// Place in the list, and of its history.
    pub(super) place: u32,
    /// Unit normal of a plane that separated the two when they were last checked; it changes the time of the answer, not
    /// the answer.
    pub(crate) axis: Vec3,
    /// Path length of both particles together since the lists were built (m) up to which they are separated, or
    /// [`PartPair::TOUCHING`].
    pub(super) separated_until: f64,
}

impl PartPair {
    /// Of a pair that touched in the last step: it is looked at in every step.
    pub(super) const TOUCHING: f64 = f64::NEG_INFINITY;

    /// Whether two pairs are of the same two particles.
    pub(super) fn is_of_same_particles(&self, other: &Self) -> bool {
        (self.a, self.b) == (other.a, other.b)
    }

    /// Number of pairs that follow each other from this one on, the first of the list, and are of the same particles.
    #[inline(always)]
    pub(super) fn number_of_same_particles(&self, list: &[Self]) -> usize {
        list.iter().position(|pair| !pair.is_of_same_particles(self)).unwrap_or(list.len())
    }

    /// Whether the pair touched in the last step.
    pub(super) fn is_touching(&self) -> bool {
        self.separated_until == Self::TOUCHING
    }

    /// Forgets that the two touched.
    pub(super) fn part(&mut self) {
        self.separated_until = self.separated_until.max(0.0);
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
