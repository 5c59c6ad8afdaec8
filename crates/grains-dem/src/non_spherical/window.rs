//! Parts that touched in the last step: the distances of those of a window of the list are found together.

use super::histories::Histories;
use super::pairs::PartPair;
use crate::catalogue::Catalogue;
use crate::contacts::BLOCK;
use crate::narrow_phase::{Meeting, PartContact, PlacedPart, Pose, SweptFrame, across_gap};
use crate::particles::Particles;
use grains_geometry::gjk::{BoxQueries, CylinderQueries, EllipsoidQueries, Separation};
use grains_geometry::{Core, Mat3, Vec3};
use multiversion::multiversion;
use std::ops::Range;

/// Largest number of pairs of particles in a window that are not known to be apart.
const GROUPS: usize = 4 * BLOCK;

/// Pairs of particles side by side in the list, and the distances of those of their parts that touched and are found together.
#[derive(Clone, Debug)]
pub(super) struct Window {
    ellipsoids: EllipsoidQueries<BLOCK>,
    cylinders: CylinderQueries<BLOCK>,
    boxes: BoxQueries<BLOCK>,
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
        let is_for = |holds: fn(&Core) -> bool| cores.iter().all(|core| holds(core));
        is_for(|core| core.ellipsoid().is_some())
            || is_for(|core| matches!(core, Core::Cylinder { .. }))
            || is_for(|core| matches!(core, Core::Box(_)))
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
        let kind = if let (Some(first), Some(second)) = (a.core.ellipsoid(), b.core.ellipsoid()) {
            let Some(start) = histories.start_of_ellipsoids(pair) else { return };
            self.ellipsoids.push([first, second], &placement, &start);
            QueryKind::Ellipsoids(self.ellipsoids.len() as u32 - 1)
        } else if let (&Core::Box(first), &Core::Box(second)) = (a.core, b.core) {
            let Some(start) = histories.start_of_boxes(pair, &[first, second]) else { return };
            QueryKind::Boxes(self.boxes.push(&[first, second], &placement, &start) as u32)
        } else {
            let Some(marks) = histories.start_of_cylinders(pair) else { return };
            if !self.cylinders.takes([a.core, b.core], &placement, &marks) {
                return;
            }
            QueryKind::Cylinders(self.cylinders.len() as u32 - 1)
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
                histories.set_start_of_ellipsoids(pair, &nearest);
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use grains_geometry::gjk::{BoxStart, CylinderMarks, StartForm, distance};
    use grains_geometry::{Placement, Rotation, Simplex, Superellipsoid};

    /// Numbers from 0 to 1.
    struct Random(u64);

    impl Random {
        fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn vector(&mut self, size: f64) -> Vec3 {
            Vec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5) * size
        }

        /// A pair of cores that lie in any way a gap of 0.001 to 0.1 apart and then move a little, and the start that was left before.
        fn moved_pair(&mut self, core: impl Fn(&mut Self) -> Core) -> ([Core; 2], Placement, Simplex) {
            let cores = [core(self), core(self)];
            let matrix = Rotation::from_scaled_axis(self.vector(6.0)).to_rotation_matrix().into_inner();
            let way = self.vector(1.0).normalize();
            let reach = cores[0].support_value(&way) + cores[1].support_value(&matrix.tr_mul(&-way));
            let mut placement = Placement { matrix, translation: way * (reach + 0.001 + 0.1 * self.unit()) };
            let mut start = Simplex::default();
            distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
            placement.translation += self.vector(1e-4);
            (cores, placement, start)
        }
    }

    impl Random {
        /// Half edges of two boxes of which the second, of another scale, is turned by up to `rocking` (rad) from face to face, a gap of
        /// 0.001 to 0.1 apart, and then moves a little; and the start that was left before.
        fn moved_boxes(&mut self, rocking: f64) -> ([Vec3; 2], Placement, Simplex) {
            let halves = [0; 2].map(|_| Vec3::repeat(0.7) + self.vector(1.0));
            let scale = 0.5 + self.unit();
            let turn = |random: &mut Self, angle: f64| {
                Rotation::from_scaled_axis(random.vector(angle)).to_rotation_matrix().into_inner()
            };
            let spin = Rotation::from_scaled_axis(Vec3::z() * self.unit()).to_rotation_matrix().into_inner();
            let mut matrix = turn(self, rocking) * spin * scale;
            let way = (Vec3::z() + self.vector(if rocking < 1.0 { 0.1 } else { 4.0 })).normalize();
            let face = if rocking < 1.0 { Vec3::z() } else { way };
            let reach = halves[0].dot(&face.abs()) + halves[1].dot(&matrix.tr_mul(&face).abs());
            let height = (reach + 0.001 + 0.1 * self.unit()) / way.dot(&face);
            let mut placement = Placement { matrix, translation: way * height };
            let cores = halves.map(Core::Box);
            let mut start = Simplex::default();
            distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
            matrix = turn(self, 1e-4 * rocking.min(1.0)) * matrix;
            placement = Placement { matrix, translation: placement.translation + self.vector(1e-4) };
            (halves, placement, start)
        }
    }

    /// Whatever lanes the processor has, the numbers are those of one lane, and those of the query of one pair.
    #[test]
    fn lanes_of_any_width_find_the_same_distances_of_ellipsoids() {
        let (mut random, mut answered) = (Random(7), 0);
        for _ in 0..100 {
            let mut queries = EllipsoidQueries::<BLOCK>::default();
            let mut asked = Vec::new();
            while !queries.is_full() {
                let (cores, placement, start) = random.moved_pair(|random| {
                    let axes = Vec3::repeat(0.7) + random.vector(0.6);
                    Core::superellipsoid(Superellipsoid::new(axes, [1.0; 2]).unwrap().eroded(0.01))
                });
                if start.len == 1 {
                    let bodies = cores.each_ref().map(|core| core.ellipsoid().unwrap());
                    queries.push(bodies, &placement, &start.a[0]);
                    asked.push((cores, placement, start));
                }
            }
            let mut plain = queries.clone();
            solve(&mut queries, &mut CylinderQueries::default(), &mut BoxQueries::default());
            plain.solve();
            for (k, (cores, placement, mut start)) in asked.into_iter().enumerate() {
                let found = queries.answer(k);
                assert_eq!(found, plain.answer(k));
                if let Some((answer, left)) = found {
                    let alone =
                        distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
                    assert_eq!((answer, left), (alone, [start.a[0], start.b[0]]));
                    answered += 1;
                }
            }
        }
        assert!(answered > 4000, "{answered}");
    }

    /// The same of cylinders.
    #[test]
    fn lanes_of_any_width_find_the_same_distances_of_cylinders() {
        let (mut random, mut answered) = (Random(8), 0);
        for _ in 0..100 {
            let mut queries = CylinderQueries::<BLOCK>::default();
            let mut asked = Vec::new();
            while queries.len() < BLOCK {
                let (cores, placement, start) = random.moved_pair(|random| Core::Cylinder {
                    radius: 0.2 + random.unit(),
                    half_height: 0.2 + random.unit(),
                });
                let form = StartForm::of(&cores[0], &cores[1]).unwrap();
                let mut words = vec![0; form.words()];
                form.write(cores.each_ref(), &start, &mut words);
                let Some(marks) = CylinderMarks::read(&words) else { continue };
                if queries.takes(cores.each_ref(), &placement, &marks) {
                    asked.push((cores, placement, marks, start));
                }
            }
            let mut plain = queries.clone();
            solve(&mut EllipsoidQueries::default(), &mut queries, &mut BoxQueries::default());
            plain.solve();
            for (k, (cores, placement, marks, mut start)) in asked.into_iter().enumerate() {
                let found = queries.answer(k);
                let (mut left, mut same) = (marks, marks);
                queries.refresh(k, &mut left);
                plain.refresh(k, &mut same);
                assert_eq!((found, left), (plain.answer(k), same));
                if let Some(answer) = found {
                    let alone =
                        distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
                    assert_eq!(answer, alone);
                    answered += 1;
                }
            }
        }
        assert!(answered > 4000, "{answered}");
    }

    /// The same of boxes that rock on their faces or lie in any way, the second of another scale.
    #[test]
    fn lanes_of_any_width_find_the_same_distances_of_boxes() {
        let (mut random, mut asked_for, mut answered) = (Random(9), 0, [0; 3]);
        for block in 0..300 {
            let mut queries = BoxQueries::<BLOCK>::default();
            let mut asked = Vec::new();
            for _ in 0..BLOCK {
                let rocking = [1e-6, 1e-4, 1e-2, 6.0][block % 4];
                let (halves, placement, start) = random.moved_boxes(rocking);
                let cores = halves.map(Core::Box);
                let form = StartForm::of(&cores[0], &cores[1]).unwrap();
                let mut words = vec![0; form.words()];
                form.write(cores.each_ref(), &start, &mut words);
                let Some(touched) = BoxStart::read(&halves, &words) else { continue };
                let number = queries.push(&halves, &placement, &touched);
                asked.push((number, halves, placement, start));
            }
            let mut plain = queries.clone();
            solve(&mut EllipsoidQueries::default(), &mut CylinderQueries::default(), &mut queries);
            plain.solve();
            asked_for += asked.len();
            for (number, halves, placement, mut start) in asked {
                let found = queries.answer(number);
                assert_eq!(found, plain.answer(number));
                let Some((answer, left)) = found else { continue };
                let cores = halves.map(Core::Box);
                let query = |start: &mut Simplex| {
                    distance(&cores[0], &cores[1], &placement, f64::INFINITY, start).unwrap()
                };
                assert_eq!(answer, query(&mut start));
                let form = StartForm::of(&cores[0], &cores[1]).unwrap();
                let mut words = [vec![0; form.words()], vec![0; form.words()]];
                form.write(cores.each_ref(), &start, &mut words[0]);
                left.write(&halves, &mut words[1]);
                assert_eq!(words[0], words[1]);
                let afresh = query(&mut Simplex::default());
                let [gap, other] = [answer, afresh].map(|found| match found {
                    Separation::Apart { distance, .. } => distance,
                    _ => f64::NAN,
                });
                assert!((gap - other).abs() < 1e-10 * halves[0].norm(), "{gap} instead of {other}");
                let kind = match left {
                    BoxStart::CornerOnFace([on_a, _]) => usize::from(on_a.abs() != halves[0]),
                    BoxStart::EdgeOnEdge(_) => 2,
                };
                answered[kind] += 1;
            }
        }
        assert!(answered.iter().all(|&kind| kind > asked_for / 10), "{answered:?} of {asked_for}");
        assert!(answered.iter().sum::<usize>() > asked_for * 9 / 10, "{answered:?} of {asked_for}");
    }
}
