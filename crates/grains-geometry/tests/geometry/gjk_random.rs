//! A million random pairs in release, a hundred thousand otherwise: every answer is certified by its own
//! duality gap, whatever the shapes, the size, the slenderness, and the start.

use crate::gjk_common::{KINDS, Kind, Pair, Random};
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Core, Placement, Simplex};

const PAIRS: usize = 1_000_000;

/// Calls `check` for `pairs` pairs spread over all kinds, slendernesses up to 100, alignments, sizes of
/// 1e-6 to 1 m, gaps from touching to far.
fn for_all_pairs(seed: u64, pairs: usize, mut check: impl FnMut(&mut Random, [Kind; 2], Pair)) {
    let mut random = Random(seed);
    for number in 0..pairs {
        let kinds = [KINDS[number % 6], KINDS[number / 6 % 6]];
        let slenderness = if random.below(2) == 0 { 1.0 } else { 100.0 };
        let (aligned, size) = (random.below(2) == 0, random.log(1e-6, 1.0));
        let pair = Pair::random(&mut random, kinds, slenderness, aligned, size);
        let near = random.below(2) == 0;
        let target = pair.size * random.log(1e-6, 1.0);
        check(&mut random, kinds, if near { pair.at_distance(target) } else { pair });
    }
}

/// Bound on the duality gap, relative to the size.
fn gap_bound(kinds: [Kind; 2]) -> f64 {
    if kinds.iter().any(|kind| kind.is_curved()) { 1e-9 } else { 1e-13 }
}

#[test]
fn cold_and_warm_answers_are_certified_and_agree() {
    for_all_pairs(1, PAIRS, |random, kinds, pair| {
        let bound = gap_bound(kinds);
        let mut simplex = Simplex::default();
        let gap = pair.certify(&pair.query(&mut simplex));
        assert!(gap < bound, "{kinds:?}: gap {gap:e}");
        let motion = random.log(1e-7, 1e-1);
        let moved = pair.moved(random, motion);
        assert!(moved.certify(&moved.query(&mut simplex)) < bound, "{kinds:?} warm");
        let (warm, cold) = (moved.distance(&mut simplex), moved.distance(&mut Simplex::default()));
        assert!((warm - cold).abs() <= bound * pair.size, "{kinds:?}: warm {warm}, cold {cold}");
    });
}

#[test]
fn touching_pairs_are_certified_down_to_the_meeting_distance() {
    for_all_pairs(2, PAIRS / 10, |random, kinds, pair| {
        let target = pair.size * random.log(1e-11, 1e-6);
        let pair = pair.at_distance(target);
        let answer = pair.query(&mut Simplex::default());
        // Rounding turns a v this short by up to 1e-15 of the size over its length.
        let bound = if kinds.iter().any(|kind| kind.is_curved()) { 1e-8 } else { 1e-13 };
        assert!(pair.certify(&answer) < bound, "{kinds:?} at {:e}", target / pair.size);
    });
}

#[test]
fn beyond_is_answered_past_the_cutoff_only_and_leaves_a_good_start() {
    for_all_pairs(3, PAIRS / 10, |random, kinds, pair| {
        let mut simplex = Simplex::default();
        let exact = pair.distance(&mut simplex);
        if exact <= 1e-9 * pair.size {
            return;
        }
        for start in [Simplex::default(), simplex] {
            let mut start = start;
            let near = distance(&pair.a, &pair.b, &pair.placement, exact * (1.0 + 1e-2), &mut start.clone());
            assert!(matches!(near, Ok(Separation::Apart { .. })), "{kinds:?}");
            let far = distance(&pair.a, &pair.b, &pair.placement, exact * (1.0 - 1e-2), &mut start);
            let Ok(Separation::Beyond { axis }) = far else { panic!("{kinds:?}: {far:?}") };
            let gap = pair.gap_across(&axis);
            assert!(
                gap > exact * (1.0 - 1e-2) - 1e-13 * pair.size && gap < exact + 1e-13 * pair.size,
                "{kinds:?}"
            );
            let moved = pair.moved(random, 1e-4);
            assert!(moved.certify(&moved.query(&mut start)) < gap_bound(kinds));
        }
    });
}

#[test]
fn exchanging_the_cores_reverses_the_answer() {
    for_all_pairs(4, PAIRS / 10, |_, kinds, pair| {
        let exchanged = pair.exchanged();
        let scale = pair.placement.matrix.column(0).norm();
        let answers = (pair.query(&mut Simplex::default()), exchanged.query(&mut Simplex::default()));
        let (
            Separation::Apart { distance: ab, normal: n, .. },
            Separation::Apart { distance: ba, normal: m, .. },
        ) = answers
        else {
            return;
        };
        assert!((ab - ba * scale).abs() <= gap_bound(kinds) * pair.size, "{kinds:?}: {ab}, {}", ba * scale);
        let back = -(pair.placement.matrix * m / scale);
        // The normal is good to the root of the gap over the least radius, here 1e-2 of the size; and
        // where v is short, rounding of the points turns it.
        let tolerance = 3e-6 + 3e-11 * pair.size / ab;
        assert!(
            (n - back).norm() < tolerance,
            "{kinds:?}: normals {:e} apart at {:e}",
            (n - back).norm(),
            ab / pair.size
        );
    });
}

#[test]
fn turning_both_bodies_changes_nothing() {
    let mut random = Random(5);
    for number in 0..PAIRS / 50 {
        let kinds = [[Kind::Hull, Kind::Triangle][number % 2], KINDS[number / 2 % 6]];
        let pair = Pair::random(&mut random, kinds, 10.0, number % 3 == 0, 1e-3);
        let turn = random.rotation();
        let a = match &pair.a {
            Core::Polyhedron(hull) => Core::polyhedron(hull.vertices().iter().map(|v| turn * v).collect()),
            Core::Triangle(corners) => Core::Triangle(corners.map(|v| turn * v)),
            _ => continue,
        };
        let matrix = turn.to_rotation_matrix() * pair.placement.matrix;
        let turned = Pair::new(
            a,
            pair.b.clone(),
            Placement { matrix, translation: turn * pair.placement.translation },
        );
        let (d, e) = (pair.distance(&mut Simplex::default()), turned.distance(&mut Simplex::default()));
        assert!((d - e).abs() < 1e-12 * pair.size, "{kinds:?}: {d} {e}");
    }
}

#[test]
fn any_points_of_the_bodies_are_a_valid_start() {
    for_all_pairs(6, PAIRS / 10, |random, kinds, pair| {
        let cold = pair.distance(&mut Simplex::default());
        let mut start = Simplex { len: 1 + random.below(4) as u8, ..Simplex::default() };
        for i in 0..start.len as usize {
            // Hulls and triangles need not hold their origin.
            let hollow = matches!(kinds[0], Kind::Hull | Kind::Triangle);
            let depth = if hollow { 1.0 } else { random.unit() };
            start.a[i] = pair.a.support(&random.direction()) * depth;
            start.b[i] = pair.b.support(&random.direction());
        }
        let warm = pair.distance(&mut start);
        assert!((warm - cold).abs() <= gap_bound(kinds) * pair.size, "{kinds:?}: {warm} {cold}");
    });
}

#[test]
fn invalid_numbers_are_an_error_not_a_distance() {
    let mut pair = Pair::random(&mut Random(7), [Kind::Box, Kind::Cylinder], 1.0, false, 1.0);
    pair.placement.translation.x = f64::NAN;
    let error = distance(&pair.a, &pair.b, &pair.placement, 1.0, &mut Simplex::default())
        .expect_err("there is no distance");
    assert!(error.to_string().contains("Cylinder"));
}
