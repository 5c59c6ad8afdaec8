//! Contacts of bodies that touch in one point each, under one law: their forces are found several at a time.

use super::pairs::{BodyPair, Memories};
use super::point_contact::Touch;
use crate::catalogue::Catalogue;
use crate::contacts::{BLOCK, Columns, LoadLattice, set, vector_at, whole_lanes};
use crate::narrow_phase::{PartContact, Pose};
use crate::particles::{Body, Load};
use grains_contact::PreparedLaw;
use grains_geometry::Vec3;
use multiversion::multiversion;

/// Contacts under one law, side by side: what the law needs, and what it answers.
#[derive(Clone, Debug)]
pub(super) struct Run {
    len: usize,
    law: Option<PreparedLaw>,
    materials: [u16; 2],
    /// Place of the pair.
    pair: [u32; BLOCK],
    /// Normal (-) and overlap (m).
    normals: Columns<4>,
    /// Contact point from the centre of the first body, and inverse of the mass felt there (1/kg).
    arms: Columns<4>,
    /// Contact point from the centre of the second body, and smaller inscribed radius (m).
    other_arms: Columns<4>,
    /// Velocities (m/s).
    velocities: [Columns<3>; 2],
    /// Angular velocities (rad/s).
    spins: [Columns<3>; 2],
    /// Tangential springs (m), before and after.
    springs: Columns<3>,
    /// Force on the first body (N).
    forces: Columns<3>,
    /// Torques (N m).
    torques: [Columns<3>; 2],
}

impl Default for Run {
    fn default() -> Self {
        let (three, four) = ([[0.0; BLOCK]; 3], [[0.0; BLOCK]; 4]);
        Self {
            len: 0,
            law: None,
            materials: [0; 2],
            pair: [0; BLOCK],
            normals: four,
            arms: four,
            other_arms: four,
            velocities: [three; 2],
            spins: [three; 2],
            springs: three,
            forces: three,
            torques: [three; 2],
        }
    }
}

impl Run {
    /// Whether a contact of two bodies can be taken.
    #[inline(always)]
    pub(super) fn has_room_for(&self, bodies: [&Body; 2]) -> bool {
        self.len == 0 || self.len < BLOCK && self.materials == materials(bodies)
    }

    /// Takes the contact of the pair at `place`.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        (place, found): (usize, &PartContact),
        [a, b]: [&Body; 2],
        poses: &[Pose; 2],
        spring: &Vec3,
        catalogue: &Catalogue,
    ) {
        let k = self.len;
        if k == 0 {
            self.materials = materials([a, b]);
            self.law = Some(*catalogue.contacts.prepared(self.materials[0], self.materials[1]));
        }
        self.pair[k] = place as u32;
        let Touch { normal, overlap, arms: [arm, other_arm], velocities, spins } = Touch::of([a, b], found);
        let inverse = poses[0].inverse_mass_along(a.mass_felt(), &arm, &normal)
            + poses[1].inverse_mass_along(b.mass_felt(), &other_arm, &normal);
        let radius = poses[0].inscribed_radius().min(poses[1].inscribed_radius());
        set(&mut self.normals, k, [normal.x, normal.y, normal.z, overlap]);
        set(&mut self.arms, k, [arm.x, arm.y, arm.z, inverse]);
        set(&mut self.other_arms, k, [other_arm.x, other_arm.y, other_arm.z, radius]);
        for side in 0..2 {
            set(&mut self.velocities[side], k, velocities[side].into());
            set(&mut self.spins[side], k, spins[side].into());
        }
        set(&mut self.springs, k, (*spring).into());
        self.len += 1;
    }

    /// Finds the forces of all contacts taken, hands each to `visit` with its pair, the overlap over the smaller inscribed
    /// radius (-) and the loads on both bodies, and begins anew.
    #[inline(always)]
    pub(super) fn finish(
        &mut self,
        (pairs, memories): (&mut [BodyPair], &mut Memories),
        lattice: &LoadLattice,
        dt: f64,
        mut visit: impl FnMut(&BodyPair, f64, [Load; 2]),
    ) {
        let Some(law) = self.law.take() else { return };
        evaluate(self, &law, lattice, dt);
        for k in 0..self.len.min(BLOCK) {
            let pair = &mut pairs[self.pair[k] as usize];
            memories.of(pair).spring = vector_at(&self.springs, k);
            let force = vector_at(&self.forces, k);
            let loads = [
                Load { force, torque: vector_at(&self.torques[0], k) },
                Load { force: -force, torque: vector_at(&self.torques[1], k) },
            ];
            visit(pair, self.normals[3][k] / self.other_arms[3][k], loads);
        }
        self.len = 0;
    }
}

/// Materials of two bodies, in one order for either.
#[inline(always)]
fn materials([a, b]: [&Body; 2]) -> [u16; 2] {
    let (a, b) = (a.kind.material, b.kind.material);
    [a.min(b), a.max(b)]
}

/// Forces and torques of all contacts; the same arithmetic as one by one, in lanes of any width.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn evaluate(run: &mut Run, law: &PreparedLaw, lattice: &LoadLattice, dt: f64) {
    let Run { normals, arms, other_arms, velocities, spins, springs, forces, torques, .. } = run;
    for k in whole_lanes(run.len) {
        let touch = Touch {
            normal: vector_at(normals, k),
            overlap: normals[3][k],
            arms: [vector_at(arms, k), vector_at(other_arms, k)],
            velocities: [0, 1].map(|side| vector_at(&velocities[side], k)),
            spins: [0, 1].map(|side| vector_at(&spins[side], k)),
        };
        let mut spring = vector_at(springs, k);
        let [load, other] = touch.loads(&law.at(1.0 / arms[3][k]), &mut spring, lattice, dt);
        set(springs, k, spring.into());
        set(forces, k, load.force.into());
        set(&mut torques[0], k, load.torque.into());
        set(&mut torques[1], k, other.torque.into());
    }
}
