//! Contacts of particles that touch in one point each, of one pair of materials, evaluated together.

use super::histories::Histories;
use super::pairs::PartPair;
use super::point_contact::{PartPoint, arms};
use crate::catalogue::Catalogue;
use crate::contact_history::LawHistory;
use crate::contacts::{
    BLOCK, Batch, BatchedContact, Columns, ContactColumns, ContactLoads, ContactPass, LoadQuanta, set,
    vector_at,
};
use crate::narrow_phase::{PartContact, Pose};
use crate::particles::Body;
use grains_contact::PreparedLaw;
use grains_geometry::Vec3;
use multiversion::multiversion;

/// Contact points of two bodies, column by column.
#[derive(Clone, Debug)]
struct PointColumns {
    /// Normal (-) and overlap (m).
    normals: Columns<4>,
    /// Contact point from the centre of the first body, and inverse of the effective mass there (1/kg).
    arms: Columns<4>,
    /// Contact point from the centre of the second body, and smaller inscribed radius (m).
    other_arms: Columns<4>,
    /// Velocities (m/s); with that of the first the sum of the largest inverse moments of inertia (1/(kg m²)), with that
    /// of the second the effective radius (m).
    velocities: [Columns<4>; 2],
    /// Angular velocities (rad/s).
    spins: [Columns<3>; 2],
}

impl Default for PointColumns {
    fn default() -> Self {
        let (three, four) = ([[0.0; BLOCK]; 3], [[0.0; BLOCK]; 4]);
        Self { normals: four, arms: four, other_arms: four, velocities: [four; 2], spins: [three; 2] }
    }
}

impl PointColumns {
    /// Sets the point in which two bodies touch, at its arms from their centres of mass (m).
    #[inline(always)]
    fn set(
        &mut self,
        k: usize,
        (bodies, found, arms): ([&Body; 2], &PartContact, &[Vec3; 2]),
        [inverse_mass, radius, inverse_inertia, effective_radius]: [f64; 4],
    ) {
        let (n, [arm, other]) = (&found.normal, arms);
        set(&mut self.normals, k, [n.x, n.y, n.z, found.overlap]);
        set(&mut self.arms, k, [arm.x, arm.y, arm.z, inverse_mass]);
        set(&mut self.other_arms, k, [other.x, other.y, other.z, radius]);
        for (side, last) in [inverse_inertia, effective_radius].into_iter().enumerate() {
            let (v, w) = (&bodies[side].velocity, &bodies[side].angular_velocity);
            set(&mut self.velocities[side], k, [v.x, v.y, v.z, last]);
            set(&mut self.spins[side], k, [w.x, w.y, w.z]);
        }
    }
}

impl ContactColumns for PointColumns {
    type Point = PartPoint;

    #[inline(always)]
    fn contact(&self, k: usize) -> BatchedContact<PartPoint> {
        let overlap = self.normals[3][k];
        let point = PartPoint {
            normal: vector_at(&self.normals, k),
            overlap,
            arms: [vector_at(&self.arms, k), vector_at(&self.other_arms, k)],
            velocities: [0, 1].map(|side| vector_at(&self.velocities[side], k)),
            spins: [0, 1].map(|side| vector_at(&self.spins[side], k)),
            inverse_inertia: self.velocities[0][3][k],
        };
        let effective_mass = 1.0 / self.arms[3][k];
        let effective_radius = self.velocities[1][3][k];
        BatchedContact { point, effective_mass, effective_radius, depth: overlap / self.other_arms[3][k] }
    }
}

/// Contacts that wait for others of the same two materials.
#[derive(Clone, Debug, Default)]
pub(super) struct PointBatch {
    batch: Batch<PointColumns>,
    law: Option<PreparedLaw>,
    materials: [u16; 2],
}

impl PointBatch {
    /// Whether a contact of two bodies can be taken.
    #[inline(always)]
    pub(super) fn has_room_for(&self, bodies: [&Body; 2]) -> bool {
        self.batch.len == 0 || self.batch.len < BLOCK && self.materials == materials(bodies)
    }

    /// Takes the contact of the pair at `place`.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        (place, found): (usize, &PartContact),
        [a, b]: [&Body; 2],
        poses: &[Pose; 2],
        (displacement, law_history, films): (&Vec3, Option<&LawHistory>, f64),
        catalogue: &Catalogue,
    ) {
        let law = catalogue.contacts.prepared(a.kind.material, b.kind.material);
        if self.batch.len == 0 {
            self.materials = materials([a, b]);
            self.law = Some(*law);
        }
        let arms = arms([a, b], found);
        let inverse_mass = poses[0].inverse_effective_mass(a.contact_mass(), &arms[0], &found.normal)
            + poses[1].inverse_effective_mass(b.contact_mass(), &arms[1], &found.normal);
        let radius = poses[0].inscribed_radius().min(poses[1].inscribed_radius());
        let of_law = [catalogue.inverse_inertia([a, b], law), catalogue.effective_radius([a, b], law)];
        let numbers = [inverse_mass, radius, of_law[0], of_law[1]];
        self.batch.columns.set(self.batch.len, ([a, b], found, &arms), numbers);
        self.batch.push(place as u32, displacement);
        if let Some(history) = law_history {
            self.batch.set_law_history(history);
        }
        self.batch.set_films(films);
    }

    /// Finds the loads of all contacts taken, hands each to `visit` with its pair and the overlap over the smaller
    /// inscribed radius (-), and begins anew.
    #[inline(always)]
    pub(super) fn finish(
        &mut self,
        (pairs, histories): (&mut [PartPair], &mut Histories),
        pass: &mut ContactPass,
        mut visit: impl FnMut(&mut ContactPass, &PartPair, f64, ContactLoads),
    ) {
        let Some(law) = self.law.take() else { return };
        evaluate(&mut self.batch, &law, &pass.quanta, pass.dt);
        for k in 0..self.batch.len.min(BLOCK) {
            let pair = &mut pairs[self.batch.pair[k] as usize];
            histories.springs(pair).tangential_displacement = self.batch.tangential_displacement(k);
            histories.set_law(pair, &self.batch.law_history(k));
            visit(pass, pair, self.batch.depth(k), self.batch.loads(k));
        }
        self.batch.len = 0;
    }
}

/// Materials of two bodies, in one order for either.
#[inline(always)]
fn materials([a, b]: [&Body; 2]) -> [u16; 2] {
    let (a, b) = (a.kind.material, b.kind.material);
    [a.min(b), a.max(b)]
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn evaluate(batch: &mut Batch<PointColumns>, law: &PreparedLaw, quanta: &LoadQuanta, dt: f64) {
    batch.evaluate(law, quanta, dt);
}
