//! Contacts between bodies that are not both spheres, part by part: a plane that separates two parts, else GJK on their
//! cores.
//!
//! Most listed pairs are apart. The gap across a plane says how far the two may go before they are looked at again;
//! then two support functions give the gap across the same plane as it is now, and where there is none a query from a
//! cold start finds the contact or another plane. A pair that touches starts from its last simplex. So its history
//! begins with its contact, and planes and path lengths, which depend on when lists were built, change the time of an answer
//! only.

use super::found::Contacts;
use super::histories::Histories;
use super::list::PartPairList;
use super::pairs::PartPair;
use super::window::Window;
use crate::catalogue::{Catalogue, FaceContact};
use crate::error::{StepError, vector};
use crate::narrow_phase::{Meeting, PartContact, PlacedPart, Pose, gap_across_plane, meet_parts};
use crate::particles::Particles;
use grains_geometry::{ContactPatch, GjkError, Vec3};

/// Calls `visit` with every pair of parts that touch, their contact, and where they touch if not in a point.
///
/// # Errors
/// A distance that could not be found.
pub(crate) fn meet(
    particles: &Particles,
    list: &mut PartPairList,
    catalogue: &Catalogue,
    mut visit: impl FnMut(&PartPair, &PartContact, Option<&ContactPatch>),
) -> Result<(), StepError> {
    let PartPairList { pairs, histories, found, .. } = list;
    for group in pairs.chunk_by_mut(PartPair::is_of_same_particles) {
        find_contacts(particles, group, histories, catalogue, (found, None))?;
        for item in &found.items {
            visit(&group[item.place], &item.contact, found.footprint(item));
        }
    }
    Ok(())
}

/// Finds which pairs of parts of two particles touch; their points are taken from the centre of mass of the first.
///
/// Distances that the window has found are not looked for again.
pub(super) fn find_contacts(
    particles: &Particles,
    group: &mut [PartPair],
    histories: &mut Histories,
    catalogue: &Catalogue,
    (found, mut window): (&mut Contacts, Option<&mut Window>),
) -> Result<(), StepError> {
    found.clear();
    let (a, b) = (group[0].a as usize, group[0].b as usize);
    let (body_a, body_b) = (&particles.bodies[a], &particles.bodies[b]);
    let gone = particles.path_length[a] + particles.path_length[b];
    if group.iter().all(|pair| gone < pair.separated_until) {
        return Ok(());
    }
    let separation = body_b.position - body_a.position;
    let reach = catalogue.contacts.reach_between(body_a.kind.material, body_b.kind.material);
    let range = body_a.radius + body_b.radius + reach;
    if separation.norm_squared() >= range * range {
        let gap = separation.norm() - range;
        for pair in group {
            pair.stay_apart(gone, gap);
        }
        return Ok(());
    }
    let poses = [a, b].map(|i| Pose::of(particles, i, catalogue));
    for (place, pair) in group.iter_mut().enumerate() {
        if gone < pair.separated_until {
            continue;
        }
        if !pair.is_touching() {
            let gap = gap_across_plane(&poses, &pair.parts, &separation, &pair.axis) - reach;
            if gap > 0.0 {
                pair.stay_apart(gone, gap);
                continue;
            }
        }
        let found = (&mut *found, window.as_deref_mut());
        find_contact(place, pair, &poses, &separation, histories, (catalogue.faces, reach), found).map_err(
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

/// Finds whether a pair of parts touches by a query, or how it is separated.
#[inline(always)]
fn find_contact(
    place: usize,
    pair: &mut PartPair,
    poses: &[Pose; 2],
    separation: &Vec3,
    histories: &mut Histories,
    (faces, reach): (FaceContact, f64),
    (found, window): (&mut Contacts, Option<&mut Window>),
) -> Result<(), GjkError> {
    let known = window.and_then(|window| window.contact(pair, histories));
    if let (Some((contact, offset)), false) = (known, faces == FaceContact::MultiPoint) {
        found.push(place, contact, &offset, None);
        return Ok(());
    }
    let [part_a, part_b] = [0, 1].map(|k| PlacedPart::of(&poses[k], pair.parts[k]));
    let between = separation + (part_b.offset - part_a.offset);
    let range = part_a.bounding_radius + part_b.bounding_radius + reach;
    if between.norm_squared() >= range * range {
        pair.part();
        pair.separate_by(&between);
        return Ok(());
    }
    let parts = [&part_a, &part_b];
    if let Some((contact, _)) = known {
        found.take(place, contact, parts, &between, faces);
        return Ok(());
    }
    let placement = part_a.placement(&part_b.rotation, part_b.scale, &between);
    let cores = [part_a.core, part_b.core];
    let simplex = histories.start(pair, cores, &mut found.simplex);
    let mut meeting = meet_parts(&part_a, &part_b, &placement, simplex)?;
    if let (Meeting::Apart(_), true) = (&meeting, reach > 0.0) {
        meeting = meet_parts(&part_a.swollen(reach), &part_b, &placement, simplex)?.shrunk(reach);
    }
    match meeting {
        Meeting::Apart(normal) => {
            pair.part();
            pair.separate_by(&normal);
        }
        Meeting::Touching(contact) => {
            histories.begin(pair);
            histories.keep_start(pair, cores, &found.simplex);
            found.take(place, contact, parts, &between, faces);
        }
    }
    Ok(())
}
