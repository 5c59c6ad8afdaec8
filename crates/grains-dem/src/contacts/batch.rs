//! Contacts of one pair of materials, evaluated several at a time in the lanes of the processor.

use super::lanes::{BLOCK, Columns, set, vector_at, whole_lanes};
use super::load_quanta::LoadQuanta;
use super::loads::{ContactLoads, ContactPoint};
use grains_contact::PreparedLaw;
use grains_geometry::Vec3;

/// What is known of the contacts of a batch, column by column.
pub(crate) trait ContactColumns {
    type Point: ContactPoint;

    /// Contact `k` of the batch.
    fn contact(&self, k: usize) -> BatchedContact<Self::Point>;
}

/// A contact of a batch.
pub(crate) struct BatchedContact<Point> {
    pub(crate) point: Point,
    /// Effective mass at the contact point (kg).
    pub(crate) effective_mass: f64,
    /// Overlap over the smaller inscribed radius (-).
    pub(crate) depth: f64,
}

/// Contacts under one law, side by side: what the law needs, and what it answers.
#[derive(Clone, Debug)]
pub(crate) struct Batch<C> {
    pub(crate) len: usize,
    /// Place of the pair in its list.
    pub(crate) pair: [u32; BLOCK],
    pub(crate) columns: C,
    /// Tangential displacements (m), before and after.
    tangential_displacements: Columns<3>,
    /// Angles rolled (rad), before and after.
    rolling_angles: Columns<3>,
    /// Force on the first body (N).
    forces: Columns<3>,
    /// Torques (N m).
    torques: [Columns<3>; 2],
    /// Overlap over the smaller inscribed radius (-).
    depth: [f64; BLOCK],
}

impl<C: Default> Default for Batch<C> {
    fn default() -> Self {
        let three = [[0.0; BLOCK]; 3];
        Self {
            len: 0,
            pair: [0; BLOCK],
            columns: C::default(),
            tangential_displacements: three,
            rolling_angles: three,
            forces: three,
            torques: [three; 2],
            depth: [0.0; BLOCK],
        }
    }
}

impl<C> Batch<C> {
    /// Adds a contact, whose columns are set for place `len`.
    #[inline(always)]
    pub(crate) fn push(&mut self, pair: u32, tangential_displacement: &Vec3) {
        self.pair[self.len] = pair;
        set(&mut self.tangential_displacements, self.len, (*tangential_displacement).into());
        self.len += 1;
    }

    /// Sets the angle rolled (rad) of the contact added last, for a law that resists rolling.
    #[inline(always)]
    pub(crate) fn set_rolling_angle(&mut self, angle: &Vec3) {
        set(&mut self.rolling_angles, self.len - 1, (*angle).into());
    }

    /// Angle rolled (rad) of contact `k` after the step.
    #[inline(always)]
    pub(crate) fn rolling_angle(&self, k: usize) -> Vec3 {
        vector_at(&self.rolling_angles, k)
    }

    /// Tangential displacement (m) of contact `k` after the step.
    #[inline(always)]
    pub(crate) fn tangential_displacement(&self, k: usize) -> Vec3 {
        vector_at(&self.tangential_displacements, k)
    }

    /// Loads of contact `k`.
    #[inline(always)]
    pub(crate) fn loads(&self, k: usize) -> ContactLoads {
        let torques = [vector_at(&self.torques[0], k), vector_at(&self.torques[1], k)];
        ContactLoads { force: vector_at(&self.forces, k), torques }
    }

    /// Overlap over the smaller inscribed radius of contact `k` (-).
    #[inline(always)]
    pub(crate) fn depth(&self, k: usize) -> f64 {
        self.depth[k]
    }
}

impl<C: ContactColumns> Batch<C> {
    /// Finds the loads of all contacts; the same arithmetic as one by one, in lanes of any width.
    #[inline(always)]
    pub(crate) fn evaluate(&mut self, law: &PreparedLaw, quanta: &LoadQuanta, dt: f64) {
        if law.resists_rolling() {
            self.evaluate_rolling::<true>(law, quanta, dt);
        } else {
            self.evaluate_rolling::<false>(law, quanta, dt);
        }
    }

    /// The same for laws that resist rolling, or do not.
    #[inline(always)]
    fn evaluate_rolling<const ROLLING: bool>(&mut self, law: &PreparedLaw, quanta: &LoadQuanta, dt: f64) {
        let Self { columns, tangential_displacements, rolling_angles, forces, torques, depth, .. } = self;
        for k in whole_lanes(self.len) {
            let contact = columns.contact(k);
            let mut displacement = vector_at(tangential_displacements, k);
            let law = law.at(contact.effective_mass);
            let mut loads = ContactLoads::of(&contact.point, &law, &mut displacement, quanta, dt);
            if ROLLING {
                let mut angle = vector_at(rolling_angles, k);
                let rolled = (&contact.point.rolling(), &mut angle);
                loads.add_rolling(&contact.point.encounter(), &law, rolled, quanta, dt);
                set(rolling_angles, k, angle.into());
            }
            set(tangential_displacements, k, displacement.into());
            set(forces, k, loads.force.into());
            set(&mut torques[0], k, loads.torques[0].into());
            set(&mut torques[1], k, loads.torques[1].into());
            depth[k] = contact.depth;
        }
    }
}
