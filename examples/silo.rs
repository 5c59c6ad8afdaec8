//! Runs a silo through the library: `mpirun -n 2 silo ../cases/silo/quick.toml [SECONDS]`.
//!
//! It looks at the particles four times; after three of them a wall called "plate" stops where it is.

use grains_simulation::{Job, Motion, Options, RunError, Simulation, Status, abort, load, start};

fn run(job: &Job, path: &str, end: f64) -> Result<(), RunError> {
    let case = load(path.as_ref(), job)?;
    let mut silo = Simulation::new(&case, job, Options::default())?;
    for quarter in 1..=4 {
        if silo.run_to(0.25 * end * f64::from(quarter))? != Status::Running {
            break;
        }
        // What a rank sees are its own particles; sums over the ranks are those of the transport.
        let energy: f64 = silo.particles().map(|particle| particle.kinetic_energy()).sum();
        let highest = silo.particles().map(|particle| particle.position().z).fold(f64::MIN, f64::max);
        let load: f64 = silo.walls().map(|wall| wall.load.force.z).sum();
        let (energy, load) = (silo.sum(energy), silo.sum(load));
        let highest = silo.max(highest);
        if silo.is_first_rank() {
            println!(
                "t = {:.3} s: {energy:.3e} J, up to {highest:.3} m, walls carry {load:.3} N",
                silo.time()
            );
        }
        if quarter == 3 && silo.walls().any(|wall| wall.name == "plate") {
            silo.set_wall_motion("plate", Motion::Fixed)?;
        }
    }
    let is_first = silo.is_first_rank();
    let summary = silo.close()?;
    if is_first {
        println!("{} particles, {} steps, {:.1} s", summary.inside, summary.steps, summary.seconds);
    }
    Ok(())
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, path, rest @ ..] = &arguments[..] else { panic!("usage: silo CASE [SECONDS]") };
    let end = rest.first().map_or(2.0, |text| text.parse().expect("seconds are a number"));
    let job = start().unwrap_or_else(|error| panic!("{error}"));
    if let Err(error) = run(&job, path, end) {
        eprintln!("{error}");
        abort(1);
    }
}
