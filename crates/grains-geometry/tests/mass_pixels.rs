//! The pixel rule against counting every cell, closed forms and the parallel-axis theorem.
#![allow(clippy::unwrap_used, reason = "a test stops at what it does not expect")]

mod support;

use grains_geometry::{Component, MassProperties, Mat3, RegularSolid, Rotation, Shape, Vec3};
use support::{Random, close};

/// A box, a cylinder, a tetrahedron and a ball that overlap, turned at random.
fn mixed(random: &mut Random, size: f64) -> Shape {
    let shapes = [
        Shape::cuboid(Vec3::new(1.0, 0.4, 0.6) * size, 0.05).unwrap(),
        Shape::cylinder(0.3 * size, 0.9 * size, 0.05).unwrap(),
        Shape::regular(RegularSolid::Tetrahedron, 0.7 * size, 0.05).unwrap(),
        Shape::sphere(0.4 * size).unwrap(),
    ];
    let place = |shape: Shape| {
        let position = random.vector() * (0.25 * size);
        Component::new(shape, position).turned(random.rotation())
    };
    Shape::glued(&shapes.into_iter().map(place).collect::<Vec<_>>(), 0.02).unwrap()
}

/// Corners of the box around the parts, found by halving.
fn counted(shape: &Shape, lower: Vec3, cell: Vec3, cells: u32) -> (f64, Vec3, Mat3) {
    let (mut count, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
    for k in 0..cells {
        for j in 0..cells {
            for i in 0..cells {
                let index = Vec3::new(f64::from(i), f64::from(j), f64::from(k));
                let x = lower + cell.component_mul(&index.add_scalar(0.5));
                if shape.contains(&x) {
                    count += 1.0;
                    first += x;
                    second += x * x.transpose();
                }
            }
        }
    }
    (count, first, second)
}

#[test]
fn rows_count_what_testing_every_cell_counts() {
    let mut random = Random::new(7);
    for size in [1e-6, 1.0, 30.0] {
        let shape = mixed(&mut random, size);
        let cells = 60;
        let mass = MassProperties::of_pixels(&shape.parts, cells);
        // The box of the rule is that of the parts with sharp edges; their corners show in a finer count.
        let (lower, upper) = sharp_box(&shape);
        let cell = (upper - lower) / f64::from(cells);
        let (count, first, second) = counted(&shape, lower, cell, cells);
        close(mass.volume, count * cell.product(), 1e-12);
        let center = first / count;
        assert!((mass.center - center).norm() < 1e-12 * size);
        let moments = (second - center * first.transpose()) * cell.product();
        let inertia = Mat3::identity() * moments.trace() - moments;
        assert!((mass.inertia - inertia).norm() < 1e-11 * inertia.norm());
    }
}

/// The box around the parts with sharp edges: balls, boxes and cylinders by formula, polyhedra from the
/// corners of their faces' planes.
fn sharp_box(shape: &Shape) -> (Vec3, Vec3) {
    use grains_geometry::Core;
    let mut extents = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    for part in &shape.parts {
        let r = &part.rotation;
        let (low, high) = match &part.core {
            Core::Point => (Vec3::repeat(-part.crust), Vec3::repeat(part.crust)),
            Core::Box(half) => {
                let h = r.abs() * half.add_scalar(part.crust);
                (-h, h)
            }
            Core::Cylinder { radius, half_height } => {
                let h = Vec3::from_fn(|a, _| {
                    (radius + part.crust) * (1.0 - r[(a, 2)].powi(2)).sqrt()
                        + (half_height + part.crust) * r[(a, 2)].abs()
                });
                (-h, h)
            }
            Core::Polyhedron(hull) => {
                // Three faces of the tetrahedron meet in each corner.
                let faces = hull.faces();
                assert_eq!(faces.len(), 4);
                let corner = |skip: usize| {
                    let f: Vec<_> = (0..4).filter(|k| *k != skip).map(|k| &faces[k]).collect();
                    let normals = Mat3::from_rows(&[
                        f[0].normal.transpose(),
                        f[1].normal.transpose(),
                        f[2].normal.transpose(),
                    ]);
                    let offsets = Vec3::new(f[0].offset, f[1].offset, f[2].offset).add_scalar(part.crust);
                    r * (normals.try_inverse().unwrap() * offsets)
                };
                let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
                (0..4).map(corner).fold(start, |(l, u), p| (l.inf(&p), u.sup(&p)))
            }
            Core::Superellipsoid(_) | Core::Triangle(_) => unreachable!("no part of these shapes"),
        };
        extents = (extents.0.inf(&(low + part.center)), extents.1.sup(&(high + part.center)));
    }
    extents
}

/// Published convergence of the rule on a ball: relative errors of the volume.
#[test]
fn the_volume_of_a_ball_converges_as_known() {
    let ball = Shape::sphere(1.5e-3).unwrap();
    for (cells, expected) in [(50, 4.6e-3), (100, 7.4e-4), (200, 2.5e-5), (400, 3.1e-5)] {
        let pixels = MassProperties::of_pixels(&ball.parts, cells);
        let error = (pixels.volume / ball.volume - 1.0).abs();
        assert!((error / expected - 1.0).abs() < 0.03, "{cells} cells: {error:e}");
    }
    let report = ball.mass_report(500);
    assert!(report.volume_difference.abs() < 1e-4 && report.inertia_difference.abs() < 1e-4, "{report:?}");
}

#[test]
fn pixels_agree_with_closed_forms_of_turned_bodies() {
    let mut random = Random::new(11);
    let bodies = [
        Shape::cuboid(Vec3::new(1.0, 2.0, 0.5), 0.02).unwrap(),
        Shape::cylinder(0.5, 3.0, 0.02).unwrap(),
        Shape::regular(RegularSolid::Icosahedron, 1.0, 0.1).unwrap(),
    ];
    for body in bodies {
        let (turn, place) = (random.rotation(), random.vector());
        let mut parts = body.parts.clone();
        let matrix = turn.to_rotation_matrix().into_inner();
        for part in &mut parts {
            part.center = matrix * part.center + place;
            part.rotation = matrix * part.rotation;
        }
        let exact = MassProperties::in_body_frame(body.volume, &body.inertia).placed(&turn, &place);
        let pixels = MassProperties::of_pixels(&parts, 500);
        close(pixels.volume, exact.volume, 2e-4);
        assert!((pixels.center - exact.center).norm() < 2e-4, "{}", body.name);
        assert!((pixels.inertia - exact.inertia).norm() < 5e-4 * exact.inertia.norm(), "{}", body.name);
    }
}

/// The sum of the halves of a box is the box.
#[test]
fn sums_follow_the_parallel_axis_theorem() {
    let whole = Shape::cuboid(Vec3::new(2.0, 1.0, 3.0), 0.02).unwrap();
    let half = Shape::cuboid(Vec3::new(1.0, 1.0, 3.0), 0.02).unwrap();
    let place = |x: f64| {
        let mass = MassProperties::in_body_frame(half.volume, &half.inertia);
        mass.placed(&Rotation::identity(), &Vec3::new(x, 5.0, -7.0))
    };
    let sum = MassProperties::sum(&[place(2.5), place(3.5)]);
    close(sum.volume, whole.volume, 1e-15);
    assert!((sum.center - Vec3::new(3.0, 5.0, -7.0)).norm() < 1e-14);
    assert!((sum.inertia - Mat3::from_diagonal(&whole.inertia)).norm() < 1e-13);
}
