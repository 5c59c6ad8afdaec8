//! The search for wall elements near particles.

use super::list_context::ListContext;
use crate::contact_history::WallHistory;
use crate::particles::Particles;
use crate::periodic_images as images;
use crate::walls::{Surface, WallList};
use grains_geometry::Vec3;

/// The search for the walls near a particle and its periodic images.
pub(super) struct WallSearch<'a> {
    pub(super) context: &'a ListContext<'a>,
    /// Distance any wall may move before the lists are rebuilt (m).
    pub(super) wall_allowance: f64,
    /// Scratch: elements of a surface near the particle.
    pub(super) elements: Vec<u32>,
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
                self.find_elements(at, &body.position, range, image, &list.shifts);
                for part in 0..shape.parts.len() as u16 {
                    for &element in &self.elements {
                        let key = (at.wall as u16, at.number as u16, part, element, image);
                        let known = known.iter().find(|m| m.key() == key).map(|m| m.contact);
                        list.push(i as u32, key, known.unwrap_or_default(), is_closed_form);
                    }
                }
            }
        }
    }

    /// Finds the elements of a surface within `range` (m) of an image of a particle at `position` (m).
    fn find_elements(&mut self, at: Numbered, position: &Vec3, range: f64, image: u8, shifts: &[Vec3]) {
        let global = &self.context.decomposition.global;
        let wrapped = self.context.walls[at.wall].wrapped_axes(at.surface);
        self.elements.clear();
        // Near a face it may soon be met at the other one.
        for alias in images::near_faces(global, position, range, wrapped) {
            let shift = shifts[image as usize] + shifts[alias as usize];
            let center = self.context.states[at.wall].to_wall(&(position + shift));
            at.surface.for_each_near(&center, range, |e| self.elements.push(e));
        }
        self.elements.sort_unstable();
        self.elements.dedup();
    }
}
