//! Verlet lists with a skin per particle, built from linked cells.
//!
//! A particle may move by its *reach* before the lists must be rebuilt; fast particles get a larger reach,
//! so that a few falling grains do not force a dense bed to rebuild. Reaches, and so the times of rebuilds,
//! cannot change a result: a pair remembers something only while its positions in consecutive steps say so.

use crate::bodies::{BodyList, BodyPair, PlacedPart, Pose};
use crate::images;
use crate::memory::{BodyMemory, ContactMemory, Memories, SphereMemory, WallMemory};
use crate::spheres::SpherePair;
use crate::walls::{Wall, WallList, WallPair, WallState};
use crate::{Body, Catalogue, Particles, Surface};
use grains_domain::{CellGrid, Decomposition, GlobalBox};
use grains_geometry::obb::boxes_apart;
use grains_geometry::{Rotation, Vec3};

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
    /// Distance any wall may move before the lists are rebuilt (m).
    pub(crate) wall_reach: f64,
    // scratch
    reaches: Vec<f64>,
    probes: Vec<[f64; 4]>,
    owned_start: Vec<u32>,
    clone_start: Vec<u32>,
    clone_order: Vec<u32>,
    cells: Vec<u32>,
    elements: Vec<u32>,
    near_parts: [Vec<u16>; 2],
}

/// What list building needs to know besides the particles.
pub(crate) struct Surroundings<'a> {
    pub(crate) decomposition: &'a Decomposition,
    pub(crate) grid: &'a CellGrid,
    pub(crate) catalogue: &'a Catalogue,
    pub(crate) walls: &'a [Wall],
    pub(crate) states: &'a [WallState],
    pub(crate) skin: Skin,
    /// Thickness of the films of fluid that act between spheres (m).
    pub(crate) film: f64,
    pub(crate) dt: f64,
    /// Time of the positions (s).
    pub(crate) time: f64,
}

impl Neighbours {
    /// Order of the particles in `stays` by cell, into `order`.
    pub(crate) fn sort_by_cell(
        &mut self,
        particles: &Particles,
        stays: &[u32],
        grid: &CellGrid,
        order: &mut Vec<u32>,
    ) {
        let cell_of =
            |i: u32| grid.index(grid.own_place(particles.bodies[i as usize].position.into())) as u32;
        self.cells.clear();
        self.cells.extend(stays.iter().map(|&i| cell_of(i)));
        bin(&self.cells, grid.len(), &mut self.owned_start, order);
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
        self.bin_clones(particles, around.grid);
        self.spheres.clear();
        self.bodies.clear();
        self.walls.pairs.clear();
        self.walls.simplexes.clear();
        let all_spheres = around.catalogue.all_spheres();
        let grid = around.grid;
        let mut near_walls =
            WallSearch { around, wall_reach: self.wall_reach, elements: std::mem::take(&mut self.elements) };
        self.walls.shifts = images::shifts(&around.decomposition.global);
        for (i, &origin) in origins.iter().enumerate() {
            let [x, y, z] = grid.own_place(particles.bodies[i].position.into());
            for (dy, dz) in [(0, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                let (row_y, row_z) = (y as isize + dy, z as isize + dz);
                let row = (row_z as usize * grid.counts[1] + row_y as usize) * grid.counts[0] + x;
                let own_row = dy == 0 && dz == 0;
                let start = if own_row { i + 1 } else { self.owned_start[row - 1] as usize };
                let end = self.owned_start[row + 2] as usize;
                self.pair_up(i, start..end, particles, origin, memories, around, all_spheres);
            }
            if !self.clone_order.is_empty() && near_border([x, y, z], grid) {
                for dz in -1..=1 {
                    for dy in -1..=1 {
                        let row = ((z as isize + dz) as usize * grid.counts[1] + (y as isize + dy) as usize)
                            * grid.counts[0]
                            + x;
                        let range = self.clone_start[row - 1] as usize..self.clone_start[row + 2] as usize;
                        for k in range {
                            let j = self.clone_order[k] as usize;
                            self.pair_up(i, j..j + 1, particles, origin, memories, around, all_spheres);
                        }
                    }
                }
            }
            near_walls.search(
                &mut self.walls,
                particles,
                i,
                self.references[i].reach,
                memories.walls.row(origin as usize),
            );
        }
        self.elements = near_walls.elements;
        self.bodies.reserve();
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

    fn bin_clones(&mut self, particles: &Particles, grid: &CellGrid) {
        self.cells.clear();
        let clones = &particles.bodies[particles.owned..];
        self.cells.extend(clones.iter().map(|b| grid.index(grid.place(b.position.into())) as u32));
        bin(&self.cells, grid.len(), &mut self.clone_start, &mut self.clone_order);
        for slot in &mut self.clone_order {
            *slot += particles.owned as u32;
        }
    }

    /// Adds the pairs of particle `i` with the candidates within range.
    #[allow(clippy::too_many_arguments)] // inner loop: a struct built per particle would cost time
    #[inline]
    fn pair_up(
        &mut self,
        i: usize,
        candidates: std::ops::Range<usize>,
        particles: &Particles,
        origin: u32,
        memories: &Memories,
        around: &Surroundings,
        all_spheres: bool,
    ) {
        let [x, y, z, r] = self.probes[i];
        for j in candidates {
            let [xj, yj, zj, rj] = self.probes[j];
            let (dx, dy, dz, range) = (xj - x, yj - y, zj - z, r + rj);
            if dx * dx + dy * dy + dz * dz >= range * range {
                continue;
            }
            let both_spheres = all_spheres
                || [i, j].iter().all(|&k| around.catalogue.shape(particles.bodies[k].kind).is_sphere());
            if both_spheres {
                let id = particles.ids[j];
                let known = memories.spheres.row(origin as usize).iter().find(|m| m.partner == id);
                let spring = known.map_or(Vec3::zeros(), |m| m.spring);
                self.spheres.push(SpherePair { a: i as u32, b: j as u32, spring });
            } else {
                self.pair_parts(i, j, particles, origin, memories, around);
            }
        }
    }

    /// Adds the pairs of parts of two bodies whose boxes come within reach.
    fn pair_parts(
        &mut self,
        i: usize,
        j: usize,
        particles: &Particles,
        origin: u32,
        memories: &Memories,
        around: &Surroundings,
    ) {
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
                let known = memories.bodies.row(origin as usize).iter();
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

fn near_border(place: [usize; 3], grid: &CellGrid) -> bool {
    (0..3).any(|a| place[a] == 1 || place[a] == grid.counts[a] - 2)
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
