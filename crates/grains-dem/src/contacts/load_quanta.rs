//! How loads are rounded so that their sums are exact.

use grains_domain::Quantum;
use grains_geometry::Vec3;

/// How far contact loads may go before sums lose exactness, and how they are rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadQuanta {
    force: Quantum,
    torque: Quantum,
    /// Largest admissible component of a force sum (N).
    pub(crate) largest_force: f64,
}

impl LoadQuanta {
    /// Quanta for this largest force (N) of a contact or bond of bodies up to this bounding radius (m), with a margin of some ten
    /// such contacts in one direction.
    ///
    /// Sums over all contacts of a wall that a load of `wall_load` (N) moves are
    /// exact as well, with a margin for what stops it. A quantum changes a velocity by some
    /// 10⁻¹³ m/s per step, about what f64 itself does at metres per second.
    pub(crate) fn new(largest_of_one: f64, largest_radius: f64, wall_load: f64) -> Self {
        let largest = (32.0 * largest_of_one).max(256.0 * wall_load);
        let (force, torque) =
            (Quantum::for_sums_below(largest), Quantum::for_sums_below(largest * largest_radius));
        Self { force, torque, largest_force: 0.25 * largest }
    }

    /// The multiples to which forces (N) and torques (N m) are rounded.
    pub(crate) fn quanta(&self) -> [f64; 2] {
        [self.force.size(), self.torque.size()]
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
