//! Mass properties of unions: pieces of polyhedra and chords against closed forms, each other and counted points.
use crate::support::{Random, close};
use grains_geometry::{
    Component, MassProperties, MassSource, Mat3, RegularSolid, Rotation, Shape, ShapeError, Vec3,
};
use std::f64::consts::PI;

/// Mass properties of a composite in the frame its components were given in.
fn in_user_frame(shape: &Shape) -> MassProperties {
    let (rotation, center) = &shape.user_to_body;
    MassProperties::in_body_frame(shape.volume, &shape.inertia).placed(rotation, center)
}

#[track_caller]
fn same(a: &MassProperties, b: &MassProperties, tolerance: f64, size: f64) {
    close(a.volume, b.volume, tolerance);
    assert!((a.center - b.center).norm() < tolerance * size, "{} {}", a.center, b.center);
    assert!((a.inertia - b.inertia).norm() < tolerance * b.inertia.norm(), "{} {}", a.inertia, b.inertia);
}

/// A box by its corners, not turned.
fn cuboid(lower: &Vec3, upper: &Vec3) -> MassProperties {
    let e = upper - lower;
    let squares = e.component_mul(&e);
    let inertia = (Vec3::repeat(squares.sum()) - squares) * (e.product() / 12.0);
    MassProperties::in_body_frame(e.product(), &inertia)
        .placed(&Rotation::identity(), &((lower + upper) / 2.0))
}

/// Two boxes, their union by inclusion and exclusion of the box they share: also where faces lie in one plane, as they do
/// in bodies people build.
#[test]
fn two_boxes_have_the_mass_of_their_closed_form() {
    let mut random = Random::new(3);
    for number in 0..300 {
        let size = 10f64.powf(random.range(-6.0, 1.0));
        let grid = |x: Vec3| if number % 2 == 0 { x.map(|x| (4.0 * x).round() / 4.0) } else { x };
        let half = [(); 2].map(|()| grid(random.vector().abs().add_scalar(0.26)).map(|x| x.max(0.25)) * size);
        let at = [Vec3::zeros(), grid(random.vector() * 0.5) * size];
        let (lower, upper) = ((-half[0]).sup(&(at[1] - half[1])), half[0].inf(&(at[1] + half[1])));
        if (upper - lower).min() <= 1e-3 * size {
            continue;
        }
        let parts = [0, 1].map(|k| Component::new(Shape::cuboid(half[k] * 2.0, 0.02).unwrap(), at[k]));
        let turn = random.rotation();
        let turned = parts.map(|part| Component { position: turn * part.position, ..part }.turned(turn));
        let shape = Shape::glued(&turned, 0.02).unwrap();
        assert_eq!(shape.report.mass, MassSource::Clipped);
        let [a, b] = [0, 1].map(|k| cuboid(&(at[k] - half[k]), &(at[k] + half[k])));
        let shared = cuboid(&lower, &upper);
        // What they share counts as negative mass.
        let negative = MassProperties { volume: -shared.volume, inertia: -shared.inertia, ..shared };
        let exact = MassProperties::sum(&[a, b, negative]).placed(&turn, &Vec3::zeros());
        same(&in_user_frame(&shape), &exact, 1e-11, size);
    }
}

/// Polyhedra at random: cut in pieces in any order, or by chords.
#[test]
fn pieces_and_chords_agree_in_any_order() {
    let mut random = Random::new(4);
    let mut tried = 0;
    while tried < 25 {
        let any = |random: &mut Random| match random.index(3) {
            0 => Shape::cuboid(Vec3::new(1.0, 0.4, 0.6), 0.02).unwrap(),
            1 => Shape::regular(RegularSolid::Dodecahedron, 0.6, 0.02).unwrap(),
            _ => {
                let points: Vec<Vec3> = (0..12).map(|_| random.direction() * 0.6).collect();
                Shape::hull(&points, 0.02).unwrap()
            }
        };
        let count = 2 + random.index(5);
        let mut parts: Vec<Component> = (0..count)
            .map(|_| {
                let shape = any(&mut random);
                Component::new(shape, random.vector() * 0.35).turned(random.rotation())
            })
            .collect();
        let Ok(shape) = Shape::glued(&parts, 1e-3) else { continue };
        tried += 1;
        parts.reverse();
        let reversed = Shape::glued(&parts, 1e-3).unwrap();
        same(&in_user_frame(&reversed), &in_user_frame(&shape), 1e-11, 1.0);
        let report = shape.mass_report();
        assert!(
            report.volume_difference.abs() < 1e-4 && report.inertia_difference.abs() < 2e-4,
            "{report:?}"
        );
    }
}

/// Chords against closed forms, at any size and however the bodies lie; the error is about what it is said to be.
#[test]
fn chords_agree_with_closed_forms_of_turned_bodies() {
    let mut random = Random::new(11);
    let bodies = [
        Shape::sphere(1.0).unwrap(),
        Shape::cuboid(Vec3::new(1.0, 2.0, 0.5), 0.02).unwrap(),
        Shape::cuboid(Vec3::new(1.0, 1.0, 0.02), 0.02).unwrap(),
        Shape::cylinder(0.5, 3.0, 0.02).unwrap(),
        Shape::regular(RegularSolid::Icosahedron, 1.0, 0.1).unwrap(),
        Shape::superellipsoid(Vec3::new(1.0, 0.7, 0.5), [0.3, 0.8], 0.02).unwrap(),
        Shape::superellipsoid(Vec3::new(1.0, 0.7, 0.5), [1.5, 1.2], 0.02).unwrap(),
    ];
    for body in bodies {
        for turned in [false, true] {
            let turn = if turned { random.rotation() } else { Rotation::identity() };
            let place = random.vector();
            let mut parts = body.parts.clone();
            let matrix = turn.to_rotation_matrix().into_inner();
            for part in &mut parts {
                part.center = matrix * part.center + place;
                part.rotation = matrix * part.rotation;
            }
            let exact = MassProperties::in_body_frame(body.volume, &body.inertia).placed(&turn, &place);
            let (chords, lines, error) = MassProperties::of_chords(&parts);
            assert!(error < 2e-5 && lines <= 2048, "{}: {error:e} with {lines}", body.name);
            same(&chords, &exact, 5e-5, 1.0);
        }
    }
}

/// Two balls: without the lens they share. Two crossed cylinders: without the 16/3 r³ they share (Archimedes).
#[test]
fn round_bodies_have_the_volume_of_their_union() {
    for size in [1e-6, 1.0, 30.0] {
        let ball = Shape::sphere(size).unwrap();
        for d in [0.01, 0.3, 1.0, 1.9] {
            let at = |x: f64| Component::new(ball.clone(), Vec3::new(x, 3.0 * size, 0.0));
            let pair = Shape::glued(&[at(0.0), at(d * size)], 0.02).unwrap();
            let lens = PI / 12.0 * (4.0 + d) * (2.0 - d) * (2.0 - d) * size.powi(3);
            assert!(matches!(pair.report.mass, MassSource::Chords { error, .. } if error < 3e-5));
            close(pair.volume, 2.0 * ball.volume - lens, 4e-5);
        }
        let beam = Shape::cylinder(0.5 * size, 3.0 * size, 0.02).unwrap();
        let across = Rotation::from_axis_angle(&Vec3::x_axis(), 0.5 * PI);
        let cross = [
            Component::new(beam.clone(), Vec3::zeros()),
            Component::new(beam.clone(), Vec3::zeros()).turned(across),
        ];
        let cross = Shape::glued(&cross, 0.02).unwrap();
        close(cross.volume, 2.0 * beam.volume - 16.0 / 3.0 * (0.5 * size).powi(3), 4e-5);
    }
}

/// Different bodies, turned at random, against counted points.
#[test]
fn mixed_bodies_have_the_mass_of_counted_points() {
    let mut random = Random::new(7);
    let shapes = [
        Shape::cuboid(Vec3::new(1.0, 0.4, 0.6), 0.05).unwrap(),
        Shape::cylinder(0.3, 0.9, 0.05).unwrap(),
        Shape::regular(RegularSolid::Tetrahedron, 0.7, 0.05).unwrap(),
        Shape::sphere(0.4).unwrap(),
        Shape::superellipsoid(Vec3::new(0.5, 0.3, 0.2), [0.3, 1.4], 0.02).unwrap(),
    ];
    let place = |shape: Shape| {
        let position = random.vector() * 0.25;
        Component::new(shape, position).turned(random.rotation())
    };
    let shape = Shape::glued(&shapes.into_iter().map(place).collect::<Vec<_>>(), 1e-3).unwrap();
    let (mut count, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
    let (cells, r) = (160, shape.bounding_radius);
    let cell = 2.0 * r / f64::from(cells);
    let at = |k: u32| cell * (f64::from(k) + 0.5) - r;
    for k in 0..cells {
        for j in 0..cells {
            for i in 0..cells {
                let x = Vec3::new(at(i), at(j), at(k));
                if shape.contains(&x) {
                    count += 1.0;
                    first += x;
                    second += x * x.transpose();
                }
            }
        }
    }
    close(count * cell.powi(3), shape.volume, 2e-3);
    assert!((first / count).norm() < 2e-3);
    let moments = second * cell.powi(3);
    let inertia = Mat3::identity() * moments.trace() - moments;
    assert!((inertia - Mat3::from_diagonal(&shape.inertia)).norm() < 4e-3 * shape.inertia.norm());
}

/// A plate of a ten-thousandth of its width and a wire glued to it, beyond any grid of chords.
#[test]
fn a_union_too_thin_to_resolve_is_refused_with_its_error() {
    let disc = Shape::cylinder(1.0, 1e-6, 0.02).unwrap();
    let up = Rotation::from_axis_angle(&Vec3::x_axis(), 0.3);
    let cross = [Component::new(disc.clone(), Vec3::zeros()), Component::new(disc, Vec3::zeros()).turned(up)];
    match Shape::glued(&cross, 0.02) {
        Err(ShapeError::Unresolved { error, .. }) => assert!(error > 2e-3),
        Ok(shape) => close(shape.volume, 2.0 * PI * 1e-6, 2e-3),
        Err(other) => panic!("{other}"),
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
