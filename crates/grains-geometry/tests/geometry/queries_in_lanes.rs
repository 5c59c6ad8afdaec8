//! Pairs of ellipsoids, of cylinders and of boxes answered many at a time are answered as one by one.

use crate::gjk_common::{Pair, Random, place};
use grains_geometry::gjk::{
    BoxQueries, BoxStart, CylinderMarks, CylinderQueries, EllipsoidQueries, Separation, StartForm,
};
use grains_geometry::{Core, Rotation, Simplex, Superellipsoid, Vec3};

const BLOCK: usize = 64;

/// A pair after it moved, and the start that was left before.
struct Moved {
    pair: Pair,
    start: Simplex,
}

impl Moved {
    fn bodies(&self) -> [&Superellipsoid; 2] {
        [&self.pair.a, &self.pair.b].map(|core| core.ellipsoid().unwrap())
    }
}

fn ellipsoid(random: &mut Random, size: f64) -> Core {
    let axes = Vec3::from_fn(|_, _| size * random.log(0.3, 1.0));
    let body = Superellipsoid::new(axes, [1.0; 2]).unwrap();
    let inset = [0.0, 0.02, 0.3][random.below(3)] * body.min_curvature_radius();
    Core::superellipsoid(body.eroded(inset))
}

/// Pairs of any shapes and sizes a small way apart that moved by 1e-9 to 1e-2 of their size.
fn moved(
    random: &mut Random,
    count: usize,
    core: impl Fn(&mut Random, f64) -> Core,
    turn: impl Fn(&mut Random) -> Rotation,
) -> Vec<Moved> {
    (0..count)
        .map(|_| {
            let size = random.log(1e-6, 1e3);
            let (a, b) = (core(random, size), core(random, size));
            let scale = random.log(0.5, 2.0);
            let apart = random.direction() * (a.radius() + b.radius() * scale);
            let pair = Pair::new(a, b, place(&turn(random), scale, apart));
            let gap = pair.size * random.log(1e-4, 0.1);
            let pair = pair.at_distance(gap);
            let mut start = Simplex::default();
            pair.query(&mut start);
            let motion = random.log(1e-9, 1e-2).min(0.1 * gap / pair.size);
            Moved { pair: pair.moved(random, motion), start }
        })
        .collect()
}

/// Answers to the pairs of ellipsoids in the given order, in blocks of some length, with the starts they leave.
fn answers(pairs: &[Moved], order: &[usize], length: usize) -> Vec<Option<(Separation, [Vec3; 2])>> {
    let mut answers = vec![None; pairs.len()];
    let mut queries = EllipsoidQueries::<BLOCK>::default();
    for block in order.chunks(length) {
        queries.clear();
        for &i in block {
            queries.push(pairs[i].bodies(), &pairs[i].pair.placement, &pairs[i].start.a[0]);
        }
        assert_eq!((queries.len(), queries.is_full()), (block.len(), block.len() == BLOCK));
        queries.solve();
        for (k, &i) in block.iter().enumerate() {
            answers[i] = queries.answer(k);
        }
    }
    answers
}

/// Answers to a number of pairs, which must be the same in any order and in blocks of any length.
fn same_in_any_blocks<T: PartialEq + std::fmt::Debug>(
    random: &mut Random,
    count: usize,
    answers: impl Fn(&[usize], usize) -> Vec<T>,
) -> Vec<T> {
    let mut order: Vec<usize> = (0..count).collect();
    let found = answers(&order, BLOCK);
    for length in [1, 7, BLOCK - 1, BLOCK] {
        for k in (1..order.len()).rev() {
            order.swap(k, random.below(k + 1));
        }
        assert_eq!(answers(&order, length), found, "blocks of {length}");
    }
    found
}

#[test]
fn ellipsoids_of_a_block_are_answered_as_one_by_one() {
    let mut random = Random(31);
    let pairs = moved(&mut random, 20_000, ellipsoid, Random::rotation);
    let found = same_in_any_blocks(&mut random, pairs.len(), |order, length| answers(&pairs, order, length));
    let mut answered = 0;
    for (Moved { pair, start }, found) in pairs.iter().zip(&found) {
        let mut alone = *start;
        let wanted = pair.query(&mut alone);
        if let Some((answer, left)) = found {
            assert_eq!(*answer, wanted);
            assert_eq!((1, *left), (alone.len, [alone.a[0], alone.b[0]]));
            answered += 1;
        }
    }
    assert!(answered > 19_000, "{answered}");
}

/// Bodies in each other, or far from the start: the answer is none, or that of the query.
#[test]
fn ellipsoids_without_a_start_are_left_to_the_query() {
    let mut random = Random(32);
    let (mut answered, mut left_over) = (0, 0);
    for _ in 0..2000 {
        let (a, b) = (ellipsoid(&mut random, 1.0), ellipsoid(&mut random, 1.0));
        let apart = random.direction() * ((a.radius() + b.radius()) * random.unit());
        let pair = Pair::new(a, b, place(&random.rotation(), 1.0, apart));
        let towards = pair.placement.translation.normalize() + random.direction() * random.log(0.1, 10.0);
        let on_a = pair.a.support(&towards);
        let start = Simplex { len: 1, a: [on_a; 4], b: [Vec3::x(); 4] };
        let pairs = [Moved { pair, start }];
        match answers(&pairs, &[0], 1)[0] {
            Some((answer, _)) => {
                assert!(pairs[0].pair.certify(&answer) < 1e-13);
                answered += 1;
            }
            None => left_over += 1,
        }
    }
    assert!(answered > 100 && left_over > 100, "{answered} and {left_over}");
}

/// Cylinders, slender and flat, that lie in any way, and along and across each other.
fn cylinders(random: &mut Random, count: usize) -> Vec<Moved> {
    let cylinder = |random: &mut Random, size: f64| Core::Cylinder {
        radius: size * random.log(0.1, 1.0),
        half_height: size * random.log(0.1, 1.0),
    };
    let turn = |random: &mut Random| if random.below(2) == 0 { random.rotation() } else { random.aligned() };
    moved(random, count, cylinder, turn)
}

/// What is kept of the start of a query of two cylinders.
fn marks(pair: &Pair, start: &Simplex) -> Option<CylinderMarks> {
    let cores = [&pair.a, &pair.b];
    let form = StartForm::of(cores[0], cores[1]).unwrap();
    let mut words = vec![0; form.words()];
    form.write(cores, start, &mut words);
    let marks = CylinderMarks::read(&words);
    // A start that is read is written as it was.
    let (mut read, mut again) = (Simplex::default(), vec![0; form.words()]);
    form.read(cores, &words, &mut read);
    form.write(cores, &read, &mut again);
    assert_eq!(CylinderMarks::read(&again), marks);
    marks
}

/// Answers to the pairs of cylinders that are taken in the given order, in blocks of some length, with the starts they leave.
fn answers_of_cylinders(
    pairs: &[Moved],
    order: &[usize],
    length: usize,
) -> Vec<Option<(Separation, CylinderMarks)>> {
    let mut answers = vec![None; pairs.len()];
    let mut queries = CylinderQueries::<BLOCK>::default();
    for block in order.chunks(length) {
        queries.clear();
        let mut taken = Vec::new();
        for &i in block {
            let Moved { pair, start } = &pairs[i];
            let cores = [&pair.a, &pair.b];
            let marks = marks(pair, start);
            if let Some(marks) = marks.filter(|marks| queries.takes(cores, &pair.placement, marks)) {
                taken.push((i, marks));
            }
        }
        assert_eq!(queries.len(), taken.len());
        queries.solve();
        for (k, &(i, mut marks)) in taken.iter().enumerate() {
            answers[i] = queries.answer(k).map(|found| {
                queries.refresh(k, &mut marks);
                (found, marks)
            });
        }
    }
    answers
}

#[test]
fn cylinders_of_a_block_are_answered_as_one_by_one() {
    let mut random = Random(33);
    let pairs = cylinders(&mut random, 20_000);
    let found = same_in_any_blocks(&mut random, pairs.len(), |order, length| {
        answers_of_cylinders(&pairs, order, length)
    });
    let mut answered = 0;
    for (Moved { pair, start }, found) in pairs.iter().zip(&found) {
        let mut alone = *start;
        let wanted = pair.query(&mut alone);
        if let Some((answer, left)) = found {
            assert_eq!(*answer, wanted);
            assert_eq!(Some(*left), marks(pair, &alone));
            assert!(pair.certify(answer) < 1e-13);
            answered += 1;
        }
    }
    println!("{answered} of {} answered together", pairs.len());
    assert!(answered > 13_000, "{answered}");
}

/// Boxes, slender and flat, that lie in any way, and almost face to face.
fn boxes(random: &mut Random, count: usize) -> Vec<Moved> {
    let cuboid =
        |random: &mut Random, size: f64| Core::Box(Vec3::from_fn(|_, _| size * random.log(0.1, 1.0)));
    let turn = |random: &mut Random| if random.below(2) == 0 { random.rotation() } else { random.aligned() };
    moved(random, count, cuboid, turn)
}

/// Half edges of two boxes (m).
fn half_edges(pair: &Pair) -> [Vec3; 2] {
    [&pair.a, &pair.b].map(|core| match core {
        Core::Box(half) => *half,
        _ => unreachable!(),
    })
}

/// What is kept of the start of a query of two boxes.
fn words(pair: &Pair, start: &Simplex) -> Vec<u64> {
    let cores = [&pair.a, &pair.b];
    let form = StartForm::of(cores[0], cores[1]).unwrap();
    let mut words = vec![0; form.words()];
    form.write(cores, start, &mut words);
    words
}

/// Answers to the pairs of boxes that are taken in the given order, in blocks of some length, with the starts they leave.
fn answers_of_boxes(pairs: &[Moved], order: &[usize], length: usize) -> Vec<Option<(Separation, BoxStart)>> {
    let mut answers = vec![None; pairs.len()];
    let mut queries = BoxQueries::<BLOCK>::default();
    for block in order.chunks(length) {
        queries.clear();
        let mut taken = Vec::new();
        for &i in block {
            let Moved { pair, start } = &pairs[i];
            let halves = half_edges(pair);
            if let Some(start) = BoxStart::read(&halves, &words(pair, start)) {
                let number = queries.push(&halves, &pair.placement, &start);
                assert_eq!(queries.halves(number), halves);
                taken.push((i, number));
            }
        }
        queries.solve();
        for &(i, number) in &taken {
            answers[i] = queries.answer(number);
        }
    }
    answers
}

#[test]
fn boxes_of_a_block_are_answered_as_one_by_one() {
    let mut random = Random(34);
    let pairs = boxes(&mut random, 20_000);
    let found =
        same_in_any_blocks(&mut random, pairs.len(), |order, length| answers_of_boxes(&pairs, order, length));
    // Corners of A, of B, and edges.
    let mut answered = [0; 3];
    for (Moved { pair, start }, found) in pairs.iter().zip(&found) {
        let mut alone = *start;
        let wanted = pair.query(&mut alone);
        let Some((answer, left)) = found else { continue };
        assert_eq!(*answer, wanted);
        let halves = half_edges(pair);
        let mut kept = words(pair, start);
        left.write(&halves, &mut kept);
        assert_eq!(kept, words(pair, &alone));
        assert_eq!(BoxStart::read(&halves, &kept), Some(*left));
        assert!(pair.certify(answer) < 1e-13);
        let afresh = pair.distance(&mut Simplex::default());
        let Separation::Apart { distance, .. } = answer else { unreachable!() };
        assert!((distance - afresh).abs() < 1e-12 * pair.size, "{distance} instead of {afresh}");
        let kind = match left {
            BoxStart::CornerOnFace([on_a, _]) => usize::from(on_a.abs() != halves[0]),
            BoxStart::EdgeOnEdge(_) => 2,
        };
        answered[kind] += 1;
    }
    println!("{answered:?} of {} answered together", pairs.len());
    let [on_b, on_a, edges] = answered;
    assert!(on_b > 1500 && on_a > 1500 && edges > 4000, "{answered:?}");
}
