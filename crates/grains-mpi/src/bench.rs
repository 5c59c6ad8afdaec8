//! `grains-mpi bench`: time per particle and step, and per cell and step of a fluid, without output.

use grains_dem::{Dem, Phase, StepReport, Traffic};
use grains_domain::Transport;
use grains_simulation::{RunError, Simulation};
use std::time::Instant;

/// Does `warm` steps, and then `segments` times `steps` steps; prints what each took.
///
/// # Errors
/// As for a run.
pub fn time(mut simulation: Simulation, [warm, steps, segments]: [u64; 3]) -> Result<(), RunError> {
    for _ in 0..warm {
        simulation.step_unobserved()?;
    }
    let is_first = simulation.transport().rank() == 0;
    let particles = simulation.dem().totals(simulation.transport()).particles as f64;
    let before = (simulation.dem().traffic(), simulation.dem().report);
    for _ in 0..segments {
        simulation.reset_clock();
        let fluid_before =
            simulation.fluid().map(|f| (f.steps, f.iterations, [f.seconds, f.exchange_seconds]));
        let rebuilds = simulation.dem().report.rebuilds;
        let begun = Instant::now();
        for _ in 0..steps {
            simulation.step_unobserved()?;
        }
        let mut seconds = [begun.elapsed().as_secs_f64()];
        simulation.transport().max(&mut seconds);
        let per = |s: f64| 1e6 * s / steps as f64 / particles;
        let dem = simulation.dem();
        if is_first && particles > 0.0 {
            let ([spheres, bodies, walls], clones) = dem.list_sizes();
            say!(
                "us_per_particle_step {:.5} particles {particles} rebuilds {} pairs {spheres} {bodies} {walls} clones {clones}",
                per(seconds[0]),
                dem.report.rebuilds - rebuilds
            );
            let phases = Phase::ALL.iter().zip(dem.clock.seconds());
            let phases = phases.map(|((_, name), &seconds)| format!("  {name} {:.5}", per(seconds)));
            say!("{}", phases.collect::<String>());
        }
        if let (true, Some(fluid), Some(before)) = (is_first, simulation.fluid(), fluid_before) {
            let (steps, iterations, [flow, exchange]) = before;
            let (steps, iterations) = (fluid.steps - steps, fluid.iterations - iterations);
            let cells = fluid.cells();
            let per = |seconds: f64| 1e9 * seconds / (steps.max(1) * cells as u64) as f64;
            say!(
                "fluid_ns_per_cell_step {:.2} exchange {:.2} cells {cells} steps {steps} iterations {iterations}",
                per(fluid.seconds - flow),
                per(fluid.exchange_seconds - exchange)
            );
        }
    }
    let (dem, transport) = (simulation.dem(), simulation.transport());
    let (neighbours, walls) = dem.coordination();
    let mut counts =
        [neighbours.iter().map(|&c| u64::from(c)).sum::<u64>(), walls.iter().map(|&c| u64::from(c)).sum()];
    transport.sum_counts(&mut counts);
    if is_first && particles > 0.0 {
        say!("contacts_per_particle {:.4} wall_contacts {}", counts[0] as f64 / 2.0 / particles, counts[1]);
    }
    per_rank(dem, &before, transport);
    Ok(())
}

/// Prints mean and maximum over the ranks of what can be counted.
fn per_rank(dem: &Dem, (before, counted): &(Traffic, StepReport), transport: &impl Transport) {
    let now = dem.traffic();
    let updates = (now.updates - before.updates).max(1) as f64;
    let quantities = [
        ("owned", dem.particles.owned as f64),
        ("clones", (dem.particles.len() - dem.particles.owned) as f64),
        ("neighbours", dem.neighbour_ranks() as f64),
        ("messages", (now.messages - before.messages) as f64 / updates),
        ("bytes", (now.bytes - before.bytes) as f64 / updates),
        ("inner_pairs", dem.inner_share()),
        ("rebuilds", (dem.report.rebuilds - counted.rebuilds) as f64),
        ("border_rebuilds", (dem.report.border_rebuilds - counted.border_rebuilds) as f64),
        ("common_rebuilds", (dem.report.common_rebuilds - counted.common_rebuilds) as f64),
        ("waits", (now.waits - before.waits) as f64 / updates),
        ("wait_us", 1e6 * (now.wait - before.wait) / updates),
        ("memory_bytes", dem.memory_use().total() as f64),
        ("memory_bytes_particles", dem.memory_use().particles as f64),
        ("memory_bytes_lists", dem.memory_use().lists as f64),
    ];
    let mut sums = quantities.map(|(_, value)| value);
    let mut largest = sums;
    transport.sum(&mut sums);
    transport.max(&mut largest);
    if transport.rank() == 0 {
        for ((name, _), (sum, largest)) in quantities.iter().zip(sums.iter().zip(largest)) {
            say!("per_rank {name} mean {:.2} max {largest:.2}", sum / transport.size() as f64);
        }
    }
}
