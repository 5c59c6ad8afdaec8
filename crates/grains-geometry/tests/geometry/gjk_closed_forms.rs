//! Distances known in closed form.

use crate::gjk_common::{Random, place};
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Core, Rotation, Simplex, Superellipsoid, Vec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

const SIZES: [f64; 3] = [1e-6, 1e-3, 1.0];

/// Distance and normal of the pair of unit size at the given rotation and translation, checked to be the
/// same at all sizes.
fn query(core: impl Fn(f64) -> [Core; 2], rotation: Rotation, translation: Vec3) -> (f64, Vec3) {
    let answers = SIZES.map(|size| {
        let [a, b] = core(size);
        let placement = place(&rotation, 1.0, translation * size);
        match distance(&a, &b, &placement, f64::INFINITY, &mut Simplex::default()).expect("converges") {
            Separation::Apart { distance, normal, .. } => (distance / size, normal),
            other => panic!("{other:?} at size {size}"),
        }
    });
    for (d, n) in answers {
        assert!((d - answers[2].0).abs() < 1e-11 && (n - answers[2].1).norm() < 1e-7);
    }
    answers[2]
}

fn expect(answer: (f64, Vec3), distance: f64, normal: Vec3) {
    expect_within(1e-14, answer, distance, normal);
}

fn expect_within(tolerance: f64, (d, n): (f64, Vec3), distance: f64, normal: Vec3) {
    assert!((d - distance).abs() < tolerance, "distance {d}, not {distance}");
    assert!((n - normal).norm() < 1e-7, "normal {n}, not {normal}");
}

fn boxes(s: f64) -> [Core; 2] {
    [Core::Box(Vec3::new(1.0, 2.0, 3.0) * s), Core::Box(Vec3::new(0.5, 0.7, 0.3) * s)]
}

fn cylinders(s: f64) -> [Core; 2] {
    [
        Core::Cylinder { radius: 0.5 * s, half_height: 2.0 * s },
        Core::Cylinder { radius: 0.3 * s, half_height: s },
    ]
}

#[test]
fn aligned_boxes() {
    let none = Rotation::identity();
    expect(query(boxes, none, Vec3::new(2.0, 0.1, -0.2)), 0.5, Vec3::x());
    expect(query(boxes, none, Vec3::new(0.1, -3.0, -0.2)), 0.3, -Vec3::y());
    // Edge to edge, and corner to corner.
    let gap = Vec3::new(0.3, 0.4, 0.0);
    expect(query(boxes, none, Vec3::new(1.5, 2.7, 1.0) + gap), 0.5, gap / 0.5);
    let gap = Vec3::new(0.2, 0.3, 0.6);
    expect(query(boxes, none, Vec3::new(1.5, 2.7, 3.3) + gap), 0.7, gap / 0.7);
}

#[test]
fn crossed_edges_of_boxes() {
    // Each is turned onto an edge: top edge of A along x, bottom edge of B along y.
    let cubes = |s: f64| [Core::Box(Vec3::repeat(s)), Core::Box(Vec3::repeat(s))];
    let turn = Rotation::from_scaled_axis(Vec3::new(FRAC_PI_4, 0.0, 0.0));
    let other = Rotation::from_scaled_axis(Vec3::new(0.0, FRAC_PI_4, 0.0));
    let normal = turn.inverse() * Vec3::z();
    let height = 2.0 * 2.0_f64.sqrt();
    let answer = query(cubes, turn.inverse() * other, normal * (height + 0.01));
    expect(answer, 0.01, normal);
}

#[test]
fn points() {
    let against = |b: fn(f64) -> Core| move |s: f64| [Core::Point, b(s)];
    let none = Rotation::identity();
    expect(
        query(against(|_| Core::Point), none, Vec3::new(3.0, 4.0, 12.0)),
        13.0,
        Vec3::new(3.0, 4.0, 12.0) / 13.0,
    );
    let cube = against(|s| Core::Box(Vec3::repeat(s)));
    expect(query(cube, none, Vec3::new(1.5, 0.0, 0.0)), 0.5, Vec3::x());
    expect(query(cube, none, Vec3::new(1.3, -1.4, 0.2)), 0.5, Vec3::new(0.6, -0.8, 0.0));
    let can = against(|s| Core::Cylinder { radius: s, half_height: s });
    expect(query(can, none, Vec3::new(0.0, 1.5, 0.2)), 0.5, Vec3::y());
    expect(query(can, none, Vec3::new(0.3, 0.2, 1.5)), 0.5, Vec3::z());
    expect(query(can, none, Vec3::new(1.3, 0.0, 1.4)), 0.5, Vec3::new(0.6, 0.0, 0.8));
    let triangle = against(|s| Core::Triangle([Vec3::zeros(), Vec3::x() * s, Vec3::y() * s]));
    expect(query(triangle, none, Vec3::new(-0.2, -0.2, 0.5)), 0.5, Vec3::z());
    expect(query(triangle, none, Vec3::new(-0.2, 0.3, 0.4)), 0.5, Vec3::new(0.0, 0.6, 0.8));
    expect(query(triangle, none, Vec3::new(0.0, 0.3, 0.4)), 0.5, Vec3::new(0.0, 0.6, 0.8));
}

#[test]
fn points_agree_with_the_iterative_search() {
    // A polyhedron of one vertex is a point without closed forms.
    let mut random = Random(1);
    for _ in 0..20_000 {
        let e = Vec3::from_fn(|_, _| random.log(0.01, 1.0));
        let core = match random.below(3) {
            0 => Core::Box(e),
            1 => Core::Cylinder { radius: e.x, half_height: e.y },
            _ => Core::Triangle([random.direction(), random.direction(), random.direction()]),
        };
        let placement = place(&random.rotation(), random.log(0.1, 10.0), random.direction() * 2.0);
        let dot = Core::polyhedron(vec![Vec3::zeros()]);
        let ask = |a: &Core, b: &Core| {
            distance(a, b, &placement, f64::INFINITY, &mut Simplex::default()).expect("converges")
        };
        for [exact, searched] in
            [[ask(&Core::Point, &core), ask(&dot, &core)], [ask(&core, &Core::Point), ask(&core, &dot)]]
        {
            match (exact, searched) {
                (
                    Separation::Apart { distance: d, normal: n, point_b: p, .. },
                    Separation::Apart { distance: e, normal: m, point_b: q, .. },
                ) => {
                    assert!(
                        (d - e).abs() < 1e-11 && (n - m).norm() < 1e-5 && (p - q).norm() < 1e-5,
                        "{core:?} {d} {e} {n} {m}"
                    );
                }
                (exact, searched) => assert_eq!(exact, searched),
            }
        }
    }
}

#[test]
fn parallel_cylinders() {
    let none = Rotation::identity();
    // Side by side, end to end, and rim to rim across.
    expect(query(cylinders, none, Vec3::new(0.6, 0.8, 0.5)), 0.2, Vec3::new(0.6, 0.8, 0.0));
    expect(query(cylinders, none, Vec3::new(0.1, 0.2, -3.25)), 0.25, -Vec3::z());
    expect(query(cylinders, none, Vec3::new(0.0, 1.1, 3.4)), 0.5, Vec3::new(0.0, 0.6, 0.8));
}

#[test]
fn crossed_cylinders() {
    // Axes at 90 and at 50 degrees, the common perpendicular along x.
    for angle in [FRAC_PI_2, 0.87] {
        let turn = Rotation::from_scaled_axis(Vec3::x() * angle);
        expect(query(cylinders, turn, Vec3::new(1.0, 0.1, 0.3)), 0.2, Vec3::x());
    }
    // B stands with its rim on the side of A: the lowest rim point of B, tilted by 0.4.
    let tilt = 0.4_f64;
    let turn = Rotation::from_scaled_axis(Vec3::new(0.0, FRAC_PI_2 - tilt, 0.0));
    let drop = tilt.sin() * 0.3 + tilt.cos() * 1.0;
    expect(query(cylinders, turn, Vec3::new(0.5 + 0.05 + drop, 0.0, 0.0)), 0.05, Vec3::x());
}

#[test]
fn cylinder_on_triangle() {
    let wall = |s: f64| {
        let corners = [Vec3::new(-9.0, -9.0, 0.0), Vec3::new(9.0, -9.0, 0.0), Vec3::new(0.0, 9.0, 0.0)];
        [Core::Triangle(corners.map(|c| c * s)), Core::Cylinder { radius: 0.3 * s, half_height: s }]
    };
    // Standing, lying, and leaning.
    expect_within(1e-11, query(wall, Rotation::identity(), Vec3::new(0.1, 0.2, 1.05)), 0.05, Vec3::z());
    let lying = Rotation::from_scaled_axis(Vec3::new(FRAC_PI_2, 0.0, 0.0));
    expect_within(1e-11, query(wall, lying, Vec3::new(0.1, 0.2, 0.35)), 0.05, Vec3::z());
    let lean = 0.7_f64;
    let drop = lean.cos() * 1.0 + lean.sin() * 0.3;
    let leaning = Rotation::from_scaled_axis(Vec3::new(lean, 0.0, 0.0));
    expect_within(1e-11, query(wall, leaning, Vec3::new(0.1, 0.2, drop + 0.05)), 0.05, Vec3::z());
}

#[test]
fn triangles() {
    let pair = |s: f64| {
        let corners = [Vec3::zeros(), Vec3::x() * s, Vec3::y() * s];
        [Core::Triangle(corners), Core::Triangle(corners)]
    };
    let none = Rotation::identity();
    expect(query(pair, none, Vec3::new(0.1, 0.1, 0.4)), 0.4, Vec3::z());
    expect(query(pair, none, Vec3::new(1.3, 0.0, 0.4)), 0.5, Vec3::new(0.6, 0.0, 0.8));
    expect(query(pair, none, Vec3::new(0.0, -1.25, 0.0)), 0.25, -Vec3::y());
    let half = 0.5_f64.sqrt();
    expect(query(pair, none, Vec3::new(1.0, 1.0, 0.0)), half, Vec3::new(half, half, 0.0));
}

#[test]
fn meeting_cores() {
    for size in SIZES {
        for (pair, shift) in
            [(boxes(size), Vec3::new(1.4, 2.6, 3.2)), (cylinders(size), Vec3::new(0.4, 0.4, 2.0))]
        {
            for factor in [0.0, 0.5, 1.0, 1.0 - 1e-13] {
                let placement = place(&Rotation::identity(), 1.0, shift * (size * factor));
                let mut simplex = Simplex::default();
                for _ in 0..2 {
                    let answer = distance(&pair[0], &pair[1], &placement, 0.1 * size, &mut simplex);
                    assert_eq!(answer.expect("converges"), Separation::Meeting);
                }
            }
        }
    }
}

/// Bodies of very different size that stand on each other's axis, to the last bit: no direction leads away from it.
#[test]
fn superellipsoids_on_the_axis_of_a_cylinder() {
    let mut random = Random(11);
    for k in 0..3000 {
        let [x, y, z] = [0; 3].map(|_| random.log(1e-2, 1.0));
        let exponent = [1.0, 1.0, 0.5, 0.25][k % 4];
        let body = Superellipsoid::new(Vec3::new(x, y, z), [exponent; 2]).unwrap();
        let inset = 0.05 * body.inscribed_radius();
        let core = Core::superellipsoid(body.eroded(inset));
        let [radius, half_height] = [0; 2].map(|_| random.log(1e-4, 1e2) * z);
        let cylinder = Core::Cylinder { radius, half_height };
        let size = x.max(y).max(z) + radius + half_height;
        let turn = Rotation::from_scaled_axis(Vec3::z() * (6.0 * random.unit()));
        let turn = turn * Rotation::from_scaled_axis(Vec3::z() * random.unit());
        // The support value is that of the core, so the gap is known to rounding.
        let (gap, top) = (random.log(1e-9, 1e-1) * size, core.support_value(&Vec3::z()));
        for (a, b) in [(&core, &cylinder), (&cylinder, &core)] {
            let placement = place(&turn, 1.0, Vec3::z() * (top + half_height + gap));
            let mut simplex = Simplex::default();
            for _ in 0..3 {
                let found = distance(a, b, &placement, f64::INFINITY, &mut simplex).unwrap();
                let Separation::Apart { distance, normal, .. } = found else {
                    panic!("pair {k}: {found:?} for a gap of {gap}");
                };
                assert!((distance - gap).abs() < 1e-9 * size, "pair {k}: {distance} for {gap}");
                assert!((normal - Vec3::z()).norm() * distance < 1e-5 * size, "pair {k}: {normal}");
                let points = simplex.a.iter().chain(&simplex.b);
                assert!(points.flatten().all(|x| x.is_finite()), "pair {k}: {simplex:?}");
            }
        }
    }
}
