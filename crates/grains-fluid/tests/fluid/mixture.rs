//! Fluid among particles: manufactured solution, limits, drag.

use crate::common::{difference, order};
use grains_domain::SerialTransport;
use grains_fluid::{Boundaries, Condition, Drive, Faces, Flow, FlowSetup, Grid, MixtureModel, Profile, Side};
use std::f64::consts::PI;

const SERIAL: SerialTransport = SerialTransport;
const NU: f64 = 0.05;
const OMEGA: f64 = 1.3;

/// Fields of the manufactured solution (reference: ε = 0.6 + 0.2 cos x cos y sin ωt, ε u = q, ρ = 1).
#[derive(Clone, Copy)]
struct Made {
    eps: f64,
    q: [f64; 2],
    p: f64,
}

fn made([x, y]: [f64; 2], t: f64) -> Made {
    let (a, b) = (t.cos(), 0.1 * OMEGA * (OMEGA * t).cos());
    Made {
        eps: 0.6 + 0.2 * x.cos() * y.cos() * (OMEGA * t).sin(),
        q: [a * x.sin() * y.cos() - b * x.sin() * y.cos(), -a * x.cos() * y.sin() - b * x.cos() * y.sin()],
        p: x.sin() * y.sin() * t.cos(),
    }
}

/// Source of the momentum equation, by differences of high order of the exact fields.
fn momentum_source(component: usize, at: [f64; 2], t: f64, model: MixtureModel) -> f64 {
    let derivative = |f: &dyn Fn([f64; 2]) -> f64, axis: usize, at: [f64; 2]| {
        const H: f64 = 2e-2;
        let weights = [(1.0, 0.8), (2.0, -0.2), (3.0, 4.0 / 105.0), (4.0, -1.0 / 280.0)];
        let sum: f64 = weights
            .iter()
            .map(|(steps, weight)| {
                let (mut low, mut high) = (at, at);
                low[axis] -= steps * H;
                high[axis] += steps * H;
                weight * (f(high) - f(low))
            })
            .sum();
        sum / H
    };
    let q = |b: usize| move |at: [f64; 2]| made(at, t).q[b];
    let u = |b: usize| move |at: [f64; 2]| made(at, t).q[b] / made(at, t).eps;
    let rate = (made(at, t + 1e-4).q[component] - made(at, t - 1e-4).q[component]) / 2e-4;
    let mut sum = rate;
    for b in 0..2 {
        sum += derivative(&|at| q(b)(at) * u(component)(at), b, at);
        let stress = |at: [f64; 2]| {
            let strain = derivative(&u(component), b, at) + derivative(&u(b), component, at);
            NU * made(at, t).eps * strain
        };
        sum -= derivative(&stress, b, at);
    }
    let factor = if model == MixtureModel::A { made(at, t).eps } else { 1.0 };
    sum + factor * derivative(&|at| made(at, t).p, component, at)
}

/// Velocity and pressure errors at t = 0.25 and the largest mass residual (1/s).
///
/// The void fraction's rate is a backward difference, of first order: steps fall with h².
fn made_errors(n: usize, model: MixtureModel) -> [f64; 3] {
    let grid = Grid::uniform([0.0; 3], [2.0 * PI, 2.0 * PI, 1.0], [n, n, 1], [true; 3]).unwrap();
    let mut flow =
        Flow::new(FlowSetup { mixture: Some(model), ..FlowSetup::new(grid, 1.0, NU) }, &SERIAL).unwrap();
    let exact = |at: [f64; 3], t: f64| made([at[0], at[1]], t);
    flow.initialise(
        |at| {
            let m = exact(at, 0.0);
            [m.q[0] / m.eps, m.q[1] / m.eps, 0.0]
        },
        |at| exact(at, 0.0).p,
        &SERIAL,
    );
    let (h, cells) = (2.0 * PI / n as f64, n as isize);
    let steps = n * n / 12;
    let dt = 0.25 / steps as f64;
    let centre = |i: isize| (i as f64 + 0.5) * h;
    let face = |i: isize| (i + 1) as f64 * h;
    let set_void = |flow: &mut Flow, t: f64| {
        let mixture = flow.mixture.as_mut().unwrap();
        for j in 0..cells {
            for i in 0..cells {
                mixture.void_fraction.set(i, j, 0, made([centre(i), centre(j)], t).eps);
            }
        }
    };
    set_void(&mut flow, 0.0);
    flow.mixture.as_mut().unwrap().begin();
    let mut residual = 0.0_f64;
    for _ in 0..steps {
        let (now, middle) = (flow.state.time + dt, flow.state.time + 0.5 * dt);
        set_void(&mut flow, now);
        let mixture = flow.mixture.as_mut().unwrap();
        for j in 0..cells {
            for i in 0..cells {
                mixture.source.x.set(i, j, 0, momentum_source(0, [face(i), centre(j)], middle, model));
                mixture.source.y.set(i, j, 0, momentum_source(1, [centre(i), face(j)], middle, model));
            }
        }
        flow.step(dt, &SERIAL).unwrap();
        residual = residual.max(flow.divergence(&SERIAL)[0]);
    }
    let (t, mut sums) = (flow.state.time, [0.0; 2]);
    let (mut mean, mut exact_mean) = (0.0, 0.0);
    for j in 0..cells {
        for i in 0..cells {
            mean += flow.state.pressure.at(i, j, 0);
            exact_mean += made([centre(i), centre(j)], t - 0.5 * dt).p;
        }
    }
    let shift = (exact_mean - mean) / (n * n) as f64;
    for j in 0..cells {
        for i in 0..cells {
            let m = made([face(i), centre(j)], t);
            sums[0] += (flow.state.velocity.x.at(i, j, 0) - m.q[0] / m.eps).powi(2);
            let p = made([centre(i), centre(j)], t - 0.5 * dt).p;
            sums[1] += (flow.state.pressure.at(i, j, 0) + shift - p).powi(2);
        }
    }
    [sums[0].sqrt() / n as f64, sums[1].sqrt() / n as f64, residual]
}

#[test]
fn manufactured_porosity_is_of_order_two() {
    for model in [MixtureModel::A, MixtureModel::B] {
        let sizes = [10, 16, 26];
        let errors = sizes.map(|n| made_errors(n, model));
        for (pair, n) in errors.windows(2).zip(sizes.windows(2)) {
            let ratio = n[1] as f64 / n[0] as f64;
            let [velocity, pressure] = [0, 1].map(|f| order(pair[0][f], pair[1][f], ratio));
            assert!((velocity - 2.0).abs() < 0.1, "{model:?} {velocity}: {errors:?}");
            assert!((pressure - 2.0).abs() < 0.25, "{model:?} {pressure}: {errors:?}");
        }
        assert!(errors.iter().all(|e| e[2] < 1e-9), "{errors:?}");
    }
}

/// A lid cavity in three dimensions after some steps.
fn cavity(mixture: Option<MixtureModel>, eps: f64) -> Flow {
    let lid = Condition::Wall { velocity: [1.0, 0.0, 0.0] };
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [12, 10, 8], [false, false, true]).unwrap();
    let boundaries = Boundaries::default().with(1, Side::High, lid);
    let setup = FlowSetup { boundaries, mixture, ..FlowSetup::new(grid, 1.3, 0.02) };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    if let Some(mixture) = &mut flow.mixture {
        mixture.void_fraction.fill(eps);
        mixture.begin();
    }
    for _ in 0..20 {
        flow.step(0.02, &SERIAL).unwrap();
    }
    flow
}

#[test]
fn a_uniform_void_fraction_is_a_single_phase() {
    let single = cavity(None, 1.0);
    for model in [MixtureModel::A, MixtureModel::B] {
        for eps in [1.0, 0.4] {
            let mixed = cavity(Some(model), eps);
            for axis in 0..3 {
                let [a, b] = [&single, &mixed].map(|f| f.state.velocity.component(axis).to_vec());
                let error = difference(&a, &b);
                assert!(error < 1e-9, "{model:?} {eps} axis {axis}: {error:.2e}");
            }
            // Model A shares the pressure gradient with the particles, model B bears ε times the stress alone.
            let factor = if model == MixtureModel::A { 1.0 } else { 1.0 / eps };
            let [a, b]: [Vec<f64>; 2] = [&single, &mixed].map(|f| f.state.pressure.own().collect());
            let scaled: Vec<f64> = b.iter().map(|p| p * factor).collect();
            assert!(difference(&a, &scaled) < 1e-7, "{model:?} {eps}: {:.2e}", difference(&a, &scaled));
        }
    }
}

/// Column along x with an inlet and an outlet; drag and void fraction by cell.
fn column(model: MixtureModel, n: usize, speed: f64) -> Flow {
    let grid = Grid::uniform([0.0; 3], [1.0, 0.2, 0.2], [n, 3, 3], [false; 3]).unwrap();
    let profile = Profile::Uniform([speed, 0.0, 0.0]);
    let boundaries = Boundaries::all(Condition::Symmetry)
        .with(0, Side::Low, Condition::Inlet { profile })
        .with(0, Side::High, Condition::Outlet { pressure: 0.0 });
    let setup = FlowSetup { boundaries, mixture: Some(model), ..FlowSetup::new(grid, 1.2, 1.8e-5) };
    Flow::new(setup, &SERIAL).unwrap()
}

fn fill_drag(drag: &mut Faces, beta: impl Fn(usize) -> f64) {
    let layout = drag.layout();
    let dims = layout.dims();
    for axis in 0..3 {
        for (p, value) in drag.component_mut(axis).iter_mut().enumerate() {
            *value = beta((p % dims[0]).saturating_sub(layout.halo));
        }
    }
}

#[test]
fn stiff_drag_is_stable_and_its_pressure_drop_exact() {
    // β of a packed bed: the relaxation time ρ ε/β is far below the step.
    let (eps, beta, q) = (0.4, 4e4, 0.5);
    for model in [MixtureModel::A, MixtureModel::B] {
        // The velocity of the inlet is superficial, also where the bed begins right behind it.
        let mut flow = column(model, 20, q);
        let mixture = flow.mixture.as_mut().unwrap();
        mixture.void_fraction.fill(eps);
        mixture.begin();
        fill_drag(&mut mixture.drag, |_| beta);
        for _ in 0..50 {
            flow.step(1e-3, &SERIAL).unwrap();
        }
        let slope = (flow.mean_pressure(0, 15, &SERIAL) - flow.mean_pressure(0, 5, &SERIAL)) / 0.5;
        let wanted = -beta * q / eps / if model == MixtureModel::A { eps } else { 1.0 };
        assert!((slope / wanted - 1.0).abs() < 1e-6, "{model:?}: {slope} {wanted}");
        assert!((flow.state.velocity.x.at(10, 1, 1) - q / eps).abs() < 1e-9);
    }
}

#[test]
fn the_pressure_jumps_by_bernoulli_where_the_void_fraction_does() {
    let (n, q, eps) = (40, 2.0, 0.4);
    let mut flow = column(MixtureModel::B, n, q);
    let mixture = flow.mixture.as_mut().unwrap();
    for k in 0..3 {
        for j in 0..3 {
            for i in n / 2..n {
                mixture.void_fraction.set(i as isize, j, k, eps);
            }
        }
    }
    mixture.begin();
    for _ in 0..3000 {
        flow.step(2e-3, &SERIAL).unwrap();
    }
    let rate = flow.flow_rate(0, n, &SERIAL) / 0.04;
    assert!((rate - q).abs() < 1e-9, "{rate}");
    let jump = flow.mean_pressure(0, n - 5, &SERIAL) - flow.mean_pressure(0, 5, &SERIAL);
    let wanted = -1.2 * q * q * (1.0 / eps - 1.0);
    assert!((jump / wanted - 1.0).abs() < 1e-3, "{jump} {wanted}");
}

#[test]
fn drag_relaxes_a_uniform_flow_to_the_particles() {
    // ρ ε du/dt = −β (u − U): backward Euler in the drag.
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [4; 3], [true; 3]).unwrap();
    let setup = FlowSetup {
        mixture: Some(MixtureModel::A),
        drive: [Drive::None; 3],
        ..FlowSetup::new(grid, 2.0, 1e-3)
    };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    flow.initialise(|_| [1.0, 0.0, 0.0], |_| 0.0, &SERIAL);
    let (eps, beta, particle, dt) = (0.7, 300.0, 0.25, 0.01);
    let mixture = flow.mixture.as_mut().unwrap();
    mixture.void_fraction.fill(eps);
    mixture.begin();
    mixture.drag.fill(beta);
    mixture.source.x.fill(beta * particle);
    let mut expected = 1.0;
    for _ in 0..5 {
        flow.step(dt, &SERIAL).unwrap();
        expected = (2.0 * eps / dt * expected + beta * particle) / (2.0 * eps / dt + beta);
    }
    assert!((flow.state.velocity.x.at(1, 1, 1) - expected).abs() < 1e-12);
}

#[test]
fn an_impossible_void_fraction_names_its_cell() {
    let mut flow = column(MixtureModel::A, 10, 0.1);
    flow.mixture.as_mut().unwrap().void_fraction.set(4, 2, 1, -0.1);
    let error = flow.step(1e-3, &SERIAL).unwrap_err();
    assert!(error.to_string().contains("void fraction -0.1000 in cell [4, 2, 1]"), "{error}");
}

#[test]
fn a_closed_or_periodic_box_stands_the_rounding_of_its_void_fraction_and_no_more() {
    for periodic in [[false; 3], [true, false, true], [true; 3]] {
        for model in [MixtureModel::A, MixtureModel::B] {
            let grid = Grid::uniform([0.0; 3], [0.02, 0.02, 0.03], [6, 6, 9], periodic).unwrap();
            let setup = FlowSetup { mixture: Some(model), ..FlowSetup::new(grid, 1000.0, 1e-3) };
            let mut flow = Flow::new(setup, &SERIAL).unwrap();
            let mut state = 7_u64;
            let mut random = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 11) as f64 / 2.0_f64.powi(53)
            };
            let cells: Vec<[isize; 3]> = (0..6 * 6 * 9).map(|n| [n % 6, n / 6 % 6, n / 36]).collect();
            let eps: Vec<f64> = cells.iter().map(|_| 0.4 + 0.6 * random()).collect();
            let set = |flow: &mut Flow, change: &mut dyn FnMut(f64) -> f64| {
                let mixture = flow.mixture.as_mut().unwrap();
                for (&[i, j, k], &eps) in cells.iter().zip(&eps) {
                    mixture.void_fraction.set(i, j, k, change(eps));
                }
            };
            set(&mut flow, &mut |eps| eps);
            flow.mixture.as_mut().unwrap().begin();
            for _ in 0..20 {
                // Deposited anew, in another order: the last two digits differ.
                set(&mut flow, &mut |eps| eps * (1.0 + 4.4e-16 * (random() - 0.5)));
                flow.step(2e-5, &SERIAL).unwrap();
            }
            // A particle of a millionth of the volume that comes from nowhere.
            set(&mut flow, &mut |eps| eps - 1e-6);
            let refused = flow.step(2e-5, &SERIAL).unwrap_err().to_string();
            assert!(refused.contains("declare an outlet"), "{refused}");
        }
    }
}
