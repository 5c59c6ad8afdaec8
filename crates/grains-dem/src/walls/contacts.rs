//! Contacts of particles with walls: the same law as between particles, against a body of infinite mass.

use super::surface::SurfaceContact;
use super::{Wall, WallLoad, WallState};
use crate::bodies::{PlacedPart, Pose};
use crate::error::vector;
use crate::forces::{LoadLattice, Tally};
use crate::images;
use crate::{Catalogue, DemSetup, Load, Particles, StepError};
use grains_contact::{Coefficients, Contact, Spread};
use grains_domain::GlobalBox;
use grains_geometry::{ContactPatch, GjkError, Simplex, Vec3};
use std::ops::Range;

/// A part of a particle and an element of a wall that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallPair {
    pub(crate) particle: u32,
    /// Triangle of a mesh, else 0.
    pub(crate) element: u32,
    pub(crate) wall: u16,
    pub(crate) surface: u16,
    pub(crate) part: u16,
    /// Periodic image of the particle, see [`crate::images`].
    pub(crate) image: u8,
    pub(crate) spring: Vec3,
    /// Spring against twisting about the normal (rad).
    pub(crate) twist: f64,
    /// Index of the pair's simplex, or `WallPair::CLOSED_FORM`.
    pub(crate) simplex: u32,
}

impl WallPair {
    pub(crate) const CLOSED_FORM: u32 = u32::MAX;

    /// Whether two pairs are of the same particle, image and surface.
    fn meets_same(&self, other: &Self) -> bool {
        let key = |p: &Self| (p.particle, p.wall, p.surface, p.image);
        key(self) == key(other)
    }

    fn forget_springs(&mut self) {
        self.spring = Vec3::zeros();
        self.twist = 0.0;
    }
}

/// All wall pairs of a rank, those of one particle and surface side by side, triangles ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct WallList {
    pub(crate) pairs: Vec<WallPair>,
    pub(crate) simplexes: Vec<Simplex>,
    /// Shift (m) of each periodic image.
    pub(crate) shifts: Vec<Vec3>,
    touching: Vec<Option<SurfaceContact>>,
}

impl WallList {
    /// End of the group of pairs of one particle, image and surface that begins at `start`.
    fn group_end(&self, start: usize) -> usize {
        let first = &self.pairs[start];
        self.pairs[start..].iter().position(|p| !p.meets_same(first)).map_or(self.pairs.len(), |n| start + n)
    }

    /// End of the pairs of one part of the particle that begin at `start`.
    fn part_end(&self, start: usize, group_end: usize) -> usize {
        let part = self.pairs[start].part;
        let others = self.pairs[start..group_end].iter().position(|p| p.part != part);
        others.map_or(group_end, |n| start + n)
    }
}

/// Where and when the walls are met.
pub(crate) struct WallScene<'a> {
    pub(crate) walls: &'a [Wall],
    pub(crate) states: &'a [WallState],
    pub(crate) time: f64,
    pub(crate) dt: f64,
    pub(crate) global: &'a GlobalBox,
}

impl<'a> WallScene<'a> {
    pub(crate) fn new(setup: &'a DemSetup, states: &'a [WallState], time: f64) -> Self {
        Self { walls: &setup.walls, states, time, dt: setup.rates.dt, global: &setup.global }
    }

    /// Centre (m) of the periodic image of a particle that a pair is about.
    ///
    /// Along axes on which a surface has no end it is its own image: it is met at the wrapped position, so
    /// that the answer does not depend on when the particle was last wrapped.
    #[inline]
    pub(crate) fn center(&self, pair: &WallPair, position: &Vec3, shifts: &[Vec3]) -> Vec3 {
        let mut center = position + shifts[pair.image as usize];
        if self.global.periodic != [false; 3] {
            let wall = &self.walls[pair.wall as usize];
            let wrapped = wall.wrapped_axes(&wall.surfaces[pair.surface as usize]);
            for a in (0..3).filter(|&a| wrapped[a] && self.global.periodic[a]) {
                center[a] = self.global.wrap_along(a, position[a]);
            }
        }
        center
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
    let mut start = 0;
    while start < list.pairs.len() {
        let end = list.group_end(start);
        if find_contacts(particles, list, start..end, scene, catalogue).is_ok() {
            let first = &list.pairs[start];
            for contact in list.touching.iter().flatten() {
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
    /// Overlap (m), positive.
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

/// Finds which pairs of a group touch, in the wall's frame.
fn find_contacts(
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
        for pair in &list.pairs[group] {
            if pair.simplex != WallPair::CLOSED_FORM {
                list.simplexes[pair.simplex as usize].len = 0;
            }
        }
        return Ok(());
    }
    let surface = &wall.surfaces[first.surface as usize];
    let shape = catalogue.shape(body.kind);
    let center = state.to_wall(&position);
    if shape.is_sphere() {
        for pair in &list.pairs[group] {
            list.touching.push(surface.meets_sphere(pair.element, &center, body.radius)?);
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
        for pair in &list.pairs[start..end] {
            let simplex = match pair.simplex {
                WallPair::CLOSED_FORM => &mut Simplex::default(),
                index => &mut list.simplexes[index as usize],
            };
            let at = center + part.offset;
            if surface.is_out_of_reach(pair.element, &center, body.radius)
                || surface.is_out_of_reach(pair.element, &at, part.bounding_radius)
            {
                // What a pair remembers must not depend on how long it was in a list before it came near.
                simplex.len = 0;
                list.touching.push(None);
                continue;
            }
            let contact = surface.meets_part(pair.element, &at, &part, simplex, catalogue.faces)?;
            // Nor on whether it was in a list while it was near: another skin may leave it out.
            if contact.is_none() {
                simplex.len = 0;
            }
            list.touching.push(contact);
        }
        join_flat_patches(&mut list.touching[start - group.start..]);
        start = end;
    }
    Ok(())
}

/// Contacts of one part with nearly the same normal are one: a flat patch is one contact, however it is
/// tessellated. Spheres need no such rule: they meet a flat patch in one point.
fn join_flat_patches(contacts: &mut [Option<SurfaceContact>]) {
    const SAME_DIRECTION: f64 = 1.0 - 1e-6;
    for k in 1..contacts.len() {
        for l in 0..k {
            if let (Some(a), Some(b)) = (contacts[l], contacts[k])
                && a.normal.dot(&b.normal) > SAME_DIRECTION
            {
                let joined = Some(a.joined(&b));
                (contacts[l], contacts[k]) =
                    if a.overlap >= b.overlap { (joined, None) } else { (None, joined) };
            }
        }
    }
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
        let ContactPatch { moment, second, .. } = footprint.moved(&turn, 1.0, &Vec3::zeros());
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
