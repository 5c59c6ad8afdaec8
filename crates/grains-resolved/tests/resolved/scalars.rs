//! Scalars about bodies and in them: exact solutions and orders, and what is kept.

use crate::common::{CUBIC, QUADRATIC, Scene, body, order};
use grains_domain::{SerialTransport, Transport};
use grains_fluid::{
    Axis, Drive, FlowSetup, Grid, Interior, Scalar, ScalarBoundaries, ScalarCondition, ScalarSetup,
    ScalarValue, Scheme, SolidCondition, SolidConditions, SolidReaction,
};
use grains_geometry::{Shape, Vec3};
use grains_testing::on_ranks;
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
        scheme: Scheme::Central,
        boundaries: ScalarBoundaries { faces: [0, 1, 2, 3, 4, 5].map(face), patches: Vec::new() },
        solids: SolidConditions { bodies, ..SolidConditions::default() },
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
    scene.resolved.place_for_scalars((&scene.shapes, &[]), &[vec![]], &mut scene.flow, &SERIAL);
    scene.flow.begin_scalars(|_| true);
    scene
}

fn only(scene: &Scene) -> &Scalar {
    &scene.flow.scalars.as_ref().unwrap().all[0]
}

/// Marches until nothing changes by more than a tolerance in a step.
fn settle(scene: &mut Scene, dt: f64, tolerance: f64) {
    for step in 1..6000 {
        let before = only(scene).value.clone();
        scene.flow.step_scalars(dt, &SERIAL).unwrap();
        let change =
            only(scene).value.own().zip(before.own()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(change.is_finite(), "step {step}");
        if change < tolerance {
            return;
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

/// Fluxes out of a body and reacted amounts over a step.
fn rates(scene: &mut Scene, dt: f64) -> [f64; 2] {
    scene.flow.step_scalars(dt, &SERIAL).unwrap();
    [only(scene).gained[0] / dt, only(scene).reacted[0] / dt]
}

#[test]
fn a_sphere_of_a_given_value_conducts_in_second_order() {
    let radius = 0.4;
    for scheme in [Scheme::Central, Scheme::Bounded] {
        let mut found = Vec::new();
        for n in [20, 40] {
            let exact = move |at: [f64; 3], _: f64| radius / arm(at).norm();
            let setup = scalar(1.0, exact, SolidCondition::Value(ScalarValue::Uniform(1.0)));
            let setup = ScalarSetup { scheme, ..setup };
            let mut scene = still(n, (&Shape::sphere(radius).unwrap(), CENTER.into()), setup, |_| 0.5);
            let dt = 2.0 * (2.0 / n as f64).powi(2);
            settle(&mut scene, dt, 1e-8);
            let [_, mean] = errors(&scene, |at| (arm(at).norm() > radius).then(|| exact(at, 0.0)));
            let [flux, _] = rates(&mut scene, dt);
            let error = flux / (4.0 * PI * radius) - 1.0;
            println!("{scheme:?} {n}: mean error {mean:.2e}, flux {error:.2e}");
            found.push([mean, error.abs()]);
        }
        // 16 cells across.
        assert!(found[1][1] < 3e-3, "{found:?}");
        assert!((0..2).all(|k| order(found[0][k], found[1][k], 2.0) > 1.8), "{found:?}");
    }
}

#[test]
fn a_sphere_that_conducts_bends_a_gradient_in_second_order() {
    let (radius, along) = (0.4, Vec3::new(0.5, -0.3, 0.8).normalize());
    // Conductivity over that of the fluid; the last one would take long on the finer grid.
    for (ratio, order_wanted) in [(0.0, 1.5), (0.1, 1.5), (4.0, 1.8)] {
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
            let interior = Interior { capacity: 1.0, diffusivity: ratio, reaction: None };
            let condition =
                if ratio > 0.0 { SolidCondition::Interior(interior) } else { SolidCondition::default() };
            let setup = scalar(1.0, exact, condition);
            let sphere = Shape::sphere(radius).unwrap();
            let mut scene = still(n, (&sphere, CENTER.into()), setup, |at| arm(at).dot(&along));
            let h = 2.0 / n as f64;
            settle(&mut scene, h * h / ratio.max(1.0), 1e-7);
            let [_, mean] =
                errors(&scene, |at| (ratio > 0.0 || arm(at).norm() > radius).then(|| exact(at, 0.0)));
            println!("{ratio} {n}: mean error {mean:.2e}");
            found.push(mean);
        }
        assert!(order(found[0], found[1], 2.0) > order_wanted, "{ratio}: {found:?}");
    }
}

/// With the partition coefficient K, the concentration inside is K φ: outside 1 − B R/r, inside S sinh(λ r)/sinh(λ R) R/r.
#[test]
fn a_reaction_in_a_sphere_takes_what_diffuses_to_it() {
    let radius = 0.4;
    for (ratio, thiele, partition) in [(0.1, 0.3, 1.0), (1.0, 3.0, 0.5), (20.0, 1.0, 2.0)] {
        let mut found = Vec::new();
        for n in [20, 40] {
            // Thiele modulus R/3 √(k/D) with D = 1; fluid of a diffusivity `ratio`.
            let rate: f64 = (3.0_f64 * thiele / radius).powi(2);
            let reaction = Some(SolidReaction { rate, order: 1.0 });
            let interior = Interior { capacity: partition, diffusivity: 1.0, reaction };
            let lambda = rate.sqrt();
            let slope = partition * (lambda / (lambda * radius).tanh() - 1.0 / radius);
            let b = slope / (ratio / radius + slope);
            let exact = move |at: [f64; 3], _: f64| {
                let r = arm(at).norm();
                match r > radius {
                    true => 1.0 - b * radius / r,
                    false => (1.0 - b) * (lambda * r).sinh() / (lambda * radius).sinh() * radius / r,
                }
            };
            let setup = scalar(ratio, exact, SolidCondition::Interior(interior));
            let initial = move |at| exact(at, 0.0);
            let mut scene = still(n, (&Shape::sphere(radius).unwrap(), CENTER.into()), setup, initial);
            let h = 2.0 / n as f64;
            let dt = h * h / ratio.max(1.0);
            settle(&mut scene, dt, 1e-7);
            let [_, reacted] = rates(&mut scene, dt);
            let error = reacted / (ratio * 4.0 * PI * radius * b) - 1.0;
            println!("{ratio} {thiele} {partition} {n}: {error:.2e}");
            found.push(error.abs());
        }
        assert!(found[1] < 0.02, "{found:?}");
        // Errors of two kinds may all but cancel.
        let is_small = found[1] < 2e-3;
        assert!(is_small || order(found[0], found[1], 2.0) > 1.5, "{ratio} {thiele}: {found:?}");
    }
}

/// Closed forms of Thiele's modulus V/A √(k/D).
#[test]
fn without_a_film_the_effectiveness_is_that_of_the_closed_forms() {
    let radius = 0.4;
    let sphere = |m: f64| (1.0 / (3.0 * m).tanh() - 1.0 / (3.0 * m)) / m;
    for thiele in [0.2, 1.0, 3.0_f64] {
        let mut found = Vec::new();
        for n in [20, 40] {
            let rate = (3.0 * thiele / radius).powi(2);
            let reaction = Some(SolidReaction { rate, order: 1.0 });
            let interior = Interior { capacity: 0.7, diffusivity: 1.0, reaction };
            let mut setup = scalar(1.0, |_, _| 2.0, SolidCondition::Interior(interior));
            setup.solids.no_film = Some(2.0);
            let mut scene = still(n, (&Shape::sphere(radius).unwrap(), CENTER.into()), setup, |_| 2.0);
            let dt = 4.0 / (n * n) as f64;
            settle(&mut scene, dt, 1e-7);
            let [_, reacted] = rates(&mut scene, dt);
            let volume = 4.0 / 3.0 * PI * radius.powi(3);
            let error = reacted / (rate * 0.7 * 2.0 * volume) / sphere(thiele) - 1.0;
            let scalars = scene.flow.scalars.as_ref().unwrap();
            let lost = scalars.content(0) - scalars.all[0].entered - scalars.all[0].produced;
            assert!(lost.abs() < 1e-12, "{lost}");
            println!("{thiele} {n}: {error:.2e}");
            found.push(error.abs());
        }
        // 16 cells across.
        assert!(found[1] < if thiele < 2.0 { 0.01 } else { 0.03 }, "{thiele}: {found:?}");
    }
}

#[test]
fn reactions_of_any_order_take_k_times_the_power_of_what_is_there() {
    for reaction_order in [0.0, 0.5, 1.0, 2.0] {
        let reaction = Some(SolidReaction { rate: 1e-4, order: reaction_order });
        let interior = Interior { capacity: 3.0, diffusivity: 10.0, reaction };
        let setup = scalar(1.0, |_, _| 2.0, SolidCondition::Interior(interior));
        let sphere = Shape::sphere(0.5).unwrap();
        let mut scene = still(16, (&sphere, CENTER.into()), setup, |_| 2.0);
        settle(&mut scene, 2e-3, 1e-9);
        let [_, reacted] = rates(&mut scene, 2e-3);
        // The concentration is 6 in all of it.
        let volume = scene.flow.scalars.as_ref().unwrap().content_of_solids(0)[0] / 6.0;
        assert!((volume / (4.0 / 3.0 * PI * 0.125) - 1.0).abs() < 0.02, "{volume}");
        let wanted = 1e-4 * 6.0_f64.powf(reaction_order) * volume;
        assert!((reacted / wanted - 1.0).abs() < 2e-3, "{reaction_order}: {reacted} {wanted}");
    }
}

/// Schwarz et al. (2006): a disc that shrinks or grows in a heat kernel, with the value of the kernel on its edge.
#[test]
fn about_a_disc_that_changes_its_size_heat_spreads_in_second_order() {
    let exact = |[x, y, _]: [f64; 3], t: f64| {
        4.0 / (5.0 * PI * (t + 1.0)) * (-(x * x + y * y) / (5.0 * (t + 1.0))).exp()
    };
    for growth in [-1.0, 1.0] {
        let mut found = Vec::new();
        for n in [16, 32, 64] {
            let axis = || Axis::uniform(-1.0, 1.0, n, false);
            let grid = Grid::new([axis(), axis(), Axis::uniform(0.0, 1.0, 1, true)]).unwrap();
            let disc = Shape::cylinder(0.392, 2.0, 0.02).unwrap();
            let place = body(0, Vec3::new(0.0, 0.0, 0.5));
            let flow = FlowSetup::new(grid, 1.0, 1.0);
            let mut scene = Scene::new(&flow, [1; 3], (&disc, &[place]), CUBIC, &SERIAL);
            let setup = scalar(1.25, exact, SolidCondition::Value(function(exact)));
            scene.flow.add_scalar(setup, |at| exact(at, 0.0), &SERIAL);
            let steps = n * n / 64;
            let (end, mut kept) = (0.1, 0.0_f64);
            let dt = end / steps as f64;
            for step in 0..=steps {
                scene.own[0].scale = 1.0 + growth * step as f64 * dt / 0.392;
                scene.place(&SERIAL);
                scene.resolved.place_for_scalars((&scene.shapes, &[]), &[vec![]], &mut scene.flow, &SERIAL);
                scene.flow.pass_solids(&SERIAL);
                if step == 0 {
                    scene.flow.begin_scalars(|_| true);
                } else {
                    scene.flow.step_scalars(dt, &SERIAL).unwrap();
                }
                let scalars = scene.flow.scalars.as_ref().unwrap();
                kept = kept.max((scalars.content(0) - scalars.all[0].entered).abs());
            }
            let radius = 0.392 + growth * end;
            let h = 2.0 / n as f64;
            let mut sum = [0.0; 2];
            for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
                let at = [-1.0 + (i as f64 + 0.5) * h, -1.0 + (j as f64 + 0.5) * h, 0.0];
                if at[0].hypot(at[1]) > radius {
                    let error = only(&scene).value.at(i as isize, j as isize, 0) - exact(at, end);
                    sum = [sum[0] + error.abs(), sum[1] + 1.0];
                }
            }
            println!("{growth} {n}: {:.2e}, unaccounted {kept:.1e}", sum[0] / sum[1]);
            assert!(kept < 1e-12);
            found.push(sum[0] / sum[1]);
        }
        assert!(order(found[0], found[2], 4.0) > 1.8, "{growth}: {found:?}");
    }
}

/// Bodies that lie at random in a periodic flow which drives the free ones; scalars of all conditions.
fn among_bodies(shape: &Shape, moves: bool, ranks: [usize; 3], transport: &dyn Transport) -> Scene {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [16; 3], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 0.05);
    setup.drive[0] = Drive::MeanVelocity(0.4);
    let mut bodies = [
        body(1, Vec3::new(0.27, 0.31, 0.68)),
        body(2, Vec3::new(0.71, 0.64, 0.33)),
        body(3, Vec3::new(0.02, 0.93, 0.97)),
    ];
    for (k, body) in bodies.iter_mut().enumerate() {
        let turn = grains_geometry::Rotation::from_euler_angles(0.4 + k as f64, 0.7, 1.9 * k as f64);
        body.rotation = turn.to_rotation_matrix().into_inner();
    }
    let forcing = if moves { QUADRATIC } else { CUBIC };
    let mut scene = Scene::new(&setup, ranks, (shape, &bodies), forcing, transport);
    scene.flow.initialise(|[_, y, z]| [0.4 + 0.2 * (2.0 * PI * (y + z)).sin(), 0.1, 0.0], |_| 0.0, transport);
    let interior =
        Interior { capacity: 2.5, diffusivity: 0.3, reaction: Some(SolidReaction { rate: 2.0, order: 1.0 }) };
    let conditions = match moves {
        true => vec![SolidCondition::Value(ScalarValue::Uniform(1.0)), SolidCondition::OfSolid],
        false => vec![
            SolidCondition::Value(ScalarValue::Uniform(1.0)),
            SolidCondition::default(),
            SolidCondition::Interior(Interior { reaction: None, ..interior }),
            SolidCondition::Interior(interior),
        ],
    };
    for (k, condition) in conditions.into_iter().enumerate() {
        // The last one is what is not uniform.
        let is_uneven = moves == (k == 1) && (moves || k == 3);
        let mut setup = scalar(0.02, |_, _| 0.0, condition);
        setup.boundaries = ScalarBoundaries::default();
        setup.scheme = Scheme::Bounded;
        let value = move |[x, _, z]: [f64; 3]| {
            if is_uneven { 1.0 + (2.0 * PI * (x - z)).sin() } else { 1.0 }
        };
        scene.flow.add_scalar(setup, value, transport);
    }
    place(&mut scene, transport);
    scene.flow.begin_scalars(|_| true);
    scene
}

fn place(scene: &mut Scene, transport: &dyn Transport) {
    let count = scene.flow.scalars.as_ref().unwrap().all.len();
    let values = vec![vec![0.5; scene.own.len()]; count];
    scene.resolved.place_for_scalars((&scene.shapes, &[]), &values, &mut scene.flow, transport);
    scene.flow.pass_solids(transport);
}

/// What is uniform stays so, what is not stays within its limits, and all of it is accounted for, past bodies of any shape that stay or
/// move, on any ranks.
#[test]
fn scalars_keep_sums_and_limits_past_bodies_of_any_shape_on_any_ranks() {
    let shapes = [
        Shape::sphere(0.2).unwrap(),
        Shape::cuboid(Vec3::new(0.3, 0.24, 0.36), 0.02).unwrap(),
        Shape::cylinder(0.14, 0.34, 0.02).unwrap(),
    ];
    for (shape, moves) in shapes.iter().flat_map(|shape| [(shape, false), (shape, true)]) {
        let mut wanted: Option<Vec<f64>> = None;
        for ranks in [[1; 3], [2, 1, 2]] {
            let found = on_ranks(ranks.iter().product(), |transport| {
                let mut scene = among_bodies(shape, moves, ranks, &transport);
                for _ in 0..12 {
                    match moves {
                        // Placed before the flow goes on: bodies and scalars are where they are in the step.
                        true => {
                            scene.own.iter_mut().for_each(|body| body.center += body.velocity * 0.01);
                            scene.place(&transport);
                            place(&mut scene, &transport);
                            scene.own.iter_mut().for_each(|body| body.center -= body.velocity * 0.01);
                            scene.move_freely((0.1, 4e-4, 2.0), Vec3::zeros(), 0.01, &transport);
                        }
                        false => scene.step(0.01, &transport),
                    }
                    let scalars = scene.flow.scalars.as_ref().unwrap();
                    for (k, scalar) in scalars.all.iter().enumerate() {
                        let mut lost = [scalars.content(k) - scalar.entered - scalar.produced];
                        transport.sum(&mut lost);
                        assert!(lost[0].abs() < 1e-12, "{k}: {lost:?}");
                        let ([_, _], [low, high]) = scalars.sums(k);
                        let is_uneven = k == if moves { 1 } else { 3 };
                        let (least, most) =
                            if is_uneven { (-1e-12, 2.0 + 1e-12) } else { (1.0 - 1e-9, 1.0 + 1e-9) };
                        assert!(low >= least && high <= most, "{moves} {k}: {low} {high}");
                    }
                }
                let scalars = scene.flow.scalars.as_ref().unwrap();
                let mut sums: Vec<f64> = (0..scalars.all.len()).map(|k| scalars.content(k)).collect();
                sums.extend(scalars.all.iter().map(|scalar| scalar.reacted.iter().sum::<f64>()));
                transport.sum(&mut sums);
                sums
            });
            let found = found.into_iter().next().unwrap();
            match &wanted {
                None => wanted = Some(found),
                Some(wanted) => {
                    for (a, b) in wanted.iter().zip(&found) {
                        assert!((a - b).abs() < 1e-9 * (1.0 + a.abs()), "{wanted:?} {found:?}");
                    }
                }
            }
        }
    }
}
