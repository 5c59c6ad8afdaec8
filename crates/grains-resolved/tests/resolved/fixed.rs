//! Flow past bodies that stay where they are.

use crate::common::{CUBIC, MULTIPLIERS, Scene, body, difference, joined, on_ranks, order, piece};
use grains_domain::{SerialTransport, Transport};
use grains_fluid::{Boundaries, Condition, Drive, FlowSetup, Grid, Profile};
use grains_geometry::{Shape, Vec3};
use grains_resolved::{
    Action, ConstraintError, Extrapolation, Forcing, Interpolation, MAX_DIFFUSION_NUMBER, Method,
    MultiplierMethod,
};

/// A sphere of a simple cubic array on unit cells, so many cells from the middle.
fn spheres(fraction: f64, cells: usize, offset: f64, drive: Drive, forcing: Forcing) -> Scene {
    let h = 1.0 / cells as f64;
    let radius = (fraction * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [cells; 3], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    setup.drive[0] = drive;
    let sphere = Shape::sphere(radius).unwrap();
    let center = Vec3::repeat(0.5) + Vec3::new(1.0, 0.7, 0.3) * (offset * h);
    Scene::new(&setup, [1; 3], (&sphere, &[body(1, center)]), forcing, &SerialTransport)
}

/// Friction coefficient K = F/(6π μ a U) of a simple cubic array of spheres in Stokes flow.
fn friction_of_array(fraction: f64, cells: usize, offset: f64, forcing: Forcing) -> f64 {
    let h = 1.0 / cells as f64;
    let radius = (fraction * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    let mut scene = spheres(fraction, cells, offset, Drive::PressureGradient(-1.0), forcing);
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

/// A cylinder of a square array on unit cells, its centre so many cells from the middle, in two dimensions.
fn cylinders(fraction: f64, cells: usize, [x, z]: [f64; 2], drive: Drive) -> Scene {
    let h = 1.0 / cells as f64;
    let grid = Grid::uniform([0.0; 3], [1.0, h, 1.0], [cells, 1, cells], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    setup.drive[0] = drive;
    let disc = Shape::cylinder((fraction / std::f64::consts::PI).sqrt(), h, 0.02).unwrap();
    let mut upright = body(1, Vec3::new(0.5 + x * h, 0.5 * h, 0.5 + z * h));
    upright.rotation =
        nalgebra::Rotation3::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0).into_inner();
    Scene::new(&setup, [1; 3], (&disc, &[upright]), CUBIC, &SerialTransport)
}

/// Force per length over μ U of a square array of cylinders.
fn friction_of_cylinders(fraction: f64, cells: usize) -> f64 {
    let h = 1.0 / cells as f64;
    let mut scene = cylinders(fraction, cells, [0.3, 0.1], Drive::PressureGradient(-1.0));
    for _ in 0..(0.5 / (h * h)) as usize {
        scene.step(h * h, &SerialTransport);
    }
    1.0 / scene.flow.mean_velocity(0, &SerialTransport)
}

/// Steps until the force changes by less than 1e-8 of itself in each of ten steps at a diffusion number, and that force
/// per volume and the gradient that drives the flow; panics if it never does.
fn settled(mut scene: Scene, diffusion_number: f64) -> [f64; 2] {
    let width = scene.resolved.subgrid.spacing.x;
    let (mut last, mut steady) = (0.0_f64, 0);
    for _ in 0..6000 {
        scene.step(diffusion_number * width * width, &SerialTransport);
        let force = -scene.actions[0].force.x;
        steady = if (force - last).abs() < 1e-8 * force.abs() { steady + 1 } else { 0 };
        last = force;
        if steady == 10 {
            let volume: f64 = (0..3).map(|a| scene.flow.setup.grid.axis(a).length()).product();
            return [force / volume, scene.flow.state.force[0]];
        }
    }
    panic!("the force goes on changing: {last} at ν Δt/Δx² = {diffusion_number}");
}

#[test]
fn force_and_gradient_settle_at_any_diffusion_number_that_is_allowed() {
    let drive = Drive::MeanVelocity(1e-3);
    for diffusion_number in [0.3, 1.0, MAX_DIFFUSION_NUMBER] {
        for (fraction, cells, found) in [(0.05, 32, 15.56), (0.2, 26, 51.53), (0.3, 32, 102.9)]
            .into_iter()
            .chain([(0.4, 32, 217.89), (0.5, 32, 532.55)])
        {
            for offset in [[0.32, 0.96], [0.0, 0.0], [0.3, 0.1], [0.25, 0.4]] {
                let [force, gradient] = settled(cylinders(fraction, cells, offset, drive), diffusion_number);
                let case = format!("{fraction} {offset:?} {diffusion_number}: {force} {gradient}");
                assert!((force / gradient - 1.0).abs() < 1e-5, "{case}");
                assert!((1e3 * force / found - 1.0).abs() < 0.015, "{case}");
            }
        }
        for (fraction, cells, found, error) in
            [(0.125, 13, 4.292, 0.04), (0.343, 18, 15.4, 0.025), (0.45, 16, 28.1, 0.06)]
        {
            let [force, gradient] = settled(spheres(fraction, cells, 0.3, drive, CUBIC), diffusion_number);
            let radius = (fraction * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
            let friction = 1e3 * force / (6.0 * std::f64::consts::PI * radius);
            assert!(
                (force / gradient - 1.0).abs() < 1e-5,
                "{fraction} {diffusion_number}: {force} {gradient}"
            );
            assert!((friction / found - 1.0).abs() < error, "{fraction} {diffusion_number}: {friction}");
        }
    }
}

#[test]
fn an_array_of_cylinders_resists_as_sangani_and_acrivos_found() {
    for (fraction, found, error) in [(0.05, 15.56, 0.005), (0.2, 51.53, 0.005), (0.4, 217.89, 0.005)] {
        let cells = (8.0 / (fraction / std::f64::consts::PI).sqrt()).round() as usize;
        let here = friction_of_cylinders(fraction, cells);
        assert!((here / found - 1.0).abs() < error, "{fraction}: {here} on {cells} cells");
    }
}

/// Amplitude of the force per length on cylinders in a flow that swings, and of that on the fluid.
fn swinging(cells: usize) -> [f64; 2] {
    // Boundary layers of sqrt(2 ν/ω) = 0.11 about cylinders 0.5 across.
    let (omega, h) = (160.0, 1.0 / cells as f64);
    let mut scene = cylinders(0.19635, cells, [0.3, 0.1], Drive::PressureGradient(-1.0));
    let steps = 400;
    let dt = 2.0 * std::f64::consts::TAU / omega / steps as f64;
    let mut carried_over = [0.0; 6];
    let mut most = [0.0_f64; 2];
    for step in 0..steps {
        let time = (step as f64 + 0.5) * dt;
        scene.flow.state.force[0] = (omega * time).cos();
        scene.step(dt, &SerialTransport);
        let action = &scene.actions[0];
        let [force, _] = action.on_prescribed(&carried_over, [&[0.0; 6]; 2], dt);
        carried_over = action.carried_over;
        if step >= steps / 2 {
            most = [most[0].max(force.x.abs() / h), most[1].max(action.force.x.abs() / h)];
        }
    }
    most
}

#[test]
fn the_force_of_an_unsteady_flow_does_not_depend_on_the_cells() {
    let [[coarse, on_fluid], [fine, _]] = [16, 64].map(swinging);
    assert!((coarse / fine - 1.0).abs() < 0.02, "{coarse} {fine}");
    assert!((coarse - fine).abs() < 0.5 * (on_fluid - fine).abs(), "{coarse} {on_fluid} {fine}");
}

/// Largest drag coefficient, half the range of the lift coefficient and Strouhal number of case 2D-2 of Schäfer and Turek
/// (1996): a cylinder off the middle of a channel at Reynolds number 100.
fn shedding(cells_across: usize) -> [f64; 3] {
    let (diameter, viscosity, longest) = (0.1, 1e-3, 2.2);
    let h = diameter / cells_across as f64;
    let [nx, ny] = [1.6, 0.41].map(|length: f64| (length / h).round() as usize);
    let grid = Grid::uniform([0.0; 3], [nx as f64 * h, ny as f64 * h, h], [nx, ny, 1], [false; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, viscosity);
    let mut boundaries = Boundaries::default();
    boundaries.faces[0] = Condition::Inlet { profile: Profile::Parabolic { mean: 1.0 } };
    boundaries.faces[1] = Condition::Outlet { pressure: 0.0 };
    (boundaries.faces[4], boundaries.faces[5]) = (Condition::Symmetry, Condition::Symmetry);
    setup.boundaries = boundaries;
    let disc = Shape::cylinder(0.5 * diameter, h, 0.02).unwrap();
    let center = Vec3::new(0.2, 0.2, 0.5 * h);
    let mut scene = Scene::new(&setup, [1; 3], (&disc, &[body(1, center)]), CUBIC, &SerialTransport);
    // Lopsided, so that vortices are shed at once.
    let first = |x: [f64; 3]| [1.0 + 0.5 * (20.0 * x[1]).sin(), 0.3 * (10.0 * x[0]).sin(), 0.0];
    scene.flow.initialise(first, |_| 0.0, &SerialTransport);
    let (dt, unit) = (0.2 * h / longest, 0.5 * diameter * h);
    let (mut carried_over, mut last, mut rises) = ([0.0; 6], 0.0, Vec::new());
    let (mut drag, mut lift) = (0.0_f64, [0.0_f64; 2]);
    for step in 1..=(2.1 / dt) as usize {
        scene.step(dt, &SerialTransport);
        let action = &scene.actions[0];
        let force = action.on_prescribed(&carried_over, [&[0.0; 6]; 2], dt)[0] / unit;
        carried_over = action.carried_over;
        let time = step as f64 * dt;
        if time > 1.1 {
            drag = drag.max(force.x);
            lift = [lift[0].min(force.y), lift[1].max(force.y)];
            if last < 0.0 && force.y >= 0.0 {
                rises.push(time - dt * force.y / (force.y - last));
            }
        }
        last = force.y;
    }
    let periods = (rises.len() - 1) as f64;
    [drag, 0.5 * (lift[1] - lift[0]), diameter * periods / (rises[rises.len() - 1] - rises[0])]
}

#[test]
fn a_cylinder_sheds_vortices_as_schaefer_and_turek_found() {
    // Drag 3.22 to 3.24, Strouhal number 0.295 to 0.305, lift about 1. Lift converges last: 0.959 here, 0.988 at 40 cells.
    let [drag, lift, strouhal] = shedding(20);
    assert!((drag / 3.23 - 1.0).abs() < 0.015, "drag {drag}");
    assert!((lift - 1.0).abs() < 0.06, "lift {lift}");
    assert!((0.295..0.305).contains(&strouhal), "Strouhal number {strouhal}");
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
    let error =
        scene.resolved.impose_rigid_velocity(None, &mut scene.flow, 0.01, &SerialTransport).unwrap_err();
    assert!(
        matches!(error, ConstraintError::NotConverged { iterations: 2, residual } if residual > 1e-10),
        "{error}"
    );
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
