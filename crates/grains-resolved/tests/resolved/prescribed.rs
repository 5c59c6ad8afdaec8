//! Bodies of prescribed motion, alone and beside free ones.

use crate::common::{CUBIC, MULTIPLIERS, QUADRATIC, Scene, body};
use grains_domain::SerialTransport;
use grains_fluid::{Drive, FlowSetup, Grid};
use grains_geometry::{Mat3, Shape, Vec3};
use grains_resolved::{BodyMotion, Forcing, RigidBody};
use std::f64::consts::{PI, TAU};

/// What a body displaces: mass (kg) and inertia (kg m²) of fluid.
#[derive(Clone, Copy)]
struct Displaced {
    mass: f64,
    inertia: f64,
}

impl Displaced {
    fn momentum(&self, body: &RigidBody) -> [f64; 6] {
        let (p, l) = (body.velocity * self.mass, body.spin * self.inertia);
        [p.x, p.y, p.z, l.x, l.y, l.z]
    }

    /// A body so many times as dense as the fluid: free, or of the motion it has.
    fn motion(&self, body: &RigidBody, density: f64, carried_over: [f64; 6], is_free: bool) -> BodyMotion {
        let (u, w) = (body.velocity, body.spin);
        BodyMotion {
            mass: density * self.mass,
            inertia: Mat3::identity() * (density * self.inertia),
            density_ratio: 1.0 / density,
            momentum: self.momentum(body).map(|p| density * p),
            contacts: [0.0; 6],
            weight: [0.0; 6],
            carried_over,
            imposed: if is_free { [None; 6] } else { [u.x, u.y, u.z, w.x, w.y, w.z].map(Some) },
        }
    }
}

/// Leads the one body of a scene to a place with a velocity and spin over a step; returns force and torque of the flow on it.
fn lead(scene: &mut Scene, displaced: &Displaced, to: [Vec3; 3], dt: f64) -> [Vec3; 2] {
    let before = displaced.momentum(&scene.own[0]);
    let carried_over = scene.actions[0].carried_over;
    [scene.own[0].center, scene.own[0].velocity, scene.own[0].spin] = to;
    scene.place(&SerialTransport);
    scene.flow.step(dt, &SerialTransport).unwrap();
    let motion = displaced.motion(&scene.own[0], 1.0, carried_over, false);
    scene.actions =
        scene.resolved.impose_rigid_velocity(Some(&[motion]), &mut scene.flow, dt, &SerialTransport).unwrap();
    scene.own[0] = scene.resolved.bodies[0].clone();
    assert_eq!([scene.own[0].velocity, scene.own[0].spin], [to[1], to[2]], "the motion is imposed");
    scene.actions[0].on_prescribed(&carried_over, [&before, &displaced.momentum(&scene.own[0])], dt)
}

/// A sphere that turns in a fluid at rest is held back by 8π μ R³ ω, in a cubic array of a volume fraction φ by
/// 1/(1 − φ) times as much, but for terms of φ^(10/3) (Zuzovsky, Adler and Brenner 1983).
#[test]
fn a_turning_sphere_is_held_back_by_the_torque_of_stokes() {
    let (radius, cells) = (0.125_f64, 40);
    let h = 1.0 / f64::from(cells);
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [cells as usize; 3], [true; 3]).unwrap();
    let setup = FlowSetup::new(grid, 1.0, 1.0);
    let mass = 4.0 / 3.0 * PI * radius.powi(3);
    let displaced = Displaced { mass, inertia: 0.4 * mass * radius * radius };
    let sphere = Shape::sphere(radius).unwrap();
    for (forcing, tolerance) in [(CUBIC, 0.02), (QUADRATIC, 0.03)] {
        let center = Vec3::new(0.51, 0.497, 0.503);
        let mut scene = Scene::new(&setup, [1; 3], (&sphere, &[body(1, center)]), forcing, &SerialTransport);
        let spin = Vec3::new(1.0, 2.0, 2.0) / 3.0 * 1e-3;
        let (mut torque, mut force) = (Vec3::zeros(), Vec3::zeros());
        for _ in 0..300 {
            [force, torque] = lead(&mut scene, &displaced, [center, Vec3::zeros(), spin], h * h);
        }
        let stokes = 8.0 * PI * radius.powi(3) / (1.0 - mass);
        let ratio = torque.dot(&spin) / -spin.norm_squared() / stokes;
        assert!((ratio - 1.0).abs() < tolerance, "{ratio} times the torque of Stokes");
        assert!(torque.cross(&spin).norm() < 0.01 * torque.norm() * spin.norm(), "{torque:?}");
        assert!(force.norm() * radius < 0.01 * torque.norm(), "{force:?}");
    }
}

/// A cylinder that swings in a fluid at rest, and one at rest in a fluid that swings, are the same flow in two frames: with the
/// acceleration dU/dt of the frame, the force on the one is that on the other and m_f dU/dt.
///
/// Both its parts, with the velocity and with the acceleration, are the same. As velocities come into the body and leave it, its
/// force jitters besides, by an amount that falls with the square of the cells' width over the step.
#[test]
fn a_swinging_cylinder_feels_what_one_at_rest_in_a_swinging_fluid_does() {
    let (cells, radius, amplitude, omega) = (32, 0.25_f64, 0.09, 160.0_f64);
    let h = 1.0 / cells as f64;
    let grid = Grid::uniform([0.0; 3], [1.0, h, 1.0], [cells, 1, cells], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    let mass = PI * radius * radius * h;
    let displaced = Displaced { mass, inertia: 0.5 * mass * radius * radius };
    let cylinder = Shape::cylinder(radius, 4.0 * h, 1e-6).unwrap();
    let mut round = body(1, Vec3::new(0.53, 0.5 * h, 0.51));
    round.rotation = *nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), 0.5 * PI).matrix();
    let scene = |setup: &FlowSetup, forcing: Forcing| {
        Scene::new(setup, [1; 3], (&cylinder, std::slice::from_ref(&round)), forcing, &SerialTransport)
    };
    for forcing in [QUADRATIC, CUBIC] {
        let mut moving = scene(&setup, forcing);
        setup.drive[0] = Drive::PressureGradient(-1.0);
        let mut resting = scene(&setup, forcing);
        setup.drive[0] = Drive::None;
        let steps = 400;
        let dt = 2.0 * TAU / omega / f64::from(steps);
        let mut carried_over = [0.0; 6];
        let (mut parts, mut jitter) = ([[0.0; 2]; 2], 0.0);
        for step in 0..steps {
            let [before, after] = [step, step + 1].map(|s| omega * f64::from(s) * dt);
            let x = Vec3::x();
            let to = [
                round.center + x * (amplitude * (1.0 - after.cos())),
                x * (amplitude * omega * after.sin()),
                Vec3::zeros(),
            ];
            let [force, _] = lead(&mut moving, &displaced, to, dt);
            // Mean acceleration in the step.
            let acceleration = amplitude * omega * (after.sin() - before.sin()) / dt;
            resting.flow.state.force[0] = -acceleration;
            resting.step(dt, &SerialTransport);
            let [at_rest, _] = resting.actions[0].on_prescribed(&carried_over, [&[0.0; 6]; 2], dt);
            carried_over = resting.actions[0].carried_over;
            if step >= steps / 4 {
                let wanted = at_rest.x + mass * acceleration;
                for (parts, force) in parts.iter_mut().zip([wanted, force.x]) {
                    parts[0] += force * after.cos();
                    parts[1] += force * after.sin();
                }
                jitter += (force.x - wanted).powi(2);
            }
        }
        let [wanted, found] = parts;
        let size = wanted[0].hypot(wanted[1]);
        let off = (found[0] - wanted[0]).hypot(found[1] - wanted[1]) / size;
        // Of a swing A cos the sum over n steps of A cos² is n A/2.
        let counted = f64::from(steps - steps / 4);
        let jitter = (jitter / counted).sqrt() / (2.0 * size / counted);
        assert!(off < 0.005 && jitter < 0.03, "{forcing:?}: off by {off}, jitter {jitter}");
    }
}

/// What the flow does to a driven body, it loses; with free ones beside it, momentum is kept to rounding.
#[test]
fn momentum_of_fluid_free_and_driven_bodies_is_accounted_for() {
    let radius = 0.18_f64;
    let mass = 4.0 / 3.0 * PI * radius.powi(3);
    let displaced = Displaced { mass, inertia: 0.4 * mass * radius * radius };
    let cells = 16;
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [cells; 3], [true; 3]).unwrap();
    let setup = FlowSetup::new(grid, 1.0, 0.05);
    for forcing in [QUADRATIC, MULTIPLIERS] {
        let balls = [
            body(1, Vec3::new(0.3, 0.3, 0.3)),
            body(2, Vec3::new(0.72, 0.75, 0.74)),
            body(3, Vec3::new(0.3, 0.75, 0.6)),
        ];
        let mut scene =
            Scene::new(&setup, [1; 3], (&Shape::sphere(radius).unwrap(), &balls), forcing, &SerialTransport);
        // The first is driven, the second fixed, the third free and twice as dense.
        let is_free = [false, false, true];
        let (dt, mut given, mut start) = (0.01, Vec3::zeros(), None);
        for step in 0..40 {
            let before: Vec<[f64; 6]> = scene.own.iter().map(|b| displaced.momentum(b)).collect();
            let carried_over: Vec<[f64; 6]> =
                scene.actions.iter().map(|action| action.carried_over).collect();
            let angle = 8.0 * f64::from(step) * dt;
            scene.own[0].velocity = Vec3::new(0.6 * angle.sin(), 0.2, -0.3 * angle.cos());
            scene.own[0].spin = Vec3::new(0.0, 2.0, angle.sin());
            scene.own.iter_mut().for_each(|body| body.center += body.velocity * dt);
            scene.place(&SerialTransport);
            scene.flow.step(dt, &SerialTransport).unwrap();
            let motions: Vec<BodyMotion> =
                (0..3).map(|k| displaced.motion(&scene.own[k], 2.0, carried_over[k], is_free[k])).collect();
            let driven = scene.own[0].clone();
            scene.actions = scene
                .resolved
                .impose_rigid_velocity(Some(&motions), &mut scene.flow, dt, &SerialTransport)
                .unwrap();
            scene.own.clone_from_slice(&scene.resolved.bodies[..3]);
            assert_eq!(scene.own[0].velocity, driven.velocity);
            assert_eq!((scene.own[1].velocity, scene.own[1].spin), (Vec3::zeros(), Vec3::zeros()));
            let after: Vec<[f64; 6]> = scene.own.iter().map(|b| displaced.momentum(b)).collect();
            for k in 0..2 {
                let [force, _] =
                    scene.actions[k].on_prescribed(&carried_over[k], [&before[k], &after[k]], dt);
                given += force * dt;
            }
            let state = &scene.flow.state;
            let sums: [f64; 3] =
                [state.velocity.x.own().sum(), state.velocity.y.own().sum(), state.velocity.z.own().sum()];
            let sums = sums.map(|sum| sum * (cells as f64).powi(-3));
            let left: Vec3 =
                scene.actions.iter().map(|a| Vec3::from_column_slice(&a.carried_over[..3])).sum();
            // Of a free body its momentum beyond that of the fluid in its place; of the others that of the fluid goes.
            let own =
                scene.own[2].velocity * mass - scene.own[..2].iter().map(|b| b.velocity * mass).sum::<Vec3>();
            let total = Vec3::from(sums) - left + own + given;
            let off = total - *start.get_or_insert(total);
            assert!(off.norm() < 1e-12, "{forcing:?}, step {step}: {off:?}");
        }
        assert!(given.norm() > 1e-4, "{given:?}");
        assert!(scene.own[2].velocity.norm() > 1e-4, "the flow takes the free one along");
    }
}
