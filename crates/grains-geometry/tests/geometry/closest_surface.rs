//! The way from a point inside a body to its surface, against parry's projections and against the bodies themselves.

use grains_geometry::{Component, Lobes, RegularSolid, Rotation, Shape, Vec3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{Ball, ConvexPolyhedron, Cuboid, Cylinder};

/// Points of a box about the origin, the same in every run.
fn points(half: f64, count: usize) -> impl Iterator<Item = Vec3> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(move |_| Vec3::from_fn(|_, _| half * (2.0 * random() - 1.0)))
}

/// Asserts that ways end on the surface; returns how many points were inside.
fn assert_ways_end_on_the_surface(shape: &Shape) -> usize {
    let size = shape.bounding_radius;
    let mut inside = 0;
    for point in points(size, 4000) {
        let way = shape.closest_surface(&point, None);
        assert_eq!(way.is_some(), shape.contains(&point), "{point:?}");
        let Some(way) = way else { continue };
        inside += 1;
        assert!((way.direction.norm() - 1.0).abs() < 1e-9 && way.distance >= 0.0, "{way:?}");
        let at = |distance: f64| shape.contains(&(point + way.direction * distance));
        assert!(!at(way.distance + 1e-6 * size), "{}: {point:?} {way:?}", shape.name);
        assert!(
            way.distance < 1e-6 * size || at(way.distance - 1e-6 * size),
            "{}: {point:?} {way:?}",
            shape.name
        );
    }
    inside
}

#[test]
fn shortest_ways_out_of_convex_bodies_are_those_of_parry() {
    let cube = RegularSolid::Icosahedron.vertices();
    let vertices: Vec<Vector> = cube.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
    // Cylinders of parry stand on their y axis.
    let upright = Rotation::from_axis_angle(&Vec3::x_axis(), -std::f64::consts::FRAC_PI_2);
    let cases: [(Shape, Box<dyn PointQuery>, Rotation); 4] = [
        (Shape::sphere(0.7).unwrap(), Box::new(Ball::new(0.7)), Rotation::identity()),
        (
            Shape::cuboid(Vec3::new(1.0, 0.6, 1.4), 0.05).unwrap(),
            Box::new(Cuboid::new(Vector::new(0.5, 0.3, 0.7))),
            Rotation::identity(),
        ),
        (Shape::cylinder(0.4, 1.2, 0.05).unwrap(), Box::new(Cylinder::new(0.6, 0.4)), upright),
        (
            Shape::hull(&cube, 0.05).unwrap(),
            Box::new(ConvexPolyhedron::from_convex_hull(&vertices).unwrap()),
            Rotation::identity(),
        ),
    ];
    for (shape, other, turned) in cases {
        assert!(assert_ways_end_on_the_surface(&shape) > 400, "{}", shape.name);
        let (to_user, shift) = shape.user_to_body;
        for point in points(0.8, 500) {
            let Some(way) = shape.closest_surface(&point, None) else { continue };
            let there = turned * (to_user * point + shift);
            let distance = other.distance_to_local_point(Vector::new(there.x, there.y, there.z), false);
            assert!((way.distance + distance).abs() < 1e-6, "{}: {way:?} against {distance}", shape.name);
        }
    }
}

#[test]
fn ways_out_of_ellipsoids_are_nearly_the_shortest() {
    let shape = Shape::superellipsoid(Vec3::new(1.0, 0.7, 0.5), [1.0, 1.0], 0.05).unwrap();
    assert!(assert_ways_end_on_the_surface(&shape) > 400);
    let directions: Vec<Vec3> = points(1.0, 4000).filter_map(|d| d.try_normalize(0.1)).collect();
    for point in points(0.9, 300) {
        let Some(way) = shape.closest_surface(&point, None).filter(|way| way.distance < 0.2) else {
            continue;
        };
        let any = |d: &Vec3| {
            let (mut low, mut high) = (0.0, 3.0);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if shape.contains(&(point + d * middle)) { low = middle } else { high = middle }
            }
            high
        };
        let shortest = directions.iter().map(any).fold(f64::INFINITY, f64::min);
        assert!(way.distance < 1.02 * shortest + 1e-9, "{point:?} {way:?} {shortest}");
    }
    for eps in [[0.2, 0.2], [0.5, 1.5], [1.8, 0.6], [2.0, 2.0]] {
        let shape = Shape::superellipsoid(Vec3::new(1.0, 0.7, 0.5), eps, 0.05).unwrap();
        assert!(assert_ways_end_on_the_surface(&shape) > 200, "{eps:?}");
    }
}

#[test]
fn ways_out_of_composites_pass_through_all_parts() {
    let lobes = Lobes::with_area_fraction(3, 0.5, 0.7).unwrap();
    let cross = Shape::cross(3, 0.1, 0.6, 0.02).unwrap();
    for shape in [Shape::lobes(lobes, 1.3, 0.02).unwrap(), cross] {
        assert!(assert_ways_end_on_the_surface(&shape) > 50, "{}", shape.name);
    }
    // Two halves of a cube: the face between them is no surface.
    let half = |x: f64| Component {
        shape: Shape::cuboid(Vec3::new(0.5, 1.0, 1.0), 0.02).unwrap(),
        position: Vec3::new(x, 0.0, 0.0),
        rotation: Rotation::identity(),
    };
    let cube = Shape::glued(&[half(-0.25), half(0.25)], 1e-9).unwrap();
    let way = cube.closest_surface(&Vec3::new(0.01, 0.3, 0.0), None).unwrap();
    assert!((way.distance - 0.2).abs() < 1e-9 && (way.direction - Vec3::y()).norm() < 1e-9, "{way:?}");
}

#[test]
fn ways_across_an_axis_stay_in_the_section() {
    let shape = Shape::cylinder(0.5, 0.1, 0.02).unwrap();
    let point = Vec3::new(0.1, 0.0, 0.04);
    assert!((shape.closest_surface(&point, None).unwrap().distance - 0.01).abs() < 1e-12);
    let way = shape.closest_surface(&point, Some(&Vec3::z())).unwrap();
    assert!((way.distance - 0.4).abs() < 1e-12 && (way.direction - Vec3::x()).norm() < 1e-12, "{way:?}");
}
