//! Contacts of spheres with walls of one pair of materials, evaluated together.

use super::pairs::{WallPair, WallScene};
use super::surface_contact::SphereTouch;
use super::wall::WallSums;
use super::wall_point::WallPoint;
use crate::contact_history::LawHistory;
use crate::contacts::{
    BLOCK, Batch, BatchedContact, Columns, ContactColumns, ContactPass, ContactPoint, LoadQuanta,
    Overlapping, set, vector_at,
};
use crate::particles::{Body, Particles};
use grains_contact::PreparedLaw;
use grains_geometry::Vec3;
use multiversion::multiversion;

/// Spheres and the walls they touch, column by column.
#[derive(Clone, Debug)]
struct SphereWallColumns {
    /// Normal into the wall (-) and overlap (m).
    normals: Columns<4>,
    /// Velocities of the centre and of the wall at the contact point (m/s), with the mass (kg) and the radius (m).
    velocities: [Columns<4>; 2],
    /// Angular velocities of both (rad/s).
    spins: [Columns<3>; 2],
}

impl Default for SphereWallColumns {
    fn default() -> Self {
        let (three, four) = ([[0.0; BLOCK]; 3], [[0.0; BLOCK]; 4]);
        Self { normals: four, velocities: [four; 2], spins: [three; 2] }
    }
}

impl ContactColumns for SphereWallColumns {
    type Point = WallPoint;

    #[inline(always)]
    fn contact(&self, k: usize) -> BatchedContact<WallPoint> {
        let Self { normals, velocities, spins } = self;
        let (normal, overlap) = (vector_at(normals, k), normals[3][k]);
        let [mass, radius] = [0, 1].map(|side| velocities[side][3][k]);
        let point = WallPoint {
            normal,
            overlap,
            arm: normal * (radius - 0.5 * overlap),
            velocities: [0, 1].map(|side| vector_at(&velocities[side], k)),
            spins: [0, 1].map(|side| vector_at(&spins[side], k)),
            inverse_inertia: 1.0 / (0.4 * mass * (radius * radius)),
        };
        BatchedContact { point, effective_mass: mass, effective_radius: radius, depth: overlap / radius }
    }
}

/// Contacts that wait for others of the same two materials.
#[derive(Clone, Debug)]
pub(super) struct SphereBatch {
    batch: Batch<SphereWallColumns>,
    /// Contact points (m).
    points: [Vec3; BLOCK],
    law: Option<PreparedLaw>,
    materials: [u16; 2],
}

impl Default for SphereBatch {
    fn default() -> Self {
        Self { batch: Batch::default(), points: [Vec3::zeros(); BLOCK], law: None, materials: [0; 2] }
    }
}

impl SphereBatch {
    /// Whether a contact of a body and a wall of these materials can be taken.
    #[inline(always)]
    pub(super) fn has_room_for(&self, materials: [u16; 2]) -> bool {
        self.batch.len == 0 || self.batch.len < BLOCK && self.materials == materials
    }

    /// Takes the contact of the pair at `place`, whose body has its image at `center` (m).
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        (place, pair, history): (usize, &WallPair, Option<&LawHistory>),
        (body, center): (&Body, &Vec3),
        touch: &SphereTouch,
        scene: &WallScene,
        (materials, law, films): ([u16; 2], &PreparedLaw, f64),
    ) {
        if self.batch.len == 0 {
            (self.materials, self.law) = (materials, Some(*law));
        }
        let (state, len) = (&scene.states[pair.wall as usize], self.batch.len);
        let normal = state.to_world(&touch.normal);
        let point = center + normal * (body.radius - 0.5 * touch.overlap);
        let (v, wall_v) = (body.velocity, state.velocity_at(&point));
        let columns = &mut self.batch.columns;
        set(&mut columns.normals, len, [normal.x, normal.y, normal.z, touch.overlap]);
        set(&mut columns.velocities[0], len, [v.x, v.y, v.z, body.mass]);
        set(&mut columns.velocities[1], len, [wall_v.x, wall_v.y, wall_v.z, body.radius]);
        set(&mut columns.spins[0], len, body.angular_velocity.into());
        set(&mut columns.spins[1], len, state.angular_velocity.into());
        self.points[len] = point;
        self.batch.push(place as u32, &pair.tangential_displacement);
        if let Some(history) = history {
            self.batch.set_law_history(history);
            self.batch.set_films(films);
        }
    }

    /// Adds the loads of all contacts taken, and begins anew.
    pub(super) fn finish(
        &mut self,
        particles: &mut Particles,
        (pairs, laws): (&mut [WallPair], &mut [LawHistory]),
        (scene, sums): (&WallScene, &mut WallSums),
        pass: &mut ContactPass,
    ) {
        let Some(law) = self.law.take() else { return };
        let quanta = pass.quanta;
        evaluate(&mut self.batch, &law, &quanta, pass.dt);
        for k in 0..self.batch.len.min(BLOCK) {
            let place = self.batch.pair[k] as usize;
            let pair = &mut pairs[place];
            pair.tangential_displacement = self.batch.tangential_displacement(k);
            if let Some(history) = laws.get_mut(place) {
                *history = self.batch.law_history(k);
            }
            let (i, loads) = (pair.particle as usize, self.batch.loads(k));
            let load = &mut particles.loads[i];
            load.force += loads.force;
            load.torque += loads.torques[0];
            sums.add(pair.wall, &loads, &self.points[k], &quanta);
            if sums.sliding.counts(pair.wall) {
                let encounter = self.batch.columns.contact(k).point.encounter();
                sums.sliding.note((pair, pair.element), &encounter, &loads.force, pass.dt);
            }
            pass.statistics.note(self.batch.depth(k), || overlapping(particles, pair, scene));
        }
        self.batch.len = 0;
    }
}

#[cold]
fn overlapping(particles: &Particles, pair: &WallPair, scene: &WallScene) -> Overlapping {
    let i = pair.particle as usize;
    Overlapping {
        id: particles.ids[i],
        other: format!("wall `{}`", scene.walls[pair.wall as usize].name),
        radius: particles.bodies[i].radius,
        position: particles.bodies[i].position,
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn evaluate(batch: &mut Batch<SphereWallColumns>, law: &PreparedLaw, quanta: &LoadQuanta, dt: f64) {
    batch.evaluate(law, quanta, dt);
}
