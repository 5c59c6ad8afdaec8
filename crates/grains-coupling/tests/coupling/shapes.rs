//! Projected areas and sphericities against closed forms.

use grains_coupling::{ShapeFactors, ShapeProfile};
use grains_geometry::{Component, Lobes, RegularSolid, Rotation, Shape, Vec3};
use std::f64::consts::PI;

const CRUST: f64 = 0.02;

/// Directions spread evenly over the sphere.
fn directions(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = PI * (5f64.sqrt() - 1.0);
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sine, cosine) = (golden * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cosine, r * sine, z)
    })
}

/// Mean projected area along the directions normal to `d`, by brute force.
fn circle_mean(profile: &ShapeProfile, d: &Vec3) -> f64 {
    let across = d.cross(&Vec3::ith(d.iamin(), 1.0)).normalize();
    let up = d.cross(&across);
    let n = 4000;
    let angle = |k: i32| PI * (f64::from(k) + 0.5) / f64::from(n);
    (0..n).map(|k| profile.projected_area(&(across * angle(k).cos() + up * angle(k).sin()))).sum::<f64>()
        / f64::from(n)
}

fn assert_close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{value} instead of {expected}");
}

fn profile(shape: &Shape) -> ShapeProfile {
    ShapeProfile::new(shape).unwrap()
}

#[test]
fn spheres_have_factors_of_one() {
    let sphere = profile(&Shape::sphere(2e-6).unwrap());
    let d = Vec3::new(0.6, 0.0, 0.8);
    assert_close(sphere.projected_area(&d), 4e-12 * PI, 1e-14);
    assert_close(sphere.longitudinal_area(&d), 4e-12 * PI, 1e-14);
    assert_eq!(sphere.factors(&d), ShapeFactors::SPHERE);
    // A superellipsoid shaped as a sphere too: the law of Hölzer and Sommerfeld is steep there.
    let round = profile(&Shape::superellipsoid(Vec3::repeat(6e-4), [1.0; 2], CRUST).unwrap());
    assert_eq!(round.sphericity, 1.0);
    for d in directions(50) {
        let factors = round.factors(&d);
        assert_close(factors.crosswise, 1.0, 1e-14);
        assert_close(factors.lengthwise, 1.0, 1e-14);
    }
}

#[test]
fn boxes_have_the_areas_of_their_faces() {
    let edges = Vec3::new(1e-3, 2e-3, 5e-3);
    for shape in [Shape::cuboid(edges, CRUST).unwrap(), {
        let corners: Vec<Vec3> = (0..8)
            .map(|k| {
                Vec3::new(1e-3 * f64::from(k & 1), 1e-3 * f64::from(k & 2), 2.5e-3 * f64::from((k & 4) >> 1))
            })
            .collect();
        Shape::hull(&corners, CRUST).unwrap()
    }] {
        let body = profile(&shape);
        assert_close(body.surface, 2.0 * (2e-6 + 5e-6 + 10e-6), 1e-12);
        let axes = [0, 1, 2].map(|a| Vec3::ith(a, 1.0));
        let mut faces: Vec<f64> = axes.iter().map(|a| body.projected_area(a)).collect();
        faces.sort_by(f64::total_cmp);
        for (face, expected) in faces.iter().zip([2e-6, 5e-6, 10e-6]) {
            assert_close(*face, expected, 1e-9);
        }
        for d in directions(20) {
            assert_close(body.longitudinal_area(&d), circle_mean(&body, &d), 1e-6);
        }
    }
    let cube = profile(&Shape::cuboid(Vec3::repeat(0.1), CRUST).unwrap());
    assert_close(cube.sphericity, (PI / 6.0).cbrt(), 1e-12);
    // Along its diagonal a cube shows a hexagon of √3 times a face.
    assert_close(cube.projected_area(&(Vec3::repeat(1.0) / 3f64.sqrt())), 3f64.sqrt() * 0.01, 1e-12);
}

#[test]
fn cylinders_and_ellipsoids_have_their_closed_forms() {
    let (r, h) = (1.5e-3, 4e-3);
    let cylinder = profile(&Shape::cylinder(r, h, CRUST).unwrap());
    assert_close(cylinder.surface, 2.0 * PI * r * (r + h), 1e-12);
    let tilted = Vec3::new(0.0, 0.6, 0.8);
    assert_close(cylinder.projected_area(&tilted), 0.8 * PI * r * r + 0.6 * 2.0 * r * h, 1e-12);
    assert_close(cylinder.longitudinal_area(&Vec3::z()), 2.0 * r * h, 1e-12);
    let across = 2.0 / PI * (2.0 * r * h + PI * r * r);
    assert_close(cylinder.longitudinal_area(&Vec3::x()), across, 1e-12);
    let a = Vec3::new(2e-3, 0.7e-3, 0.5e-3);
    let ellipsoid = profile(&Shape::superellipsoid(a, [1.0; 2], CRUST).unwrap());
    for axis in 0..3 {
        let d = Vec3::ith(axis, 1.0);
        assert_close(ellipsoid.projected_area(&d), PI * a.product() / a[axis], 1e-12);
    }
    for body in [&cylinder, &ellipsoid] {
        for d in directions(20) {
            assert_close(body.longitudinal_area(&d), circle_mean(body, &d), 1e-6);
        }
        // Cauchy: the surface of a convex body is four times its mean shadow.
        let mean = directions(20000).map(|d| body.projected_area(&d)).sum::<f64>() / 20000.0;
        assert_close(4.0 * mean, body.surface, 1e-5);
    }
}

#[test]
fn spheroids_have_their_closed_surface() {
    for ratio in [0.02, 0.5, 0.999, 1.001, 3.0, 50.0f64] {
        let shape = Shape::superellipsoid(Vec3::new(1.0, 1.0, ratio), [1.0; 2], CRUST).unwrap();
        let expected = if ratio < 1.0 {
            let e = (1.0 - ratio * ratio).sqrt();
            2.0 * PI * (1.0 + (1.0 - e * e) / e * e.atanh())
        } else {
            let e = (1.0 - 1.0 / (ratio * ratio)).sqrt();
            2.0 * PI * (1.0 + ratio / e * e.asin())
        };
        assert_close(profile(&shape).surface, expected, 1e-12);
    }
}

#[test]
fn regular_solids_have_their_sphericities() {
    // (36π V²)^⅓/S.
    for (solid, expected) in [
        (RegularSolid::Tetrahedron, 0.671139),
        (RegularSolid::Cube, 0.805996),
        (RegularSolid::Octahedron, 0.845583),
        (RegularSolid::Dodecahedron, 0.910453),
        (RegularSolid::Icosahedron, 0.939326),
    ] {
        let body = profile(&Shape::regular(solid, 1e-3, CRUST).unwrap());
        assert_close(body.sphericity, expected, 1e-6);
        for d in directions(10) {
            assert_close(body.longitudinal_area(&d), circle_mean(&body, &d), 1e-5);
        }
    }
}

#[test]
fn superellipsoids_are_tabulated_to_their_stated_error() {
    for eps in [[0.3, 0.3], [1.0, 0.4], [0.6, 1.4], [2.0, 2.0]] {
        let a = Vec3::new(1.0, 0.8, 1.5);
        let body = profile(&Shape::superellipsoid(a, eps, CRUST).unwrap());
        let [projected, longitudinal] = body.table_errors();
        println!("superellipsoid {eps:?}: {projected:?} {longitudinal:?}");
        assert!(projected.largest < 0.012 && projected.rms < 0.002, "{eps:?}: {projected:?}");
        assert!(longitudinal.largest < 0.012 && longitudinal.rms < 0.002, "{eps:?}: {longitudinal:?}");
        let mean = directions(20000).map(|d| body.projected_area(&d)).sum::<f64>() / 20000.0;
        assert_close(4.0 * mean, body.surface, 1e-3);
        for d in directions(8) {
            assert_close(body.longitudinal_area(&d), circle_mean(&body, &d), 1e-3);
        }
    }
    // ε = 2 is an octahedron: faces of normals (1/a, 1/b, 1/c), shadow along x of the rhombus 2bc.
    let octahedron = profile(&Shape::superellipsoid(Vec3::new(1.0, 0.8, 1.5), [2.0; 2], CRUST).unwrap());
    assert_close(octahedron.projected_area(&Vec3::x()), 2.0 * 0.8 * 1.5, 1e-3);
    let face = 0.5 * (0.8f64 * 0.8 * 1.5 * 1.5 + 1.5 * 1.5 + 0.8 * 0.8).sqrt();
    assert_close(octahedron.surface, 8.0 * face, 1e-3);
}

#[test]
fn composites_that_are_one_body_are_measured_as_such() {
    let edges = Vec3::new(1e-3, 2e-3, 3e-3);
    let whole = profile(&Shape::cuboid(edges, CRUST).unwrap());
    let sliced = profile(&Shape::sliced_cuboid(edges, 4, CRUST).unwrap());
    assert_close(sliced.surface, whole.surface, 1e-3);
    let [projected, longitudinal] = sliced.table_errors();
    println!("sliced box: {projected:?} {longitudinal:?}");
    assert!(projected.largest < 0.005 && projected.rms < 0.002, "{projected:?}");
    assert!(longitudinal.largest < 0.015 && longitudinal.rms < 0.003, "{longitudinal:?}");
    // The shadow itself is found to some 1e-3.
    for d in directions(300) {
        assert_close(sliced.projected_area(&d), whole.projected_area(&d), projected.largest + 1e-3);
        assert_close(sliced.longitudinal_area(&d), whole.longitudinal_area(&d), longitudinal.largest + 1e-3);
    }
    let (r, h) = (1.5e-3, 4e-3);
    let cylinder = profile(&Shape::cylinder(r, h, CRUST).unwrap());
    let sliced = profile(&Shape::sliced_cylinder(r, h, 5, CRUST).unwrap());
    assert_close(sliced.surface, cylinder.surface, 1e-3);
    for d in directions(300) {
        assert_close(
            sliced.projected_area(&d),
            cylinder.projected_area(&d),
            sliced.table_errors()[0].largest + 1e-3,
        );
    }
}

#[test]
fn crosses_lobes_and_spheres_have_their_shadows() {
    // Three beams of w × w × l: along a beam the shadow is a plus of 2 l w − w², as is that along any axis.
    let (w, l) = (1.0, 3.0);
    let cross = profile(&Shape::cross(3, w, l, CRUST).unwrap());
    for axis in 0..3 {
        assert_close(cross.projected_area(&Vec3::ith(axis, 1.0)), 2.0 * l * w - w * w, 2e-3);
    }
    // Each of six arms has a square end and four sides of w (l−w)/2.
    assert_close(cross.surface, 6.0 * (w * w + 4.0 * w * 0.5 * (l - w)), 2e-3);
    let two = Shape::glued(
        &[
            Component::new(Shape::sphere(1.0).unwrap(), Vec3::zeros()),
            Component::new(Shape::sphere(1.0).unwrap(), Vec3::new(1.0, 0.0, 0.0)),
        ],
        CRUST,
    )
    .unwrap();
    let body = profile(&two);
    // Caps of height 0.5 are missing on either side; the lens of two discs at distance 1 is 2π/3 − √3/2.
    assert_close(body.surface, 2.0 * (4.0 * PI - 2.0 * PI * 0.5), 1e-3);
    let lens = 2.0 * PI / 3.0 - 0.75f64.sqrt();
    let axis = two.user_to_body.0.inverse() * Vec3::x();
    let across = axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize();
    assert_close(body.projected_area(&axis), PI, 2e-3);
    assert_close(body.projected_area(&across), 2.0 * PI - lens, 2e-3);
    let lobes = Lobes::with_area_fraction(3, 1.0, 0.75).unwrap();
    let trilobe = profile(&Shape::lobes(lobes, 4.0, CRUST).unwrap());
    let volume = 0.75 * PI * 4.0;
    let ends: f64 = 2.0 * volume / 4.0;
    assert_close(trilobe.projected_area(&Vec3::z()), ends / 2.0, 2e-3);
    assert!(trilobe.surface > ends && trilobe.sphericity < 0.85, "{trilobe:?}");
}

#[test]
fn turned_and_scaled_bodies_keep_their_factors() {
    let edges = Vec3::new(1.0, 2.0, 3.0);
    let alone = |size: f64| {
        let turn = Rotation::from_euler_angles(0.3, 0.5, -0.2);
        let part =
            Component::new(Shape::cuboid(edges * size, CRUST).unwrap(), Vec3::repeat(size)).turned(turn);
        profile(&Shape::glued(&[part], CRUST).unwrap())
    };
    let whole = profile(&Shape::cuboid(edges, CRUST).unwrap());
    for d in directions(20) {
        for size in [1e-6, 1.0] {
            let (a, b) = (alone(size).factors(&d), whole.factors(&d));
            assert_close(a.crosswise, b.crosswise, 1e-9);
            assert_close(a.lengthwise, b.lengthwise, 1e-9);
            assert_close(a.sphericity, b.sphericity, 1e-9);
        }
    }
}
