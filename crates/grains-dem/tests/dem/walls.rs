//! Walls that bear, incline, appear and vanish, against what mechanics says.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Rolling, Tangential};
use grains_dem::{Dem, Kind, Motion, NewParticle, Surface, Wall};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use std::f64::consts::PI;
use std::sync::Arc;

const RADIUS: f64 = 1.5e-3;
const MASS: f64 = 2500.0 * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const STIFFNESS: f64 = 1e5;
const G: f64 = 9.81;

/// A sphere on, or `height` (m) above, a horizontal floor through the middle of the box, where gravity is
/// inclined by an angle (rad) towards +x.
fn sphere_on_floor(law: ContactLaw, incline: f64, height: f64, change: impl Fn(&mut Wall)) -> Dem {
    let mut setup = setup([0.2; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law);
    setup.catalogue.contacts.set(0, 1, law);
    setup.parameters.gravity = Vec3::new(incline.sin(), 0.0, -incline.cos()) * G;
    let floor = Surface::Plane { point: Vec3::repeat(0.1), normal: Vec3::z() };
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    change(&mut setup.walls[0]);
    let mut dem = Dem::new(setup, 0).unwrap();
    let sunk = MASS * G * incline.cos() / STIFFNESS;
    let particle = NewParticle {
        id: 0,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position: Vec3::new(0.05, 0.1, 0.1 + RADIUS + height - if height == 0.0 { sunk } else { 0.0 }),
        orientation: Rotation::identity(),
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    };
    let record = particle.record(&dem);
    dem.insert(&record);
    dem
}

fn law(friction: f64) -> ContactLaw {
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    ContactLaw::linear(STIFFNESS, 0.5, friction, tangential)
}

fn run(dem: &mut Dem, seconds: f64) {
    for _ in 0..(seconds / dem.setup.parameters.dt).round() as u64 {
        dem.step(&SerialTransport).unwrap();
    }
}

#[test]
fn a_floor_bears_the_weight_where_the_ball_lies() {
    let mut dem = sphere_on_floor(law(0.5), 0.0, 0.0, |_| ());
    run(&mut dem, 0.01);
    let load = dem.wall_loads(&SerialTransport)[0];
    assert!((load.force.z / (-MASS * G) - 1.0).abs() < 1e-6, "{} N for {}", load.force.z, -MASS * G);
    let torque = Vec3::new(0.05, 0.1, 0.1).cross(&load.force);
    assert!((load.torque - torque).norm() < 1e-6 * torque.norm(), "{} for {torque}", load.torque);
}

#[test]
fn a_ball_rolls_or_slides_down_an_incline_as_mechanics_says() {
    let seconds = 0.1;
    let incline = 30_f64.to_radians();
    // It rolls if mu > 2/7 tan(incline) = 0.165.
    for (friction, acceleration) in [
        (0.5, 5.0 / 7.0 * G * incline.sin()),
        (0.1, G * (incline.sin() - 0.1 * incline.cos())),
        (0.0, G * incline.sin()),
    ] {
        let mut dem = sphere_on_floor(law(friction), incline, 0.0, |_| ());
        run(&mut dem, seconds);
        let speed = dem.particles.bodies[0].velocity.x;
        assert!((speed / (acceleration * seconds) - 1.0).abs() < 2e-3, "friction {friction}: {speed} m/s");
    }
}

#[test]
fn rolling_friction_slows_a_rolling_ball() {
    let friction = 0.05;
    for rolling in [Rolling::Viscous { friction }, Rolling::spring(friction)] {
        let mut dem = sphere_on_floor(law(0.5).with_rolling(rolling), 0.0, 0.0, |_| ());
        let (speed, seconds) = (0.1, 0.1);
        dem.particles.half_velocity[0].x = speed;
        dem.particles.half_spin[0].y = speed / RADIUS;
        run(&mut dem, seconds);
        // m a = -F and I a/R = F R - mu_r R m g
        let slowed = speed - 5.0 / 7.0 * friction * G * seconds;
        let body = &dem.particles.bodies[0];
        assert!((body.velocity.x / slowed - 1.0).abs() < 1e-2, "{} for {slowed} m/s", body.velocity.x);
        assert!((body.angular_velocity.y * RADIUS / body.velocity.x - 1.0).abs() < 1e-2, "it rolls");
    }
}

/// A plane, and triangles about a point beside the ball: it rests and rolls across their edges.
fn floors() -> [Surface; 2] {
    let corners = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2], [0.0501, 0.1001]];
    let vertices = corners.map(|[x, y]| Vec3::new(x, y, 0.1)).to_vec();
    let triangles = (0..4).map(|k| [k, (k + 1) % 4, 4]).collect();
    let mesh = WallMesh::new(&TriMesh { vertices, triangles }, SMOOTH_ANGLE).unwrap();
    [Surface::Plane { point: Vec3::repeat(0.1), normal: Vec3::z() }, Surface::Mesh(Arc::new(mesh))]
}

/// With a spring a ball stands on slopes below the coefficient of rolling friction, whatever its restitution, and
/// rolls down steeper ones with 5/7 g (sin β − μr cos β).
#[test]
fn a_ball_stands_on_slopes_below_its_rolling_friction_and_rolls_down_others() {
    let (friction, seconds) = (0.1, 0.2);
    for (restitution, tangent) in [(0.5, 0.05), (1.0, 0.05), (0.5, 0.098), (0.5, 0.15), (1.0, 0.3)] {
        for surface in floors() {
            let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
            let law = ContactLaw::linear(STIFFNESS, restitution, 0.5, tangential);
            let incline = f64::atan(tangent);
            let law = law.with_rolling(Rolling::spring(friction));
            let mut dem = sphere_on_floor(law, incline, 0.0, |wall| wall.surfaces = vec![surface.clone()]);
            run(&mut dem, seconds);
            let before = dem.particles.bodies[0];
            run(&mut dem, seconds);
            let body = &dem.particles.bodies[0];
            let rate = (body.velocity.x - before.velocity.x) / seconds;
            let wanted = 5.0 / 7.0 * G * (incline.sin() - friction * incline.cos()).max(0.0);
            let what = format!("e = {restitution}, slope {tangent}: {rate} m/s2 for {wanted}, {body:?}");
            assert!((rate - wanted).abs() < 2e-3 * G * tangent, "{what}");
            if tangent < friction {
                assert!((body.position - before.position).norm() < 1e-9, "{what}");
            }
        }
    }
}

/// The couple of rolling resistance is among the loads of the wall: force and torque are in balance.
#[test]
fn a_wall_feels_the_couple_of_a_ball_that_stands_on_a_slope() {
    let law = law(0.5).with_rolling(Rolling::spring(0.1));
    let incline = f64::atan(0.05);
    let mut dem = sphere_on_floor(law, incline, 0.0, |_| ());
    run(&mut dem, 0.3);
    let load = dem.wall_loads(&SerialTransport)[0];
    let weight = dem.setup.parameters.gravity * MASS;
    let torque = dem.particles.bodies[0].position.cross(&weight);
    assert!((load.force - weight).norm() < 1e-6 * weight.norm(), "{} for {weight}", load.force);
    assert!((load.torque - torque).norm() < 1e-6 * RADIUS * weight.norm(), "{} for {torque}", load.torque);
}

#[test]
fn a_wall_is_there_from_and_until_its_times() {
    let after = |change: &dyn Fn(&mut Wall), seconds: f64| {
        let mut dem = sphere_on_floor(law(0.5), 0.0, 1e-3, change);
        run(&mut dem, seconds);
        dem.particles.bodies[0]
    };
    // A fall of 1 mm takes 14 ms: a floor that appears before is as good as one that was always there.
    let (always, later) = (after(&|_| (), 0.03), after(&|w| w.from = 0.01, 0.03));
    assert_eq!((always.position, always.velocity), (later.position, later.velocity));
    // One that vanishes before is none at all.
    let fallen = after(&|w| w.until = 0.01, 0.03);
    assert!((fallen.velocity.z + G * 0.03).abs() < 1e-3, "{}", fallen.velocity.z);
    assert!(fallen.position.z < 0.1);
}
