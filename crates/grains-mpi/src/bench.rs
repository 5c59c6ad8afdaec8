//! `grains-mpi bench`: time per particle and step, without output.

use crate::error::{RunError, agreed};
use crate::run::build;
use crate::system::{self, System};
use grains_case::Case;
use grains_comm::{Job, MpiTransport, exit};
use grains_dem::{Clock, Failure, Phase};
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
    let (System { setup, .. }, mut population) = agreed(world, build(case, job.size()))?;
    let transport = &system::transport(case, &setup, job)?;
    let mut dem = system::dem(case, setup, transport.rank()).map_err(RunError::case)?;
    match restart {
        Some(checkpoint) => crate::restart::restore(case, transport, checkpoint, &mut dem, &mut population)?,
        None => {
            population.insert_due(case, &mut dem, transport).map_err(RunError::case)?;
        }
    }
    let failed = |failure: Failure| RunError {
        code: exit::UNSTABLE,
        message: if let Failure::Here(error) = failure { error.to_string() } else { String::new() },
    };
    for _ in 0..warm {
        dem.step(transport).map_err(failed)?;
    }
    let particles = dem.totals(transport).particles as f64;
    for _ in 0..segments {
        dem.clock = Clock::default();
        let rebuilds = dem.report.rebuilds;
        let begun = Instant::now();
        for _ in 0..steps {
            dem.step(transport).map_err(failed)?;
        }
        let mut seconds = [begun.elapsed().as_secs_f64()];
        transport.max(&mut seconds);
        let per = |s: f64| 1e6 * s / steps as f64 / particles;
        if transport.rank() == 0 {
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
    }
    let (neighbours, walls) = dem.coordination();
    let mut counts =
        [neighbours.iter().map(|&c| u64::from(c)).sum::<u64>(), walls.iter().map(|&c| u64::from(c)).sum()];
    transport.sum_counts(&mut counts);
    if transport.rank() == 0 {
        say!("contacts_per_particle {:.4} wall_contacts {}", counts[0] as f64 / 2.0 / particles, counts[1]);
    }
    Ok(())
}
