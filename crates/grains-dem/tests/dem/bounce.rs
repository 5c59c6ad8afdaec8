//! Bodies of faces and of several parts bounce off a wall and off one another: no energy is made, and without damping none is
//! lost.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Tangential};
use grains_dem::{Dem, FaceContact, Kind, Motion, NewParticle, SurfaceMobility, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Component, Lobes, Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

const SIZE: f64 = 4e-3;
const STIFFNESS: f64 = 1e5;
const SPEED: f64 = 0.1;
const FLOOR: f64 = 0.02;
const CRUST: f64 = 0.02;

fn dumbbell() -> Shape {
    let ball = |x: f64| Component::new(Shape::sphere(0.4 * SIZE).unwrap(), Vec3::x() * x);
    Shape::glued(&[ball(-0.35 * SIZE), ball(0.35 * SIZE)], CRUST).unwrap()
}

fn eight_cubes() -> Shape {
    let cube = |k: u32| {
        let side = |bit: u32| if k >> bit & 1 == 0 { -0.25 * SIZE } else { 0.25 * SIZE };
        Component::new(
            Shape::cuboid(Vec3::repeat(0.5 * SIZE), CRUST).unwrap(),
            Vec3::new(side(0), side(1), side(2)),
        )
    };
    Shape::glued(&(0..8).map(cube).collect::<Vec<_>>(), CRUST).unwrap()
}

fn shapes() -> Vec<(&'static str, Shape)> {
    let lobes = Lobes::with_area_fraction(3, 0.5 * SIZE, 0.69).unwrap();
    vec![
        ("dumbbell", dumbbell()),
        ("box", Shape::cuboid(Vec3::new(1.2, 1.0, 0.8) * SIZE, CRUST).unwrap()),
        ("cylinder", Shape::cylinder(0.4 * SIZE, 1.2 * SIZE, CRUST).unwrap()),
        ("cross", Shape::cross(3, 0.3 * SIZE, 1.5 * SIZE, CRUST).unwrap()),
        ("trilobe", Shape::lobes(lobes, 1.2 * SIZE, CRUST).unwrap()),
        ("eight cubes", eight_cubes()),
    ]
}

/// What a body bounces off.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Partner {
    Plane,
    Mesh,
    Block,
    Same,
}

fn floor(partner: Partner) -> Surface {
    let point = Vec3::new(0.0, 0.0, FLOOR);
    if partner != Partner::Mesh {
        return Surface::Plane { point, normal: Vec3::z() };
    }
    let corner = |i: usize, j: usize| Vec3::new(i as f64, j as f64, 0.0) * 2.7e-3 + point;
    let n = 15;
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| corner(i, j))).collect();
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    let triangles = (0..n * n).flat_map(|k| {
        let (i, j) = (k % n, k / n);
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    });
    let mesh = TriMesh { vertices, triangles: triangles.collect() };
    Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()))
}

/// Kinetic energy (J) without the drift of a step that a free body has.
fn energy(dem: &Dem) -> f64 {
    (0..dem.particles.bodies.len())
        .map(|i| {
            let body = &dem.particles.bodies[i];
            let rotation = dem.particles.record(i).orientation;
            let omega = rotation.inverse() * body.angular_velocity;
            let inertia = dem.setup.catalogue.inertia(body);
            0.5 * (body.mass * body.velocity.norm_squared()
                + omega.component_mul(&omega).dot(&inertia))
        })
        .sum()
}

/// Energy after over before one bounce with a number of steps per shortest contact.
fn bounce(shape: &Shape, partner: Partner, turn: Rotation, restitution: f64, steps: f64) -> f64 {
    let law = ContactLaw::new(STIFFNESS, restitution, 0.0, Tangential::Viscous { rate: 0.0 });
    let block = Shape::cuboid(Vec3::new(4.0, 4.0, 1.0) * SIZE, CRUST).unwrap();
    let mut setup = setup([0.04; 3], [false; 3], vec![shape.clone(), block], law);
    setup.catalogue.faces = FaceContact::MultiPoint;
    setup.catalogue.contacts.set(0, 1, law);
    setup.catalogue.densities = vec![2500.0, 2500.0];
    setup.parameters.gravity = Vec3::zeros();
    let felt = 2500.0 * shape.volume / SurfaceMobility::of(shape).along_normal;
    let reduced = if partner == Partner::Same { 0.5 * felt } else { felt };
    setup.parameters.dt = PI * (reduced / STIFFNESS).sqrt() / steps;
    if matches!(partner, Partner::Plane | Partner::Mesh) {
        setup.walls = vec![wall("floor", floor(partner), Motion::Fixed)];
    }
    let lowest = shape.parts.iter().map(|part| {
        let toward = turn.inverse() * -Vec3::z();
        let local = part.rotation.transpose() * toward;
        toward.dot(&part.center) + part.core.support_value(&local) + part.crust
    });
    let reach = lowest.fold(f64::NEG_INFINITY, f64::max);
    let mut dem = Dem::new(setup, 0).unwrap();
    let mut add = |id, shape, position, orientation, velocity| {
        let kind = Kind { shape, material: 0 };
        let angular_velocity = Vec3::zeros();
        let new = NewParticle { id, kind, scale: 1.0, position, orientation, velocity, angular_velocity };
        let record = new.record(&dem);
        dem.insert(&record);
    };
    let at = Vec3::new(0.0203, 0.0197, FLOOR);
    let gap = Vec3::z() * 1e-7;
    add(0, 0, at + gap + Vec3::z() * reach, turn, -Vec3::z() * SPEED);
    match partner {
        Partner::Block => add(1, 1, at - Vec3::z() * 0.5 * SIZE, Rotation::identity(), Vec3::zeros()),
        Partner::Same => {
            let over = Rotation::from_axis_angle(&Vec3::x_axis(), PI) * turn;
            let below = shape.parts.iter().map(|part| {
                let toward = over.inverse() * Vec3::z();
                toward.dot(&part.center) + part.core.support_value(&(part.rotation.transpose() * toward)) + part.crust
            });
            add(1, 0, at - Vec3::z() * below.fold(f64::NEG_INFINITY, f64::max), over, Vec3::z() * SPEED);
        }
        _ => {}
    }
    let before = energy(&dem);
    let mut highest = before;
    for _ in 0..(12.0 * steps) as usize {
        dem.step(&SerialTransport).unwrap();
    }
    let _ = &mut highest;
    energy(&dem) / before
}

/// Tilts from 0 to 90 degrees about a horizontal axis, at any turn about the vertical one.
fn tilts(count: usize) -> impl Iterator<Item = Rotation> {
    (0..count).map(move |k| {
        let [first, second] = [0.618_033_988_75, 0.754_877_666_25].map(|g: f64| (k as f64 * g).fract());
        // As many tilts below a tenth of a right angle as above.
        let tilt = if k % 2 == 0 { first * 0.1 } else { first } * FRAC_PI_2;
        Rotation::from_axis_angle(&Vec3::z_axis(), second)
            * Rotation::from_axis_angle(&Vec3::y_axis(), tilt)
            * Rotation::from_axis_angle(&Vec3::x_axis(), 0.3 * second * tilt)
    })
}

#[test]
#[ignore]
fn survey() {
    for partner in [Partner::Plane, Partner::Mesh, Partner::Block, Partner::Same] {
        for (name, shape) in shapes() {
            for (e, steps) in [(1.0, 50.0), (1.0, 100.0), (1.0, 200.0), (0.8, 50.0)] {
                let ratios: Vec<f64> = tilts(60).map(|turn| bounce(&shape, partner, turn, e, steps)).collect();
                let low = ratios.iter().copied().fold(f64::INFINITY, f64::min);
                let high = ratios.iter().copied().fold(0.0, f64::max);
                let worst = ratios.iter().enumerate().max_by(|a, b| (a.1 - 1.0).abs().total_cmp(&(b.1 - 1.0).abs())).unwrap().0;
                println!("{partner:?} {name} e {e} steps {steps}: {low:.5} {high:.5} worst {worst}");
            }
        }
    }
}
