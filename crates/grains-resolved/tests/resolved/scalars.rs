//! Scalars about bodies and in them: exact solutions and orders, and what is kept.

use crate::common::{CUBIC, Scene, body, order};
use grains_domain::SerialTransport;
use grains_fluid::{
    Axis, FlowSetup, Grid, Interior, Scalar, ScalarBoundaries, ScalarCondition, ScalarSetup, ScalarValue,
    Scheme, SolidCondition, SolidConditions, SolidReaction,
};
use grains_geometry::{Shape, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

const SERIAL: SerialTransport = SerialTransport;

fn function(f: impl Fn([f64; 3], f64) -> f64 + Send + Sync + 'static) -> ScalarValue {
    ScalarValue::Function(Arc::new(f))
}

/// A scalar with diffusivity 1 and these values on all faces of the box.
fn scalar(
    diffusivity: f64,
    on_faces: impl Fn([f64; 3], f64) -> f64 + Send + Sync + 'static,
    bodies: SolidCondition,
) -> ScalarSetup {
    let on_faces = Arc::new(on_faces);
    let face = |_| {
        let f = on_faces.clone();
        ScalarCondition::Value(function(move |at, time| f(at, time)))
    };
    ScalarSetup {
        name: "scalar".into(),
        diffusivity,
        scheme: if std::env::var("BOUNDED").is_ok() { Scheme::Bounded } else { Scheme::Central },
        boundaries: ScalarBoundaries { faces: [0, 1, 2, 3, 4, 5].map(face), patches: Vec::new() },
        solids: SolidConditions { bodies, walls: Vec::new() },
        buoyancy: None,
    }
}

/// A box of edge 2 about the origin with n cells along each edge, a body in it and a scalar.
fn still(
    n: usize,
    (shape, center): (&Shape, Vec3),
    setup: ScalarSetup,
    initial: impl Fn([f64; 3]) -> f64,
) -> Scene {
    let axis = || Axis::uniform(-1.0, 1.0, n, false);
    let grid = Grid::new([axis(), axis(), axis()]).unwrap();
    let flow = FlowSetup::new(grid, 1.0, 1.0);
    let mut scene = Scene::new(&flow, [1; 3], (shape, &[body(0, center)]), CUBIC, &SERIAL);
    scene.flow.add_scalar(setup, initial, &SERIAL);
    scene.resolved.place_for_scalars(&scene.shapes, &[vec![]], &mut scene.flow, &SERIAL);
    scene.flow.begin_scalars(|_| true);
    scene
}

fn only(scene: &Scene) -> &Scalar {
    &scene.flow.scalars.as_ref().unwrap().all[0]
}

/// Marches until nothing changes by more than a tolerance in a step.
fn settle(scene: &mut Scene, dt: f64, tolerance: f64) -> usize {
    for step in 1..20_000 {
        let before = only(scene).value.clone();
        scene.flow.step_scalars(dt, &SERIAL).unwrap();
        let change = only(scene).value.own().zip(before.own()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(change.is_finite(), "step {step}"); if step % 400 == 0 { println!("{step} {change:e}"); } if step > 1600 { return step }
        if change < tolerance {
            return step;
        }
    }
    panic!("did not settle");
}

/// Largest and mean error over the cells for which something is to be expected.
fn errors(scene: &Scene, exact: impl Fn([f64; 3]) -> Option<f64>) -> [f64; 2] {
    let n = scene.flow.layout().cells;
    let h = 2.0 / n[0] as f64;
    let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                let at = [i, j, k].map(|i| -1.0 + (i as f64 + 0.5) * h);
                let Some(exact) = exact(at) else { continue };
                let error = (only(scene).value.at(i as isize, j as isize, k as isize) - exact).abs();
                largest = largest.max(error);
                sum += error;
                count += 1.0;
            }
        }
    }
    [largest, sum / count]
}

const CENTER: [f64; 3] = [0.031, -0.017, 0.043];

fn arm(at: [f64; 3]) -> Vec3 {
    Vec3::from(at) - Vec3::from(CENTER)
}

#[test]
fn sphere_of_a_given_value_conducts_in_second_order() {
    let radius = 0.4;
    let mut found = Vec::new();
    for n in [20, 40] {
        let exact = move |at: [f64; 3], _: f64| radius / arm(at).norm();
        let setup = scalar(1.0, exact, SolidCondition::Value(ScalarValue::Uniform(1.0)));
        let mut scene = still(n, (&Shape::sphere(radius).unwrap(), CENTER.into()), setup, |_| 0.5);
        let h = 2.0 / n as f64;
        let steps = settle(&mut scene, 2.0 * h * h, 1e-8);
        let errors = errors(&scene, |at| (arm(at).norm() > radius).then(|| exact(at, 0.0)));
        let before = only(&scene).gained[0];
        scene.flow.step_scalars(2.0 * h * h, &SERIAL).unwrap();
        let flux = (only(&scene).gained[0] - before) / (2.0 * h * h);
        let error = flux / (4.0 * PI * radius) - 1.0;
        println!("{n}: {steps} steps, errors {errors:?}, flux {error:.2e}");
        found.push([errors[0], errors[1], error.abs()]);
    }
    println!("orders {:?}", [0, 1, 2].map(|k| order(found[0][k], found[1][k], 2.0)));
}

#[test]
fn conducting_sphere_in_a_gradient() {
    let radius = 0.4;
    let along = Vec3::new(0.5, -0.3, 0.8).normalize();
    for ratio in [0.0, 0.1, 0.5, 2.0, 10.0, 100.0] {
        let mut found = Vec::new();
        for n in [20, 40] {
            let exact = move |at: [f64; 3], _: f64| {
                let r = arm(at);
                let polar = (ratio - 1.0) / (ratio + 2.0) * (radius / r.norm()).powi(3);
                match r.norm() > radius {
                    true => r.dot(&along) * (1.0 - polar),
                    false => r.dot(&along) * 3.0 / (ratio + 2.0),
                }
            };
            let condition = match ratio > 0.0 {
                true => SolidCondition::Interior(Interior { capacity: 1.0, diffusivity: ratio, reaction: None }),
                false => SolidCondition::default(),
            };
            let setup = scalar(1.0, exact, condition);
            let mut scene =
                still(n, (&Shape::sphere(radius).unwrap(), CENTER.into()), setup, |at| arm(at).dot(&along));
            let h = 2.0 / n as f64;
            let steps = settle(&mut scene, h * h / ratio.max(1.0), 1e-8);
            let errors = errors(&scene, |at| {
                (ratio > 0.0 || arm(at).norm() > radius).then(|| exact(at, 0.0))
            });
            println!("{ratio} {n}: {steps} steps, errors {errors:?}");
            found.push(errors);
        }
        println!("{ratio} orders {:?}", [0, 1].map(|k| order(found[0][k], found[1][k], 2.0)));
    }
}

#[test]
fn reaction_in_a_sphere() {
    let radius: f64 = 0.4;
    for ratio in [0.1, 1.0, 20.0] {
        for thiele in [0.3_f64, 1.0, 3.0] {
            let mut found = Vec::new();
            for n in [20, 40] {
                // Thiele modulus R/3 √(k/D) with D = 1; fluid of a diffusivity `ratio`.
                let rate = (3.0 * thiele / radius).powi(2);
                let reaction = Some(SolidReaction { rate, order: 1.0 });
                let interior = Interior { capacity: 1.0, diffusivity: 1.0, reaction };
                // Outside 1 − B R/r: ratio B/R = slope, 1 − B = surface, slope = surface (λ coth λR − 1/R).
                let lambda = rate.sqrt();
                let slope = lambda / (lambda * radius).tanh() - 1.0 / radius;
                let b = slope / (ratio / radius + slope);
                let exact = move |at: [f64; 3], _: f64| {
                    let r = arm(at).norm();
                    match r > radius {
                        true => 1.0 - b * radius / r,
                        false => (1.0 - b) * (lambda * r).sinh() / (lambda * radius).sinh() * radius / r.max(1e-9),
                    }
                };
                let setup = scalar(ratio, exact, SolidCondition::Interior(interior));
                let initial = move |at| exact(at, 0.0);
                let mut scene = still(n, (&Shape::sphere(radius).unwrap(), CENTER.into()), setup, initial);
                let h = 2.0 / n as f64;
                let dt = h * h / ratio.max(1.0);
                let steps = settle(&mut scene, dt, 1e-7);
                let errors = errors(&scene, |at| Some(exact(at, 0.0)));
                let before = only(&scene).reacted[0];
                scene.flow.step_scalars(dt, &SERIAL).unwrap();
                let reacted = (only(&scene).reacted[0] - before) / dt;
                let error = reacted / (ratio * 4.0 * PI * radius * b) - 1.0;
                println!("{ratio} {thiele} {n}: {steps} steps, {error:.2e} {errors:?}");
                found.push(error.abs());
            }
            println!("{thiele} order {:?}", order(found[0], found[1], 2.0));
        }
    }
}

#[test]
fn zz_bounded() {
    let radius = 0.4;
    for (name, condition) in [
        ("transparent", SolidCondition::Interior(Interior { capacity: 1.0, diffusivity: 1.0, reaction: None })),
        ("value", SolidCondition::Value(ScalarValue::Uniform(1.0))),
    ] {
        for number in [0.2, 0.5, 1.0, 2.0] {
            let n = 20;
            let is_value = name == "value";
            let exact = move |at: [f64; 3], _: f64| if is_value { radius / arm(at).norm() } else { at[0] + 0.3 * at[1] * at[2] };
            let mut setup = scalar(1.0, exact, condition.clone());
            setup.scheme = Scheme::Bounded;
            let mut scene = still(n, (&Shape::sphere(radius).unwrap(), CENTER.into()), setup, |_| 0.5);
            let h = 2.0 / n as f64;
            println!("{name} {number}");
            let steps = settle(&mut scene, number * h * h, 1e-8);
            println!("{steps}");
        }
    }
}
