//! Where particles touch walls.

use super::list::WallList;
use super::pairs::{WallPair, WallScene};
use super::surface::Surface;
use super::surface_contact::{SphereTouch, SurfaceContact};
use crate::catalogue::{Catalogue, FaceContact};
use crate::error::{StepError, vector};
use crate::narrow_phase::{PlacedPart, Pose};
use crate::particles::{Body, Particles};
use crate::periodic_images as images;
use grains_geometry::{GjkError, Simplex, Vec3};
use std::ops::Range;

/// Calls `touches` with particle, wall and overlap (m) of every wall contact.
pub(crate) fn for_each_contact(
    particles: &Particles,
    list: &mut WallList,
    scene: &WallScene,
    catalogue: &Catalogue,
    mut touches: impl FnMut(usize, usize, f64),
) {
    let mut start = 0;
    while start < list.pairs.len() {
        let end = list.group_end(start);
        if find_contacts(particles, list, start..end, scene, catalogue).is_ok() {
            let first = &list.pairs[start];
            for contact in list.touching.iter().flatten().filter(|contact| contact.overlap > 0.0) {
                touches(first.particle as usize, first.wall as usize, contact.overlap);
            }
        }
        start = end;
    }
}

/// A contact with a wall, in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallMeeting {
    pub(crate) pair: WallPair,
    /// Periodic image as seen from the wrapped position; 27 if it is none of those.
    pub(crate) image: u8,
    /// Unit normal into the wall.
    pub(crate) normal: Vec3,
    /// Overlap (m); negative where a body within reach is apart.
    pub(crate) overlap: f64,
    /// Contact point from the particle's centre of mass (m).
    pub(crate) arm: Vec3,
    /// Contact point (m).
    pub(crate) point: Vec3,
    /// Velocity of the wall there (m/s).
    pub(crate) velocity: Vec3,
}

/// Calls `visit` with every wall contact.
pub(crate) fn meet(
    particles: &Particles,
    list: &mut WallList,
    scene: &WallScene,
    catalogue: &Catalogue,
    mut visit: impl FnMut(&WallMeeting),
) -> Result<(), StepError> {
    let mut start = 0;
    while start < list.pairs.len() {
        let end = list.group_end(start);
        find_contacts(particles, list, start..end, scene, catalogue)
            .map_err(|reason| not_found(particles, &list.pairs[start], scene, &reason))?;
        for (pair, found) in list.pairs[start..end].iter().zip(&list.touching) {
            let Some(found) = found else { continue };
            let position = &particles.bodies[pair.particle as usize].position;
            let (wall, state) = (&scene.walls[pair.wall as usize], &scene.states[pair.wall as usize]);
            let center = scene.center(pair, position, &list.shifts);
            let arm = state.to_world(&(found.point - state.to_wall(&center)));
            let point = center + arm;
            let wrapped = wall.wrapped_axes(&wall.surfaces[pair.surface as usize]);
            let image = images::seen_from_wrapped(pair.image, position, scene.global, wrapped);
            visit(&WallMeeting {
                pair: *pair,
                image: image.unwrap_or(27),
                normal: state.to_world(&found.normal),
                overlap: found.overlap,
                arm,
                point,
                velocity: state.velocity_at(&point),
            });
        }
        start = end;
    }
    Ok(())
}

pub(crate) fn not_found(
    particles: &Particles,
    pair: &WallPair,
    scene: &WallScene,
    reason: &GjkError,
) -> StepError {
    StepError::Distance {
        id: particles.ids[pair.particle as usize],
        other: format!("wall `{}`", scene.walls[pair.wall as usize].name),
        place: vector(&particles.bodies[pair.particle as usize].position),
        reason: reason.to_string(),
    }
}

/// Finds which pairs of a group touch, in the wall's frame.
pub(super) fn find_contacts(
    particles: &Particles,
    list: &mut WallList,
    group: Range<usize>,
    scene: &WallScene,
    catalogue: &Catalogue,
) -> Result<(), GjkError> {
    let first = list.pairs[group.start];
    let (wall, state) = (&scene.walls[first.wall as usize], &scene.states[first.wall as usize]);
    let body = &particles.bodies[first.particle as usize];
    let position = scene.center(&first, &body.position, &list.shifts);
    list.touching.clear();
    if !wall.exists_at(scene.time) {
        list.touching.resize(group.len(), None);
        list.drop_simplexes(group);
        return Ok(());
    }
    let surface = &wall.surfaces[first.surface as usize];
    let reach = catalogue.contacts.reach_between(body.kind.material, wall.material);
    let shape = catalogue.shape(body.kind);
    let center = state.to_wall(&position);
    if shape.is_sphere() {
        for pair in &list.pairs[group] {
            let touch = meet_sphere(surface, pair.element, &center, (body.radius, reach))?;
            list.touching.push(touch.map(|touch| touch.contact(&center, body.radius)));
        }
        return Ok(());
    }
    let mut pose = Pose::of(particles, first.particle as usize, catalogue);
    let turned;
    if state.is_displaced {
        turned = state.rotation.tr_mul(pose.frame);
        pose.frame = &turned;
    }
    let mut start = group.start;
    while start < group.end {
        let end = list.part_end(start, group.end);
        let number = list.pairs[start].part;
        let part = PlacedPart::of(&pose, number);
        find_contacts_of_part(
            list,
            start..end,
            surface,
            (&center, body.radius),
            &part,
            (catalogue.faces, reach),
        )?;
        join_flat_patches(&mut list.touching[start - group.start..]);
        start = end;
    }
    Ok(())
}

/// Finds which pairs of a sphere touch, in the wall's frame.
pub(super) fn find_contacts_of_sphere(
    body: &Body,
    list: &mut WallList,
    group: Range<usize>,
    scene: &WallScene,
    catalogue: &Catalogue,
) -> Result<(), GjkError> {
    let first = &list.pairs[group.start];
    let (wall, state) = (&scene.walls[first.wall as usize], &scene.states[first.wall as usize]);
    list.touching_spheres.clear();
    if !wall.exists_at(scene.time) {
        list.touching_spheres.resize(group.len(), None);
        return Ok(());
    }
    let surface = &wall.surfaces[first.surface as usize];
    let reach = catalogue.contacts.reach_between(body.kind.material, wall.material);
    let center = state.to_wall(&scene.center(first, &body.position, &list.shifts));
    for pair in &list.pairs[group] {
        list.touching_spheres.push(meet_sphere(surface, pair.element, &center, (body.radius, reach))?);
    }
    Ok(())
}

/// Contact of a sphere of a radius (m) with an element within `reach` (m).
#[inline(always)]
fn meet_sphere(
    surface: &Surface,
    element: u32,
    center: &Vec3,
    (radius, reach): (f64, f64),
) -> Result<Option<SphereTouch>, GjkError> {
    let touch = surface.meets_sphere(element, center, radius + reach)?;
    Ok(touch.map(|touch| SphereTouch { overlap: touch.overlap - reach, ..touch }))
}

/// Finds which pairs of one part touch; its particle has its centre at `center` (m), in the wall's frame.
fn find_contacts_of_part(
    list: &mut WallList,
    pairs: Range<usize>,
    surface: &Surface,
    (center, radius): (&Vec3, f64),
    part: &PlacedPart,
    (faces, reach): (FaceContact, f64),
) -> Result<(), GjkError> {
    let WallList { pairs: all, simplexes, touching, .. } = list;
    let at = center + part.offset;
    for pair in &all[pairs] {
        let simplex = match pair.simplex {
            WallPair::CLOSED_FORM => &mut Simplex::default(),
            index => &mut simplexes[index as usize],
        };
        let is_out_of_range = surface.is_out_of_range(pair.element, center, radius + reach)
            || surface.is_out_of_range(pair.element, &at, part.bounding_radius + reach);
        let mut contact = None;
        if !is_out_of_range {
            contact = surface.meets_part(pair.element, &at, part, simplex, faces)?;
            if contact.is_none() && reach > 0.0 {
                let swollen = part.swollen(reach);
                let met = surface.meets_part(pair.element, &at, &swollen, simplex, FaceContact::Point)?;
                contact = met.map(|contact| contact.shrunk(reach));
            }
        }
        // The history of a pair must not depend on how long it was in a list before it came near, nor on whether it was
        // in a list while it was near: another skin may leave it out.
        if contact.is_none() {
            simplex.len = 0;
        }
        touching.push(contact);
    }
    Ok(())
}

/// Contacts of one part with nearly the same normal are one: a flat patch is one contact, however it is
/// tessellated. Spheres need no such rule: they meet a flat patch in one point.
fn join_flat_patches(contacts: &mut [Option<SurfaceContact>]) {
    const SAME_DIRECTION: f64 = 1.0 - 1e-6;
    for k in 1..contacts.len() {
        for l in 0..k {
            if let (Some(a), Some(b)) = (&contacts[l], &contacts[k])
                && a.normal.dot(&b.normal) > SAME_DIRECTION
            {
                let joined = Some(a.joined(b));
                (contacts[l], contacts[k]) =
                    if a.overlap >= b.overlap { (joined, None) } else { (None, joined) };
            }
        }
    }
}
