//! Parts that touched in the last step: the distances of those of a window of the list are found together.

use super::histories::Histories;
use super::pairs::PartPair;
use crate::catalogue::Catalogue;
use crate::contacts::BLOCK;
use crate::narrow_phase::{Meeting, PartContact, PlacedPart, Pose, SweptFrame, across_gap};
use crate::particles::Particles;
use grains_geometry::gjk::{
    BoxQueries, CylinderQueries, EllipsoidQueries, PolyhedronQueries, Separation, SuperellipsoidQueries,
};
use grains_geometry::{Core, Mat3, Vec3};
use multiversion::multiversion;
use std::ops::Range;

/// Largest number of pairs of particles in a window that are not known to be apart.
const GROUPS: usize = 4 * BLOCK;
/// Largest number of groups of queries of the same two bodies.
const SAME_BODIES: usize = BLOCK / 2;

/// Pairs of particles side by side in the list, and the distances of those of their parts that touched and are found together.
#[derive(Clone, Debug)]
pub(super) struct Window {
    ellipsoids: EllipsoidQueries<BLOCK>,
    cylinders: CylinderQueries<BLOCK>,
    boxes: BoxQueries<BLOCK>,
    polyhedra: PolyhedronQueries<SAME_BODIES>,
    superellipsoids: SuperellipsoidQueries<SAME_BODIES>,
    /// Pairs of two particles that are not known to be apart, from one place in the list to another.
    groups: [(u32, u32); GROUPS],
    /// Number of those.
    close: usize,
    /// Number of those that were given out.
    next: usize,
    /// Those whose distances are found, in the order of the list.
    queries: [Query; BLOCK],
    len: usize,
    /// Number of those that were asked for.
    asked: usize,
}

/// A query of a window.
#[derive(Clone, Copy, Debug)]
struct Query {
    /// Place of the pair in the list.
    place: u32,
    kind: QueryKind,
    /// How the first part lies.
    frame: SweptFrame,
    /// Its centre from the centre of mass of the particle (m).
    offset: Vec3,
    /// Crust of the second (m).
    other_crust: f64,
}

/// What is asked of two parts, by its number among the queries of its kind.
#[derive(Clone, Copy, Debug)]
enum QueryKind {
    Ellipsoids(u32),
    Cylinders(u32),
    Boxes(u32),
    Polyhedra(u32),
    Superellipsoids(u32),
}

impl Default for Window {
    fn default() -> Self {
        let frame = SweptFrame { rotation: Mat3::identity(), scale: 1.0, crust: 0.0 };
        let none = Query {
            place: 0,
            kind: QueryKind::Ellipsoids(0),
            frame,
            offset: Vec3::zeros(),
            other_crust: 0.0,
        };
        Self {
            ellipsoids: EllipsoidQueries::default(),
            cylinders: CylinderQueries::default(),
            boxes: BoxQueries::default(),
            polyhedra: PolyhedronQueries::default(),
            superellipsoids: SuperellipsoidQueries::default(),
            groups: [(0, 0); GROUPS],
            close: 0,
            next: 0,
            queries: [none; BLOCK],
            len: 0,
            asked: 0,
        }
    }
}

impl Window {
    /// Whether distances of such parts may be found together.
    pub(super) fn is_for(cores: [&Core; 2]) -> bool {
        match cores {
            [Core::Superellipsoid(first), Core::Superellipsoid(second)] => {
                !(first.is_sharp() || second.is_sharp())
            }
            [Core::Cylinder { .. }, Core::Cylinder { .. }] | [Core::Box(_), Core::Box(_)] => true,
            [Core::Polyhedron(first), Core::Polyhedron(second)] => {
                [first, second].iter().all(|hull| PolyhedronQueries::<SAME_BODIES>::are_for(hull))
            }
            _ => false,
        }
    }

    /// Looks at pairs from a place of the list on, which has one: which are not known to be apart, and the distances of parts that touched;
    /// returns the place at which the window ends.
    #[inline(always)]
    pub(super) fn fill(
        &mut self,
        pairs: &[PartPair],
        start: usize,
        histories: &Histories,
        particles: &Particles,
        catalogue: &Catalogue,
    ) -> usize {
        self.ellipsoids.clear();
        self.cylinders.clear();
        self.boxes.clear();
        self.polyhedra.clear();
        self.superellipsoids.clear();
        (self.len, self.asked, self.close, self.next) = (0, 0, 0, 0);
        let mut end = start;
        while end < pairs.len() && self.close < GROUPS {
            let first = &pairs[end];
            let length = first.number_of_same_particles(&pairs[end..]);
            let group = &pairs[end..end + length];
            if end > start && self.len + length > BLOCK {
                break;
            }
            let gone = particles.path_length[first.a as usize] + particles.path_length[first.b as usize];
            // The bridges of all are looked after.
            if particles.is_wet() || !group.iter().all(|pair| gone < pair.separated_until) {
                self.groups[self.close] = (end as u32, (end + length) as u32);
                self.close += 1;
                if group.iter().any(PartPair::is_touching) {
                    self.take(group, histories, particles, catalogue);
                }
            }
            end += length;
        }
        if self.len > 0 {
            solve(&mut self.ellipsoids, &mut self.cylinders, &mut self.boxes);
            solve_same_bodies(&mut self.polyhedra, &mut self.superellipsoids);
        }
        end
    }

    /// Whether there are pairs of the window that have not been given out.
    #[inline(always)]
    pub(super) fn has_groups(&self) -> bool {
        self.next < self.close
    }

    /// The next pairs of two particles that are not known to be apart, as places in the list that was looked at.
    #[inline(always)]
    pub(super) fn next_group(&mut self) -> Option<Range<usize>> {
        let &(start, end) = self.groups[..self.close].get(self.next)?;
        self.next += 1;
        Some(start as usize..end as usize)
    }

    /// Takes the queries of parts of two particles as far as there is room.
    #[inline(always)]
    fn take(
        &mut self,
        group: &[PartPair],
        histories: &Histories,
        particles: &Particles,
        catalogue: &Catalogue,
    ) {
        let [first, second] = [group[0].a, group[0].b].map(|i| i as usize);
        let pose_a = Pose::of(particles, first, catalogue);
        let pose_b = Pose::of(particles, second, catalogue);
        let separation = particles.bodies[second].position - particles.bodies[first].position;
        for pair in group.iter().filter(|pair| pair.is_touching()) {
            if self.len == BLOCK || pose_a.shape.discrete.is_some() {
                return;
            }
            let [a, b] = pair.parts.map(usize::from);
            if Self::is_for([&pose_a.shape.parts[a].core, &pose_b.shape.parts[b].core]) {
                self.take_parts(pair, (&pose_a, &pose_b), &separation, histories);
            }
        }
    }

    /// Takes the query of two parts of particles `separation` (m) apart that touched.
    #[inline(always)]
    fn take_parts(
        &mut self,
        pair: &PartPair,
        (pose_a, pose_b): (&Pose, &Pose),
        separation: &Vec3,
        histories: &Histories,
    ) {
        let (a, b) = (PlacedPart::of(pose_a, pair.parts[0]), PlacedPart::of(pose_b, pair.parts[1]));
        let placement = a.placement(&b.rotation, b.scale, &(separation + (b.offset - a.offset)));
        let kind = match (a.core, b.core) {
            (Core::Superellipsoid(first), Core::Superellipsoid(second)) => {
                let Some(start) = histories.start_of_surfaces(pair) else { return };
                if first.is_ellipsoid() && second.is_ellipsoid() {
                    self.ellipsoids.push([first, second], &placement, &start[0]);
                    QueryKind::Ellipsoids(self.ellipsoids.len() as u32 - 1)
                } else {
                    let number = self.superellipsoids.push([first, second], &placement, &start);
                    let Some(number) = number else { return };
                    QueryKind::Superellipsoids(number)
                }
            }
            (Core::Box(first), Core::Box(second)) => {
                let halves = [*first, *second];
                let Some(start) = histories.start_of_boxes(pair, &halves) else { return };
                QueryKind::Boxes(self.boxes.push(&halves, &placement, &start) as u32)
            }
            (Core::Polyhedron(first), Core::Polyhedron(second)) => {
                let Some(start) = histories.start_of_polyhedra(pair, [first, second]) else { return };
                let Some(number) = self.polyhedra.push([first, second], &placement, &start) else { return };
                QueryKind::Polyhedra(number)
            }
            _ => {
                let Some(marks) = histories.start_of_cylinders(pair) else { return };
                if !self.cylinders.takes([a.core, b.core], &placement, &marks) {
                    return;
                }
                QueryKind::Cylinders(self.cylinders.len() as u32 - 1)
            }
        };
        let (frame, offset, other_crust) = (a.swept_frame(), a.offset, b.crust);
        self.queries[self.len] = Query { place: pair.place, kind, frame, offset, other_crust };
        self.len += 1;
    }

    /// Contact of the parts of a pair, from the centre of the first part, which is given from the centre of mass of its particle (m), if the
    /// distance was found; pairs are asked for in the order of the list.
    #[inline(always)]
    pub(super) fn contact(
        &mut self,
        pair: &PartPair,
        histories: &mut Histories,
    ) -> Option<(PartContact, Vec3)> {
        while self.asked < self.len && self.queries[self.asked].place < pair.place {
            self.asked += 1;
        }
        let query = self.queries[..self.len].get(self.asked).filter(|query| query.place == pair.place)?;
        let contact_at = |gap: &Separation| match across_gap(&query.frame, query.other_crust, gap)? {
            Meeting::Touching(contact) => Some((contact, query.offset)),
            Meeting::Apart(_) => None,
        };
        match query.kind {
            QueryKind::Ellipsoids(k) => {
                let (gap, nearest) = self.ellipsoids.answer(k as usize)?;
                let contact = contact_at(&gap)?;
                histories.set_start_of_surfaces(pair, &nearest);
                Some(contact)
            }
            QueryKind::Cylinders(k) => {
                let contact = contact_at(&self.cylinders.answer(k as usize)?)?;
                let mut marks = histories.start_of_cylinders(pair)?;
                self.cylinders.refresh(k as usize, &mut marks);
                histories.set_start_of_cylinders(pair, &marks);
                Some(contact)
            }
            QueryKind::Boxes(k) => {
                let (gap, left) = self.boxes.answer(k as usize)?;
                let contact = contact_at(&gap)?;
                histories.set_start_of_boxes(pair, &self.boxes.halves(k as usize), &left);
                Some(contact)
            }
            QueryKind::Polyhedra(k) => {
                let (gap, left) = self.polyhedra.answer(k)?;
                let contact = contact_at(&gap)?;
                histories.set_start_of_polyhedra(pair, &left);
                Some(contact)
            }
            QueryKind::Superellipsoids(k) => {
                let (gap, nearest) = self.superellipsoids.answer(k)?;
                let contact = contact_at(&gap)?;
                histories.set_start_of_surfaces(pair, &nearest);
                Some(contact)
            }
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn solve(
    ellipsoids: &mut EllipsoidQueries<BLOCK>,
    cylinders: &mut CylinderQueries<BLOCK>,
    boxes: &mut BoxQueries<BLOCK>,
) {
    ellipsoids.solve();
    cylinders.solve();
    boxes.solve();
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn solve_same_bodies(
    polyhedra: &mut PolyhedronQueries<SAME_BODIES>,
    superellipsoids: &mut SuperellipsoidQueries<SAME_BODIES>,
) {
    polyhedra.solve();
    superellipsoids.solve();
}

#[cfg(test)]
mod tests;
