//! Time per cell and step of a fluid among particles, and the iterations of its pressure equation.
//!
//! `cargo bench -p grains-fluid --bench mixture_speed -- [tolerance ...] [part of a name ...]`

use grains_domain::SerialTransport;
use grains_fluid::{
    Boundaries, Condition, ConjugateGradients, Flow, FlowSetup, Grid, MixtureModel, Phase, Preconditioner,
    Profile, Side,
};
use std::f64::consts::PI;

const SERIAL: SerialTransport = SerialTransport;
const WIDTH: f64 = 2e-3;
const DIAMETER: f64 = 1e-3;
const SPEED: f64 = 0.9;
const DENSITY: f64 = 1.2;
const VISCOSITY: f64 = 1.8e-5;
const DT: f64 = 1e-4;

/// Void fraction by cell and step.
type VoidFraction = fn([f64; 3], f64) -> f64;

/// A sum of waves of all directions within ±1, different for every step.
fn waves([x, y, z]: [f64; 3], step: f64, shortest: f64) -> f64 {
    let term = |m: u32| {
        let m = f64::from(m);
        let length = shortest * (1.0 + 0.37 * (m % 4.0));
        let [a, b] = [2.399 * m, (1.7 * m).sin()];
        let r = (1.0 - b * b).sqrt();
        let along = x * r * a.cos() + y * r * a.sin() + z * b;
        (2.0 * PI * along / length + 5.1 * m + 0.1 * step).sin()
    };
    ((0..9).map(term).sum::<f64>() / 3.0).clamp(-1.0, 1.0)
}

/// A settled bed in the lowest fifth of 150 cells.
fn flat([_, _, z]: [f64; 3], _: f64) -> f64 {
    if z < 30.0 { 0.4 } else { 1.0 }
}

/// The same with an uneven surface and uneven packing, from cell to cell and beyond.
fn uneven(at: [f64; 3], step: f64) -> f64 {
    let height = 30.0 + 3.0 * waves([at[0], at[1], 0.0], step, 15.0);
    if at[2] < height { 0.42 + 0.04 * waves(at, step, 2.5) } else { 1.0 }
}

/// Bubbles.
fn bubbling(at: [f64; 3], step: f64) -> f64 {
    0.7 + 0.3 * waves(at, step, 8.0)
}

/// Bubbles with sharp edges in a bed of 75 cells below a freeboard.
fn sharp(at: [f64; 3], step: f64) -> f64 {
    let bubble = waves(at, step, 12.0) > 0.35;
    if at[2] < 75.0 && !bubble { 0.42 + 0.02 * waves(at, step, 2.5) } else { 0.97 }
}

/// A suspension.
fn mild(at: [f64; 3], step: f64) -> f64 {
    0.7 + 0.1 * waves(at, step, 10.0)
}

const CASES: [(&str, [usize; 3], VoidFraction); 5] = [
    ("flat bed", [40, 20, 150], flat),
    ("uneven bed", [40, 20, 150], uneven),
    ("bubbling", [40, 20, 150], bubbling),
    ("sharp bubbles", [40, 20, 150], sharp),
    ("mild 64^3", [64; 3], mild),
];

/// Drag coefficient of Ergun per volume of mixture (kg/(m³ s)).
fn ergun(eps: f64) -> f64 {
    let solid = 1.0 - eps;
    150.0 * solid * solid * VISCOSITY / (eps * DIAMETER * DIAMETER)
        + 1.75 * solid * DENSITY * SPEED / DIAMETER
}

fn set_particles(flow: &mut Flow, void: VoidFraction, step: f64) {
    let Some(mixture) = &mut flow.mixture else { return };
    let [nx, ny, nz] = mixture.void_fraction.layout().cells;
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let at = [i as f64, j as f64, k as f64];
                mixture.void_fraction.set(i as isize, j as isize, k as isize, void(at, step));
            }
        }
    }
    let strides = mixture.void_fraction.layout().strides();
    for axis in 0..3 {
        for start in mixture.void_fraction.layout().rows() {
            for p in start..start + nx {
                let eps = mixture.void_fraction.data();
                let mean = 0.5 * (eps[p] + eps[p + strides[axis]]);
                mixture.drag.component_mut(axis)[p] = ergun(mean.clamp(0.3, 1.0));
            }
        }
    }
}

fn measure(
    name: &str,
    cells: [usize; 3],
    void: VoidFraction,
    tolerance: f64,
    preconditioner: Preconditioner,
) -> Result<(), Box<dyn std::error::Error>> {
    let upper = cells.map(|n| n as f64 * WIDTH);
    let grid = Grid::uniform([0.0; 3], upper, cells, [false; 3])?;
    let profile = Profile::Uniform([0.0, 0.0, SPEED]);
    let boundaries = Boundaries::default().with(2, Side::Low, Condition::Inlet { profile }).with(
        2,
        Side::High,
        Condition::Outlet { pressure: 0.0 },
    );
    let setup =
        FlowSetup { boundaries, mixture: Some(MixtureModel::A), ..FlowSetup::new(grid, DENSITY, VISCOSITY) };
    let problem = setup.pressure_problem();
    let solver = ConjugateGradients::preconditioned(&problem, [tolerance, 500.0], preconditioner, &SERIAL);
    let mut flow = Flow::with_solver(setup, Box::new(solver), &SERIAL)?;
    let count = cells.iter().product::<usize>() as f64;
    let (mut iterations, mut best) = (0, [f64::INFINITY; Phase::ALL.len()]);
    const STEPS: [usize; 2] = [5, 15];
    for step in 0..STEPS[1] {
        set_particles(&mut flow, void, step as f64);
        if step == 0 {
            flow.mixture.iter_mut().for_each(|m| m.begin());
        }
        flow.clock.reset();
        let report = flow.step(DT, &SERIAL)?;
        if step >= STEPS[0] {
            iterations += report.solve.iterations;
            // The best of the steps: others may share the machine.
            for (best, phase) in best.iter_mut().zip(Phase::ALL) {
                *best = best.min(flow.clock.seconds(phase) / count * 1e9);
            }
        }
    }
    let mean = iterations as f64 / (STEPS[1] - STEPS[0]) as f64;
    print!(
        "{name:13} {tolerance:.0e} {preconditioner:?}: {mean:5.1} iterations, {:6.1} ns per cell:",
        best.iter().sum::<f64>()
    );
    Phase::ALL.iter().zip(best).for_each(|(phase, time)| print!("  {phase:?} {time:.1}"));
    println!();
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (tolerances, names): (Vec<String>, Vec<String>) =
        words().partition(|word| word.parse::<f64>().is_ok());
    let given: Vec<f64> = tolerances.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
    let tolerances = if given.is_empty() { vec![1e-6, 1e-8] } else { given };
    for (name, cells, void) in CASES {
        for &tolerance in &tolerances {
            for preconditioner in [Preconditioner::PlaneMeans, Preconditioner::Multigrid] {
                let title = format!("{name} {preconditioner:?}");
                if names.iter().all(|part| title.contains(part)) {
                    measure(name, cells, void, tolerance, preconditioner)?;
                }
            }
        }
    }
    Ok(())
}

/// Words of the command line without that of `cargo bench`.
fn words() -> impl Iterator<Item = String> {
    std::env::args().skip(1).filter(|word| word != "--bench")
}
