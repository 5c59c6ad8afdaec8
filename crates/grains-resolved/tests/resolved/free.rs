//! Bodies that move with the flow.

use crate::common::{MULTIPLIERS, QUADRATIC, Scene, body};
use grains_domain::SerialTransport;
use grains_fluid::{Drive, FlowSetup, Grid};
use grains_geometry::{Shape, Vec3};
use grains_resolved::Forcing;

const RADIUS: f64 = 0.25;

fn volume() -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3)
}

fn sphere() -> Shape {
    Shape::sphere(RADIUS).unwrap()
}

/// Mass, inertia and density of a sphere in a fluid of density 1.
fn ball_of(density: f64) -> (f64, f64, f64) {
    let mass = density * volume();
    (mass, 0.4 * mass * RADIUS * RADIUS, density)
}

fn setup(periodic: bool) -> FlowSetup {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [16; 3], [periodic; 3]).unwrap();
    FlowSetup::new(grid, 1.0, 0.05)
}

#[test]
fn a_neutrally_buoyant_body_in_uniform_flow_feels_nothing() {
    [QUADRATIC, MULTIPLIERS].into_iter().for_each(assert_feels_nothing);
}

fn assert_feels_nothing(forcing: Forcing) {
    let velocity = Vec3::new(0.3, -0.2, 0.1);
    let mut ball = body(1, Vec3::new(0.45, 0.5, 0.62));
    ball.velocity = velocity;
    let mut scene = Scene::new(&setup(true), [1; 3], (&sphere(), &[ball]), forcing, &SerialTransport);
    scene.flow.initialise(|_| velocity.into(), |_| 0.0, &SerialTransport);
    for _ in 0..20 {
        scene.move_freely(ball_of(1.0), Vec3::zeros(), 0.02, &SerialTransport);
        let action = scene.actions[0];
        assert!(action.force.norm() < 1e-12 && action.torque.norm() < 1e-12, "{action:?}");
        assert!((scene.own[0].velocity - velocity).norm() < 1e-12 && scene.own[0].spin.norm() < 1e-11);
    }
}

#[test]
fn bodies_and_fluid_keep_their_momentum() {
    for forcing in [QUADRATIC, MULTIPLIERS] {
        assert_keep_momentum(forcing, Vec3::new(0.72, 0.75, 0.74));
        // Velocities and points in both of two bodies that overlap belong to one of them.
        assert_keep_momentum(forcing, Vec3::new(0.5, 0.55, 0.5));
    }
}

fn assert_keep_momentum(forcing: Forcing, other: Vec3) {
    let mut balls = [body(1, Vec3::new(0.3, 0.3, 0.3)), body(2, other)];
    balls[0].velocity = Vec3::new(0.5, 0.2, 0.0);
    balls[1].velocity = Vec3::new(-0.3, 0.0, 0.4);
    balls[1].spin = Vec3::new(0.0, 3.0, 0.0);
    let mut scene = Scene::new(&setup(true), [1; 3], (&sphere(), &balls), forcing, &SerialTransport);
    let ball = ball_of(2.5);
    let total = |scene: &Scene| {
        let state = &scene.flow.state;
        let cell = 16f64.powi(-3);
        let fluid =
            [state.velocity.x.own().sum(), state.velocity.y.own().sum(), state.velocity.z.own().sum()];
        let fluid: Vec3 = fluid.map(|u: f64| u * cell).into();
        let carried_over: Vec3 =
            scene.actions.iter().map(|a| Vec3::from_column_slice(&a.carried_over[..3])).sum();
        // The fluid is everywhere: of the bodies only what they weigh more.
        fluid - carried_over + scene.own.iter().map(|b| b.velocity * (1.5 * volume())).sum::<Vec3>()
    };
    let start = total(&scene);
    for step in 0..30 {
        // Contacts push one as much as the other, and turn both.
        let push = 1e-3 * f64::from(step % 7 - 3);
        scene.contacts =
            vec![[push, 0.0, -push, 0.0, 2e-2 * push, 0.0], [-push, 0.0, push, 1e-2 * push, 0.0, 0.0]];
        scene.move_freely(ball, Vec3::zeros(), 0.01, &SerialTransport);
        assert!((total(&scene) - start).norm() < 1e-13, "{:?}", total(&scene) - start);
    }
    assert!(scene.own[0].velocity.x < 0.4, "the fluid holds them back: {:?}", scene.own);
}

#[test]
fn bodies_of_any_density_fall_or_rise_steadily() {
    for density in [0.01, 0.5, 0.9, 1.1, 10.0, 1000.0] {
        let ball = body(1, Vec3::new(0.5, 0.5, 0.5));
        let mut scene = Scene::new(&setup(false), [1; 3], (&sphere(), &[ball]), QUADRATIC, &SerialTransport);
        let mut last = 0.0;
        for step in 0..100 {
            // Chosen so that all come to about the same speed.
            let weight = Vec3::new(0.0, 0.0, 0.05 * f64::signum(1.0 - density));
            scene.move_freely(ball_of(density), weight, 0.01, &SerialTransport);
            let speed = scene.own[0].velocity.z * weight.z.signum();
            // A velocity that comes or goes jerks a body of next to no mass.
            let least = if density < 0.1 { 0.95 } else { 0.98 };
            // The first steps find the pressure.
            assert!(
                step < 10 || speed > least * last && speed < 1.0,
                "density {density}, step {step}: {last} to {speed}"
            );
            last = speed;
        }
        assert!(last > 1e-4 && scene.own[0].spin.norm() < 1e-6, "{density}: {last} {:?}", scene.own[0].spin);
    }
}

#[test]
fn no_fluid_comes_out_of_either_of_two_bodies() {
    let mut balls = [body(1, Vec3::new(0.46, 0.5, 0.54)), body(2, Vec3::new(0.5, 0.47, 1.45))];
    balls[0].velocity = Vec3::new(0.1, 0.0, 0.2);
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, 2.0], [16, 16, 32], [false; 3]).unwrap();
    let setup = FlowSetup::new(grid, 1.0, 0.05);
    let mut scene = Scene::new(&setup, [1; 3], (&sphere(), &balls), QUADRATIC, &SerialTransport);
    for _ in 0..20 {
        scene.move_freely(ball_of(2.0), Vec3::new(0.0, 0.0, -0.05), 0.01, &SerialTransport);
        // What comes from one to the other passes the plane between them.
        let through = scene.flow.flow_rate(2, 16, &SerialTransport);
        assert!(through.abs() < 1e-15, "{through}");
        assert!(scene.flow.kinetic_energy(&SerialTransport) > 1e-6);
    }
}

#[test]
fn a_body_that_moves_resists_as_one_that_the_fluid_passes() {
    // A cylinder 8 cells across in a periodic box of 6 diameters, at Reynolds number 20.
    let (cells, box_width, dt) = (8, 6.0, 1.0 / 60.0);
    let h = 1.0 / f64::from(cells);
    let n = 6 * cells as usize;
    let grid = Grid::uniform([0.0; 3], [box_width, box_width, h], [n, n, 1], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 0.05);
    setup.drive = [Drive::MeanVelocity(1.0), Drive::MeanVelocity(0.0), Drive::None];
    let disc = Shape::cylinder(0.5, h, 0.02).unwrap();
    let center = Vec3::new(3.0 + 0.3 * h, 3.0 + 0.2 * h, 0.5 * h);
    let mut scene = Scene::new(&setup, [1; 3], (&disc, &[body(1, center)]), QUADRATIC, &SerialTransport);
    scene.flow.initialise(|_| [1.0, 0.0, 0.0], |_| 0.0, &SerialTransport);
    (0..6000).for_each(|_| scene.step(dt, &SerialTransport));
    let drag = -scene.actions[0].force.x;
    // The same flow as one sees it who goes along with the fluid: now the body moves at -1, held back by its drag.
    scene.flow.setup.drive[0] = Drive::MeanVelocity(0.0);
    scene.flow.state.velocity.component_mut(0).iter_mut().for_each(|u| *u -= 1.0);
    scene.flow.state.last_dt = 0.0;
    scene.flow.refresh_velocity(7, &SerialTransport);
    scene.own[0].velocity.x = -1.0;
    let mass = 2.0 * std::f64::consts::PI / 4.0 * h;
    let (mut sum, mut furthest) = (0.0, 0.0_f64);
    for step in 0..1200 {
        scene.move_freely((mass, mass / 8.0, 2.0), Vec3::new(-drag, 0.0, 0.0), dt, &SerialTransport);
        let place = &mut scene.own[0].center.x;
        *place = place.rem_euclid(box_width);
        let speed = -scene.own[0].velocity.x;
        furthest = furthest.max((speed - 1.0).abs());
        sum += if step >= 600 { speed / 600.0 } else { 0.0 };
    }
    assert!((sum - 1.0_f64).abs() < 0.01 && furthest < 0.03, "mean speed {sum}, at most {furthest} off");
}
