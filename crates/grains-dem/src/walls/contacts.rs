//! Where particles touch walls.

use super::list::{WallList, apart_until};
use super::motion::WallState;
use super::pairs::{WallPair, WallScene};
use super::surface::Surface;
use super::surface_contact::{PartMeeting, SphereTouch, SurfaceContact};
use super::wall::Wall;
use crate::catalogue::{Catalogue, FaceContact};
use crate::error::{StepError, vector};
use crate::narrow_phase::{PlacedPart, Pose};
use crate::particles::{Body, Particles};
use crate::periodic_images as images;
use grains_geometry::{ContactPatch, GjkError, Mat3, Simplex, Vec3};
use std::ops::Range;

/// The particle of a group of pairs as the wall sees it.
pub(super) struct Approach<'a> {
    pub(super) body: Body,
    pub(super) particle: usize,
    pub(super) wall: &'a Wall,
    pub(super) state: &'a WallState,
    surface: &'a Surface,
    /// Centre of its image (m), in the world and in the wall's frame.
    pub(super) position: Vec3,
    center: Vec3,
    /// Rotation from its frame to that of the wall; none of a sphere.
    frame: Option<Mat3>,
    /// Way it has gone, as the group counts it (m).
    way: f64,
}

impl<'a> Approach<'a> {
    /// The particle of a group, unless no pair of it can touch.
    #[inline(always)]
    pub(super) fn of(
        particles: &Particles,
        (list, group): (&WallList, usize),
        scene: &WallScene<'a>,
        catalogue: &Catalogue,
    ) -> Option<Self> {
        let first = &list.pairs[list.groups[group].pairs().start];
        let particle = first.particle as usize;
        let body = particles.bodies[particle];
        let (wall, state) = (&scene.walls[first.wall as usize], &scene.states[first.wall as usize]);
        let position = scene.center(first, &body.position, &list.shifts);
        let center = state.to_wall(&position);
        let frame = (!catalogue.shape(body.kind).is_sphere()).then(|| {
            let frame = &particles.frames[particle];
            if state.is_displaced { state.rotation.tr_mul(frame) } else { *frame }
        });
        let way = list.way(group, &center, frame.as_ref().map(|frame| (frame, body.radius)));
        if way < list.groups[group].apart_until {
            return None;
        }
        let surface = &wall.surfaces[first.surface as usize];
        Some(Self { body, particle, wall, state, surface, position, center, frame, way })
    }

    /// Way of the group up to which a pair is apart that has a free path (m) from here.
    #[inline(always)]
    fn apart_until(&self, free_path: f64) -> f64 {
        apart_until(self.way, free_path, [&self.position, &self.center], self.body.radius)
    }

    #[inline(always)]
    pub(super) fn is_sphere(&self) -> bool {
        self.frame.is_none()
    }

    fn reach(&self, catalogue: &Catalogue) -> f64 {
        catalogue.contacts.reach_between(self.body.kind.material, self.wall.material)
    }
}

/// Calls `touches` with particle, wall and overlap (m) of every wall contact.
pub(crate) fn for_each_contact(
    particles: &Particles,
    list: &mut WallList,
    scene: &WallScene,
    catalogue: &Catalogue,
    mut touches: impl FnMut(usize, usize, f64),
) {
    for group in 0..list.groups.len() {
        let Some(approach) = Approach::of(particles, (list, group), scene, catalogue) else { continue };
        if find_contacts(particles, list, group, &approach, scene, catalogue).is_ok() {
            let first = &list.pairs[list.groups[group].pairs().start];
            for contact in list.touching.iter().flatten().filter(|contact| contact.overlap > 0.0) {
                touches(first.particle as usize, first.wall as usize, contact.overlap);
            }
        }
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
    /// Where the body touches if not in a point, in the wall's frame.
    pub(crate) footprint: Option<ContactPatch>,
}

/// Calls `visit` with every wall contact.
pub(crate) fn meet(
    particles: &Particles,
    list: &mut WallList,
    scene: &WallScene,
    catalogue: &Catalogue,
    mut visit: impl FnMut(&WallMeeting),
) -> Result<(), StepError> {
    for group in 0..list.groups.len() {
        let Some(approach) = Approach::of(particles, (list, group), scene, catalogue) else { continue };
        let pairs = list.groups[group].pairs();
        find_contacts(particles, list, group, &approach, scene, catalogue)
            .map_err(|reason| not_found(particles, &list.pairs[pairs.start], scene, &reason))?;
        let Approach { wall, state, surface, center, position, .. } = &approach;
        for (pair, found) in list.pairs[pairs].iter().zip(&list.touching) {
            let Some(found) = found else { continue };
            let arm = state.to_world(&(found.point - center));
            let point = position + arm;
            let wrapped = wall.wrapped_axes(surface);
            let image = images::seen_from_wrapped(pair.image, &approach.body.position, scene.global, wrapped);
            visit(&WallMeeting {
                pair: *pair,
                image: image.unwrap_or(27),
                normal: state.to_world(&found.normal),
                overlap: found.overlap,
                arm,
                point,
                velocity: state.velocity_at(&point),
                footprint: found.footprint,
            });
        }
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
    group: usize,
    approach: &Approach,
    scene: &WallScene,
    catalogue: &Catalogue,
) -> Result<(), GjkError> {
    let pairs = list.groups[group].pairs();
    list.touching.clear();
    if !approach.wall.exists_at(scene.time) {
        list.touching.resize(pairs.len(), None);
        list.drop_simplexes(pairs);
        return Ok(());
    }
    let Approach { body, center, .. } = approach;
    let Some(frame) = &approach.frame else {
        find_contacts_of_sphere(list, group, approach, scene, catalogue)?;
        list.touching.resize(pairs.len(), None);
        for (pair, touch) in &list.looked_at {
            list.touching[pair - pairs.start] = touch.map(|touch| touch.contact(center, body.radius));
        }
        return Ok(());
    };
    let mut pose = Pose::of(particles, approach.particle, catalogue);
    pose.frame = frame;
    let reach = approach.reach(catalogue);
    let (mut start, mut were_apart) = (pairs.start, false);
    if let Surface::Mesh(mesh) = approach.surface
        && approach.way >= list.groups[group].rim_until
    {
        let ball = (&**mesh, center, body.radius + reach);
        list.choose_facets(group, ball, |free_path| approach.apart_until(free_path));
        were_apart = true;
    }
    while start < pairs.end {
        let end = list.part_end(start, pairs.end);
        let part = PlacedPart::of(&pose, list.pairs[start].part);
        were_apart |= find_contacts_of_part(list, start..end, approach, &part, (catalogue.faces, reach))?;
        join_flat_patches(&mut list.touching[start - pairs.start..]);
        start = end;
    }
    if were_apart {
        list.see(group, approach.way, center, Some(frame));
    }
    list.leave(group);
    Ok(())
}

/// Finds which pairs of a sphere touch, of those that may, in the wall's frame.
#[inline(always)]
pub(super) fn find_contacts_of_sphere(
    list: &mut WallList,
    group: usize,
    approach: &Approach,
    scene: &WallScene,
    catalogue: &Catalogue,
) -> Result<(), GjkError> {
    let Approach { surface, center, way, .. } = approach;
    let (radius, reach) = (approach.body.radius, approach.reach(catalogue));
    let pairs = list.groups[group].pairs();
    list.looked_at.clear();
    if !approach.wall.exists_at(scene.time) {
        list.looked_at.extend(pairs.map(|pair| (pair, None)));
        return Ok(());
    }
    let mut were_apart = false;
    for pair in pairs {
        if *way < list.apart_until[pair] {
            continue;
        }
        let element = list.pairs[pair].element;
        let touch = surface.meets_sphere(element, center, radius + reach)?;
        list.apart_until[pair] = match touch {
            Some(_) => f64::NEG_INFINITY,
            None => approach.apart_until(surface.free_path(element, center, radius + reach)),
        };
        were_apart |= touch.is_none();
        let touch = touch.map(|touch| SphereTouch { overlap: touch.overlap - reach, ..touch });
        list.looked_at.push((pair, touch));
    }
    if were_apart {
        list.see(group, *way, center, None);
    }
    list.leave(group);
    Ok(())
}

/// Finds which pairs of one part touch, of those that may; returns whether one was looked at that does not.
fn find_contacts_of_part(
    list: &mut WallList,
    pairs: Range<usize>,
    approach: &Approach,
    part: &PlacedPart,
    (faces, reach): (FaceContact, f64),
) -> Result<bool, GjkError> {
    let Approach { surface, center, way, .. } = approach;
    let WallList { pairs: all, apart_until: until, simplexes, touching, .. } = list;
    let at = center + part.offset;
    let mut were_apart = false;
    for k in pairs {
        let pair = &all[k];
        if *way < until[k] {
            touching.push(None);
            continue;
        }
        let simplex = match pair.simplex {
            WallPair::CLOSED_FORM => &mut Simplex::default(),
            index => &mut simplexes[index as usize],
        };
        let mut gap = f64::NEG_INFINITY;
        // Edges and tips of vertices lie outside the rounded part.
        if part.vertices.is_none() {
            let of_particle = surface.distance_bound(pair.element, center) - approach.body.radius;
            let of_part = surface.distance_bound(pair.element, &at) - part.bounding_radius;
            gap = of_particle.max(of_part) - reach;
        }
        let mut contact = None;
        if gap < 0.0 {
            let mut met = surface.meets_part(pair.element, &at, part, simplex, faces)?;
            if let (PartMeeting::Apart(gap), true) = (&mut met, reach > 0.0) {
                // Within reach it acts; beyond it is out of the reach by as much less.
                *gap -= reach;
                let swollen = part.swollen(reach);
                let again = surface.meets_part(pair.element, &at, &swollen, simplex, FaceContact::Point)?;
                if let PartMeeting::Touching(contact) = again {
                    met = PartMeeting::Touching(contact.shrunk(reach));
                }
            }
            match met {
                PartMeeting::Touching(touching) => contact = Some(touching),
                PartMeeting::Apart(apart) => gap = gap.max(apart),
            }
        }
        // The history of a pair must not depend on how long it was in a list before it came near, nor on whether it was
        // in a list while it was near: another skin may leave it out.
        if contact.is_none() {
            simplex.len = 0;
            were_apart = true;
        }
        until[k] = contact.map_or_else(|| approach.apart_until(gap), |_| f64::NEG_INFINITY);
        touching.push(contact);
    }
    Ok(were_apart)
}

/// Contacts of one part with nearly the same normal are one: a flat patch is one contact, however it is
/// tessellated. Spheres need no such rule: they meet a flat patch in one point.
pub(super) fn join_flat_patches(contacts: &mut [Option<SurfaceContact>]) {
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
