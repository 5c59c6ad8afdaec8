//! Flows averaged over particles, bounded by walls that cut cells.

use crate::common::order;
use grains_domain::SerialTransport;
use grains_fluid::{
    Boundaries, BoxFace, Clearance, Condition, Drive, Flow, FlowSetup, Grid, MixtureModel, Profile, Side,
};
use std::f64::consts::PI;

const SERIAL: SerialTransport = SerialTransport;
const VISCOSITY: f64 = 0.1;

/// Inside a tube of a radius (m) along an axis, about a middle (m).
fn tube(axis: usize, middle: [f64; 3], radius: f64) -> impl Fn([f64; 3]) -> Clearance {
    move |at| {
        let off: [f64; 3] = std::array::from_fn(|a| if a == axis { 0.0 } else { at[a] - middle[a] });
        let distance = off.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = if distance > 0.0 { off.map(|x| -x / distance) } else { [0.0, 1.0, 0.0] };
        Clearance { distance: radius - distance, direction }
    }
}

/// Between two planes normal to y, a distance (m) on either side of a middle (m).
fn slot(middle: [f64; 3], half: f64) -> impl Fn([f64; 3]) -> Clearance {
    move |at| {
        let off = at[1] - middle[1];
        Clearance { distance: half - off.abs(), direction: [0.0, -off.signum(), 0.0] }
    }
}

/// Steps until nothing changes by more than a share of the largest.
fn settle(flow: &mut Flow, dt: f64) {
    let mut before = 0.0;
    for _ in 0..2000 {
        flow.step(dt, &SERIAL).unwrap();
        let energy = flow.kinetic_energy(&SERIAL);
        if (energy - before).abs() < 1e-9 * energy {
            return;
        }
        before = energy;
    }
    panic!("no steady state");
}

/// Error of the mean velocity along x of a tube or slot that cuts n² cells, over the exact one.
fn error(n: usize, clearance: &dyn Fn([f64; 3]) -> Clearance, exact: f64, model: MixtureModel) -> f64 {
    let grid = Grid::uniform([0.0; 3], [0.5, 1.0, 1.0], [2, n, n], [true, false, false]).unwrap();
    let mut drive = [Drive::None; 3];
    drive[0] = Drive::PressureGradient(-1.0);
    let setup = FlowSetup { mixture: Some(model), drive, ..FlowSetup::new(grid, 1.0, VISCOSITY) };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    flow.enclose(clearance, &SERIAL).unwrap();
    settle(&mut flow, 0.05);
    flow.flow_rate(0, 1, &SERIAL) / exact - 1.0
}

#[test]
fn poiseuille_flow_converges_whatever_cells_the_wall_cuts() {
    let radius = 0.413_f64;
    let in_tube = PI * radius.powi(4) / (8.0 * VISCOSITY);
    for model in [MixtureModel::A, MixtureModel::B] {
        let tube = tube(0, [0.0, 0.507, 0.489], radius);
        let errors = [12, 24, 48].map(|n| error(n, &tube, in_tube, model));
        println!("tube, model {model:?}: {errors:?}");
        assert!(order(errors[0].abs(), errors[2].abs(), 4.0) > 1.8, "{errors:?}");
        assert!(errors[2].abs() < 4e-3, "{errors:?}");
    }
    for half in [0.31, 0.3517] {
        let slot = slot([0.0, 0.4921, 0.5], half);
        let errors = [12, 24, 48].map(|n| slot_error(n, &slot, half));
        println!("slot of {half}: {errors:?}");
        assert!(order(errors[0].abs(), errors[2].abs(), 4.0) > 1.8, "{errors:?}");
        assert!(errors[2].abs() < 4e-3, "{errors:?}");
    }
}

/// The same of a slot in two dimensions, flow along x.
fn slot_error(n: usize, clearance: &dyn Fn([f64; 3]) -> Clearance, half: f64) -> f64 {
    let grid = Grid::uniform([0.0; 3], [0.5, 1.0, 1.0], [2, n, 1], [true, false, false]).unwrap();
    let mut drive = [Drive::None; 3];
    drive[0] = Drive::PressureGradient(-1.0);
    let mut boundaries = Boundaries::default();
    for side in [Side::Low, Side::High] {
        boundaries.faces[BoxFace { axis: 2, side }.index()] = Condition::Symmetry;
    }
    let setup = FlowSetup {
        mixture: Some(MixtureModel::A),
        drive,
        boundaries,
        ..FlowSetup::new(grid, 1.0, VISCOSITY)
    };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    flow.enclose(clearance, &SERIAL).unwrap();
    settle(&mut flow, 0.05);
    flow.flow_rate(0, 1, &SERIAL) / (2.0 * half.powi(3) / (3.0 * VISCOSITY)) - 1.0
}

/// Whatever is open, what flows through one section of a tube flows through all, and fills what particles leave.
#[test]
fn as_much_flows_through_every_section_of_a_tube() {
    let n = [10, 11, 16];
    let grid = Grid::uniform([0.0; 3], [1.0, 1.1, 1.6], n, [false; 3]).unwrap();
    let mut boundaries = Boundaries::default();
    let low = BoxFace { axis: 2, side: Side::Low };
    let high = BoxFace { axis: 2, side: Side::High };
    boundaries.faces[low.index()] = Condition::Inlet { profile: Profile::Uniform([0.0, 0.0, 0.7]) };
    boundaries.faces[high.index()] = Condition::Outlet { pressure: 0.0 };
    for model in [MixtureModel::A, MixtureModel::B] {
        let setup = FlowSetup {
            mixture: Some(model),
            boundaries: boundaries.clone(),
            ..FlowSetup::new(grid.clone(), 1.0, 0.01)
        };
        let solver = setup.suitable_solver_to(1e-13, 500, &SERIAL);
        let mut flow = Flow::with_solver(setup, solver, &SERIAL).unwrap();
        flow.enclose(&tube(2, [0.52, 0.55, 0.0], 0.431), &SERIAL).unwrap();
        let open = flow.mixture.as_ref().unwrap().openings.as_ref().unwrap().clone();
        let volume: f64 = open.cells.own().sum::<f64>() * 0.1_f64.powi(3);
        let exact = PI * 0.431_f64.powi(2) * 1.6;
        assert!((volume / exact - 1.0).abs() < 2e-3, "{volume} of {exact}");
        let mut iterations = 0;
        for step in 0..30 {
            let mixture = flow.mixture.as_mut().unwrap();
            for k in 0..n[2] as isize {
                for j in 0..n[1] as isize {
                    for i in 0..n[0] as isize {
                        // Particles that stand still, and a drag.
                        let solid = 0.6 * (0.5 + 0.5 * ((i * 7 + j * 5 + k * 3) % 11) as f64 / 10.0);
                        mixture.void_fraction.set(i, j, k, open.cells.at(i, j, k) * (1.0 - solid));
                    }
                }
            }
            if step == 0 {
                mixture.begin();
            }
            mixture.drag.fill(3.0);
            let report = flow.step(0.02, &SERIAL).unwrap();
            iterations = iterations.max(report.solve.iterations);
            let rates = (0..=n[2]).map(|node| flow.flow_rate(2, node, &SERIAL)).collect::<Vec<_>>();
            for rate in &rates {
                assert!((rate / rates[0] - 1.0).abs() < 1e-10, "{rates:?}");
            }
            let area = 0.7 * PI * 0.431_f64.powi(2);
            assert!((rates[0] / area - 1.0).abs() < 5e-3, "{} for {area}", rates[0]);
            let [divergence, fastest] = flow.divergence(&SERIAL);
            assert!(divergence < 1e-10 * fastest, "{divergence:e} of {fastest}");
        }
        assert!(iterations < 30, "{iterations} iterations for 1e-13 of model {model:?}");
        assert!(flow.state.velocity.z.data().iter().all(|u| u.abs() < 10.0));
    }
}
