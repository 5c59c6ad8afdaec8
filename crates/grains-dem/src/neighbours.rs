//! Verlet lists with a skin per particle, built from linked cells.
//!
//! A particle may move by its *reach* before the lists must be rebuilt; fast particles get a larger reach,
//! so that a few falling grains do not force a dense bed to rebuild. Reaches, and so the times of rebuilds,
//! cannot change a result: a pair remembers something only while its positions in consecutive steps say so.

use crate::bodies::{BodyList, BodyPair, PlacedPart, Pose};
use crate::dem::bytes;
use crate::images;
use crate::memory::{BodyMemory, ContactMemory, Memories, SphereMemory, WallMemory};
use crate::spheres::SpherePair;
use crate::walls::{Wall, WallList, WallPair, WallState};
use crate::{Body, Catalogue, Particles, Surface};
use grains_domain::{CellGrid, Cells, Decomposition, GlobalBox, SIZE_CLASSES, size_class};
use grains_geometry::obb::boxes_apart;
use grains_geometry::{Rotation, Vec3};
use std::ops::Range;

/// Time that a particle, a pair of parts of bodies and a pair with a wall take in a step, over that of a pair of spheres.
const WORK_OF_PARTICLE: u64 = 4;
const WORK_OF_PARTS: u64 = 10;
const WORK_AT_WALL: u64 = 2;

/// How far particles may move before lists are rebuilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// Smallest reach over radius (-).
    pub least: f64,
    /// Largest reach over radius (-).
    pub most: f64,
    /// Steps a particle should go at its present speed (-).
    pub horizon: f64,
}

impl Default for Skin {
    fn default() -> Self {
        Self { least: 0.025, most: 0.4, horizon: 60.0 }
    }
}

/// Where a particle was when the lists were built, and how far it may go from there.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Reference {
    pub(crate) position: Vec3,
    /// Reach (m).
    pub(crate) reach: f64,
}

/// The lists of one rank.
#[derive(Clone, Debug, Default)]
pub(crate) struct Neighbours {
    pub(crate) references: Vec<Reference>,
    /// Orientations when the lists were built; empty if all shapes are spheres.
    pub(crate) reference_orientations: Vec<Rotation>,
    pub(crate) spheres: Vec<SpherePair>,
    pub(crate) bodies: BodyList,
    pub(crate) walls: WallList,
    /// How many pairs, at the beginning of the lists, are of two owned particles.
    pub(crate) inner: Inner,
    /// Distance any wall may move before the lists are rebuilt (m).
    pub(crate) wall_reach: f64,
    // scratch
    reaches: Vec<f64>,
    probes: Vec<[f64; 4]>,
    owned_start: Vec<u32>,
    clone_start: Vec<u32>,
    clone_order: Vec<u32>,
    cells: Cells,
    cell_of_each: Vec<u32>,
    elements: Vec<u32>,
    near_parts: [Vec<u16>; 2],
}

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

/// Numbers of pairs of spheres, and of parts of bodies.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Inner {
    pub(crate) spheres: usize,
    pub(crate) bodies: usize,
}

/// What a search for pairs reads.
struct Search<'a> {
    particles: &'a Particles,
    /// Rows of the owned particles in `memories`.
    origins: &'a [u32],
    memories: &'a Memories,
    around: &'a Surroundings<'a>,
    all_spheres: bool,
}

impl Neighbours {
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

    /// Order of the particles in `stays` by cell, into `order`.
    pub(crate) fn sort_by_cell(
        &mut self,
        particles: &Particles,
        stays: &[u32],
        cells: Cells,
        order: &mut Vec<u32>,
    ) {
        self.cells = cells;
        let cell_of = |&i: &u32| {
            let body = &particles.bodies[i as usize];
            let grid = &self.cells.grids()[self.cells.grid_of(body.radius)];
            grid.index(grid.own_place(body.position.into())) as u32
        };
        self.cell_of_each.clear();
        self.cell_of_each.extend(stays.iter().map(cell_of));
        bin(&self.cell_of_each, self.cells.len(), &mut self.owned_start, order);
        for slot in order.iter_mut() {
            *slot = stays[*slot as usize];
        }
    }

    /// Reach of every owned particle (m), from its speed and the faces it must not cross unseen.
    pub(crate) fn choose_reaches(&mut self, particles: &Particles, around: &Surroundings) {
        let global = &around.decomposition.global;
        self.references.clear();
        self.reference_orientations.clear();
        for i in 0..particles.owned {
            let body = &particles.bodies[i];
            let mut reach = nominal_reach(body, around);
            for a in (0..3).filter(|&a| !global.periodic[a]) {
                // The lists are rebuilt in the very step in which a particle crosses a face.
                reach = reach.min(body.position[a] - global.lower[a]).min(global.upper[a] - body.position[a]);
            }
            self.references.push(Reference { position: body.position, reach });
        }
        self.reference_orientations.extend(particles.orientations.iter().take(particles.owned));
    }

    /// Builds all lists from sorted owned particles and their clones.
    pub(crate) fn build(
        &mut self,
        particles: &mut Particles,
        origins: &[u32],
        memories: &Memories,
        around: &Surroundings,
    ) {
        particles.travelled.fill(0.0);
        self.probe(particles, around);
        self.bin_clones(particles);
        self.spheres.clear();
        self.bodies.clear();
        let search =
            Search { particles, origins, memories, around, all_spheres: around.catalogue.all_spheres() };
        // Cells and their contents are lent to the search, which adds to the lists.
        let cells = std::mem::take(&mut self.cells);
        let (owned, clones) = (std::mem::take(&mut self.owned_start), std::mem::take(&mut self.clone_start));
        for (k, grid) in cells.grids().iter().enumerate() {
            self.pair_owned(&search, grid, &cells.grids()[..k], &owned);
        }
        self.inner = Inner { spheres: self.spheres.len(), bodies: self.bodies.pairs.len() };
        if particles.len() > particles.owned {
            for (k, grid) in cells.grids().iter().enumerate() {
                self.pair_with_clones(&search, &cells.grids()[..=k], grid, &owned, &clones);
                self.pair_small_clones(&search, &cells.grids()[..k], grid, &owned, &clones);
            }
        }
        (self.cells, self.owned_start, self.clone_start) = (cells, owned, clones);
        self.bodies.reserve();
        self.find_walls(&search);
    }

    /// Pairs of owned particles, those of one grid with each other and with larger ones.
    fn pair_owned(&mut self, search: &Search, grid: &CellGrid, coarser: &[CellGrid], start: &[u32]) {
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
    fn pair_with_clones(
        &mut self,
        search: &Search,
        coarser: &[CellGrid],
        grid: &CellGrid,
        owned: &[u32],
        clones: &[u32],
    ) {
        for i in held(owned, &grid.cells()) {
            let position = search.particles.bodies[i].position.into();
            for grid in coarser {
                let place = grid.own_place(position);
                if !grid.is_near_border(place) {
                    continue;
                }
                for run in grid.around(place) {
                    for slot in held(clones, &run) {
                        let clone = self.clone_order[slot] as usize;
                        self.pair_up(search, i, clone..clone + 1);
                    }
                }
            }
        }
    }

    /// Pairs of the clones of one grid with larger owned particles.
    fn pair_small_clones(
        &mut self,
        search: &Search,
        coarser: &[CellGrid],
        grid: &CellGrid,
        owned: &[u32],
        clones: &[u32],
    ) {
        for slot in held(clones, &grid.cells()) {
            let clone = self.clone_order[slot] as usize;
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
        let &Search { particles, origins, memories, around, .. } = search;
        self.walls.pairs.clear();
        self.walls.simplexes.clear();
        self.walls.shifts = images::shifts(&around.decomposition.global);
        let elements = std::mem::take(&mut self.elements);
        let mut near_walls = WallSearch { around, wall_reach: self.wall_reach, elements };
        for (i, &origin) in origins.iter().enumerate() {
            let known = memories.walls.row(origin as usize);
            near_walls.search(&mut self.walls, particles, i, self.references[i].reach, known);
        }
        self.elements = near_walls.elements;
    }

    /// Distance (m) from the centre within which owned particle `i` may act before the lists are rebuilt.
    pub(crate) fn range_of(&self, particles: &Particles, i: usize, film: f64) -> f64 {
        particles.bodies[i].radius + self.references[i].reach + 0.5 * film
    }

    /// Fills `probes` with position and radius plus reach and half a film of owned particles and clones.
    ///
    /// Faces may have shortened the reach of a clone for its owner; that only makes this list longer.
    fn probe(&mut self, particles: &Particles, around: &Surroundings) {
        self.probes.clear();
        self.reaches.clear();
        for (i, body) in particles.bodies.iter().enumerate() {
            let reach = match self.references.get(i) {
                Some(reference) => reference.reach,
                None => nominal_reach(body, around),
            };
            self.reaches.push(reach);
            let p = body.position;
            self.probes.push([p.x, p.y, p.z, body.radius + reach + 0.5 * around.film]);
        }
    }

    fn bin_clones(&mut self, particles: &Particles) {
        let clones = &particles.bodies[particles.owned..];
        let cell_of = |body: &Body| {
            let grid = &self.cells.grids()[self.cells.grid_of(body.radius)];
            grid.index(grid.place(body.position.into())) as u32
        };
        self.cell_of_each.clear();
        self.cell_of_each.extend(clones.iter().map(cell_of));
        bin(&self.cell_of_each, self.cells.len(), &mut self.clone_start, &mut self.clone_order);
        for slot in &mut self.clone_order {
            *slot += particles.owned as u32;
        }
    }

    /// Adds the pairs of owned particle `i` with the candidates within range.
    #[inline]
    fn pair_up(&mut self, search: &Search, i: usize, candidates: Range<usize>) {
        let [x, y, z, r] = self.probes[i];
        for j in candidates {
            let [xj, yj, zj, rj] = self.probes[j];
            let (dx, dy, dz, range) = (xj - x, yj - y, zj - z, r + rj);
            if dx * dx + dy * dy + dz * dz >= range * range {
                continue;
            }
            let &Search { particles, origins, memories, around, all_spheres } = search;
            let both_spheres = all_spheres
                || [i, j].iter().all(|&k| around.catalogue.shape(particles.bodies[k].kind).is_sphere());
            if both_spheres {
                let id = particles.ids[j];
                let known = memories.spheres.row(origins[i] as usize).iter().find(|m| m.partner == id);
                let spring = known.map_or(Vec3::zeros(), |m| m.spring);
                self.spheres.push(SpherePair { a: i as u32, b: j as u32, spring });
            } else {
                self.pair_parts(i, j, search);
            }
        }
    }

    /// Adds the pairs of parts of two bodies whose boxes come within reach.
    fn pair_parts(&mut self, i: usize, j: usize, search: &Search) {
        let &Search { particles, origins, memories, around, .. } = search;
        let (a, b) = if particles.ids[i] < particles.ids[j] { (i, j) } else { (j, i) };
        let margin = self.reaches[a] + self.reaches[b];
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
                let known = memories.bodies.row(origins[i] as usize).iter();
                let known = known.into_iter().find(|m| m.partner == partner && m.parts == parts);
                self.bodies.push([a, b].map(|i| i as u32), parts, &between, known.map(|m| m.contact));
            }
        }
        self.near_parts = near;
    }

    /// Gathers what all pairs remember into rows by owned particle.
    pub(crate) fn remember(
        &self,
        particles: &Particles,
        walls: &[Wall],
        global: &GlobalBox,
        memories: &mut Memories,
    ) {
        let owned = particles.owned as u32;
        let ids = &particles.ids;
        memories.fill(
            particles.owned,
            |add| {
                for pair in self.spheres.iter().filter(|p| p.spring != Vec3::zeros()) {
                    add(pair.a, SphereMemory { partner: ids[pair.b as usize], spring: pair.spring });
                    if pair.b < owned {
                        add(pair.b, SphereMemory { partner: ids[pair.a as usize], spring: -pair.spring });
                    }
                }
            },
            |add| {
                for (&BodyPair { a, b, parts, .. }, contact) in self.bodies.remembered() {
                    for (own, other) in [(a, b), (b, a)] {
                        if own < owned {
                            add(own, BodyMemory { partner: ids[other as usize], parts, contact: *contact });
                        }
                    }
                }
            },
            |add| {
                for pair in &self.walls.pairs {
                    let &WallPair { wall, surface, part, element, spring, twist, .. } = pair;
                    let simplex = self.walls.simplexes.get(pair.simplex as usize).copied();
                    let contact = ContactMemory { spring, twist, simplex: simplex.unwrap_or_default() };
                    if contact.is_empty() {
                        continue;
                    }
                    let wrapped =
                        walls[wall as usize].wrapped_axes(&walls[wall as usize].surfaces[surface as usize]);
                    let position = &particles.bodies[pair.particle as usize].position;
                    if let Some(image) = images::seen_from_wrapped(pair.image, position, global, wrapped) {
                        add(pair.particle, WallMemory { wall, surface, part, element, image, contact });
                    }
                }
            },
        );
    }

    /// What each owned particle costs in a step, in units of a pair of spheres.
    ///
    /// Pairs and particles are counted, not timed, so that borders lie alike in every run of a case.
    pub(crate) fn work_of_each(&self, owned: usize) -> Vec<u64> {
        let mut work = vec![WORK_OF_PARTICLE; owned];
        let mut add = |particle: u32, cost: u64| {
            if let Some(sum) = work.get_mut(particle as usize) {
                *sum += cost;
            }
        };
        self.spheres.iter().for_each(|pair| add(pair.a, 1));
        // One of two bodies may be a clone.
        self.bodies.pairs.iter().for_each(|pair| add(pair.a.min(pair.b), WORK_OF_PARTS));
        self.walls.pairs.iter().for_each(|pair| add(pair.particle, WORK_AT_WALL));
        work
    }

    /// The sum of it.
    pub(crate) fn work(&self, owned: usize) -> u64 {
        let [spheres, bodies, walls] = self.sizes().map(|n| n as u64);
        WORK_OF_PARTICLE * owned as u64 + spheres + WORK_OF_PARTS * bodies + WORK_AT_WALL * walls
    }

    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let Self { references, reference_orientations, spheres, bodies, walls, .. } = self;
        let Self { reaches, probes, owned_start, clone_start, clone_order, cell_of_each, .. } = self;
        bytes(references)
            + bytes(reference_orientations)
            + bytes(spheres)
            + bodies.bytes()
            + bytes(&walls.pairs)
            + bytes(&walls.simplexes)
            + bytes(reaches)
            + bytes(probes)
            + bytes(owned_start)
            + bytes(clone_start)
            + bytes(clone_order)
            + bytes(cell_of_each)
    }

    /// Number of pairs in the lists: spheres, bodies, walls.
    pub(crate) fn sizes(&self) -> [usize; 3] {
        [self.spheres.len(), self.bodies.pairs.len(), self.walls.pairs.len()]
    }
}

/// Reach of a body (m) by its size and speed: owner and clone agree on it, bit for bit.
fn nominal_reach(body: &Body, around: &Surroundings) -> f64 {
    let Surroundings { catalogue, skin, dt, .. } = around;
    let mut speed = body.velocity.norm();
    if !catalogue.shape(body.kind).is_sphere() {
        speed += body.radius * body.angular_velocity.norm();
    }
    (speed * skin.horizon * dt).clamp(skin.least * body.radius, skin.most * body.radius)
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

/// Counting sort: `order` lists the items cell by cell, those of cell c at `start[c]..start[c + 1]`.
fn bin(cells: &[u32], count: usize, start: &mut Vec<u32>, order: &mut Vec<u32>) {
    start.clear();
    start.resize(count + 1, 0);
    for &c in cells {
        start[c as usize + 1] += 1;
    }
    for c in 0..count {
        start[c + 1] += start[c];
    }
    order.clear();
    order.resize(cells.len(), 0);
    for (item, &c) in cells.iter().enumerate() {
        let at = &mut start[c as usize];
        order[*at as usize] = item as u32;
        *at += 1;
    }
    start.rotate_right(1);
    start[0] = 0;
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
                                || matches!(surface, Surface::Plane { .. } | Surface::Tube { .. });
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
