//! Which velocities bodies hold, and which of them are deep inside: against the closest surface of every velocity by itself.

use crate::node::ROUNDING;
use crate::nodes::Nodes;
use crate::profile::pitch;
use crate::spectrum::Random;
use crate::wall::{ClosestPoint, Solids};
use crate::{Extrapolation, Form, RigidBody, Subgrid};
use grains_fluid::{FlowSetup, Grid};
use grains_geometry::lanes::Vector;
use grains_geometry::{Component, Shape, Vec3};
use nalgebra::Rotation3;

fn shapes() -> Vec<Shape> {
    let ball = |x: f64| Component::new(Shape::sphere(0.6).unwrap(), Vec3::new(x, 0.0, 0.0));
    vec![
        Shape::sphere(1.0).unwrap(),
        Shape::cuboid(Vec3::new(1.0, 0.7, 1.6), 0.02).unwrap(),
        Shape::cylinder(0.6, 1.4, 0.02).unwrap(),
        Shape::cone([0.8, 0.3], 1.2, 0.02).unwrap(),
        Shape::superellipsoid(Vec3::new(1.0, 0.7, 0.8), [0.5, 1.2], 0.02).unwrap(),
        Shape::cross(3, 0.5, 1.8, 0.02).unwrap(),
        Shape::glued(&[ball(-0.5), ball(0.5)], 0.02).unwrap(),
    ]
}

fn body_shape<'a>(body: &RigidBody, shapes: &'a [Shape]) -> &'a Shape {
    body.shape(shapes).unwrap()
}

/// Asserts that what is found for a sphere is what is found for any shape.
fn assert_is_general(body: &RigidBody, shapes: &[Shape], out: Option<&ClosestPoint>, position: &Vec3) {
    let local = body.rotation.tr_mul(&(position - body.center)) / body.scale;
    let general = body_shape(body, shapes).closest_surface(&local, None);
    let on_surface = (local.norm() - body_shape(body, shapes).bounding_radius).abs() < 1e-12;
    assert!(on_surface || out.is_some() == general.is_some(), "{body:?} {position:?}");
    if let (Some(out), Some(general)) = (out, general) {
        let direction = body.rotation * general.direction;
        assert!((out.surface.distance - general.distance * body.scale).abs() < 1e-12, "{out:?} {general:?}");
        assert!((out.surface.direction - direction).norm() < 1e-9, "{out:?} {general:?}");
    }
}

#[test]
fn velocities_are_deep_where_the_way_out_is_longer_than_a_cell_in_any_pose() {
    let mut random = Random(11);
    let shapes = shapes();
    let (mut deep, mut near) = (0, 0);
    for k in 0..15 * shapes.len() {
        let grid = Grid::uniform([0.0; 3], [20.0, 18.0, 22.0], [20, 20, 20], [true; 3]).unwrap();
        let subgrid = Subgrid::new(&FlowSetup { halo: 3, ..FlowSetup::new(grid, 1.0, 1.0) }).unwrap();
        let turn = [random.turn(), random.turn(), random.turn()];
        let body = RigidBody {
            id: 1,
            form: Form::Shape((k % shapes.len()) as u16),
            scale: 1.5 + 5.5 * random.next(),
            center: Vec3::from_fn(|_, _| 20.0 * random.next()),
            rotation: Rotation3::from_euler_angles(turn[0], turn[1], turn[2]).into_inner(),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
        };
        let solids =
            Solids { bodies: std::slice::from_ref(&body), shapes: &shapes, walls: &[], subgrid: &subgrid };
        let mut nodes = Nodes::new(&subgrid);
        nodes.find(&solids, Extrapolation::Rigid);
        for component in 0..3 {
            for place in 0..subgrid.layout.len() {
                let position = subgrid.position(component, place);
                let out = solids.closest_point(0, &position);
                if body_shape(&body, &shapes).is_sphere() {
                    assert_is_general(&body, &shapes, out.as_ref(), &position);
                }
                let inside = out.filter(|out| out.arm.norm() < body.radius(&shapes));
                let is_held = nodes.holder(component, place).is_some();
                assert_eq!(is_held, inside.is_some(), "{body:?} {component} {position:?}");
                let is_own = subgrid.is_own(component, subgrid.indices(place));
                let Some(out) = inside.filter(|_| is_own) else { continue };
                let width = pitch(&Vector::<f64>::of(&out.surface.direction), &subgrid) * (1.0 - ROUNDING);
                let is_deep = out.surface.distance.max(0.0) >= width;
                assert_eq!(nodes.is_deep(component, place), is_deep, "{body:?} {component} {position:?}");
                if is_deep { deep += 1 } else { near += 1 }
            }
        }
    }
    assert!(deep > 10_000 && near > 10_000, "{deep} {near}");
}
