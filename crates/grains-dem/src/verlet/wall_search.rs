//! The search for wall elements near particles.

use super::list_context::ListContext;
use crate::contact_history::WallHistory;
use crate::particles::{Body, Particles};
use crate::periodic_images as images;
use crate::walls::{
    Surface, WallList, WallState, apart_until, facet_element, may_stand, stands, triangle_of_facet,
};
use grains_geometry::{Aabb, Bvh, OverFacet, Vec3, WallMesh};

/// Share of its coordinates by which the box of a surface is wider, to cover rounding.
const ROUNDING: f64 = 1e-12;

/// The search for the walls near a particle and its periodic images.
pub(super) struct WallSearch<'a> {
    context: &'a ListContext<'a>,
    /// Distance any wall may move before the lists are rebuilt (m).
    wall_allowance: f64,
    /// Surfaces of walls that exist still, in order.
    surfaces: Vec<Numbered<'a>>,
    /// Places in `surfaces` of those without an end, and of the others.
    endless: Vec<u32>,
    bounded: Vec<u32>,
    /// Boxes around the others where they are now.
    boxes: Bvh,
    /// Scratch: places of surfaces near a particle.
    near: Vec<u32>,
    /// Scratch: elements of a surface near the particle, and up to which way (m) of the particle they are apart.
    elements: Vec<(u32, f64)>,
    /// Scratch: first triangles of facets near the particle, and where it lies over them.
    facets: Vec<(u32, OverFacet)>,
}

/// A surface of a wall, by number.
#[derive(Clone, Copy)]
struct Numbered<'a> {
    wall: usize,
    number: usize,
    surface: &'a Surface,
}

/// A periodic image of a body near a surface, as the surface sees it.
#[derive(Clone, Copy)]
struct NearSurface<'a> {
    at: Numbered<'a>,
    body: &'a Body,
    image: u8,
    /// Distance from its centre within which elements are near (m).
    range: f64,
    /// Contacts there were.
    known: &'a [WallHistory],
}

impl NearSurface<'_> {
    /// The elements of its contacts with the surface.
    fn known_elements(&self) -> impl Iterator<Item = u32> {
        let place = (self.at.wall, self.at.number);
        let known = self.known.iter().filter(move |m| (usize::from(m.wall), usize::from(m.surface)) == place);
        known.map(|m| m.element)
    }
}

impl<'a> WallSearch<'a> {
    pub(super) fn new(context: &'a ListContext<'a>, wall_allowance: f64) -> Self {
        let walls = context.walls.iter().enumerate().filter(|(_, wall)| context.time < wall.until);
        let surfaces = walls.flat_map(|(wall, of)| {
            let surfaces = of.surfaces.iter().enumerate();
            surfaces.map(move |(number, surface)| Numbered { wall, number, surface })
        });
        let surfaces: Vec<Numbered> = surfaces.collect();
        let (mut endless, mut bounded, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        for (place, at) in surfaces.iter().enumerate() {
            match at.surface.extents() {
                Some(corners) => {
                    bounded.push(place as u32);
                    boxes.push(box_in_world(&corners, &context.states[at.wall]));
                }
                None => endless.push(place as u32),
            }
        }
        let boxes = Bvh::new(&boxes);
        let (near, elements, facets) = (Vec::new(), Vec::new(), Vec::new());
        Self { context, wall_allowance, surfaces, endless, bounded, boxes, near, elements, facets }
    }

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
        self.find_surfaces(&body.position, range, &list.shifts);
        for k in 0..self.near.len() {
            let at = self.surfaces[self.near[k] as usize];
            let wrapped = context.walls[at.wall].wrapped_axes(at.surface);
            for image in images::near_faces(global, &body.position, range, wrapped.map(|w| !w)) {
                let near = NearSurface { at, body, image, range, known };
                let rim_until = match at.surface {
                    Surface::Mesh(mesh) if !shape.is_sphere() => {
                        self.find_triangles_and_facets(&near, mesh, &list.shifts)
                    }
                    _ => {
                        self.find_elements(&near, &list.shifts);
                        f64::INFINITY
                    }
                };
                let start = list.pairs.len();
                for part in 0..shape.parts.len() as u16 {
                    for &(element, apart_until) in &self.elements {
                        let key = (at.wall as u16, at.number as u16, part, element, image);
                        let known = known.iter().find(|m| m.key() == key).map(|m| m.contact);
                        let is_closed_form = shape.is_sphere() || at.surface.has_closed_form(element);
                        list.push(i as u32, key, known.unwrap_or_default(), is_closed_form, apart_until);
                    }
                }
                let frame =
                    particles.frames.get(i).map(|frame| context.states[at.wall].rotation.tr_mul(frame));
                let seen = context.states[at.wall].to_wall(&(body.position + list.shifts[image as usize]));
                list.close_group(start, (seen, frame.as_ref()), rim_until);
            }
        }
    }

    /// Finds the surfaces of which something may lie within `range` (m) of a position (m) or an image of it.
    fn find_surfaces(&mut self, position: &Vec3, range: f64, shifts: &[Vec3]) {
        let Self { context, endless, bounded, boxes, near, .. } = self;
        near.clone_from(endless);
        let half = Vec3::repeat(range);
        for image in images::near_faces(&context.decomposition.global, position, range, [true; 3]) {
            let center = position + shifts[image as usize];
            boxes.for_each_in_box(&(center - half), &(center + half), |k| near.push(bounded[k as usize]));
        }
        near.sort_unstable();
        near.dedup();
    }

    /// Where a body is met: one place, or several near a face of the box along an axis on which it is met at the wrapped position.
    ///
    /// World and wall's frame (m); whether it is its own.
    fn places(
        context: &'a ListContext<'a>,
        near: &NearSurface,
        shifts: &[Vec3],
    ) -> impl Iterator<Item = ([Vec3; 2], bool)> {
        let &NearSurface { at, body, image, range, .. } = near;
        let wrapped = context.walls[at.wall].wrapped_axes(at.surface);
        let aliases = images::near_faces(&context.decomposition.global, &body.position, range, wrapped);
        aliases.map(move |alias| {
            let position = body.position + (shifts[image as usize] + shifts[alias as usize]);
            ([position, context.states[at.wall].to_wall(&position)], alias == images::HOME)
        })
    }

    /// Finds the elements of a surface near a body, and up to which way (m) they are apart.
    ///
    /// Those are left out that a sphere cannot touch before the lists are rebuilt, unless the contact is known.
    fn find_elements(&mut self, near: &NearSurface, shifts: &[Vec3]) {
        let Self { context, elements, .. } = self;
        let &NearSurface { at, body, range, known, .. } = near;
        let radius = body.radius + context.reach;
        let is_sphere = context.catalogue.shape(body.kind).is_sphere();
        elements.clear();
        for ([position, center], is_home) in Self::places(context, near, shifts) {
            at.surface.for_each_near(&center, range, |element| {
                let is_known = || known.iter().any(|m| m.element == element);
                if !is_sphere || is_known() {
                    elements.push((element, f64::NEG_INFINITY));
                    return;
                }
                let free_path = at.surface.free_path(element, &center, radius);
                let until = apart_until(0.0, free_path, [&position, &center], body.radius);
                if until < range - radius {
                    elements.push((element, if is_home { until } else { f64::NEG_INFINITY }));
                }
            });
        }
        sort(elements);
    }

    /// Finds the triangles of a mesh near a body that is no sphere, and facets that may stand for theirs; returns up to which way (m)
    /// of the body it is known which do.
    ///
    /// Of a facet and its triangles those are left out that are not met before the lists are rebuilt, unless a contact is known.
    fn find_triangles_and_facets(&mut self, near: &NearSurface, mesh: &WallMesh, shifts: &[Vec3]) -> f64 {
        let Self { context, elements, facets, .. } = self;
        let &NearSurface { at, body, range, .. } = near;
        let reach =
            context.catalogue.contacts.reach_between(body.kind.material, context.walls[at.wall].material);
        let (clearance, way) = (mesh.clearance(body.radius + reach), range - body.radius - context.reach);
        // So far that the rim is found if it can come near.
        let range = range.max(clearance + 1.01 * way);
        elements.clear();
        facets.clear();
        let (mut count, mut last) = (0, [Vec3::zeros(); 2]);
        for (place, _) in Self::places(context, near, shifts) {
            (count, last) = (count + 1, place);
            at.surface.for_each_near(&place[1], range, |triangle| {
                elements.push((triangle, f64::NEG_INFINITY));
                let facet = mesh.facet(triangle);
                if may_stand(facet, body.radius) {
                    let over = mesh.over_triangle(triangle, &place[1]);
                    match facets.iter_mut().find(|(first, _)| *first == facet.first) {
                        Some((_, joined)) => *joined = joined.joined(&over),
                        None => facets.push((facet.first, over.joined(&OverFacet::outside(range)))),
                    }
                }
            });
        }
        let mut rim_until = f64::INFINITY;
        for &(first, over) in facets.iter() {
            let is_of = |t: u32| triangle_of_facet(t).is_none() && mesh.facet(t).first == first;
            let facet = facet_element(first);
            let (is_met, free_path) = stands(&over, clearance);
            let until = apart_until(0.0, free_path, [&last[0], &last[1]], body.radius);
            let stays = count == 1 && until >= way;
            if stays && is_met && !near.known_elements().any(is_of) {
                elements.retain(|&(t, _)| !is_of(t));
            } else if stays && !is_met && !near.known_elements().any(|element| element == facet) {
                continue;
            } else {
                rim_until = f64::NEG_INFINITY;
            }
            elements.push((facet, f64::NEG_INFINITY));
        }
        sort(elements);
        rim_until
    }
}

/// Sorts elements, each once with the shorter way.
fn sort(elements: &mut Vec<(u32, f64)>) {
    elements.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    elements.dedup_by_key(|(element, _)| *element);
}

/// Box around one of the wall's frame, given by two corners (m), where the wall is now.
fn box_in_world([lower, upper]: &[Vec3; 2], state: &WallState) -> Aabb {
    let corner = |k: usize| {
        let local = Vec3::from_fn(|a, _| if k >> a & 1 == 0 { lower[a] } else { upper[a] });
        state.to_world(&local) + state.translation
    };
    let corners: [Vec3; 8] = std::array::from_fn(corner);
    let Aabb { lower, upper } = Aabb::around(&corners);
    let margin = ROUNDING * (lower.amax() + upper.amax());
    Aabb { lower: lower.add_scalar(-margin), upper: upper.add_scalar(margin) }
}
