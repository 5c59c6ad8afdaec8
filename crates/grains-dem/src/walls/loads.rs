//! Loads of wall contacts: the law of particles, against a body of infinite mass.

use super::contacts::{find_contacts, not_found};
use super::pairs::{WallList, WallPair, WallScene};
use super::surface_contact::SurfaceContact;
use super::wall::WallLoad;
use crate::catalogue::Catalogue;
use crate::contacts::{LoadLattice, Tally};
use crate::error::{StepError, vector};
use crate::narrow_phase::Pose;
use crate::particles::{Load, Particles};
use grains_contact::{Coefficients, Contact, Spread};
use grains_geometry::{Footprint, Vec3};
use std::ops::Range;

/// Adds the loads of all wall contacts to particles and walls.
pub(crate) fn add_forces(
    particles: &mut Particles,
    list: &mut WallList,
    scene: &WallScene,
    catalogue: &Catalogue,
    lattice: &LoadLattice,
    wall_loads: &mut [WallLoad],
    tally: &mut Tally,
) {
    let mut start = 0;
    while start < list.pairs.len() {
        let end = list.group_end(start);
        if let Err(reason) = find_contacts(particles, list, start..end, scene, catalogue) {
            tally.error = Some(not_found(particles, &list.pairs[start], scene, &reason));
            return;
        }
        let parts = touching_parts(list, start..end, scene);
        let first = &list.pairs[start];
        let body = &particles.bodies[first.particle as usize];
        let center = scene.center(first, &body.position, &list.shifts);
        let wall = &scene.walls[first.wall as usize];
        let law = catalogue.contacts.law(body.kind.material, wall.material);
        let mass = felt_mass(particles, first, &list.touching, &center, scene, catalogue);
        let law = law.coefficients(mass).shared(parts.max(1), catalogue.sharing);
        for (pair, contact) in list.pairs[start..end].iter_mut().zip(&list.touching) {
            match contact {
                None => pair.forget_springs(),
                Some(contact) => add_contact(
                    particles, pair, contact, &center, scene, &law, catalogue, lattice, wall_loads, tally,
                ),
            }
        }
        start = end;
    }
}

/// Number of parts of the particle that touch; each part's springs go where its contacts have gone.
fn touching_parts(list: &mut WallList, group: Range<usize>, scene: &WallScene) -> usize {
    let (mut parts, mut start) = (0, group.start);
    while start < group.end {
        let end = list.part_end(start, group.end);
        let touching = &list.touching[start - group.start..end - group.start];
        parts += usize::from(touching.iter().any(Option::is_some));
        if end > start + 1 {
            hand_over_springs(&mut list.pairs[start..end], touching, scene);
        }
        start = end;
    }
    parts
}

/// Mass (kg) that a particle sets against a wall, as felt amid its contacts.
fn felt_mass(
    particles: &Particles,
    pair: &WallPair,
    touching: &[Option<SurfaceContact>],
    center: &Vec3,
    scene: &WallScene,
    catalogue: &Catalogue,
) -> f64 {
    let body = &particles.bodies[pair.particle as usize];
    let count = touching.iter().flatten().count();
    if count == 0 || catalogue.shape(body.kind).is_sphere() {
        return body.mass;
    }
    let state = &scene.states[pair.wall as usize];
    let point = touching.iter().flatten().map(|c| c.point).sum::<Vec3>() / count as f64;
    let normal = touching.iter().flatten().map(|c| c.normal).sum::<Vec3>();
    let normal = normal.try_normalize(f64::EPSILON).unwrap_or_else(Vec3::zeros);
    let arm = state.to_world(&(point - state.to_wall(center)));
    let pose = Pose::of(particles, pair.particle as usize, catalogue);
    1.0 / pose.inverse_mass_along(body.mass, &arm, &state.to_world(&normal))
}

/// Gives the spring of a contact that ended to one that began beside it on the same surface, as when a
/// ball rolls from one triangle of a flat floor to the next.
fn hand_over_springs(pairs: &mut [WallPair], touching: &[Option<SurfaceContact>], scene: &WallScene) {
    let surface = &scene.walls[pairs[0].wall as usize].surfaces[pairs[0].surface as usize];
    for k in 0..pairs.len() {
        let Some(contact) = touching[k] else { continue };
        if pairs[k].spring != Vec3::zeros() {
            continue;
        }
        let orphan = (0..pairs.len()).find(|&l| {
            touching[l].is_none()
                && pairs[l].spring != Vec3::zeros()
                && surface.goes_on(pairs[l].element, pairs[k].element, &contact.normal)
        });
        if let Some(l) = orphan {
            (pairs[k].spring, pairs[k].twist) = (pairs[l].spring, pairs[l].twist);
            pairs[l].forget_springs();
        }
    }
}

/// Adds the load of one contact.
#[allow(clippy::too_many_arguments)] // the one place where particle, wall and sums come together
#[inline]
fn add_contact(
    particles: &mut Particles,
    pair: &mut WallPair,
    found: &SurfaceContact,
    center: &Vec3,
    scene: &WallScene,
    law: &Coefficients,
    catalogue: &Catalogue,
    lattice: &LoadLattice,
    wall_loads: &mut [WallLoad],
    tally: &mut Tally,
) {
    let (i, w) = (pair.particle as usize, pair.wall as usize);
    let (wall, state, body) = (&scene.walls[w], &scene.states[w], &particles.bodies[i]);
    let normal = state.to_world(&found.normal);
    let arm = state.to_world(&(found.point - state.to_wall(center)));
    let point = center + arm;
    let contact = Contact {
        normal,
        overlap: found.overlap,
        velocity: state.velocity_at(&point) - (body.velocity + body.angular_velocity.cross(&arm)),
    };
    let force = lattice.force(&law.force(&contact, &mut pair.spring, scene.dt));
    let mut torque = lattice.torque(&arm.cross(&force));
    if let Some(footprint) = found.footprint {
        let (turn, spin) = (state.rotation, state.angular_velocity - body.angular_velocity);
        let Footprint { moment, second, .. } = footprint.moved(&turn, 1.0, &Vec3::zeros());
        let spread = Spread { moment, second };
        torque += lattice.torque(&law.spread_torque(&contact, &spread, &spin, &mut pair.twist, scene.dt));
    }
    if law.resists_rolling() {
        let spin = body.angular_velocity - state.angular_velocity;
        torque += lattice.torque(&law.rolling_torque(&contact, &spin, arm.norm()));
    }
    let radius = catalogue.inscribed_radius(body);
    if tally.note(found.overlap / radius) {
        tally.error = Some(StepError::Overlap {
            id: particles.ids[i],
            other: format!("wall `{}`", wall.name),
            overlap: found.overlap,
            percent: 100.0 * found.overlap / radius,
            limit: 100.0 * tally.limit(),
            place: vector(&body.position),
        });
    }
    let load: &mut Load = &mut particles.loads[i];
    load.force += force;
    load.torque += torque;
    wall_loads[w].force -= force;
    wall_loads[w].torque -= lattice.torque(&point.cross(&force));
}
