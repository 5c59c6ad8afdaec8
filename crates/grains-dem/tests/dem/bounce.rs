//! Bodies of faces and of several parts bounce off a wall and off one another: no energy is made, and without damping none is
//! lost.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Tangential};
use grains_dem::{Dem, FaceContact, Kind, Motion, NewParticle, Surface, SurfaceMobility};
use grains_domain::SerialTransport;
use grains_geometry::{Component, Lobes, Rotation, Shape, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

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

/// The surface point of a turned body that is farthest in a direction, from its centre (m).
fn farthest(shape: &Shape, turn: &Rotation, direction: Vec3) -> Vec3 {
    let toward = turn.inverse() * direction;
    let points = shape.parts.iter().map(|part| {
        let core = part.core.support(&(part.rotation.transpose() * toward));
        part.center + part.rotation * core + toward * part.crust
    });
    turn * points.max_by(|a, b| a.dot(&toward).total_cmp(&b.dot(&toward))).unwrap()
}

/// What a body bounces off.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Partner {
    Plane,
    Block,
}

/// Kinetic energy (J).
fn energy(dem: &Dem) -> f64 {
    (0..dem.particles.bodies.len())
        .map(|i| {
            let body = &dem.particles.bodies[i];
            let rotation = dem.particles.record(i).orientation;
            let omega = rotation.inverse() * body.angular_velocity;
            let inertia = dem.setup.catalogue.inertia(body);
            0.5 * (body.mass * body.velocity.norm_squared() + omega.component_mul(&omega).dot(&inertia))
        })
        .sum()
}

/// Energy after over before one bounce with a number of steps per shortest contact.
fn bounce(shape: &Shape, partner: Partner, turn: Rotation, restitution: f64, steps: f64) -> f64 {
    let law = ContactLaw::linear(STIFFNESS, restitution, 0.0, Tangential::Viscous { rate: 0.0 });
    let block = Shape::cuboid(Vec3::new(4.0, 4.0, 1.0) * SIZE, CRUST).unwrap();
    let mut setup = setup([0.04; 3], [false; 3], vec![shape.clone(), block], law);
    setup.catalogue.faces = FaceContact::MultiPoint;
    setup.catalogue.contacts.set(0, 1, law);
    setup.catalogue.densities = vec![2500.0, 2500.0];
    setup.parameters.gravity = Vec3::zeros();
    let felt = 2500.0 * shape.volume / SurfaceMobility::of(shape).along_normal;
    setup.parameters.dt = PI * (felt / STIFFNESS).sqrt() / steps;
    if partner == Partner::Plane {
        let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, FLOOR), normal: Vec3::z() };
        setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    }
    let mut dem = Dem::new(setup, 0).unwrap();
    let mut add = |id, shape, position, orientation, velocity| {
        let kind = Kind { shape, material: 0 };
        let angular_velocity = Vec3::zeros();
        let new = NewParticle { id, kind, scale: 1.0, position, orientation, velocity, angular_velocity };
        let record = new.record(&dem);
        dem.insert(&record);
    };
    let at = Vec3::new(0.0203, 0.0197, FLOOR);
    add(0, 0, at + Vec3::z() * 1e-7 - farthest(shape, &turn, -Vec3::z()), turn, -Vec3::z() * SPEED);
    if partner == Partner::Block {
        add(1, 1, at - Vec3::z() * 0.5 * SIZE, Rotation::identity(), Vec3::zeros());
    }
    let before = energy(&dem);
    // Until they have been apart for a while: a body may touch several times in a row.
    let (mut step, mut apart, mut last) = (0.0, 0.0, before);
    while step < 2.0 * steps || apart < steps {
        dem.step(&SerialTransport).unwrap();
        let now = energy(&dem);
        apart = if (now / last - 1.0).abs() < 1e-13 { apart + 1.0 } else { 0.0 };
        (last, step) = (now, step + 1.0);
        assert!(step < 100.0 * steps, "no rebound");
    }
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
fn elastic_bounces_keep_the_energy_to_second_order() {
    for partner in [Partner::Plane, Partner::Block] {
        for (name, shape) in shapes() {
            // Root mean square of the error: where a body meets between two steps spreads it.
            let [coarse, fine] = [50.0, 200.0].map(|steps| {
                let errors: Vec<f64> =
                    tilts(24).map(|turn| bounce(&shape, partner, turn, 1.0, steps) - 1.0).collect();
                let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
                let limit = 1e-3 * (50.0 / steps);
                assert!(worst < limit, "{name} on {partner:?}, {steps} steps: {worst:e}");
                (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
            });
            // Sixteen of second order, four of first; below a part in a hundred thousand there is nothing to measure.
            assert!(fine < coarse / 8.0 || fine < 1e-5, "{name} on {partner:?}: {coarse:e}, {fine:e}");
        }
    }
}

#[test]
fn damped_bounces_take_energy() {
    const RESTITUTION: f64 = 0.8;
    for partner in [Partner::Plane, Partner::Block] {
        for (name, shape) in shapes() {
            for (k, turn) in tilts(24).enumerate() {
                let left = bounce(&shape, partner, turn, RESTITUTION, 50.0);
                assert!(left < 1.0, "{name} on {partner:?}: {left}");
                // The first falls flat: the whole of it has the restitution.
                if k == 0 && partner == Partner::Plane {
                    assert!((left - RESTITUTION.powi(2)).abs() < 2e-3, "{name}: {left}");
                }
            }
        }
    }
}
