//! Bodies and walls in fluids whose viscosity depends on the rate of shear, against closed forms and against each other.

use crate::common::*;
use crate::walls::{Walled, at_rest, cylinder};
use grains_domain::SerialTransport;
use grains_fluid::{
    Bingham, Boundaries, Condition, Drive, FlowSetup, Grid, PowerLaw, Profile, Regularisation, Rheology,
    ViscosityLaw,
};
use grains_geometry::{Shape, Vec3};
use grains_resolved::{RigidBody, SolidSide};
use std::f64::consts::PI;

fn bingham(yield_stress: f64, exponent: f64) -> Rheology {
    let regularisation = Regularisation::Papanastasiou { exponent };
    Rheology::Bingham(Bingham { yield_stress, plastic_viscosity: 1.0, regularisation })
}

fn power_law(index: f64) -> Rheology {
    Rheology::PowerLaw(PowerLaw { consistency: 1.0, index, max_viscosity: Some(100.0) })
}

/// A flow of unit density on a grid.
fn setup(grid: Grid, rheology: Rheology) -> FlowSetup {
    FlowSetup { viscosity_law: Some(ViscosityLaw::Rheology(rheology)), ..FlowSetup::new(grid, 1.0, 1.0) }
}

/// A sheet one cell thick, of h (m).
fn sheet([nx, ny]: [usize; 2], h: f64, is_periodic: bool) -> Grid {
    let upper = [nx as f64 * h, ny as f64 * h, h];
    Grid::uniform([0.0; 3], upper, [nx, ny, 1], [is_periodic, false, false]).unwrap()
}

fn without_friction(mut boundaries: Boundaries) -> Boundaries {
    (boundaries.faces[4], boundaries.faces[5]) = (Condition::Symmetry, Condition::Symmetry);
    boundaries
}

/// Pressure gradient (Pa/m) and radius (m) of the pipes.
const GRADIENT: f64 = 10.0;
const RADIUS: f64 = 0.4;

/// Largest and mean square errors over the largest velocity, in a pipe along x off the grid lines.
///
/// Of τ = τ_y + γ̇ⁿ it is u = (G/2)^m/(m + 1) ((R − r_p)^(m + 1) − (r − r_p)₊^(m + 1)), m = 1/n, r_p = 2 τ_y/G.
fn pipe(n: usize, rheology: Rheology, index: f64) -> [f64; 2] {
    let h = 1.0 / n as f64;
    let grid = Grid::uniform([0.0; 3], [8.0 * h, 1.0, 1.0], [8, n, n], [true; 3]).unwrap();
    let mut setup = setup(grid, rheology);
    setup.drive[0] = Drive::PressureGradient(-GRADIENT);
    let center = Vec3::new(0.0, 0.513, 0.487);
    let mut walled = Walled::still(&setup, &[cylinder(center, Vec3::x(), RADIUS, SolidSide::Outside)]);
    for _ in 0..600 {
        walled.step(2.0 * h * h, &SerialTransport);
    }
    let (plug, power) = (2.0 * rheology.yield_stress() / GRADIENT, 1.0 / index + 1.0);
    let part = |r: f64| (r - plug).max(0.0).powf(power);
    let profile = |r: f64| (0.5 * GRADIENT).powf(power - 1.0) / power * (part(RADIUS) - part(r));
    let mut area = 0.0;
    let exact = |c: usize, at: Vec3| {
        let r = (at - center).yz().norm();
        (r < RADIUS).then(|| if c == 0 { profile(r) } else { 0.0 })
    };
    walled.compare(|c, at| exact(c, at).filter(|_| c == 0), |_, _| area += h * h / 8.0);
    // The wall holds what the gradient drives: the velocities that are free.
    let force = walled.resolved.on_walls[0].force / (8.0 * h * GRADIENT);
    assert!((force.x / area - 1.0).abs() < 1e-3 && force.yz().norm() < 1e-3 * area, "{force:?} {area}");
    walled.errors(exact).map(|e| e / profile(0.0))
}

#[test]
fn pipes_off_the_grid_lines_carry_plugs_and_thinning_fluids() {
    // The border of a plug has no second derivative.
    for (rheology, index, bound) in
        [(power_law(0.6), 0.6, 1.8), (power_law(1.4), 1.4, 1.8), (bingham(0.6, 300.0), 1.0, 1.4)]
    {
        let errors = [12, 24].map(|n| pipe(n, rheology, index));
        let found = order(errors[0][1], errors[1][1], 2.0);
        println!("{rheology:?}: {errors:?}, order {found:.2}");
        assert!(errors[1][1] < 0.005 && found > bound, "{rheology:?}: {errors:?}, order {found:.2}");
    }
}

/// Torque of a power-law fluid on two cylinders, one of which turns: M = 2π (Δω (2/n)/(a^(−2/n) − b^(−2/n)))ⁿ per length.
#[test]
fn torques_on_cylinders_are_those_of_a_thinning_fluid() {
    let (radii, rates, index, n) = ([0.2_f64, 0.42], [1.0, -0.5], 0.6, 40);
    let h = 1.0 / n as f64;
    let setup = FlowSetup {
        boundaries: without_friction(Boundaries::default()),
        ..setup(sheet([n; 2], h, false), power_law(index))
    };
    let walls = [(radii[0], SolidSide::Inside), (radii[1], SolidSide::Outside)]
        .map(|(radius, solid)| cylinder(Vec3::zeros(), Vec3::z(), radius, solid));
    let place = |k: usize| RigidBody {
        center: Vec3::new(0.507, 0.496, 0.0),
        spin: Vec3::z() * rates[k],
        ..at_rest(k)
    };
    let mut walled = Walled::new(&setup, [1; 3], (&walls, vec![place(0), place(1)]), &SerialTransport);
    walled.settle(h * h, 1e-7);
    let [a, b] = radii.map(|r| r.powf(-2.0 / index));
    let wanted = 2.0 * PI * ((rates[0] - rates[1]) * 2.0 / index / (a - b)).powf(index);
    // About the middle of the cylinders, where no net force is left.
    let torques = [0, 1].map(|k| walled.resolved.on_walls[k].torque.z / h);
    println!("torques {torques:?}, {wanted}");
    for (torque, sign) in torques.into_iter().zip([-1.0, 1.0]) {
        assert!((sign * torque / wanted - 1.0).abs() < 0.02, "{torques:?} {wanted}");
    }
}

/// A cylinder in the middle of a channel of mud: force per length as a body and as a wall.
#[test]
fn a_cylinder_in_mud_has_one_drag_as_a_body_and_as_a_wall() {
    let (radius, n) = (0.2, 24);
    let h = 1.0 / n as f64;
    let inlet = Condition::Inlet { profile: Profile::Uniform([1.0, 0.0, 0.0]) };
    let outlet = Condition::Outlet { pressure: 0.0 };
    let boundaries = Boundaries::default().with(0, grains_fluid::Side::Low, inlet);
    let boundaries = without_friction(boundaries.with(0, grains_fluid::Side::High, outlet));
    let setup = FlowSetup { boundaries, ..setup(sheet([2 * n, n], h, false), bingham(2.0, 100.0)) };
    let center = Vec3::new(0.81, 0.53, 0.5 * h);
    let disc = Shape::cylinder(radius, h, 0.02).unwrap();
    let mut scene = Scene::new(&setup, [1; 3], (&disc, &[body(1, center)]), QUADRATIC, &SerialTransport);
    let mut walled = Walled::still(&setup, &[cylinder(center, Vec3::z(), radius, SolidSide::Inside)]);
    for _ in 0..400 {
        scene.step(h * h, &SerialTransport);
        walled.step(h * h, &SerialTransport);
    }
    let [of_body, of_wall] = [-scene.actions[0].force, walled.resolved.on_walls[0].force].map(|f| f / h);
    println!("as a body {of_body:?}, as a wall {of_wall:?}");
    assert!((of_body.x / of_wall.x - 1.0).abs() < 0.01, "{of_body:?} {of_wall:?}");
    assert!((of_body.y - of_wall.y).abs() < 0.01 * of_wall.x.abs(), "{of_body:?} {of_wall:?}");
}

/// A sphere in creeping flow of a Bingham fluid, 2 τ_y R/(μ U) = 10, regularised by 100 R/U: its drag is 17.78 times that of Stokes
/// by the minimum of the power of all axisymmetric flows (cases/bingham-sphere/reference.py).
#[test]
fn a_sphere_in_mud_has_the_drag_of_the_least_power() {
    let (n, half, density) = (30, 2.5, 0.01);
    let h = 2.0 * half / n as f64;
    let grid = Grid::uniform([-half; 3], [half; 3], [n; 3], [false; 3]).unwrap();
    let far = [1.0, 0.0, 0.0];
    let mut boundaries = Boundaries::default();
    boundaries.faces.fill(Condition::Wall { velocity: far });
    boundaries.faces[0] = Condition::Inlet { profile: Profile::Uniform(far) };
    boundaries.faces[1] = Condition::Outlet { pressure: 0.0 };
    let setup = FlowSetup { boundaries, density, ..setup(grid, bingham(5.0, 100.0)) };
    let ball = Shape::sphere(1.0).unwrap();
    let mut scene =
        Scene::new(&setup, [1; 3], (&ball, &[body(1, Vec3::zeros())]), QUADRATIC, &SerialTransport);
    scene.flow.initialise(|_| far, |_| 0.0, &SerialTransport);
    for _ in 0..80 {
        scene.step(h * h * density, &SerialTransport);
    }
    let drag = -scene.actions[0].force / (6.0 * PI);
    println!("drag {drag:?}");
    assert!((drag.x / 17.78 - 1.0).abs() < 0.05 && drag.yz().norm() < 1e-3 * drag.x, "{drag:?}");
}
