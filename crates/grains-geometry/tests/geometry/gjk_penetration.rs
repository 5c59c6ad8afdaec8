//! Penetration depths: closed forms, and certificates of random pairs.

use crate::gjk_common::{KINDS, Kind, Pair, Random, place};
use grains_geometry::epa::{Penetration, penetration};
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Core, Placement, Rotation, Simplex, Superellipsoid, Vec3};
use std::f64::consts::FRAC_PI_2;

const PAIRS: usize = if cfg!(debug_assertions) { 20_000 } else { 200_000 };

/// The penetration if the cores meet.
fn penetrate(pair: &Pair) -> Option<Penetration> {
    let mut simplex = Simplex::default();
    let answer = distance(&pair.a, &pair.b, &pair.placement, f64::INFINITY, &mut simplex).expect("converges");
    (answer == Separation::Meeting)
        .then(|| penetration(&pair.a, &pair.b, &pair.placement, &simplex).expect("converges"))
}

fn moved_out(pair: &Pair, p: &Penetration) -> Pair {
    let translation = pair.placement.translation + p.normal * p.depth;
    Pair::new(pair.a.clone(), pair.b.clone(), Placement { matrix: pair.placement.matrix, translation })
}

/// Least overlap of two boxes over the 15 axes: exact, by the theorem of the separating axis.
fn box_depth(half_a: &Vec3, half_b: &Vec3, placement: &Placement) -> f64 {
    let m = &placement.matrix;
    let mut axes: Vec<Vec3> = (0..3).flat_map(|i| [Vec3::ith(i, 1.0), m.column(i).normalize()]).collect();
    for i in 0..3 {
        for j in 0..3 {
            axes.extend(Vec3::ith(i, 1.0).cross(&m.column(j)).try_normalize(1e-6));
        }
    }
    let overlap = |axis: &Vec3| {
        half_a.dot(&axis.abs()) + half_b.dot(&m.tr_mul(axis).abs()) - placement.translation.dot(axis).abs()
    };
    axes.iter().map(overlap).fold(f64::INFINITY, f64::min)
}

#[test]
fn random_boxes_have_the_depth_of_the_least_overlap() {
    let mut random = Random(1);
    let mut met = 0;
    for _ in 0..PAIRS / 4 {
        let size = random.log(1e-6, 1.0);
        let pair = Pair::random(&mut random, [Kind::Box; 2], 100.0, false, size);
        let (Core::Box(a), Core::Box(b)) = (&pair.a, &pair.b) else { unreachable!() };
        let exact = box_depth(a, b, &pair.placement);
        let Some(p) = penetrate(&pair) else {
            assert!(exact < 1e-12 * pair.size);
            continue;
        };
        met += 1;
        assert!((p.depth - exact).abs() < 1e-13 * pair.size, "{} {exact}", p.depth);
    }
    assert!(met > PAIRS / 100);
}

#[test]
fn random_pairs_are_separated_by_the_least_translation() {
    let mut random = Random(2);
    for number in 0..PAIRS {
        let kinds = [KINDS[number % 6], KINDS[number / 6 % 6]];
        let slenderness = if random.below(2) == 0 { 1.0 } else { 100.0 };
        let (aligned, size) = (random.below(2) == 0, random.log(1e-6, 1.0));
        let pair = Pair::random(&mut random, kinds, slenderness, aligned, size);
        let Some(p) = penetrate(&pair) else { continue };
        // Faces parallel to 1e-9, say, leave slivers whose normals have lost digits.
        let bound = if kinds.iter().any(|kind| kind.is_curved()) { 1e-8 } else { 1e-10 };
        // No plane separates the cores that meet; moved out, they just touch.
        assert!(p.depth >= -2e-12 * pair.size, "{kinds:?}: {}", p.depth);
        let moved = moved_out(&pair, &p);
        assert!(moved.lower_bound(&p.normal).abs() <= 1e-13 * pair.size);
        let left = moved.distance(&mut Simplex::default());
        assert!(left <= bound * pair.size, "{kinds:?}: left apart by {:e}", left / pair.size);
        assert!((p.point_a - p.point_b - p.normal * p.depth).norm() <= 1e-13 * pair.size);
        for _ in 0..10 {
            let far = random.direction();
            let near = (p.normal + far * random.log(1e-6, 1.0)).normalize();
            for direction in [far, near] {
                let depth = -pair.lower_bound(&direction);
                assert!(
                    p.depth <= depth + bound * pair.size,
                    "{kinds:?}: {direction:?} needs {:e} less",
                    (p.depth - depth) / pair.size
                );
            }
        }
    }
}

/// Depth and normal at unit size.
fn depth(a: Core, b: Core, rotation: Rotation, translation: Vec3) -> (f64, Vec3) {
    let pair = Pair::new(a, b, place(&rotation, 1.0, translation));
    let p = penetrate(&pair).expect("the cores meet");
    (p.depth, p.normal)
}

fn expect((d, n): (f64, Vec3), depth: f64, normal: Vec3) {
    assert!((d - depth).abs() < 1e-12, "depth {d}, not {depth}");
    assert!((n - normal).norm() < 1e-6, "normal {n}, not {normal}");
}

#[test]
fn closed_forms() {
    let cube = || Core::Box(Vec3::repeat(1.0));
    let can = |radius: f64| Core::Cylinder { radius, half_height: 2.0 };
    let none = Rotation::identity();
    expect(depth(cube(), cube(), none, Vec3::new(1.7, 0.3, -0.2)), 0.3, Vec3::x());
    expect(depth(cube(), cube(), none, Vec3::new(0.1, 0.3, -2.0)), 0.0, -Vec3::z());
    expect(depth(cube(), Core::Point, none, Vec3::new(0.1, 0.8, 0.2)), 0.2, Vec3::y());
    expect(depth(Core::Point, can(1.0), none, Vec3::new(0.54, 0.72, 0.2)), 0.1, Vec3::new(0.6, 0.8, 0.0));
    expect(depth(can(1.0), can(0.5), none, Vec3::new(0.84, 1.12, 0.2)), 0.1, Vec3::new(0.6, 0.8, 0.0));
    let across = Rotation::from_scaled_axis(Vec3::x() * FRAC_PI_2);
    expect(depth(can(1.0), can(0.5), across, Vec3::new(1.45, 0.3, 0.2)), 0.05, Vec3::x());
    let wall =
        Core::Triangle([Vec3::new(-9.0, -9.0, 0.0), Vec3::new(9.0, -9.0, 0.0), Vec3::new(0.0, 9.0, 0.0)]);
    expect(depth(wall.clone(), can(0.5), none, Vec3::new(0.1, 0.2, 1.9)), 0.1, Vec3::z());
    expect(depth(wall.clone(), can(0.5), across, Vec3::new(0.1, 0.2, 0.45)), 0.05, Vec3::z());
    // On the wall either side will do.
    let (d, n) = depth(wall, Core::Point, none, Vec3::new(0.1, 0.2, 0.0));
    assert!(d == 0.0 && n.z.abs() == 1.0);
}

#[test]
fn cylinders_on_one_axis_leave_sideways_or_along() {
    let can = |radius: f64, half_height: f64| Core::Cylinder { radius, half_height };
    let none = Rotation::identity();
    // Any sideways direction is as good as the next.
    let (d, n) = depth(can(1.0, 2.0), can(0.5, 2.0), none, Vec3::new(0.0, 0.0, 0.1));
    assert!((d - 1.5).abs() < 1e-12 && n.z.abs() < 1e-7);
    expect(depth(can(1.0, 0.2), can(0.5, 0.3), none, Vec3::new(0.0, 0.0, 0.1)), 0.4, Vec3::z());
}

#[test]
fn flat_sets_have_no_depth() {
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y()];
    let pair = || (Core::Triangle(corners), Core::Triangle(corners));
    let (a, b) = pair();
    let (d, n) = depth(a, b, Rotation::identity(), Vec3::new(0.2, 0.2, 0.0));
    assert!(d.abs() < 1e-15 && n.z.abs() == 1.0);
    let (d, n) = depth(Core::Point, Core::Point, Rotation::identity(), Vec3::zeros());
    assert!(d == 0.0 && n.norm() == 1.0);
}

/// Smallest depth over directions all around, the best of them improved by ever smaller changes.
fn searched_depth(pair: &Pair) -> f64 {
    const DIRECTIONS: usize = 4000;
    let depth = |normal: &Vec3| -pair.lower_bound(normal);
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let mut found: Vec<(f64, Vec3)> = (0..DIRECTIONS)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
            let (s, c) = (golden * i as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let normal = Vec3::new(r * c, r * s, z);
            (depth(&normal), normal)
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut random = Random(11);
    let improved = found.into_iter().take(12).map(|(mut best, mut normal)| {
        let mut reach = 0.05;
        for _ in 0..2000 {
            let next = (normal + random.direction() * reach).normalize();
            let there = depth(&next);
            if there < best {
                (best, normal) = (there, next);
            } else {
                reach = (0.97 * reach).max(1e-10);
            }
        }
        best
    });
    improved.fold(f64::INFINITY, f64::min)
}

/// Bodies of revolution about nearly one axis have a ring of nearly equal depths.
#[test]
fn bodies_of_revolution_about_nearly_one_axis_have_the_smallest_depth() {
    let mut random = Random(5);
    let (mut met, mut worst) = (0, 0.0_f64);
    for number in 0..PAIRS / 50 {
        let mut core = |which: usize| match which {
            0 => random.core(Kind::Cylinder, 10.0),
            1 => random.core(Kind::Cone, 10.0),
            2 => {
                let [a, c] = [0, 1].map(|_| random.log(0.2, 1.0));
                let body = Superellipsoid::new(Vec3::new(a, a, c), [0.3 + random.unit(), 1.0]).unwrap();
                Core::superellipsoid(body)
            }
            3 => Core::Point,
            _ => random.core(Kind::Segment, 10.0),
        };
        let (a, b) = (core(number % 3), core(number / 3 % 5));
        let tilt = Rotation::from_scaled_axis(random.direction() * random.log(1e-9, 0.1));
        let offset = random.direction() * random.log(1e-9, 0.2);
        let pair = Pair::new(a, b, place(&tilt, 1.0, offset));
        let Some(p) = penetrate(&pair) else { continue };
        met += 1;
        let excess = (p.depth - searched_depth(&pair)) / pair.size;
        worst = worst.max(excess);
        assert!(excess < 1e-6, "{:?} {:?} {:?}: {excess:e} too deep", pair.a, pair.b, pair.placement);
    }
    assert!(met > PAIRS / 100, "{met}");
    println!("{met} pairs, at most {worst:e} of their size too deep");
}
