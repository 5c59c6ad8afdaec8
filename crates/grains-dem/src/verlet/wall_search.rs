//! The search for wall elements near particles.

use super::list_context::ListContext;
use crate::contact_history::WallHistory;
use crate::particles::{Body, Particles};
use crate::periodic_images as images;
use crate::walls::{Surface, WallList, apart_until};
use grains_geometry::Vec3;

/// The search for the walls near a particle and its periodic images.
pub(super) struct WallSearch<'a> {
    pub(super) context: &'a ListContext<'a>,
    /// Distance any wall may move before the lists are rebuilt (m).
    pub(super) wall_allowance: f64,
    /// Scratch: elements of a surface near the particle, and up to which way (m) of the particle they are apart.
    pub(super) elements: Vec<(u32, f64)>,
}

/// A surface of a wall, by number.
#[derive(Clone, Copy)]
struct Numbered<'a> {
    wall: usize,
    number: usize,
    surface: &'a Surface,
}

impl WallSearch<'_> {
    /// Adds the wall pairs of owned particle `i`, whose contacts were `known`.
    pub(super) fn search(
        &mut self,
        list: &mut WallList,
        particles: &Particles,
        i: usize,
        allowance: f64,
        known: &[WallHistory],
    ) {
        let (body, context) = (&particles.bodies[i], self.context);
        let (shape, global) = (context.catalogue.shape(body.kind), &context.decomposition.global);
        let range = body.radius + allowance + context.reach + self.wall_allowance;
        let surfaces =
            context.walls.iter().enumerate().filter(|(_, wall)| context.time < wall.until).flat_map(
                |(wall, of)| {
                    let surfaces = of.surfaces.iter().enumerate();
                    surfaces.map(move |(number, surface)| Numbered { wall, number, surface })
                },
            );
        for at in surfaces {
            let wrapped = context.walls[at.wall].wrapped_axes(at.surface);
            let is_closed_form = shape.is_sphere() || at.surface.has_closed_form();
            for image in images::near_faces(global, &body.position, range, wrapped.map(|w| !w)) {
                self.find_elements(at, body, range, (image, &list.shifts), known);
                let start = list.pairs.len();
                for part in 0..shape.parts.len() as u16 {
                    for &(element, apart_until) in &self.elements {
                        let key = (at.wall as u16, at.number as u16, part, element, image);
                        let known = known.iter().find(|m| m.key() == key).map(|m| m.contact);
                        list.push(i as u32, key, known.unwrap_or_default(), is_closed_form, apart_until);
                    }
                }
                let frame =
                    particles.frames.get(i).map(|frame| context.states[at.wall].rotation.tr_mul(frame));
                let seen = context.states[at.wall].to_wall(&(body.position + list.shifts[image as usize]));
                list.close_group(start, seen, frame.as_ref());
            }
        }
    }

    /// Finds the elements of a surface within `range` (m) of an image of a body, and up to which way (m) they are apart.
    ///
    /// Those are left out that a sphere cannot touch before the lists are rebuilt, unless the contact is `known`.
    fn find_elements(
        &mut self,
        at: Numbered,
        body: &Body,
        range: f64,
        (image, shifts): (u8, &[Vec3]),
        known: &[WallHistory],
    ) {
        let Self { context, elements, .. } = self;
        let global = &context.decomposition.global;
        let wrapped = context.walls[at.wall].wrapped_axes(at.surface);
        let radius = body.radius + context.reach;
        let is_sphere = context.catalogue.shape(body.kind).is_sphere();
        elements.clear();
        // Near a face it may soon be met at the other one.
        for alias in images::near_faces(global, &body.position, range, wrapped) {
            let position = body.position + (shifts[image as usize] + shifts[alias as usize]);
            let center = context.states[at.wall].to_wall(&position);
            at.surface.for_each_near(&center, range, |element| {
                let is_known = || known.iter().any(|m| m.element == element);
                if !is_sphere || is_known() {
                    elements.push((element, f64::NEG_INFINITY));
                    return;
                }
                let free_path = at.surface.free_path(element, &center, radius);
                let until = apart_until(0.0, free_path, [&position, &center], body.radius);
                if until < range - radius {
                    elements.push((element, if alias == images::HOME { until } else { f64::NEG_INFINITY }));
                }
            });
        }
        elements.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        elements.dedup_by_key(|(element, _)| *element);
    }
}
