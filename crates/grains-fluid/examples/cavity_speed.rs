//! Time per cell and step of a three-dimensional lid-driven cavity: Reynolds 100, Courant number 0.25.
//!
//! `cargo run --release -p grains-fluid --example cavity_speed -- 64 128`

use grains_domain::SerialTransport;
use grains_fluid::{Boundaries, Condition, Diffusion, Flow, FlowSetup, Grid, Phase, Side};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sizes: Vec<usize> = std::env::args().skip(1).map(|n| n.parse()).collect::<Result<_, _>>()?;
    let sizes = if sizes.is_empty() { vec![32, 64, 128] } else { sizes };
    for n in sizes {
        for diffusion in [Diffusion::CrankNicolson, Diffusion::Explicit] {
            measure(n, diffusion)?;
        }
    }
    Ok(())
}

fn measure(n: usize, diffusion: Diffusion) -> Result<(), Box<dyn std::error::Error>> {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [n; 3], [false; 3])?;
    let lid = Condition::Wall { velocity: [1.0, 0.0, 0.0] };
    let boundaries = Boundaries::default().with(1, Side::High, lid);
    let setup = FlowSetup { boundaries, diffusion, ..FlowSetup::new(grid, 1.0, 0.01) };
    let mut flow = Flow::new(setup, &SerialTransport)?;
    let cells = (n * n * n) as f64;
    let explicit_limit = 0.2 / (3.0 * 0.01 * (n * n) as f64);
    let dt = match diffusion {
        Diffusion::CrankNicolson => 0.25 / n as f64,
        Diffusion::Explicit => explicit_limit.min(0.25 / n as f64),
    };
    for _ in 0..3 {
        flow.step(dt, &SerialTransport)?;
    }
    let steps = (2e7 / cells).ceil().max(5.0) as usize;
    // The best of a few batches: others may share the machine.
    let mut best = (f64::INFINITY, [0.0; 6]);
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
    print!("{n:4}^3 {diffusion:?}: {:6.1} ns per cell and step, divergence {:.1e}:", best.0, worst / scale);
    for (phase, time) in Phase::ALL.iter().zip(best.1) {
        print!("  {phase:?} {time:.1}");
    }
    println!();
    Ok(())
}
