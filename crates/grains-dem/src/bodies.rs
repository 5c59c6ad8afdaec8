//! Contacts between bodies that are not both spheres, part by part: a plane that parts two parts, else GJK on their
//! cores.
//!
//! Most listed pairs are apart. The gap across a plane says how far the two may go before they are looked at again;
//! then two support functions give the gap across the same plane as it is now, and where there is none a query from a
//! cold start finds the contact or another plane. A pair that touches starts from its last simplex. So its history
//! begins with its contact, and planes and ways, which depend on when lists were built, change the time of an answer
//! only.

mod list;
mod parts;
mod run;
mod touch;

use crate::catalogue::FaceContact;
use crate::error::vector;
use crate::forces::{LoadLattice, Tally};
use crate::{Body, Catalogue, Load, Particles, StepError};
use grains_contact::{Coefficients, Spread};
use grains_geometry::{ContactPatch, GjkError, Simplex, Vec3};
pub(crate) use list::{BodyList, BodyPair};
use list::{Contacts, Found, Memories};
pub(crate) use parts::{Meeting, PartContact, PlacedPart, Pose, spread, touch};
use parts::{gap_across, meet_parts};
use run::Run;
use std::ops::Range;
use touch::Touch;

/// Adds the loads of the contacts between bodies that are not both spheres, of a range of the list.
///
/// Bodies that touch in one point, the most, wait for others like them; sums of loads are exact in any order.
pub(crate) fn add_forces(
    particles: &mut Particles,
    (list, range): (&mut BodyList, Range<usize>),
    catalogue: &Catalogue,
    lattice: &LoadLattice,
    dt: f64,
    tally: &mut Tally,
) {
    let BodyList { pairs, memories, found, run } = list;
    let pairs = &mut pairs[range];
    let mut start = 0;
    while start < pairs.len() {
        let group = start..end_of_group(pairs, start);
        start = group.end;
        if let Err(error) = find_contacts(particles, &mut pairs[group.clone()], memories, catalogue, found) {
            tally.error = Some(error);
            continue;
        }
        let pair = pairs[group.start];
        let (a, b) = (pair.a as usize, pair.b as usize);
        match &found.items[..] {
            [] => {}
            [item] if found.footprint(item).is_none() => {
                let bodies = [a, b].map(|i| &particles.bodies[i]);
                if !run.has_room_for(bodies) {
                    finish(run, (pairs, memories), particles, catalogue, lattice, dt, tally);
                }
                let bodies = [a, b].map(|i| &particles.bodies[i]);
                let poses = [a, b].map(|i| Pose::of(particles, i, catalogue));
                let place = group.start + item.place;
                let spring = memories.of(&mut pairs[place]).spring;
                tally.cores_met += u64::from(item.contact.cores_met);
                run.take((place, &item.contact), bodies, &poses, &spring, catalogue);
            }
            _ => add_contacts(particles, (&mut pairs[group], memories, found), catalogue, lattice, dt, tally),
        }
    }
    finish(run, (pairs, memories), particles, catalogue, lattice, dt, tally);
}

/// Adds the loads of the contacts that wait.
fn finish(
    run: &mut Run,
    waiting: (&mut [BodyPair], &mut Memories),
    particles: &mut Particles,
    catalogue: &Catalogue,
    lattice: &LoadLattice,
    dt: f64,
    tally: &mut Tally,
) {
    run.finish(waiting, lattice, dt, |pair, depth, loads| {
        add(particles, pair, &loads);
        if tally.note(depth) {
            tally.error = Some(too_deep(tally, particles, pair, depth, catalogue));
        }
    });
}

/// Adds the loads of all contacts of two bodies that touch in several points, or in one that is spread.
fn add_contacts(
    particles: &mut Particles,
    (group, memories, found): (&mut [BodyPair], &mut Memories, &Contacts),
    catalogue: &Catalogue,
    lattice: &LoadLattice,
    dt: f64,
    tally: &mut Tally,
) {
    let (a, b) = (group[0].a as usize, group[0].b as usize);
    let poses = [a, b].map(|i| Pose::of(particles, i, catalogue));
    let bodies = [a, b].map(|i| &particles.bodies[i]);
    let law = coefficients(bodies, &poses, &found.items, catalogue);
    let radius = poses[0].inscribed_radius().min(poses[1].inscribed_radius());
    let mut deepest = 0.0_f64;
    for item in &found.items {
        let Found { place, contact, .. } = item;
        tally.cores_met += u64::from(contact.cores_met);
        deepest = deepest.max(contact.overlap);
        let memory = memories.of(&mut group[*place]);
        let bodies = [a, b].map(|i| &particles.bodies[i]);
        let touch = Touch::of(bodies, contact);
        let mut loads = touch.loads(&law, &mut memory.spring, lattice, dt);
        if let Some(&ContactPatch { moment, second, .. }) = found.footprint(item) {
            let (spin, spread) = (touch.spins[1] - touch.spins[0], Spread { moment, second });
            let torque = law.spread_torque(&touch.contact(), &spread, &spin, &mut memory.twist, dt);
            let torque = lattice.torque(&torque);
            loads[0].torque += torque;
            loads[1].torque -= torque;
        }
        add(particles, &group[0], &loads);
    }
    if tally.note(deepest / radius) {
        tally.error = Some(too_deep(tally, particles, &group[0], deepest / radius, catalogue));
    }
}

/// Adds the loads on two bodies to the sums of those this rank owns.
#[inline(always)]
fn add(particles: &mut Particles, pair: &BodyPair, loads: &[Load; 2]) {
    for (index, load) in [pair.a, pair.b].into_iter().zip(loads) {
        if let Some(sum) = particles.loads.get_mut(index as usize) {
            sum.force += load.force;
            sum.torque += load.torque;
        }
    }
}

#[cold]
fn too_deep(
    tally: &Tally,
    particles: &Particles,
    pair: &BodyPair,
    depth: f64,
    catalogue: &Catalogue,
) -> StepError {
    let (a, b) = (pair.a as usize, pair.b as usize);
    StepError::Overlap {
        id: particles.ids[a],
        other: format!("particle {}", particles.ids[b]),
        overlap: depth * smaller_radius(particles, a, b, catalogue),
        percent: 100.0 * depth,
        limit: 100.0 * tally.limit(),
        place: vector(&particles.bodies[a].position),
    }
}

/// End of the pairs of the same two bodies from `start` on.
#[inline(always)]
fn end_of_group(pairs: &[BodyPair], start: usize) -> usize {
    let is_other = |pair: &BodyPair| !pair.is_of_same_bodies(&pairs[start]);
    pairs[start + 1..].iter().position(is_other).map_or(pairs.len(), |length| start + 1 + length)
}

/// Calls `visit` with every pair of parts that touch and their contact.
///
/// # Errors
/// A distance that could not be found.
pub(crate) fn meet(
    particles: &Particles,
    list: &mut BodyList,
    catalogue: &Catalogue,
    mut visit: impl FnMut(&BodyPair, &PartContact),
) -> Result<(), StepError> {
    let BodyList { pairs, memories, found, .. } = list;
    for group in pairs.chunk_by_mut(BodyPair::is_of_same_bodies) {
        find_contacts(particles, group, memories, catalogue, found)?;
        for Found { place, contact, .. } in &found.items {
            visit(&group[*place], contact);
        }
    }
    Ok(())
}

/// Smaller inscribed radius of two particles (m).
#[inline(always)]
pub(crate) fn smaller_radius(particles: &Particles, a: usize, b: usize, catalogue: &Catalogue) -> f64 {
    let radius = |i: usize| catalogue.inscribed_radius(&particles.bodies[i]);
    radius(a).min(radius(b))
}

/// The law of each of the contacts of two particles, for the mass felt amid them.
#[inline(always)]
fn coefficients(
    [a, b]: [&Body; 2],
    poses: &[Pose; 2],
    found: &[Found],
    catalogue: &Catalogue,
) -> Coefficients {
    let count = found.len();
    let (mut normal, mut arm) = (Vec3::zeros(), Vec3::zeros());
    for Found { contact, .. } in found {
        normal += contact.normal;
        arm += contact.point;
    }
    if count > 1 {
        // Of normals that cancel any direction will do.
        normal = normal.try_normalize(f64::EPSILON).unwrap_or_else(Vec3::zeros);
        arm /= count as f64;
    }
    let arm_b = arm - (b.position - a.position);
    let inverse = poses[0].inverse_mass_along(a.mass_felt(), &arm, &normal)
        + poses[1].inverse_mass_along(b.mass_felt(), &arm_b, &normal);
    let law = catalogue.contacts.prepared(a.kind.material, b.kind.material);
    law.at(1.0 / inverse).shared(count, catalogue.sharing)
}

/// Finds which pairs of parts of two particles touch; their points are taken from the centre of mass of the first.
fn find_contacts(
    particles: &Particles,
    group: &mut [BodyPair],
    memories: &mut Memories,
    catalogue: &Catalogue,
    found: &mut Contacts,
) -> Result<(), StepError> {
    found.clear();
    let (a, b) = (group[0].a as usize, group[0].b as usize);
    let (body_a, body_b) = (&particles.bodies[a], &particles.bodies[b]);
    let gone = particles.travelled[a] + particles.travelled[b];
    if group.iter().all(|pair| gone < pair.apart_until) {
        return Ok(());
    }
    let separation = body_b.position - body_a.position;
    let reach = body_a.radius + body_b.radius;
    if separation.norm_squared() >= reach * reach {
        let gap = separation.norm() - reach;
        for pair in group {
            memories.forget(pair);
            pair.stay_apart(gone, gap);
        }
        return Ok(());
    }
    let poses = [a, b].map(|i| Pose::of(particles, i, catalogue));
    for (place, pair) in group.iter_mut().enumerate() {
        if gone < pair.apart_until {
            continue;
        }
        if !pair.is_touching() {
            let gap = gap_across(&poses, &pair.parts, &separation, &pair.axis);
            if gap > 0.0 {
                pair.stay_apart(gone, gap);
                continue;
            }
        }
        find_contact(place, pair, &poses, &separation, memories, catalogue.faces, found).map_err(
            |reason| StepError::Distance {
                id: particles.ids[a],
                other: format!("particle {}", particles.ids[b]),
                place: vector(&body_a.position),
                reason: reason.to_string(),
            },
        )?;
    }
    Ok(())
}

/// Finds whether a pair of parts touches by a query, or how it is parted.
#[inline(always)]
fn find_contact(
    place: usize,
    pair: &mut BodyPair,
    poses: &[Pose; 2],
    separation: &Vec3,
    memories: &mut Memories,
    faces: FaceContact,
    found: &mut Contacts,
) -> Result<(), GjkError> {
    let [part_a, part_b] = [0, 1].map(|k| PlacedPart::of(&poses[k], pair.parts[k]));
    let between = separation + (part_b.offset - part_a.offset);
    let reach = part_a.bounding_radius + part_b.bounding_radius;
    if between.norm_squared() >= reach * reach {
        memories.forget(pair);
        pair.part_by(&between);
        return Ok(());
    }
    let placement = part_a.placement(&part_b.rotation, part_b.scale, &between);
    let mut cold = Simplex::default();
    let simplex = if pair.is_touching() { &mut memories.of(pair).simplex } else { &mut cold };
    match meet_parts(&part_a, &part_b, &placement, simplex)? {
        Meeting::Apart(normal) => {
            memories.forget(pair);
            pair.part_by(&normal);
        }
        Meeting::Touching(mut contact) => {
            if !pair.is_touching() {
                memories.of(pair).simplex = cold;
            }
            let is_spread = faces == FaceContact::Spread && part_a.vertices.is_none();
            let footprint = is_spread
                .then(|| spread(&part_a, part_b.core, &placement, part_b.crust, &mut contact))
                .flatten();
            contact.point += part_a.offset;
            found.push(place, contact, footprint);
        }
    }
    Ok(())
}
