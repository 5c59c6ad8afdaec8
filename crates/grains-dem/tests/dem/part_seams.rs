//! What friction has wound up goes on while a pair touches, from one part of a body onto the next, and ends with its patch.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Tangential};
use grains_dem::{Dem, FaceContact, Kind, Motion, NewParticle, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Component, Lobes, Rotation, Shape, Vec3};
use std::f64::consts::{FRAC_PI_2, TAU};

const SIZE: f64 = 4e-3;
const DEPTH: f64 = 4e-5;
const FLOOR: f64 = 0.02;
const DT: f64 = 1e-5;
const CRUST: f64 = 0.02;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Partner {
    Plane,
    Block,
}

fn shapes() -> Vec<(&'static str, Shape)> {
    let ball = |x: f64| Component::new(Shape::sphere(0.4 * SIZE).unwrap(), Vec3::x() * x);
    let edge = 0.5 * SIZE;
    let cube = |k: u32| {
        let side = |bit: u32| (f64::from(k >> bit & 1) - 0.5) * edge;
        let place = Vec3::new(side(0), side(1), side(2));
        Component::new(Shape::cuboid(Vec3::repeat(edge), CRUST).unwrap(), place)
    };
    let lobes = Lobes::with_area_fraction(3, 0.5 * SIZE, 0.69).unwrap();
    vec![
        ("dumbbell", Shape::glued(&[-0.35, 0.35].map(|x| ball(x * SIZE)), CRUST).unwrap()),
        ("trilobe", Shape::lobes(lobes, 1.2 * SIZE, CRUST).unwrap()),
        ("cross", Shape::cross(3, 0.3 * SIZE, 1.5 * SIZE, CRUST).unwrap()),
        ("eight cubes", Shape::glued(&(0..8).map(cube).collect::<Vec<_>>(), CRUST).unwrap()),
    ]
}

/// Height of the centre of a turned body over its lowest point (m).
fn height(shape: &Shape, turn: &Rotation) -> f64 {
    let down = turn.inverse() * -Vec3::z();
    let reach = |part: &grains_geometry::Part| {
        let core = part.core.support(&(part.rotation.transpose() * down));
        (part.center + part.rotation * core).dot(&down) + part.crust
    };
    shape.parts.iter().map(reach).fold(0.0, f64::max)
}

/// A body too heavy for contacts to move, on a floor or a block too heavy as well.
fn scene(shape: &Shape, partner: Partner, faces: FaceContact, start: Rotation) -> Dem {
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.0 };
    let law = ContactLaw::linear(1e4, 1.0, 1e3, tangential);
    let block = Shape::cuboid(Vec3::new(7.0, 7.0, 2.0) * SIZE, CRUST).unwrap();
    let mut setup = setup([0.04; 3], [false; 3], vec![shape.clone(), block], law);
    setup.catalogue.densities[0] = 1e14;
    setup.catalogue.faces = faces;
    setup.catalogue.contacts.set(0, 1, law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = DT;
    if partner == Partner::Plane {
        let surface = Surface::Plane { point: Vec3::z() * FLOOR, normal: Vec3::z() };
        setup.walls = vec![wall("floor", surface, Motion::Fixed)];
    }
    let mut dem = Dem::new(setup, 0).unwrap();
    let mut add = |id: u64, shape: u16, height: f64, orientation: Rotation| {
        let new = NewParticle {
            id,
            kind: Kind { shape, material: 0 },
            scale: 1.0,
            position: Vec3::new(0.02, 0.02, height),
            orientation,
            velocity: Vec3::zeros(),
            angular_velocity: Vec3::zeros(),
            temperature: 0.0,
        };
        let record = new.record(&dem);
        dem.insert(&record);
    };
    add(0, 0, FLOOR + height(shape, &start) + 1e-6, start);
    if partner == Partner::Block {
        add(1, 1, FLOOR - SIZE, Rotation::identity());
    }
    dem
}

fn place(dem: &Dem, id: u64) -> usize {
    dem.particles.ids.iter().position(|&other| other == id).unwrap()
}

/// Moves the body by one step with a velocity aside (m/s) and a spin about y (rad/s), to this depth (m) in its partner;
/// returns the force on the partner along y, in any unit.
fn step(dem: &mut Dem, partner: Partner, aside: f64, spin: f64, depth: f64) -> f64 {
    turn(dem, aside, Vec3::y() * spin, depth);
    if partner == Partner::Plane {
        dem.step(&SerialTransport).unwrap();
        return dem.wall_loads(&SerialTransport)[0].force.y;
    }
    let block = place(dem, 1);
    dem.particles.half_velocity[block] = Vec3::zeros();
    dem.particles.half_spin[block] = Vec3::zeros();
    dem.step(&SerialTransport).unwrap();
    dem.particles.half_velocity[place(dem, 1)].y
}

/// Gives the body a velocity aside (m/s), a spin (rad/s) and the velocity to this depth (m).
fn turn(dem: &mut Dem, aside: f64, spin: Vec3, depth: f64) {
    let i = place(dem, 0);
    let now = dem.particles.record(i).orientation;
    let shape = &dem.setup.catalogue.shapes[0];
    let body = &dem.particles.bodies[i];
    let rise = FLOOR + height(shape, &(Rotation::new(spin * DT) * now)) - depth - body.position.z;
    let momentum = now * dem.setup.catalogue.inertia(body).component_mul(&(now.inverse() * spin));
    dem.particles.half_velocity[i] = Vec3::new(0.0, aside, rise / DT);
    dem.particles.half_spin[i] = momentum;
}

/// A body pushed aside by less than it takes to slide and rolled once around keeps the force aside, whichever of
/// its parts it rolls over.
#[test]
fn the_force_along_the_axis_of_rolling_stays_over_all_parts() {
    // Lobes lie along z.
    let lying = Rotation::from_axis_angle(&Vec3::x_axis(), FRAC_PI_2);
    let starts = [lying, Rotation::identity(), Rotation::from_axis_angle(&Vec3::z_axis(), FRAC_PI_2)];
    for (name, shape, start) in
        shapes().iter().flat_map(|(name, shape)| starts.map(|start| (name, shape, start)))
    {
        for (partner, faces) in [
            (Partner::Plane, FaceContact::Point),
            (Partner::Plane, FaceContact::MultiPoint),
            (Partner::Block, FaceContact::Point),
            (Partner::Block, FaceContact::MultiPoint),
        ] {
            let mut dem = scene(shape, partner, faces, start);
            let (pressed, pushed, turned) = (40, 40, 2000);
            for k in 0..pressed {
                step(&mut dem, partner, 0.0, 0.0, DEPTH * f64::from(k + 1) / f64::from(pressed));
            }
            for _ in 0..pushed {
                step(&mut dem, partner, 0.01, 0.0, DEPTH);
            }
            step(&mut dem, partner, 0.0, 0.0, DEPTH);
            let first = step(&mut dem, partner, 0.0, 0.0, DEPTH);
            assert!(first != 0.0);
            let mut worst = 0.0_f64;
            for _ in 0..turned {
                let force = step(&mut dem, partner, 0.0, TAU / (f64::from(turned) * DT), DEPTH);
                worst = worst.max((force / first - 1.0).abs());
            }
            assert!(worst < 1e-7, "{name} on {partner:?}, {faces:?}: {worst:e}");
        }
    }
}

/// A cube pressed on its face and twisted is turned back by its patch; once it has stood on a corner it is not.
#[test]
fn the_torsion_of_a_face_ends_on_a_corner() {
    let cube = Shape::cuboid(Vec3::repeat(SIZE), CRUST).unwrap();
    for partner in [Partner::Plane, Partner::Block] {
        let mut dem = scene(&cube, partner, FaceContact::MultiPoint, Rotation::identity());
        let tilt = Vec3::new(1.0, 0.7, 0.0) * (0.7 / (400.0 * DT));
        let (none, twist) = (Vec3::zeros(), Vec3::z() * (2e-3 / (40.0 * DT)));
        // Spin, over so many steps.
        let stages = [(none, 40), (twist, 40), (none, 1), (tilt, 400), (-tilt, 400), (none, 1)];
        let mut couples = Vec::new();
        for (spin, steps) in stages {
            for _ in 0..steps {
                turn(&mut dem, 0.0, spin, DEPTH);
                let block = dem.particles.ids.iter().position(|&id| id == 1);
                if let Some(block) = block {
                    dem.particles.half_velocity[block] = Vec3::zeros();
                    dem.particles.half_spin[block] = Vec3::zeros();
                }
                dem.step(&SerialTransport).unwrap();
            }
            couples.push(couple(&dem, partner));
        }
        let [wound, back] = [couples[2], couples[5]];
        assert!(wound != 0.0 && back.abs() < 1e-3 * wound.abs(), "{partner:?}: {couples:?}");
    }
}

/// Couple about z on the partner, about the middle of the scene, in any unit.
fn couple(dem: &Dem, partner: Partner) -> f64 {
    match partner {
        Partner::Block => dem.particles.half_spin[place(dem, 1)].z,
        Partner::Plane => {
            let load = &dem.wall_loads(&SerialTransport)[0];
            load.torque.z - (0.02 * load.force.y - 0.02 * load.force.x)
        }
    }
}
