//! Time per cell and step of a three-dimensional lid-driven cavity: Reynolds 100, Courant number 0.25.
//!
//! `cargo bench -p grains-fluid --bench cavity_speed -- 64 128`

use grains_domain::SerialTransport;
use grains_fluid::{
    Boundaries, Condition, Diffusion, Flow, FlowSetup, Grid, MixtureModel, Phase, ScalarBoundaries,
    ScalarSetup, Scheme, Side, SolidConditions,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sizes: Vec<usize> = words().map(|n| n.parse()).collect::<Result<_, _>>()?;
    let sizes = if sizes.is_empty() { vec![32, 64, 128] } else { sizes };
    for n in sizes {
        measure(n, Diffusion::Implicit, None, 0)?;
        measure(n, Diffusion::Implicit, None, 1)?;
        measure(n, Diffusion::Implicit, None, 2)?;
        measure(n, Diffusion::Explicit, None, 0)?;
        measure(n, Diffusion::Implicit, Some(MixtureModel::A), 0)?;
        measure(n, Diffusion::Implicit, Some(MixtureModel::A), 1)?;
    }
    Ok(())
}

/// With particles: void fraction and drag vary along all axes.
fn add_particles(flow: &mut Flow) {
    let layout = flow.layout();
    let Some(mixture) = &mut flow.mixture else { return };
    let dims = layout.dims();
    let wave = |p: usize| {
        let place = [p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]];
        place.iter().zip(dims).map(|(m, d)| (6.0 * *m as f64 / d as f64).sin()).product::<f64>()
    };
    mixture.void_fraction.data_mut().iter_mut().enumerate().for_each(|(p, e)| *e = 0.7 + 0.2 * wave(p));
    for component in mixture.drag.components_mut() {
        component.iter_mut().enumerate().for_each(|(p, b)| *b = 10.0 * (1.0 + wave(p)));
    }
    mixture.begin();
}

/// Of one phase or with particles, with no scalar, one that is bounded, or that and one by central differences.
fn measure(
    n: usize,
    diffusion: Diffusion,
    mixture: Option<MixtureModel>,
    scalars: usize,
) -> Result<(), Box<dyn std::error::Error>> {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [n; 3], [false; 3])?;
    let lid = Condition::Wall { velocity: [1.0, 0.0, 0.0] };
    let boundaries = Boundaries::default().with(1, Side::High, lid);
    let setup = FlowSetup { boundaries, diffusion, mixture, ..FlowSetup::new(grid, 1.0, 0.01) };
    let mut flow = Flow::new(setup, &SerialTransport)?;
    add_particles(&mut flow);
    for scheme in [Scheme::Bounded, Scheme::Central].into_iter().take(scalars) {
        let (name, boundaries) = (String::new(), ScalarBoundaries::default());
        let solids = SolidConditions::default();
        let setup = ScalarSetup { name, diffusivity: 0.01, scheme, boundaries, solids, buoyancy: None };
        flow.add_scalar(setup, |[x, ..]| x, &SerialTransport);
    }
    let cells = (n * n * n) as f64;
    let explicit_limit = 0.2 / (3.0 * 0.01 * (n * n) as f64);
    let dt = match diffusion {
        Diffusion::Implicit => 0.25 / n as f64,
        Diffusion::Explicit => explicit_limit.min(0.25 / n as f64),
    };
    for _ in 0..3 {
        flow.step(dt, &SerialTransport)?;
    }
    let least = if mixture.is_some() { 2.0 } else { 5.0 };
    let steps = (if mixture.is_some() { 4e6 } else { 2e7 } / cells).ceil().max(least) as usize;
    // The best of a few batches: others may share the machine.
    let mut best = (f64::INFINITY, [0.0; Phase::ALL.len()]);
    for _ in 0..5 {
        flow.clock.reset();
        for _ in 0..steps {
            flow.step(dt, &SerialTransport)?;
        }
        let split = Phase::ALL.map(|p| flow.clock.seconds(p) / (steps as f64 * cells) * 1e9);
        let total = split.iter().sum();
        if total < best.0 {
            best = (total, split);
        }
    }
    let [worst, scale] = flow.divergence(&SerialTransport);
    let phases = if mixture.is_some() { ", particles" } else { "" };
    print!(
        "{n:4}^3 {diffusion:?}{phases}, {scalars} scalars: {:6.1} ns per cell and step, divergence {:.1e}:",
        best.0,
        worst / scale
    );
    for (phase, time) in Phase::ALL.iter().zip(best.1) {
        print!("  {phase:?} {time:.1}");
    }
    println!();
    Ok(())
}

/// Words of the command line without that of `cargo bench`.
fn words() -> impl Iterator<Item = String> {
    std::env::args().skip(1).filter(|word| word != "--bench")
}
