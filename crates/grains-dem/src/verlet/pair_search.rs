//! The search for the pairs of the lists in the surrounding cells.

use super::allowances::clone_allowance;
use super::cell_list::{CellList, Clones, held};
use super::list_context::ListContext;
use super::lists::{Inner, VerletLists};
use super::wall_search::WallSearch;
use crate::bonds::{Made, are_bonded};
use crate::catalogue::Catalogue;
use crate::contact_history::SavedHistories;
use crate::contacts::SpherePair;
use crate::error::StepError;
use crate::narrow_phase::{PlacedPart, Pose};
use crate::particles::{Body, Particles};
use crate::periodic_images as images;
use grains_domain::CellGrid;
use grains_geometry::Vec3;
use grains_geometry::obb::boxes_apart;
use std::ops::Range;

/// What a search for pairs reads.
struct Search<'a> {
    particles: &'a Particles,
    cell_list: &'a CellList,
    clones: Clones,
    /// Position, and radius plus allowance and half the reach (m), of owned particles and clones.
    probes: Vec<[f64; 4]>,
    /// By the places of the owned particles before they were sorted.
    histories: &'a SavedHistories,
    context: &'a ListContext<'a>,
    all_spheres: bool,
    has_bonds: bool,
}

/// What became of bonds while lists were built: numbers of ends of owned particles.
#[derive(Debug, Default)]
pub(crate) struct BondChanges {
    /// Bonds made.
    pub(crate) made: Made,
    /// Ends whose partner has left the box.
    pub(crate) left: u64,
    pub(crate) error: Option<StepError>,
}

impl Search<'_> {
    /// Allowance of a particle (m).
    fn allowance(&self, i: usize) -> f64 {
        self.probes[i][3] - self.particles.bodies[i].radius - 0.5 * self.context.reach
    }
}

impl VerletLists {
    /// Builds all lists from sorted owned particles and their clones.
    pub(crate) fn build(
        &mut self,
        particles: &mut Particles,
        cell_list: &CellList,
        histories: &SavedHistories,
        context: &ListContext,
    ) -> BondChanges {
        particles.path_length.fill(0.0);
        self.spheres.clear();
        self.sphere_laws.clear();
        self.part_pairs.clear();
        self.resting.spheres.clear();
        self.resting.part_pairs.clear();
        let has_clones = particles.len() > particles.owned;
        let clones = if has_clones { Clones::new(particles, &cell_list.cells) } else { Clones::default() };
        let (probes, all_spheres) = (self.probes(particles, context), context.catalogue.all_spheres());
        let has_bonds = !histories.bonds.is_empty() || context.forming.is_some();
        let search =
            Search { particles, cell_list, clones, probes, histories, context, all_spheres, has_bonds };
        self.find_bonds(&search);
        let grids = cell_list.cells.grids();
        for (k, grid) in grids.iter().enumerate() {
            self.pair_owned(&search, grid, &grids[..k]);
        }
        self.inner = Inner { spheres: self.spheres.len(), part_pairs: self.part_pairs.pairs.len() };
        if has_clones {
            for (k, grid) in grids.iter().enumerate() {
                self.pair_with_clones(&search, &grids[..=k], grid);
                self.pair_small_clones(&search, &grids[..k], grid);
            }
        }
        self.part_pairs.reserve();
        self.resting.part_pairs.reserve();
        self.find_walls(&search);
        self.bonds.sort(particles.owned);
        std::mem::take(&mut self.bond_changes)
    }

    /// Finds the bonds there are; those to be made follow with the pairs.
    fn find_bonds(&mut self, search: &Search) {
        let &Search { particles, cell_list, histories, context, .. } = search;
        match self.bonds.find(particles, histories, &cell_list.order, context.may_leave) {
            Ok(left) => self.bond_changes.left = left,
            Err(error) => self.bond_changes.error = Some(error),
        }
    }

    /// Whether two particles are bonded, maybe from now on.
    fn bonds_pair(&mut self, search: &Search, i: usize, j: usize) -> bool {
        let &Search { particles, cell_list, histories, context, .. } = search;
        let (bonds, made) = (&mut self.bonds, &mut self.bond_changes.made);
        are_bonded(histories, cell_list.order[i] as usize, particles.ids[j])
            || context
                .forming
                .is_some_and(|forming| forming.bond(bonds, particles, [i, j], context.catalogue, made))
    }

    /// Pairs of owned particles, those of one grid with each other and with larger ones.
    fn pair_owned(&mut self, search: &Search, grid: &CellGrid, coarser: &[CellGrid]) {
        let start = &search.cell_list.start;
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
        let (owned, clones) = (&search.cell_list.start, &search.clones);
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
        let (owned, clones) = (&search.cell_list.start, &search.clones);
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
        let &Search { particles, cell_list, histories, context, .. } = search;
        for list in [&mut self.walls, &mut self.resting.walls] {
            list.clear();
            list.keep_laws = context.catalogue.contacts.keep_law_history();
            list.shifts = images::shifts(&context.decomposition.global);
        }
        let mut near_walls =
            WallSearch { context, wall_allowance: self.wall_allowance, elements: Vec::new() };
        for (i, &origin) in cell_list.order.iter().enumerate() {
            if particles.bodies[i].is_prescribed() {
                if context.conducts {
                    let allowance = self.references[i].allowance;
                    near_walls.search(&mut self.resting.walls, particles, i, allowance, &[]);
                }
                continue;
            }
            let known = histories.walls.row(origin as usize);
            near_walls.search(&mut self.walls, particles, i, self.references[i].allowance, known);
        }
    }

    /// Position, and radius plus allowance and half the reach (m), of owned particles and clones.
    ///
    /// Faces may have shortened the allowance of a clone for its owner; that only makes this list longer.
    fn probes(&self, particles: &Particles, context: &ListContext) -> Vec<[f64; 4]> {
        let probe = |(i, body): (usize, &Body)| {
            let allowance =
                self.references.get(i).map_or_else(|| clone_allowance(body, context), |own| own.allowance);
            let p = body.position;
            [p.x, p.y, p.z, body.radius + allowance + 0.5 * context.reach]
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
            let &Search { particles, cell_list, histories, context, all_spheres, .. } = search;
            let is_resting = particles.bodies[i].is_prescribed() && particles.bodies[j].is_prescribed();
            if is_resting && !context.conducts {
                continue;
            }
            if !is_resting && search.has_bonds && self.bonds_pair(search, i, j) {
                continue;
            }
            let both_spheres = all_spheres
                || [i, j].iter().all(|&k| context.catalogue.shape(particles.bodies[k].kind).is_sphere());
            if is_resting && both_spheres {
                let tangential_displacement = Vec3::zeros();
                let pair = SpherePair { a: i as u32, b: j as u32, tangential_displacement };
                self.resting.spheres.push(pair);
            } else if both_spheres {
                let (id, row) = (particles.ids[j], cell_list.order[i] as usize);
                let of_row = histories.spheres.row(row);
                let known = of_row.iter().position(|m| m.partner == id);
                let tangential_displacement =
                    known.map_or(Vec3::zeros(), |k| of_row[k].tangential_displacement);
                if self.spheres.len() == self.spheres.capacity() {
                    // Pairs are a quarter of all memory: they do not double.
                    self.spheres.reserve_exact(self.spheres.len() / 8 + 64);
                }
                self.spheres.push(SpherePair { a: i as u32, b: j as u32, tangential_displacement });
                if context.catalogue.contacts.keep_law_history() {
                    let law = known.and_then(|k| histories.sphere_laws.row(row).get(k));
                    self.sphere_laws.push(law.copied().unwrap_or_default());
                }
            } else {
                self.pair_parts(i, j, is_resting, search);
            }
        }
    }

    /// Adds the pairs of parts of two bodies whose boxes come within allowance.
    fn pair_parts(&mut self, i: usize, j: usize, is_resting: bool, search: &Search) {
        let &Search { particles, cell_list, histories, context, .. } = search;
        let (a, b) = if particles.ids[i] < particles.ids[j] { (i, j) } else { (j, i) };
        let margin = search.allowance(a) + search.allowance(b) + context.catalogue.contacts.reach();
        let separation = particles.bodies[b].position - particles.bodies[a].position;
        let mut near = std::mem::take(&mut self.near_parts);
        parts_near(&mut near[0], particles, a, (b, &separation), margin, context.catalogue);
        parts_near(&mut near[1], particles, b, (a, &-separation), margin, context.catalogue);
        let poses = [a, b].map(|i| Pose::of(particles, i, context.catalogue));
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
                let known = histories.part_pairs.row(cell_list.order[i] as usize).iter();
                let known = known.into_iter().find(|m| m.partner == partner && m.parts == parts);
                let list = if is_resting { &mut self.resting.part_pairs } else { &mut self.part_pairs };
                list.push([a, b].map(|i| i as u32), parts, &between, known.map(|m| m.contact));
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
    let allowance = particles.bodies[other].radius + margin;
    near.clear();
    near.extend((0..shape.parts.len() as u16).filter(|&k| {
        let part = &shape.parts[k as usize];
        let range = part.bounding_radius * scale + allowance;
        shape.parts.len() == 1
            || (separation - particles.frames[i] * part.center * scale).norm_squared() < range * range
    }));
}
