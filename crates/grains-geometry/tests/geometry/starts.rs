//! What is kept of a simplex between two queries is the simplex, or the features that it marks.

use crate::gjk_common::{KINDS, Kind, Pair, Random};
use grains_geometry::gjk::{Separation, StartForm};
use grains_geometry::{Core, Simplex, Superellipsoid, Vec3};

/// What comes back of a start that is written in its form, if there is one.
fn kept(pair: &Pair, start: &Simplex) -> Option<Simplex> {
    let cores = [&pair.a, &pair.b];
    let form = StartForm::of(&pair.a, &pair.b)?;
    let mut words = vec![0; form.words()];
    form.write(cores, start, &mut words);
    // Only the points that there are come back.
    let mut kept = Simplex { len: 3, a: [Vec3::repeat(f64::NAN); 4], b: [Vec3::repeat(f64::NAN); 4] };
    form.read(cores, &words, &mut kept);
    Some(kept)
}

fn assert_same(kept: &Simplex, start: &Simplex) {
    let len = start.len as usize;
    assert_eq!((kept.len, &kept.a[..len], &kept.b[..len]), (start.len, &start.a[..len], &start.b[..len]));
}

#[test]
fn starts_of_all_kinds_come_back_as_they_were() {
    let mut random = Random(41);
    let mut lengths = [0; 5];
    for number in 0..60_000 {
        let kinds: [Kind; 2] = [0, 1].map(|_| KINDS[random.below(KINDS.len())]);
        if kinds == [Kind::Cylinder; 2] {
            continue;
        }
        let aligned = number % 2 == 0;
        let pair = Pair::random(&mut random, kinds, 2.0, aligned, 1.0);
        let gap = if number % 3 == 0 { 1e-3 } else { 0.2 };
        let pair = if number % 5 == 0 { pair } else { pair.at_distance(gap) };
        let mut start = Simplex::default();
        for _ in 0..3 {
            pair.query(&mut start);
            kept(&pair, &start).iter().for_each(|kept| assert_same(kept, &start));
            let moved = pair.moved(&mut random, 1e-3);
            moved.query(&mut start);
            if let Some(kept) = kept(&moved, &start) {
                assert_same(&kept, &start);
                lengths[start.len as usize] += 1;
            }
        }
    }
    assert!(lengths[1..].iter().all(|&count| count > 1000), "{lengths:?}");
}

#[test]
fn starts_of_superellipsoids_are_those_on_their_surfaces() {
    let mut random = Random(42);
    let body = |random: &mut Random| {
        let axes = Vec3::from_fn(|_, _| random.log(0.4, 1.0));
        let eps = [[1.0; 2], [0.25; 2], [0.7, 0.4]][random.below(3)];
        Core::superellipsoid(Superellipsoid::new(axes, eps).unwrap())
    };
    let mut on_surfaces = 0;
    for _ in 0..5000 {
        let (a, b) = (body(&mut random), body(&mut random));
        let apart = random.direction() * (a.radius() + b.radius());
        let placement = crate::gjk_common::place(&random.rotation(), 1.0, apart);
        let pair = Pair::new(a, b, placement).at_distance(0.01);
        let mut start = Simplex::default();
        pair.query(&mut start);
        let back = kept(&pair, &start).unwrap();
        match start.len {
            1 => {
                assert_same(&back, &start);
                on_surfaces += 1;
            }
            _ => assert_eq!(back.len, 0),
        }
    }
    assert!(on_surfaces > 4900, "{on_surfaces}");
}

/// Of two cylinders the features come back: the next query finds what it finds from the whole simplex. Features of axes that are parallel
/// are not kept.
#[test]
fn starts_of_cylinders_are_the_features_that_touch() {
    let mut random = Random(43);
    let (mut warm, mut cold) = (0, 0);
    for number in 0..10_000 {
        let aligned = number % 4 == 0;
        let pair = Pair::random(&mut random, [Kind::Cylinder; 2], 10.0, aligned, 1.0).at_distance(1e-3);
        let mut start = Simplex::default();
        let is_apart = matches!(pair.query(&mut start), Separation::Apart { .. });
        let mut back = kept(&pair, &start).unwrap();
        if is_apart && !aligned {
            *(if back.len == 0 { &mut cold } else { &mut warm }) += 1;
        }
        let moved = pair.moved(&mut random, 1e-5);
        let (wanted, found) = (moved.query(&mut start), moved.query(&mut back));
        let (distance, normal, found, other) = match (wanted, found) {
            (
                Separation::Apart { distance, normal, .. },
                Separation::Apart { distance: found, normal: other, .. },
            ) => (distance, normal, found, other),
            (wanted, found) => {
                assert_eq!(wanted, found);
                continue;
            }
        };
        assert!((distance - found).abs() <= 1e-12 * pair.size, "{number}: {distance}, {found}");
        assert!((normal - other).norm() * distance <= 1e-7 * pair.size, "{number}: {normal}, {other}");
    }
    println!("{warm} starts are warm, {cold} cold");
    assert!(warm > 50 * cold && warm > 3000, "{warm} warm, {cold} cold");
}
