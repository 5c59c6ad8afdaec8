//! `grains-mpi bench`: time per particle and step, and per cell and step of a fluid, without output.

use crate::error::RunError;
use crate::fluid::{FluidPhase, follow_borders};
use crate::population::Population;
use crate::run::build;
use crate::system::{self, System};
use grains_case::Case;
use grains_comm::{Job, MpiTransport, exit};
use grains_dem::{Clock, Dem, Failure, Phase, Traffic};
use grains_domain::Transport;
use std::path::Path;
use std::time::Instant;

/// Runs `warm` steps from the beginning or a checkpoint, and then `segments` times `steps` steps; prints what each took.
///
/// # Errors
/// As for a run.
pub fn time(
    case: &Case,
    job: &Job,
    world: &MpiTransport,
    restart: Option<&Path>,
    [warm, steps, segments]: [u64; 3],
) -> Result<(), RunError> {
    let (System { setup, .. }, mut population) = build(case, world)?;
    let transport = &system::transport(case, &setup, job)?;
    let mut dem = system::dem(case, setup, transport.rank()).map_err(RunError::case)?;
    let mut fluid = FluidPhase::new(case, &[], &mut dem, population.kinds(), transport)?;
    match restart {
        Some(checkpoint) => {
            crate::restart::restore(case, transport, checkpoint, (&mut dem, &mut fluid), &mut population)?;
        }
        None => {
            population.insert_due(case, &mut dem, transport).map_err(RunError::case)?;
            dem.refresh(transport).map_err(failed)?;
            follow_borders(&mut fluid, (case, &[]), &mut dem, population.kinds(), transport)?;
            if let Some(fluid) = &mut fluid {
                fluid.begin(&dem, transport)?;
            }
        }
    }
    for _ in 0..warm {
        step(case, (&mut dem, &mut fluid), &population, transport)?;
    }
    let particles = dem.totals(transport).particles as f64;
    let traffic = dem.traffic();
    for _ in 0..segments {
        dem.clock = Clock::default();
        let fluid_before = fluid.as_ref().map(|f| (f.steps, f.iterations, f.seconds));
        let rebuilds = dem.report.rebuilds;
        let begun = Instant::now();
        for _ in 0..steps {
            step(case, (&mut dem, &mut fluid), &population, transport)?;
        }
        let mut seconds = [begun.elapsed().as_secs_f64()];
        transport.max(&mut seconds);
        let per = |s: f64| 1e6 * s / steps as f64 / particles;
        if transport.rank() == 0 {
            let ([spheres, bodies, walls], clones) = dem.list_sizes();
            if particles > 0.0 {
                say!(
                    "us_per_particle_step {:.5} particles {particles} rebuilds {} pairs {spheres} {bodies} {walls} clones {clones}",
                    per(seconds[0]),
                    dem.report.rebuilds - rebuilds
                );
                let phases = Phase::ALL.iter().zip(dem.clock.seconds());
                let phases = phases.map(|((_, name), &seconds)| format!("  {name} {:.5}", per(seconds)));
                say!("{}", phases.collect::<String>());
            }
            if let (Some(fluid), Some((steps, iterations, [flow, exchange]))) = (&fluid, fluid_before) {
                let (steps, iterations) = (fluid.steps - steps, fluid.iterations - iterations);
                let cells = fluid.flow.setup.grid.cells().iter().product::<usize>();
                let per = |seconds: f64| 1e9 * seconds / (steps.max(1) * cells as u64) as f64;
                say!(
                    "fluid_ns_per_cell_step {:.2} exchange {:.2} cells {cells} steps {steps} iterations {iterations}",
                    per(fluid.seconds[0] - flow),
                    per(fluid.seconds[1] - exchange)
                );
            }
        }
    }
    let (neighbours, walls) = dem.coordination();
    let mut counts =
        [neighbours.iter().map(|&c| u64::from(c)).sum::<u64>(), walls.iter().map(|&c| u64::from(c)).sum()];
    transport.sum_counts(&mut counts);
    if transport.rank() == 0 && particles > 0.0 {
        say!("contacts_per_particle {:.4} wall_contacts {}", counts[0] as f64 / 2.0 / particles, counts[1]);
    }
    per_rank(&dem, &traffic, transport);
    Ok(())
}

/// Prints mean and maximum over the ranks of what can be counted.
fn per_rank(dem: &Dem, before: &Traffic, transport: &MpiTransport) {
    let now = dem.traffic();
    let updates = (now.updates - before.updates).max(1) as f64;
    let quantities = [
        ("owned", dem.particles.owned as f64),
        ("clones", (dem.particles.len() - dem.particles.owned) as f64),
        ("neighbours", dem.neighbour_ranks() as f64),
        ("messages", (now.messages - before.messages) as f64 / updates),
        ("bytes", (now.bytes - before.bytes) as f64 / updates),
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

/// A step of the particles, and of the fluid if it is its turn; without particles always of the fluid.
fn step(
    case: &Case,
    (dem, fluid): (&mut Dem, &mut Option<FluidPhase>),
    population: &Population,
    transport: &MpiTransport,
) -> Result<(), RunError> {
    if fluid.is_none() {
        return dem.step(transport).map_err(failed);
    }
    if fluid.as_ref().is_some_and(|fluid| !fluid.is_alone()) {
        dem.refresh(transport).map_err(failed)?;
    }
    follow_borders(fluid, (case, &[]), dem, population.kinds(), transport)?;
    let Some(fluid) = fluid else { return Ok(()) };
    if !fluid.is_alone() {
        dem.add_forces(transport);
    }
    fluid.act(dem, u64::MAX, transport)?;
    if fluid.is_alone() {
        dem.resume_at(fluid.next_step);
        return Ok(());
    }
    dem.advance(transport).map_err(failed)?;
    fluid.catch_up(dem, transport)
}

fn failed(failure: Failure) -> RunError {
    let message = if let Failure::Here(error) = failure { error.to_string() } else { String::new() };
    RunError { code: exit::UNSTABLE, message }
}
