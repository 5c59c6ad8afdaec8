//! Areas of surfaces against closed forms.
use crate::support::close;
use grains_geometry::{Component, DecompositionOptions, Lobes, RegularSolid, Rotation, Shape, Vec3};
use std::f64::consts::{PI, TAU};

#[test]
fn convex_bodies_have_the_areas_of_their_closed_forms() {
    close(Shape::sphere(2e-3).unwrap().area(), 16e-6 * PI, 1e-14);
    close(Shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.1).unwrap().area(), 22.0, 1e-14);
    close(Shape::cylinder(0.5, 3.0, 0.02).unwrap().area(), TAU * 0.5 * 3.5, 1e-14);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
    let tetrahedron = Shape::hull(&corners, 0.02).unwrap();
    close(tetrahedron.area(), 1.5 + 3f64.sqrt() / 2.0, 1e-14);
    let cube = Shape::regular(RegularSolid::Cube, 0.01, 0.02).unwrap();
    close(cube.area(), 6.0 * cube.volume.powf(2.0 / 3.0), 1e-14);
}

#[test]
fn superellipsoids_have_the_areas_of_ellipsoids_octahedra_and_nearly_boxes() {
    let of = |axes: [f64; 3], eps: [f64; 2]| Shape::superellipsoid(axes.into(), eps, 0.02).unwrap().area();
    close(of([2.0; 3], [1.0; 2]), 16.0 * PI, 1e-6);
    // Spheroids of revolution about z, prolate and oblate.
    let (a, c) = (1.0_f64, 3.0_f64);
    let e = (1.0 - a * a / (c * c)).sqrt();
    close(of([a, a, c], [1.0; 2]), TAU * a * a * (1.0 + c / (a * e) * e.asin()), 1e-5);
    let (a, c) = (2.0_f64, 0.5_f64);
    let e = (1.0 - c * c / (a * a)).sqrt();
    close(of([a, a, c], [1.0; 2]), TAU * a * a * (1.0 + (1.0 - e * e) / e * e.atanh()), 1e-5);
    close(of([1.0; 3], [2.0; 2]), 4.0 * 3f64.sqrt(), 1e-4);
    // Bodies of revolution: 2π ∫ r ds along the meridian r^q + (z/2)^q = 1, in short chords.
    for eps in [0.05, 0.4, 1.5] {
        let q = 2.0 / eps;
        let at = |k: u32| {
            let (z, r) = (f64::from(k) / 1e5 * PI / 2.0).sin_cos();
            let norm = (r.powf(q) + z.powf(q)).powf(1.0 / q);
            (r / norm, 2.0 * z / norm)
        };
        let ring = |(r, z): (f64, f64), (s, w): (f64, f64)| PI * (r + s) * (r - s).hypot(z - w);
        let area: f64 = (0..100_000).map(|k| 2.0 * ring(at(k), at(k + 1))).sum();
        close(of([1.0, 1.0, 2.0], [eps, 1.0]), area, 3e-4);
    }
    close(of([1e-3, 2e-3, 3e-3], [0.3, 0.7]), 1e-6 * of([1.0, 2.0, 3.0], [0.3, 0.7]), 1e-9);
}

#[test]
fn what_lies_in_another_part_is_no_surface() {
    // Spheres of radius r at a distance d: each lacks a cap of height r − d/2.
    let sphere = Shape::sphere(1.0).unwrap();
    for along in [Vec3::x(), Vec3::z(), Vec3::new(0.6, 0.0, 0.8)] {
        let d = 1.2;
        let pair = [Component::new(sphere.clone(), Vec3::zeros()), Component::new(sphere.clone(), along * d)];
        close(Shape::glued(&pair, 0.1).unwrap().area(), 2.0 * TAU * (1.0 + d / 2.0), 3e-4);
    }
    // Cubes side by side, touching and overlapping, make a box; the half of one that rests on the other is hidden.
    let cube = Shape::cuboid(Vec3::repeat(1.0), 0.02).unwrap();
    for (at, wanted) in [([1.0, 0.0, 0.0], 10.0), ([0.5, 0.0, 0.0], 8.0), ([1.0, 0.5, 0.0], 11.0)] {
        let pair = [Component::new(cube.clone(), Vec3::zeros()), Component::new(cube.clone(), at.into())];
        close(Shape::glued(&pair, 0.02).unwrap().area(), wanted, 3e-4);
    }
    // The same body twice, once as a hull turned into place.
    let corners: Vec<Vec3> =
        (0..8).map(|k| Vec3::from_fn(|a, _| if k >> a & 1 == 1 { 0.5 } else { -0.5 })).collect();
    let hull = Component::new(Shape::hull(&corners, 0.02).unwrap(), Vec3::zeros());
    let turn = Rotation::from_axis_angle(&Vec3::z_axis(), PI / 2.0);
    let twice = [Component::new(cube, Vec3::zeros()), hull.turned(turn)];
    close(Shape::glued(&twice, 0.02).unwrap().area(), 6.0, 3e-4);
}

#[test]
fn lobes_and_crosses_have_the_areas_of_their_outlines() {
    for (count, fraction) in [(3, 0.75), (4, 0.8), (5, 0.85)] {
        let lobes = Lobes::with_area_fraction(count, 0.8e-3, fraction).unwrap();
        let (length, rho, c) = (3.2e-3, lobes.lobe_radius(), lobes.offset);
        // Each lobe's arc reaches to where it meets its neighbour's, half the distance of their centres from its own.
        let half = c * (PI / f64::from(count)).sin();
        let inner = (half / rho).acos();
        let arc = PI / 2.0 + PI / f64::from(count) - inner;
        let perimeter = 2.0 * f64::from(count) * rho * arc;
        let section = PI * lobes.radius.powi(2) * lobes.area_fraction();
        let shape = Shape::lobes(lobes, length, 0.02).unwrap();
        close(shape.area(), perimeter * length + 2.0 * section, 3e-4);
    }
    // Beams of width w and length l: each has two ends, and four sides where it leaves the middle.
    let cross = |beams: u32| Shape::cross(beams, 1.0, 3.0, 0.02).unwrap().area();
    close(cross(3), 6.0 + 6.0 * 4.0, 3e-4);
    close(cross(2), 4.0 + 4.0 * 4.0 + 2.0, 3e-4);
}

#[test]
fn a_mesh_has_its_own_area() {
    let mesh = Shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.02).unwrap().surface;
    let options = DecompositionOptions { cache: None, ..DecompositionOptions::default() };
    close(Shape::of_mesh(&mesh, 0.1, &options, 0.02).unwrap().area(), 0.22, 1e-12);
}
