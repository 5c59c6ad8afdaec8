//! The search for the pairs of the lists: particles sorted by cell, and what may touch in the cells around.

use super::{Inner, Neighbours, nominal_reach};
use crate::bodies::{PlacedPart, Pose};
use crate::images;
use crate::memory::{Memories, WallMemory};
use crate::spheres::SpherePair;
use crate::walls::{Wall, WallList, WallPair, WallState};
use crate::{Body, Catalogue, Particles, Skin, Surface};
use grains_domain::{CellGrid, Cells, Decomposition, SIZE_CLASSES, size_class};
use grains_geometry::Vec3;
use grains_geometry::obb::boxes_apart;
use std::ops::Range;

/// What list building needs to know besides the particles.
pub(crate) struct Surroundings<'a> {
    pub(crate) decomposition: &'a Decomposition,
    pub(crate) catalogue: &'a Catalogue,
    pub(crate) walls: &'a [Wall],
    pub(crate) states: &'a [WallState],
    pub(crate) skin: Skin,
    /// Largest bounding radius of any particle (m).
    pub(crate) largest_radius: f64,
    /// Thickness of the films of fluid that act between spheres (m).
    pub(crate) film: f64,
    pub(crate) dt: f64,
    /// Time of the positions (s).
    pub(crate) time: f64,
}

/// How far from its centre (m) a particle among `stays` may act before the lists are rebuilt, at most, per class of
/// sizes; and how many there are of each.
pub(crate) fn widest(
    particles: &Particles,
    stays: &[u32],
    around: &Surroundings,
) -> ([f64; SIZE_CLASSES], [usize; SIZE_CLASSES]) {
    let (mut widest, mut counts) = ([0.0; SIZE_CLASSES], [0; SIZE_CLASSES]);
    for &i in stays {
        let body = &particles.bodies[i as usize];
        let class = size_class(body.radius, around.largest_radius);
        widest[class] =
            f64::max(widest[class], body.radius + nominal_reach(body, around) + 0.5 * around.film);
        counts[class] += 1;
    }
    (widest, counts)
}

/// The owned particles sorted by cell.
pub(crate) struct Sorted {
    /// What places they had before.
    pub(crate) order: Vec<u32>,
    cells: Cells,
    /// The first of every cell.
    start: Vec<u32>,
}

impl Sorted {
    /// Sorts the particles in `stays`.
    pub(crate) fn new(particles: &Particles, stays: &[u32], cells: Cells) -> Self {
        let cell_of = |&i: &u32| {
            let body = &particles.bodies[i as usize];
            let grid = &cells.grids()[cells.grid_of(body.radius)];
            grid.index(grid.own_place(body.position.into())) as u32
        };
        let (start, mut order) = bin(&stays.iter().map(cell_of).collect::<Vec<_>>(), cells.len());
        order.iter_mut().for_each(|slot| *slot = stays[*slot as usize]);
        Self { order, cells, start }
    }
}

/// The clones by cell.
#[derive(Default)]
struct Clones {
    order: Vec<u32>,
    /// The first of every cell in `order`.
    start: Vec<u32>,
}

impl Clones {
    fn new(particles: &Particles, cells: &Cells) -> Self {
        let cell_of = |body: &Body| {
            let grid = &cells.grids()[cells.grid_of(body.radius)];
            grid.index(grid.place(body.position.into())) as u32
        };
        let clones = particles.bodies[particles.owned..].iter().map(cell_of);
        let (start, mut order) = bin(&clones.collect::<Vec<_>>(), cells.len());
        order.iter_mut().for_each(|slot| *slot += particles.owned as u32);
        Self { order, start }
    }
}

/// What a search for pairs reads.
struct Search<'a> {
    particles: &'a Particles,
    sorted: &'a Sorted,
    clones: Clones,
    /// Position, and radius plus reach and half a film (m), of owned particles and clones.
    probes: Vec<[f64; 4]>,
    /// By the places of the owned particles before they were sorted.
    memories: &'a Memories,
    around: &'a Surroundings<'a>,
    all_spheres: bool,
}

impl Search<'_> {
    /// Reach of a particle (m).
    fn reach(&self, i: usize) -> f64 {
        self.probes[i][3] - self.particles.bodies[i].radius - 0.5 * self.around.film
    }
}

impl Neighbours {
    /// Builds all lists from sorted owned particles and their clones.
    pub(crate) fn build(
        &mut self,
        particles: &mut Particles,
        sorted: &Sorted,
        memories: &Memories,
        around: &Surroundings,
    ) {
        particles.travelled.fill(0.0);
        self.spheres.clear();
        self.bodies.clear();
        let has_clones = particles.len() > particles.owned;
        let clones = if has_clones { Clones::new(particles, &sorted.cells) } else { Clones::default() };
        let (probes, all_spheres) = (self.probes(particles, around), around.catalogue.all_spheres());
        let search = Search { particles, sorted, clones, probes, memories, around, all_spheres };
        let grids = sorted.cells.grids();
        for (k, grid) in grids.iter().enumerate() {
            self.pair_owned(&search, grid, &grids[..k]);
        }
        self.inner = Inner { spheres: self.spheres.len(), bodies: self.bodies.pairs.len() };
        if has_clones {
            for (k, grid) in grids.iter().enumerate() {
                self.pair_with_clones(&search, &grids[..=k], grid);
                self.pair_small_clones(&search, &grids[..k], grid);
            }
        }
        self.bodies.reserve();
        self.find_walls(&search);
    }

    /// Pairs of owned particles, those of one grid with each other and with larger ones.
    fn pair_owned(&mut self, search: &Search, grid: &CellGrid, coarser: &[CellGrid]) {
        let start = &search.sorted.start;
        for i in held(start, &grid.cells()) {
            let position = search.particles.bodies[i].position.into();
            for (k, run) in grid.half_around(grid.own_place(position)).iter().enumerate() {
                let first = if k == 0 { i + 1 } else { start[run.start] as usize };
                self.pair_up(search, i, first..start[run.end] as usize);
            }
            for grid in coarser.iter().filter(|grid| !held(start, &grid.cells()).is_empty()) {
                for run in grid.around(grid.own_place(position)) {
                    self.pair_up(search, i, held(start, &run));
                }
            }
        }
    }

    /// Pairs of the owned particles of one grid with clones of their size and larger ones.
    fn pair_with_clones(&mut self, search: &Search, coarser: &[CellGrid], grid: &CellGrid) {
        let (owned, clones) = (&search.sorted.start, &search.clones);
        for i in held(owned, &grid.cells()) {
            let position = search.particles.bodies[i].position.into();
            for grid in coarser {
                let place = grid.own_place(position);
                if !grid.is_near_border(place) {
                    continue;
                }
                for run in grid.around(place) {
                    for slot in held(&clones.start, &run) {
                        let clone = clones.order[slot] as usize;
                        self.pair_up(search, i, clone..clone + 1);
                    }
                }
            }
        }
    }

    /// Pairs of the clones of one grid with larger owned particles.
    fn pair_small_clones(&mut self, search: &Search, coarser: &[CellGrid], grid: &CellGrid) {
        let (owned, clones) = (&search.sorted.start, &search.clones);
        for slot in held(&clones.start, &grid.cells()) {
            let clone = clones.order[slot] as usize;
            let position = search.particles.bodies[clone].position.into();
            for grid in coarser.iter().filter(|grid| !held(owned, &grid.cells()).is_empty()) {
                for run in grid.around(grid.place(position)) {
                    for i in held(owned, &run) {
                        self.pair_up(search, i, clone..clone + 1);
                    }
                }
            }
        }
    }

    /// Pairs of owned particles with walls.
    fn find_walls(&mut self, search: &Search) {
        let &Search { particles, sorted, memories, around, .. } = search;
        self.walls.pairs.clear();
        self.walls.simplexes.clear();
        self.walls.shifts = images::shifts(&around.decomposition.global);
        let mut near_walls = WallSearch { around, wall_reach: self.wall_reach, elements: Vec::new() };
        for (i, &origin) in sorted.order.iter().enumerate() {
            if particles.bodies[i].is_guided() {
                continue;
            }
            let known = memories.walls.row(origin as usize);
            near_walls.search(&mut self.walls, particles, i, self.references[i].reach, known);
        }
    }

    /// Position, and radius plus reach and half a film (m), of owned particles and clones.
    ///
    /// Faces may have shortened the reach of a clone for its owner; that only makes this list longer.
    fn probes(&self, particles: &Particles, around: &Surroundings) -> Vec<[f64; 4]> {
        let probe = |(i, body): (usize, &Body)| {
            let reach = self.references.get(i).map_or_else(|| nominal_reach(body, around), |own| own.reach);
            let p = body.position;
            [p.x, p.y, p.z, body.radius + reach + 0.5 * around.film]
        };
        particles.bodies.iter().enumerate().map(probe).collect()
    }

    /// Adds the pairs of owned particle `i` with the candidates within range.
    #[inline]
    fn pair_up(&mut self, search: &Search, i: usize, candidates: Range<usize>) {
        let [x, y, z, r] = search.probes[i];
        for j in candidates {
            let [xj, yj, zj, rj] = search.probes[j];
            let (dx, dy, dz, range) = (xj - x, yj - y, zj - z, r + rj);
            if dx * dx + dy * dy + dz * dz >= range * range {
                continue;
            }
            let &Search { particles, sorted, memories, around, all_spheres, .. } = search;
            if particles.bodies[i].is_guided() && particles.bodies[j].is_guided() {
                continue;
            }
            let both_spheres = all_spheres
                || [i, j].iter().all(|&k| around.catalogue.shape(particles.bodies[k].kind).is_sphere());
            if both_spheres {
                let id = particles.ids[j];
                let known = memories.spheres.row(sorted.order[i] as usize).iter().find(|m| m.partner == id);
                let spring = known.map_or(Vec3::zeros(), |m| m.spring);
                if self.spheres.len() == self.spheres.capacity() {
                    // Pairs are a quarter of all memory: they do not double.
                    self.spheres.reserve_exact(self.spheres.len() / 8 + 64);
                }
                self.spheres.push(SpherePair { a: i as u32, b: j as u32, spring });
            } else {
                self.pair_parts(i, j, search);
            }
        }
    }

    /// Adds the pairs of parts of two bodies whose boxes come within reach.
    fn pair_parts(&mut self, i: usize, j: usize, search: &Search) {
        let &Search { particles, sorted, memories, around, .. } = search;
        let (a, b) = if particles.ids[i] < particles.ids[j] { (i, j) } else { (j, i) };
        let margin = search.reach(a) + search.reach(b);
        let separation = particles.bodies[b].position - particles.bodies[a].position;
        let mut near = std::mem::take(&mut self.near_parts);
        parts_near(&mut near[0], particles, a, (b, &separation), margin, around.catalogue);
        parts_near(&mut near[1], particles, b, (a, &-separation), margin, around.catalogue);
        let poses = [a, b].map(|i| Pose::of(particles, i, around.catalogue));
        for &part in &near[0] {
            let part_a = PlacedPart::of(&poses[0], part);
            for &other in &near[1] {
                let part_b = PlacedPart::of(&poses[1], other);
                let between = separation + (part_b.offset - part_a.offset);
                let range = part_a.bounding_radius + part_b.bounding_radius + margin;
                if between.norm_squared() >= range * range {
                    continue;
                }
                let placement = part_a.placement(&part_b.rotation, part_b.scale, &between);
                let half = |k: usize, part: u16| &poses[k].shape.parts[part as usize].half_extents;
                if boxes_apart(half(0, part), half(1, other), &placement, margin / part_a.scale) {
                    continue;
                }
                let (partner, parts) = (particles.ids[j], [part, other]);
                let known = memories.bodies.row(sorted.order[i] as usize).iter();
                let known = known.into_iter().find(|m| m.partner == partner && m.parts == parts);
                self.bodies.push([a, b].map(|i| i as u32), parts, &between, known.map(|m| m.contact));
            }
        }
        self.near_parts = near;
    }
}

/// The parts of particle `i` within `margin` (m) of the bounding sphere of another, `separation` (m) away.
fn parts_near(
    near: &mut Vec<u16>,
    particles: &Particles,
    i: usize,
    (other, separation): (usize, &Vec3),
    margin: f64,
    catalogue: &Catalogue,
) {
    let body = &particles.bodies[i];
    let shape = catalogue.shape(body.kind);
    let scale = body.radius / shape.bounding_radius;
    let reach = particles.bodies[other].radius + margin;
    near.clear();
    near.extend((0..shape.parts.len() as u16).filter(|&k| {
        let part = &shape.parts[k as usize];
        let range = part.bounding_radius * scale + reach;
        shape.parts.len() == 1
            || (separation - particles.frames[i] * part.center * scale).norm_squared() < range * range
    }));
}

/// The slots of a run of cells.
fn held(start: &[u32], cells: &Range<usize>) -> Range<usize> {
    start[cells.start] as usize..start[cells.end] as usize
}

/// Counting sort: the first item of every cell, and the items cell by cell.
fn bin(cells: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0; count + 1];
    for &c in cells {
        start[c as usize + 1] += 1;
    }
    for c in 0..count {
        start[c + 1] += start[c];
    }
    let mut order = vec![0; cells.len()];
    for (item, &c) in cells.iter().enumerate() {
        let at = &mut start[c as usize];
        order[*at as usize] = item as u32;
        *at += 1;
    }
    start.rotate_right(1);
    start[0] = 0;
    (start, order)
}

/// Search for the walls near a particle and its periodic images.
struct WallSearch<'a> {
    around: &'a Surroundings<'a>,
    wall_reach: f64,
    elements: Vec<u32>,
}

impl WallSearch<'_> {
    /// Adds the wall pairs of an owned particle.
    fn search(
        &mut self,
        list: &mut WallList,
        particles: &Particles,
        i: usize,
        reach: f64,
        known: &[WallMemory],
    ) {
        let body = &particles.bodies[i];
        let shape = self.around.catalogue.shape(body.kind);
        let global = &self.around.decomposition.global;
        let range = body.radius + reach + self.around.film + self.wall_reach;
        for (w, wall) in self.around.walls.iter().enumerate().filter(|(_, w)| self.around.time < w.until) {
            let state = &self.around.states[w];
            for (s, surface) in wall.surfaces.iter().enumerate() {
                let wrapped = wall.wrapped_axes(surface);
                for image in images::near_faces(global, &body.position, range, wrapped.map(|w| !w)) {
                    self.elements.clear();
                    // Near a face it may soon be met at the other one.
                    for alias in images::near_faces(global, &body.position, range, wrapped) {
                        let shift = list.shifts[image as usize] + list.shifts[alias as usize];
                        let center = state.to_wall(&(body.position + shift));
                        surface.for_each_near(&center, range, |e| self.elements.push(e));
                    }
                    self.elements.sort_unstable();
                    self.elements.dedup();
                    for part in 0..shape.parts.len() as u16 {
                        for &element in &self.elements {
                            let key = (w as u16, s as u16, part, element, image);
                            let known =
                                known.iter().find(|m| (m.wall, m.surface, m.part, m.element, m.image) == key);
                            let memory = known.map(|m| m.contact).unwrap_or_default();
                            let closed = shape.is_sphere()
                                || matches!(
                                    surface,
                                    Surface::Plane { .. } | Surface::Tube { .. } | Surface::OpenTube(_)
                                );
                            let simplex = if closed {
                                WallPair::CLOSED_FORM
                            } else {
                                list.simplexes.push(memory.simplex);
                                list.simplexes.len() as u32 - 1
                            };
                            list.pairs.push(WallPair {
                                particle: i as u32,
                                element,
                                wall: w as u16,
                                surface: s as u16,
                                part,
                                image,
                                spring: memory.spring,
                                twist: memory.twist,
                                simplex,
                            });
                        }
                    }
                }
            }
        }
    }
}
