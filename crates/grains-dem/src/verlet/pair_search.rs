//! The search for the pairs of the lists in the surrounding cells.

use super::cell_list::{CellList, Clones, held};
use super::list_context::ListContext;
use super::lists::{Inner, VerletLists};
use super::references::{Reference, References};
use super::wall_search::WallSearch;
use crate::bonds::{Made, are_bonded};
use crate::contact_history::SavedHistories;
use crate::contacts::SpherePair;
use crate::error::StepError;
use crate::memory_use::make_room;
use crate::narrow_phase::{PlacedPart, Pose, widest_gap};
use crate::particles::{Body, Particles};
use crate::periodic_images as images;
use crate::rotation::frame;
use grains_domain::CellGrid;
use grains_geometry::obb::axis_of_widest_gap;
use grains_geometry::{Mat3, Vec3};
use std::ops::Range;

/// What a search for pairs reads.
struct Search<'a> {
    particles: &'a Particles,
    references: &'a References,
    cell_list: &'a CellList,
    clones: Clones,
    /// Position of the reference, and radius plus allowance and half the reach (m), of owned particles and clones.
    probes: Vec<[f64; 4]>,
    histories: &'a SavedHistories,
    /// Rows of the owned particles in the histories: what places they had before they were sorted; the same if they were not.
    order: Option<&'a [u32]>,
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

    /// Row of owned particle `i` in the histories.
    #[inline]
    fn row(&self, i: usize) -> usize {
        self.order.map_or(i, |order| order[i] as usize)
    }

    /// Rotation of a particle where its reference is.
    fn frame(&self, i: usize) -> Mat3 {
        let reference = &self.references.orientations[i];
        match *reference == self.particles.orientations[i] {
            true => self.particles.frames[i],
            false => frame(reference),
        }
    }
}

/// Position of the reference, and radius plus allowance and half the reach (m), of owned particles and clones.
fn probes(particles: &Particles, references: &[Reference], context: &ListContext) -> Vec<[f64; 4]> {
    let probe = |(body, reference): (&Body, &Reference)| {
        let Reference { position: p, mut allowance } = *reference;
        // Beyond the border that images slide along, how far they may slide.
        if context.images.is_some_and(|images| images.side(&p) != 0.0) {
            allowance += context.slide;
        }
        [p.x, p.y, p.z, body.radius + allowance + 0.5 * context.reach]
    };
    particles.bodies.iter().zip(references).map(probe).collect()
}

impl VerletLists {
    /// Builds all lists from sorted owned particles and their clones; `order` holds what places they had before.
    pub(crate) fn build(
        &mut self,
        particles: &mut Particles,
        cell_list: &CellList,
        (histories, order): (&SavedHistories, &[u32]),
        context: &ListContext,
    ) -> BondChanges {
        particles.path_length.fill(0.0);
        self.forget_pairs(Inner::default(), context);
        self.search_with(particles, cell_list, (histories, Some(order)), context, |lists, search| {
            let grids = cell_list.cells.grids();
            for (k, grid) in grids.iter().enumerate() {
                lists.pair_owned(search, grid, &grids[..k]);
            }
            lists.inner = lists.numbers();
            lists.pair_all_with_clones(search);
            lists.find_walls(search);
        })
    }

    /// Builds the lists of pairs with clones anew, as clones have changed; owned particles are where they were.
    ///
    /// `histories` are of these pairs, and of all bonds.
    pub(crate) fn rebuild_border(
        &mut self,
        particles: &Particles,
        cell_list: &CellList,
        histories: &SavedHistories,
        context: &ListContext,
    ) -> BondChanges {
        self.forget_pairs(self.inner, context);
        self.search_with(particles, cell_list, (histories, None), context, Self::pair_all_with_clones)
    }

    /// Searches for pairs; the bonds are found before and sorted after.
    fn search_with(
        &mut self,
        particles: &Particles,
        cell_list: &CellList,
        (histories, order): (&SavedHistories, Option<&[u32]>),
        context: &ListContext,
        find: impl FnOnce(&mut Self, &Search),
    ) -> BondChanges {
        let references = std::mem::take(&mut self.references);
        let has_clones = particles.len() > particles.owned;
        let search = Search {
            particles,
            references: &references,
            cell_list,
            clones: match has_clones {
                true => Clones::new(particles, &references.places, &cell_list.cells),
                false => Clones::default(),
            },
            probes: probes(particles, &references.places, context),
            histories,
            order,
            context,
            all_spheres: context.catalogue.all_spheres(),
            has_bonds: !histories.bonds.is_empty() || context.forming.is_some(),
        };
        self.find_bonds(&search);
        find(self, &search);
        self.bonds.sort(particles.owned);
        self.references = references;
        std::mem::take(&mut self.bond_changes)
    }

    /// Numbers of pairs now.
    fn numbers(&self) -> Inner {
        Inner {
            spheres: self.spheres.len(),
            part_pairs: self.part_pairs.pairs.len(),
            resting_spheres: self.resting.spheres.len(),
            resting_part_pairs: self.resting.part_pairs.pairs.len(),
        }
    }

    /// Forgets all pairs but the first ones.
    fn forget_pairs(&mut self, kept: Inner, context: &ListContext) {
        let keep_laws = context.catalogue.contacts.keep_law_history();
        self.spheres.truncate(kept.spheres);
        self.sphere_laws.truncate(kept.spheres);
        self.part_pairs.truncate(kept.part_pairs, keep_laws);
        self.resting.spheres.truncate(kept.resting_spheres);
        self.resting.part_pairs.truncate(kept.resting_part_pairs, keep_laws);
    }

    /// Pairs of owned particles with clones.
    fn pair_all_with_clones(&mut self, search: &Search) {
        if search.clones.start.is_empty() {
            return;
        }
        let grids = search.cell_list.cells.grids();
        for (k, grid) in grids.iter().enumerate() {
            self.pair_with_clones(search, &grids[..=k], grid);
            self.pair_small_clones(search, &grids[..k], grid);
        }
    }

    /// Finds the bonds there are; those to be made follow with the pairs.
    fn find_bonds(&mut self, search: &Search) {
        let &Search { particles, histories, context, .. } = search;
        match self.bonds.find(particles, histories, |i| search.row(i), context.may_leave) {
            Ok(left) => self.bond_changes.left = left,
            Err(error) => self.bond_changes.error = Some(error),
        }
    }

    /// Whether two particles are bonded, maybe from now on.
    fn bonds_pair(&mut self, search: &Search, i: usize, j: usize) -> bool {
        let &Search { particles, histories, context, .. } = search;
        let (bonds, made) = (&mut self.bonds, &mut self.bond_changes.made);
        are_bonded(histories, search.row(i), particles.ids[j])
            || context
                .forming
                .is_some_and(|forming| forming.bond(bonds, particles, [i, j], context.catalogue, made))
    }

    /// Pairs of owned particles, those of one grid with each other and with larger ones.
    fn pair_owned(&mut self, search: &Search, grid: &CellGrid, coarser: &[CellGrid]) {
        let start = &search.cell_list.start;
        for i in held(start, &grid.cells()) {
            let position = search.references.places[i].position.into();
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
            let position = search.references.places[i].position.into();
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
            let position = search.references.places[clone].position.into();
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
        let &Search { particles, references, histories, context, .. } = search;
        for list in [&mut self.walls, &mut self.resting.walls] {
            list.clear();
            list.keep_laws = context.catalogue.contacts.keep_law_history();
            list.shifts = images::shifts(&context.decomposition.global);
        }
        let mut near_walls = WallSearch::new(context, self.wall_allowance);
        for (i, body) in particles.bodies[..particles.owned].iter().enumerate() {
            let Reference { position, allowance } = references.places[i];
            // From where it is; it is somewhere else than its reference only beyond a border.
            let allowance = allowance + (body.position - position).norm();
            if body.is_prescribed() {
                if context.conducts {
                    near_walls.search(&mut self.resting.walls, particles, i, allowance, &[]);
                }
                continue;
            }
            let known = histories.walls.row(search.row(i));
            near_walls.search(&mut self.walls, particles, i, allowance, known);
        }
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
            let &Search { particles, histories, context, all_spheres, .. } = search;
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
                let (id, row) = (particles.ids[j], search.row(i));
                let of_row = histories.spheres.row(row);
                let known = of_row.iter().position(|m| m.partner == id);
                let tangential_displacement =
                    known.map_or(Vec3::zeros(), |k| of_row[k].tangential_displacement);
                make_room(&mut self.spheres, 1);
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
        let &Search { particles, references, histories, context, .. } = search;
        let (a, b) = if particles.ids[i] < particles.ids[j] { (i, j) } else { (j, i) };
        let margin = search.allowance(a) + search.allowance(b) + context.catalogue.contacts.reach();
        let separation = references.places[b].position - references.places[a].position;
        let (bodies, frames) = ([a, b].map(|i| &particles.bodies[i]), [a, b].map(|i| search.frame(i)));
        let poses = [0, 1].map(|k| Pose::of_body(bodies[k], &frames[k], context.catalogue));
        let mut near = std::mem::take(&mut self.near_parts);
        parts_near(&mut near[0], &poses[0], &separation, bodies[1].radius + margin);
        parts_near(&mut near[1], &poses[1], &-separation, bodies[0].radius + margin);
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
                let (half, local) = ([half(0, part), half(1, other)], margin / part_a.scale);
                let Some(axis) = axis_of_widest_gap(half[0], half[1], &placement, local) else { continue };
                let (partner, parts) = (particles.ids[j], [part, other]);
                let known = histories.part_pairs.row(search.row(i)).iter();
                let known = known.into_iter().find(|m| m.partner == partner && m.parts == parts);
                let axes = [part_a.rotation * axis, between];
                let (gap, axis) = widest_gap(&poses, &parts, &separation, &axes);
                if known.is_none() && gap > margin {
                    continue;
                }
                let list = if is_resting { &mut self.resting.part_pairs } else { &mut self.part_pairs };
                let cores = [part_a.core, part_b.core];
                list.push([a, b].map(|i| i as u32), (parts, cores), &axis, known.map(|m| &m.contact));
            }
        }
        self.near_parts = near;
    }
}

/// The parts of a body within a distance (m) of a point, `separation` (m) away.
fn parts_near(near: &mut Vec<u16>, pose: &Pose, separation: &Vec3, distance: f64) {
    let Pose { shape, frame, scale } = *pose;
    near.clear();
    near.extend((0..shape.parts.len() as u16).filter(|&k| {
        let part = &shape.parts[k as usize];
        let range = part.bounding_radius * scale + distance;
        shape.parts.len() == 1 || (separation - frame * part.center * scale).norm_squared() < range * range
    }));
}
