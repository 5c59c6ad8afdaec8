//! What is kept of a simplex between two queries is the simplex.

use crate::gjk_common::{KINDS, Kind, Pair, Random};
use grains_geometry::gjk::StartForm;
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
