//! All contacts of a step in one list, found as for soft bodies.
//!
//! A soft contact lies midway in the overlap. Here the overlap is an error of the time step, which relocation
//! undoes: each body is hit where it is deepest, the points that relocation brings together.

use super::key::Key;
use crate::catalogue::Catalogue;
use crate::contacts::{Overlapping, PassStatistics, SpherePair};
use crate::narrow_phase::PartContact;
use crate::non_spherical::{self, PartPair};
use crate::particles::Particles;
use crate::verlet::VerletLists;
use crate::walls::{self, WallMeeting, WallScene};
use grains_geometry::Vec3;

/// The second body of a contact.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Counterpart {
    /// A particle of this rank's arrays, and its deepest point from its centre of mass (m).
    Particle(u32, Vec3),
    /// A wall.
    Wall {
        wall: u16,
        /// Contact point (m).
        point: Vec3,
        /// Velocity of the wall there (m/s).
        velocity: Vec3,
    },
}

/// Two bodies that touch; at least one of them is an owned particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HardContact {
    pub(crate) key: Key,
    /// First body, of two particles the one of lower identity.
    pub(crate) a: u32,
    pub(crate) counterpart: Counterpart,
    /// Unit normal from the first body to the second.
    pub(crate) normal: Vec3,
    /// Overlap (m), positive.
    pub(crate) overlap: f64,
    /// Its deepest point from its centre of mass (m).
    pub(crate) arm: Vec3,
    /// Restitution (-).
    pub(crate) restitution: f64,
    /// Coulomb friction coefficient (-).
    pub(crate) friction: f64,
}

/// Fills `contacts` with all contacts at the present positions.
pub(crate) fn collect(
    contacts: &mut Vec<HardContact>,
    particles: &Particles,
    neighbours: &mut VerletLists,
    scene: &WallScene,
    catalogue: &Catalogue,
    statistics: &mut PassStatistics,
) {
    contacts.clear();
    for pair in &neighbours.spheres {
        contacts.extend(of_spheres(pair, particles, catalogue, statistics));
    }
    let met = non_spherical::meet(particles, &mut neighbours.part_pairs, catalogue, |pair, contact, _| {
        contacts.push(of_bodies(pair, contact, particles, catalogue, statistics));
    });
    if let Err(error) = met {
        statistics.error = Some(error);
    }
    let met = walls::meet(particles, &mut neighbours.walls, scene, catalogue, |meeting| {
        contacts.push(of_wall(meeting, particles, scene, catalogue, statistics));
    });
    if let Err(error) = met {
        statistics.error = Some(error);
    }
}

fn of_spheres(
    pair: &SpherePair,
    particles: &Particles,
    catalogue: &Catalogue,
    statistics: &mut PassStatistics,
) -> Option<HardContact> {
    let (mut a, mut b) = (pair.a, pair.b);
    if particles.ids[a as usize] > particles.ids[b as usize] {
        std::mem::swap(&mut a, &mut b);
    }
    let (one, two) = (&particles.bodies[a as usize], &particles.bodies[b as usize]);
    let (separation, radii) = (two.position - one.position, one.radius + two.radius);
    let square = separation.norm_squared();
    if square >= radii * radii {
        return None;
    }
    let distance = square.sqrt();
    let (normal, overlap) = (separation * (1.0 / distance), radii - distance);
    note(statistics, overlap, one.radius.min(two.radius), particles, a, || {
        format!("particle {}", particles.ids[b as usize])
    });
    let arms = [normal * one.radius, normal * -two.radius];
    Some(of_particles([a, b], [0, 0], normal, overlap, arms, (particles, catalogue)))
}

fn of_bodies(
    pair: &PartPair,
    contact: &PartContact,
    particles: &Particles,
    catalogue: &Catalogue,
    statistics: &mut PassStatistics,
) -> HardContact {
    let (a, b) = (pair.a as usize, pair.b as usize);
    statistics.deep_penetrations += u64::from(contact.is_deep_penetration);
    let radius = catalogue.smaller_inscribed_radius([a, b].map(|i| &particles.bodies[i]));
    note(statistics, contact.overlap, radius, particles, pair.a, || format!("particle {}", particles.ids[b]));
    let separation = particles.bodies[b].position - particles.bodies[a].position;
    let half = contact.normal * (0.5 * contact.overlap);
    let arms = [contact.point + half, contact.point - half - separation];
    let of = (particles, catalogue);
    of_particles([pair.a, pair.b], pair.parts, contact.normal, contact.overlap, arms, of)
}

fn of_particles(
    [a, b]: [u32; 2],
    parts: [u16; 2],
    normal: Vec3,
    overlap: f64,
    arms: [Vec3; 2],
    (particles, catalogue): (&Particles, &Catalogue),
) -> HardContact {
    let kind = |i: u32| particles.bodies[i as usize].kind;
    let law = catalogue.contacts.law(kind(a).material, kind(b).material);
    HardContact {
        key: Key::of_pair([a, b].map(|i| particles.ids[i as usize]), parts),
        a,
        counterpart: Counterpart::Particle(b, arms[1]),
        normal,
        overlap,
        arm: arms[0],
        restitution: law.restitution,
        friction: law.friction,
    }
}

fn of_wall(
    meeting: &WallMeeting,
    particles: &Particles,
    scene: &WallScene,
    catalogue: &Catalogue,
    statistics: &mut PassStatistics,
) -> HardContact {
    let WallMeeting { pair, image, normal, overlap, arm, point, velocity, .. } = *meeting;
    let (i, wall) = (pair.particle as usize, &scene.walls[pair.wall as usize]);
    let body = &particles.bodies[i];
    let inscribed = catalogue.inscribed_radius(body);
    let half = normal * (0.5 * overlap);
    note(statistics, overlap, inscribed, particles, pair.particle, || format!("wall `{}`", wall.name));
    let law = catalogue.contacts.law(body.kind.material, wall.material);
    HardContact {
        key: Key::of_wall(particles.ids[i], [pair.wall, pair.surface, pair.part], pair.element, image),
        a: pair.particle,
        counterpart: Counterpart::Wall { wall: pair.wall, point: point - half, velocity },
        normal,
        overlap,
        arm: arm + half,
        restitution: law.restitution,
        friction: law.friction,
    }
}

/// Notes an overlap (m) of particle `a` with another body, on a radius (m); beyond the limit it is an error.
fn note(
    statistics: &mut PassStatistics,
    overlap: f64,
    radius: f64,
    particles: &Particles,
    a: u32,
    other: impl FnOnce() -> String,
) {
    let (id, position) = (particles.ids[a as usize], particles.bodies[a as usize].position);
    statistics.note(overlap / radius, || Overlapping { id, other: other(), radius, position });
}
