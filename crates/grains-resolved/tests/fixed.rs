//! Flow past bodies that stay where they are.

#![allow(clippy::unwrap_used)]

mod common;

use common::{CUBIC, MULTIPLIERS, Scene, body, difference, joined, on_ranks, order, piece};
use grains_domain::{SerialTransport, Transport};
use grains_fluid::{Drive, FlowSetup, Grid};
use grains_geometry::{Shape, Vec3};
use grains_resolved::{Action, Extrapolation, FollowError, Forcing, Interpolation, Method, MultiplierMethod};

/// Friction coefficient K = F/(6π μ a U) of a simple cubic array of spheres in Stokes flow.
fn friction_of_array(fraction: f64, cells: usize, offset: f64, forcing: Forcing) -> f64 {
    let h = 1.0 / cells as f64;
    let radius = (fraction * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [cells; 3], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    setup.drive[0] = Drive::PressureGradient(-1.0);
    let sphere = Shape::sphere(radius).unwrap();
    let center = Vec3::repeat(0.5) + Vec3::new(1.0, 0.7, 0.3) * (offset * h);
    let mut scene = Scene::new(&setup, [1; 3], (&sphere, &[body(1, center)]), forcing, &SerialTransport);
    let mut last = 0.0;
    for step in 1..4000 {
        scene.step(h * h, &SerialTransport);
        if step % 20 == 0 {
            let mean = scene.flow.mean_velocity(0, &SerialTransport);
            if (mean - last).abs() < 1e-5 * mean {
                // What drives the fluid is what holds the body.
                assert!((scene.actions[0].force.x + 1.0).abs() < 1e-3, "{:?}", scene.actions);
                return radius * radius / (4.5 * fraction * mean);
            }
            last = mean;
        }
    }
    panic!("no steady flow");
}

#[test]
fn an_array_of_spheres_resists_as_zick_and_homsy_found() {
    let [coarse, fine] = [13, 26].map(|n| (friction_of_array(0.125, n, 0.3, CUBIC) / 4.292 - 1.0).abs());
    assert!(coarse < 0.04 && fine < 0.006, "{coarse} {fine}");
    assert!(order(coarse, fine, 2.0) > 2.5, "{coarse} {fine}");
    let dense = friction_of_array(0.343, 18, 0.3, CUBIC);
    assert!((dense / 15.4 - 1.0).abs() < 0.025, "{dense}");
    // Where the body lies in its cells does not matter.
    let elsewhere = friction_of_array(0.343, 18, 0.0, CUBIC);
    assert!((elsewhere / dense - 1.0).abs() < 0.01, "{elsewhere} {dense}");
}

/// Force per length over μ U of a square array of cylinders, in two dimensions.
fn friction_of_cylinders(fraction: f64, cells: usize) -> f64 {
    let h = 1.0 / cells as f64;
    let grid = Grid::uniform([0.0; 3], [1.0, h, 1.0], [cells, 1, cells], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    setup.drive[0] = Drive::PressureGradient(-1.0);
    let disc = Shape::cylinder((fraction / std::f64::consts::PI).sqrt(), h, 0.02).unwrap();
    let mut upright = body(1, Vec3::new(0.5 + 0.3 * h, 0.5 * h, 0.5 + 0.1 * h));
    upright.rotation =
        nalgebra::Rotation3::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0).into_inner();
    let mut scene = Scene::new(&setup, [1; 3], (&disc, &[upright]), CUBIC, &SerialTransport);
    for _ in 0..(0.5 / (h * h)) as usize {
        scene.step(h * h, &SerialTransport);
    }
    1.0 / scene.flow.mean_velocity(0, &SerialTransport)
}

#[test]
fn an_array_of_cylinders_resists_as_sangani_and_acrivos_found() {
    for (fraction, found, error) in [(0.05, 15.56, 0.005), (0.2, 51.53, 0.005), (0.4, 217.89, 0.005)] {
        let cells = (8.0 / (fraction / std::f64::consts::PI).sqrt()).round() as usize;
        let here = friction_of_cylinders(fraction, cells);
        assert!((here / found - 1.0).abs() < error, "{fraction}: {here} on {cells} cells");
    }
}

#[test]
fn spheres_that_touch_their_images_let_fluid_pass() {
    let touching = friction_of_array(std::f64::consts::PI / 6.0, 16, 0.0, CUBIC);
    assert!((touching / 42.1 - 1.0).abs() < 0.03, "{touching}");
}

#[test]
fn cruder_extrapolations_are_less_exact() {
    let error = |extrapolation| {
        let forcing = Forcing { method: Method::Direct { extrapolation }, ..CUBIC };
        (friction_of_array(0.343, 18, 0.3, forcing) / 15.4 - 1.0).abs()
    };
    let [rigid, linear, quadratic, cubic] =
        [Extrapolation::Rigid, Extrapolation::Linear, Extrapolation::Quadratic, Extrapolation::Cubic]
            .map(error);
    assert!(cubic < quadratic && quadratic < linear && linear < rigid && rigid < 0.3);
}

#[test]
fn multipliers_converge_to_the_same_drag() {
    let [coarse, fine] = [18, 36].map(|n| friction_of_array(0.343, n, 0.3, MULTIPLIERS) / 15.4 - 1.0);
    assert!(coarse.abs() < 0.06 && fine.abs() < 0.03, "{coarse} {fine}");
    let Method::Multiplier(method) = MULTIPLIERS.method else { unreachable!() };
    let method = Method::Multiplier(MultiplierMethod { interpolation: Interpolation::Multilinear, ..method });
    let crude = friction_of_array(0.343, 18, 0.3, Forcing { method, ..MULTIPLIERS }) / 15.4 - 1.0;
    assert!(crude > coarse && crude < 0.4, "{crude}");
}

#[test]
fn a_solve_that_stalls_is_an_error() {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [12; 3], [true; 3]).unwrap();
    let Method::Multiplier(method) = MULTIPLIERS.method else { unreachable!() };
    let forcing =
        Forcing { method: Method::Multiplier(MultiplierMethod { iterations: 2, ..method }), ..MULTIPLIERS };
    let sphere = Shape::sphere(0.3).unwrap();
    let mut ball = body(1, Vec3::repeat(0.5));
    ball.velocity.x = 1.0;
    let setup = FlowSetup::new(grid, 1.0, 1.0);
    let mut scene = Scene::new(&setup, [1; 3], (&sphere, &[ball]), forcing, &SerialTransport);
    scene.flow.step(0.01, &SerialTransport).unwrap();
    let error = scene.resolved.follow(None, &mut scene.flow, 0.01, &SerialTransport).unwrap_err();
    assert!(matches!(error, FollowError::Stalled { iterations: 2, residual } if residual > 1e-10), "{error}");
}

#[test]
fn flow_past_bodies_is_the_same_on_any_ranks() {
    for forcing in [CUBIC, MULTIPLIERS] {
        assert_same_on_any_ranks(forcing);
    }
}

fn assert_same_on_any_ranks(forcing: Forcing) {
    let grid = Grid::uniform([0.0; 3], [1.0, 0.8, 1.2], [20, 16, 24], [true, false, true]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 0.1);
    setup.drive[0] = Drive::PressureGradient(-1.0);
    setup.drive[2] = Drive::MeanVelocity(0.2);
    let box_ = Shape::cuboid(Vec3::new(0.35, 0.2, 0.3), 0.02).unwrap();
    let mut bodies = vec![body(7, Vec3::new(0.5, 0.4, 0.6)), body(3, Vec3::new(0.98, 0.3, 0.03))];
    bodies[0].rotation = nalgebra::Rotation3::from_euler_angles(0.3, 0.5, 0.7).into_inner();
    bodies[1].spin = Vec3::new(0.0, 1.0, 2.0);
    let run = |ranks: [usize; 3]| {
        let results = on_ranks(ranks.iter().product(), |transport| {
            let mut scene = Scene::new(&setup, ranks, (&box_, &bodies), forcing, &transport);
            for _ in 0..5 {
                scene.step(0.01, &transport);
            }
            let load = |a: &Action| [a.force.x, a.force.y, a.force.z, a.torque.x, a.torque.y, a.torque.z];
            let own: Vec<_> = scene.own.iter().map(|b| b.id).zip(scene.actions.iter().map(load)).collect();
            let (layout, first) = (scene.flow.layout(), scene.flow.first_cell());
            assert!(transport.size() > 1 || own.len() == 2);
            (scene.flow.state.velocity.components().map(|u| piece(u, layout, first)), own)
        });
        let velocity: Vec<f64> =
            (0..3).flat_map(|c| joined(results.iter().map(|r| r.0[c].clone()).collect())).collect();
        let mut loads: Vec<(u64, [f64; 6])> = results.into_iter().flat_map(|r| r.1).collect();
        loads.sort_by_key(|(id, _)| *id);
        (velocity, loads)
    };
    // Multipliers are found to their tolerance.
    let tolerance = if forcing == CUBIC { 1e-12 } else { 1e-9 };
    let (velocity, loads) = run([1; 3]);
    assert!(loads[1].1[0] < -0.01, "{loads:?}");
    for ranks in [[2, 1, 1], [1, 1, 3], [2, 2, 1]] {
        let (others, other_loads) = run(ranks);
        assert!(
            difference(&velocity, &others) < tolerance,
            "{ranks:?} {forcing:?} {}",
            difference(&velocity, &others)
        );
        for (a, b) in loads.iter().zip(&other_loads) {
            assert!(a.0 == b.0 && difference(&a.1, &b.1) < 100.0 * tolerance, "{ranks:?} {a:?} {b:?}");
        }
    }
}
