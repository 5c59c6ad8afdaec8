#![allow(clippy::unwrap_used)]

use super::*;
use grains_geometry::gjk::{BoxStart, CylinderMarks, PolyhedronStart, StartForm, distance};
use grains_geometry::{ConvexHull, Placement, Rotation, Simplex, Superellipsoid};

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
    fn moved_pair(&mut self, mut core: impl FnMut(&mut Self) -> Core) -> ([Core; 2], Placement, Simplex) {
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

    /// The hull of random points, some with sharp tips.
    fn polyhedron(&mut self) -> Core {
        let number = 4 + (self.unit() * 12.0) as usize;
        let stretch = Vec3::repeat(0.3) + self.vector(0.5);
        let points: Vec<Vec3> =
            (0..number).map(|_| self.vector(1.0).normalize().component_mul(&stretch)).collect();
        let hull = ConvexHull::new(&points).unwrap();
        Core::polyhedron_with_faces(hull.vertices, hull.faces)
    }

    /// Two polyhedra of which the second, of another scale, is turned by up to `rocking` (rad) from face to face, or lies in any way if this
    /// is 1 or more, a gap of 0.001 to 0.1 apart, and then moves a little; and the start that was left before.
    fn moved_polyhedra(&mut self, cores: &[Core; 2], rocking: f64) -> (Placement, Simplex) {
        let turned = |random: &mut Self, angle: f64| Rotation::from_scaled_axis(random.vector(angle));
        let [face_a, face_b] = cores.each_ref().map(|core| {
            let Core::Polyhedron(hull) = core else { unreachable!() };
            hull.faces()[(self.unit() * hull.faces().len() as f64) as usize].normal
        });
        let onto = Rotation::rotation_between(&face_b, &-face_a).unwrap_or_default();
        let spin = Rotation::from_scaled_axis(face_a * (6.0 * self.unit()));
        let scale = 0.5 + self.unit();
        let mut rotation = turned(self, rocking) * spin * onto;
        let matrix = |rotation: &Rotation| rotation.to_rotation_matrix().into_inner() * scale;
        let reach =
            cores[0].support_value(&face_a) + cores[1].support_value(&matrix(&rotation).tr_mul(&-face_a));
        let aside = self.vector(0.3);
        let across = aside - face_a * aside.dot(&face_a);
        let translation = face_a * (reach + 0.001 + 0.1 * self.unit()) + across;
        let mut start = Simplex::default();
        let before = Placement { matrix: matrix(&rotation), translation };
        distance(&cores[0], &cores[1], &before, f64::INFINITY, &mut start).unwrap();
        rotation = turned(self, 1e-4 * rocking.min(1.0)) * rotation;
        let placement = Placement { matrix: matrix(&rotation), translation: translation + self.vector(1e-4) };
        (placement, start)
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
                let alone = distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
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
                let alone = distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
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

/// The same of polyhedra, some pairs of the same two.
#[test]
fn lanes_of_any_width_find_the_same_distances_of_polyhedra() {
    let (mut random, mut asked_for, mut answered) = (Random(10), 0, [0; 3]);
    for block in 0..400 {
        let mut queries = PolyhedronQueries::<SAME_BODIES>::default();
        let mut asked = Vec::new();
        let shapes: Vec<Core> = (0..1 + block % 3).map(|_| random.polyhedron()).collect();
        for k in 0..BLOCK {
            let cores = [0, 1].map(|side| shapes[(k >> (3 * side)) % shapes.len()].clone());
            let (placement, start) = random.moved_polyhedra(&cores, [1e-6, 1e-4, 1e-2, 6.0][block % 4]);
            let form = StartForm::of(&cores[0], &cores[1]).unwrap();
            let mut words = vec![0; form.words()];
            form.write(cores.each_ref(), &start, &mut words);
            let [Core::Polyhedron(first), Core::Polyhedron(second)] = &cores else { unreachable!() };
            let Some(touched) = PolyhedronStart::read([first, second], &words) else { continue };
            let Some(number) = queries.push([first, second], &placement, &touched) else { continue };
            asked.push((number, cores, placement, start));
        }
        let mut plain = queries.clone();
        solve_same_bodies(&mut queries, &mut SuperellipsoidQueries::default());
        plain.solve();
        asked_for += asked.len();
        for (number, cores, placement, mut start) in asked {
            let found = queries.answer(number);
            assert_eq!(found, plain.answer(number));
            let Some((answer, left)) = found else { continue };
            let query = |start: &mut Simplex| {
                distance(&cores[0], &cores[1], &placement, f64::INFINITY, start).unwrap()
            };
            assert_eq!(answer, query(&mut start));
            let form = StartForm::of(&cores[0], &cores[1]).unwrap();
            let mut words = [vec![0; form.words()], vec![0; form.words()]];
            form.write(cores.each_ref(), &start, &mut words[0]);
            left.write(&mut words[1]);
            assert_eq!(words[0], words[1]);
            let afresh = query(&mut Simplex::default());
            let [gap, other] = [answer, afresh].map(|found| match found {
                Separation::Apart { distance, .. } => distance,
                _ => f64::NAN,
            });
            assert!((gap - other).abs() < 1e-10, "{gap} instead of {other}");
            let kind = match left {
                PolyhedronStart::OnFirst(..) => 0,
                PolyhedronStart::OnSecond(..) => 1,
                PolyhedronStart::EdgeOnEdge(..) => 2,
            };
            answered[kind] += 1;
        }
    }
    assert!(answered.iter().all(|&kind| kind > asked_for / 20), "{answered:?} of {asked_for}");
    assert!(answered.iter().sum::<usize>() > asked_for * 4 / 5, "{answered:?} of {asked_for}");
}

/// The same of superellipsoids without edges, some beside ellipsoids.
#[test]
fn lanes_of_any_width_find_the_same_distances_of_superellipsoids() {
    let (mut random, mut asked_for, mut answered) = (Random(11), 0, 0);
    for block in 0..200 {
        let mut queries = SuperellipsoidQueries::<SAME_BODIES>::default();
        let mut asked = Vec::new();
        let shapes: Vec<Core> = (0..1 + block % 3)
            .map(|_| {
                let axes = Vec3::repeat(0.7) + random.vector(0.6);
                let eps = [[0.25, 0.25], [0.5, 0.5], [0.4, 0.8], [0.2, 1.0], [0.33, 0.7], [0.9, 0.9]];
                let eps = if random.unit() < 0.2 { [1.0; 2] } else { eps[block % 6] };
                Core::superellipsoid(Superellipsoid::new(axes, eps).unwrap().eroded(0.01))
            })
            .collect();
        let mut pairs = Vec::new();
        for k in 0..BLOCK {
            let mut side = 0;
            let (_, placement, start) = random.moved_pair(|_| {
                side += 1;
                shapes[(k >> (3 * (side - 1))) % shapes.len()].clone()
            });
            pairs.push(([k, k >> 3].map(|k| k % shapes.len()), placement, start));
        }
        for (cores, placement, start) in pairs {
            let [Core::Superellipsoid(first), Core::Superellipsoid(second)] = cores.map(|k| &shapes[k])
            else {
                unreachable!()
            };
            if start.len != 1 || first.is_ellipsoid() && second.is_ellipsoid() {
                continue;
            }
            let points = [start.a[0], start.b[0]];
            let Some(number) = queries.push([first, second], &placement, &points) else { continue };
            asked.push((number, cores, placement, start));
        }
        let mut plain = queries.clone();
        solve_same_bodies(&mut PolyhedronQueries::default(), &mut queries);
        plain.solve();
        asked_for += asked.len();
        for (number, cores, placement, mut start) in asked {
            let found = queries.answer(number);
            assert_eq!(found, plain.answer(number));
            let Some((answer, left)) = found else { continue };
            let cores = cores.map(|k| &shapes[k]);
            let query =
                |start: &mut Simplex| distance(cores[0], cores[1], &placement, f64::INFINITY, start).unwrap();
            assert_eq!((answer, left), (query(&mut start), [start.a[0], start.b[0]]));
            let afresh = query(&mut Simplex::default());
            let [gap, other] = [answer, afresh].map(|found| match found {
                Separation::Apart { distance, .. } => distance,
                _ => f64::NAN,
            });
            assert!((gap - other).abs() < 1e-9, "{gap} instead of {other}");
            answered += 1;
        }
    }
    assert!(asked_for > 100 * BLOCK && answered > asked_for * 4 / 5, "{answered} of {asked_for}");
}
