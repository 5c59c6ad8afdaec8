//! The library from outside: a simulation that is looked at, stopped and restarted has the bits of one that is let run.

#![allow(clippy::unwrap_used)]

mod ranks;

use grains_analysis::{Analysis, Common, Times, analyse, mixing, region::RegionOptions};
use grains_domain::Transport;
use grains_simulation::{Case, Inflow, Job, Motion, Options, Simulation, Status};
use ranks::on_ranks;
use std::path::{Path, PathBuf};

/// An empty folder of a test, the same on all ranks.
fn folder(job: &Job, name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("library-{name}-{}", job.size()));
    if job.transport().rank() == 0 {
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
    }
    job.transport().any(false);
    folder
}

/// A case of the tests with its results in a folder.
fn case(name: &str, results: &Path) -> Case {
    changed_case(name, results, &[])
}

/// A case of the tests with parts of its text replaced.
fn changed_case(name: &str, results: &Path, changes: &[(&str, &str)]) -> Case {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/cases").join(name);
    let text = changes.iter().fold(std::fs::read_to_string(&path).unwrap(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    });
    let text = text.replace("directory = \"results\"", &format!("directory = {results:?}"));
    Case::parse(&text, name, path.parent().unwrap()).unwrap()
}

/// Identity, position and velocity of all particles of all ranks, by identity, as bits.
fn state(simulation: &Simulation) -> Vec<[u64; 7]> {
    let row = |p: grains_simulation::ParticleView<'_>| {
        let (x, v) = (p.position(), p.velocity());
        [p.id as f64, x.x, x.y, x.z, v.x, v.y, v.z]
    };
    let own: Vec<f64> = simulation.particles().flat_map(row).collect();
    let all = simulation.transport().gather(&own);
    let mut rows: Vec<[u64; 7]> =
        all.chunks_exact(7).map(|row| std::array::from_fn(|k| row[k].to_bits())).collect();
    rows.sort_unstable();
    rows
}

fn finish(simulation: &mut Simulation) {
    while simulation.step().unwrap() == Status::Running {}
}

#[test]
fn a_silo_in_pieces_is_that_in_one() {
    on_ranks(&[1, 2, 3], "a_silo_in_pieces_is_that_in_one", |job| {
        let new = |name: &str, restart: Option<&str>| {
            let results = match restart {
                Some(_) => {
                    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("library-{name}-{}", job.size()))
                }
                None => folder(job, name),
            };
            let options = Options { restart: restart.map(PathBuf::from), ..Options::default() };
            Simulation::new(&case("silo.toml", &results), job, options).unwrap()
        };
        let mut whole = new("whole", None);
        finish(&mut whole);
        let expected = state(&whole);
        assert!(expected.len() > 50, "{} particles", expected.len());

        // Looked at in odd moments, and a wall told to do what it does.
        let mut pieces = new("pieces", None);
        let plate = Motion::Translation { velocity: [1.0, 0.0, 0.0].into(), start: 0.07, end: 0.1 };
        for time in [0.00312, 0.0127, 0.0831, 0.1113] {
            assert_eq!(pieces.run_to(time).unwrap(), Status::Running);
            assert!((pieces.time() - time).abs() < 2e-5, "{} s", pieces.time());
            let fastest = pieces.particles().map(|p| p.velocity().norm()).fold(0.0, f64::max);
            assert!(fastest < 10.0);
            pieces.set_wall_motion("plate", plate.clone()).unwrap();
        }
        finish(&mut pieces);
        assert_eq!(state(&pieces), expected);

        // Closed at a moment at which nothing is due, and continued.
        let mut first = new("stopped", None);
        first.run_to(0.0973).unwrap();
        let summary = first.close().unwrap();
        assert_eq!(summary.inserted, summary.inside + summary.left);
        let mut second = new("stopped", Some("latest"));
        assert!((second.time() - 0.0973).abs() < 2e-5);
        finish(&mut second);
        assert_eq!(state(&second), expected);

        // Stopped at the wish of the last rank alone, and continued.
        let mut asked = new("asked", None);
        asked.run_to(0.0519).unwrap();
        if job.transport().rank() + 1 == job.size() {
            asked.stop();
        }
        finish(&mut asked);
        assert_eq!(asked.step().unwrap(), Status::Stopped);
        drop(asked);
        let mut continued = new("asked", Some("latest"));
        finish(&mut continued);
        assert_eq!(state(&continued), expected);

        // Without files.
        let results = folder(job, "silent");
        let options = Options { writes_files: false, ..Options::default() };
        let mut silent = Simulation::new(&case("silo.toml", &results), job, options).unwrap();
        finish(&mut silent);
        assert_eq!(state(&silent), expected);
        assert_eq!(std::fs::read_dir(&results).unwrap().count(), 0);
    });
}

/// Names and columns of the time series of a run.
fn series(results: &Path) -> Vec<(String, Vec<f64>)> {
    let text = std::fs::read_to_string(results.join("series.csv")).unwrap();
    let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(','));
    let names: Vec<&str> = rows.next().unwrap().collect();
    let mut columns: Vec<(String, Vec<f64>)> =
        names.into_iter().map(|name| (name.to_string(), Vec::new())).collect();
    for row in rows {
        // A row has no number where there is nothing to measure.
        columns.iter_mut().zip(row).for_each(|((_, column), x)| column.push(x.parse().unwrap_or(0.0)));
    }
    columns
}

/// Stops fall amid steps of the fluid, where bodies and walls lie elsewhere than in its last one.
#[test]
fn a_fluid_that_is_stopped_amid_its_steps_goes_on_as_if_it_had_not_been() {
    let name = "a_fluid_that_is_stopped_amid_its_steps_goes_on_as_if_it_had_not_been";
    let packing = [("end = 5", "end = 0.6"), ("checkpoint = 2.5", "checkpoint = 0.3")];
    let dye = "cfl = 0.5\n[[fluid.scalar]]\nname = \"dye\"\nkind = \"concentration\"\ndiffusivity = 0.02\n\
               initial = \"step(z - 2)\"\nparticles = { value = 2 }\n";
    let dyed = [packing[0], packing[1], ("cfl = 0.5\n", dye)];
    let cases: [(&str, &[(&str, &str)]); 11] = [
        ("resolved.toml", &[]),
        ("resolved_driven.toml", &[]),
        ("resolved_heat.toml", &[]),
        ("resolved_packing.toml", &packing),
        ("resolved_packing.toml", &dyed),
        ("walls_of_fluid.toml", &[]),
        ("bed.toml", &[]),
        ("column.toml", &[]),
        ("heated.toml", &[]),
        ("leaving.toml", &[]),
        ("settling.toml", &[]),
    ];
    on_ranks(&[1, 2], name, |job| {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut draw = |count: u64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state % count
        };
        for (number, (case, changes)) in cases.iter().enumerate() {
            let label = |kind: &str| format!("amid-{number}-{kind}");
            let whole = folder(job, &label("whole"));
            let new = |results: &Path, restart: Option<&str>| {
                let options = Options { restart: restart.map(PathBuf::from), ..Options::default() };
                Simulation::new(&changed_case(case, results, changes), job, options).unwrap()
            };
            let mut run = new(&whole, None);
            let mut steps = 0;
            while run.step().unwrap() == Status::Running {
                steps += 1;
            }
            drop(run);
            let pieces = folder(job, &label("pieces"));
            for piece in 0.. {
                let mut run = new(&pieces, (piece > 0).then_some("latest"));
                for _ in 0..1 + draw(steps / 3) {
                    run.step().unwrap();
                }
                run.stop();
                finish(&mut run);
                if run.step().unwrap() == Status::Finished {
                    assert!(piece > 1, "{case} was stopped {piece} times");
                    break;
                }
            }
            if job.transport().rank() > 0 {
                continue;
            }
            let table = series(&whole);
            let largest = |column: &[f64]| column.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            for ((name, expected), (_, found)) in table.iter().zip(series(&pieces)) {
                // What is unaccounted for is rounding of what there is.
                let content = name.strip_suffix("_unaccounted").map(|scalar| format!("{scalar}_content"));
                let of = table.iter().find(|(other, _)| content.as_ref() == Some(other));
                let size = largest(of.map_or(expected, |(_, content)| content));
                assert_eq!(expected.len(), found.len());
                // What is no number in one is none in the other.
                let difference = |(a, b): (&f64, &f64)| match a.is_nan() || b.is_nan() {
                    true if a.is_nan() == b.is_nan() => 0.0,
                    true => f64::INFINITY,
                    false => (a - b).abs(),
                };
                let worst = expected.iter().zip(&found).map(difference).fold(0.0, f64::max);
                let told = format!("{case} {number} {name}: differs by {worst:e} of {size:e}");
                assert!(worst <= (1e-7 * size).max(1e-12), "{told}");
            }
        }
    });
}

#[test]
fn the_summary_counts_the_particles_that_were_inside_at_each_step() {
    on_ranks(&[1, 2, 3], "the_summary_counts_the_particles_that_were_inside_at_each_step", |job| {
        let results = folder(job, "counted");
        let mut silo = Simulation::new(&case("silo.toml", &results), job, Options::default()).unwrap();
        let mut own = 0;
        while silo.step().unwrap() == Status::Running {
            own += silo.particles().count();
        }
        let counted = silo.sum(own as f64);
        let summary = silo.close().unwrap();
        // They leave, so that those at the end are no measure of it.
        assert!(summary.left > 0);
        assert_eq!(summary.particle_steps as f64, counted);
        let seconds = summary.microseconds_per_particle_step().unwrap() * 1e-6 * counted;
        assert!((seconds - summary.seconds).abs() < 1e-9 * summary.seconds);
    });
}

#[test]
fn a_wall_moves_otherwise_from_where_it_is() {
    on_ranks(&[2], "a_wall_moves_otherwise_from_where_it_is", |job| {
        let results = folder(job, "plate");
        let mut silo = Simulation::new(&case("silo.toml", &results), job, Options::default()).unwrap();
        silo.run_to(0.08).unwrap();
        let place = |silo: &Simulation| {
            silo.walls().find(|wall| wall.name == "plate").map(|wall| wall.state.translation).unwrap()
        };
        let before = place(&silo);
        assert!((before.x - 0.01).abs() < 1e-4, "{before}");
        silo.set_wall_motion("plate", Motion::Fixed).unwrap();
        assert_eq!(place(&silo), before);
        silo.run_to(0.09).unwrap();
        assert_eq!(place(&silo), before);
        let error = silo.set_wall_motion("plat", Motion::Fixed).unwrap_err();
        assert!(error.message.contains("no wall is called `plat`; there are silo"), "{error}");
    });
}

#[test]
fn a_steered_inlet_stays_when_cells_change_hands_and_is_set_again_after_a_restart() {
    on_ranks(
        &[1, 3],
        "a_steered_inlet_stays_when_cells_change_hands_and_is_set_again_after_a_restart",
        |job| {
            let bed = |results: &Path, options: Options| {
                // Slabs whose borders move as the heap at one side spreads.
                let ranks = format!("[domain]\nranks = [{}, 1, 1]\n", job.size());
                let changes = [
                    ("name = \"bed\"\nseed", "gravity = [30, 0, -9.81]\nseed"),
                    ("upper = [0.0317, 0.008, 0.03]", "upper = [0.014, 0.008, 0.03]"),
                    ("cells = [12, 4, 16]", "cells = [24, 4, 16]"),
                    ("[domain]\n", &ranks),
                ];
                let case = changed_case("bed.toml", results, &changes);
                Simulation::new(&case, job, options).unwrap()
            };
            let restarted = || Options { restart: Some("latest".into()), ..Options::default() };
            let throttle =
                |bed: &mut Simulation| bed.set_inflow(0, Inflow::Velocity([0.0, 0.0, 0.3])).unwrap();
            // Velocities of the faces of the inlet on this rank (m/s).
            let inflow = |bed: &Simulation| -> Vec<f64> {
                let flow = bed.fluid().unwrap().flow;
                let [nx, ny, _] = flow.layout().cells.map(|n| n as isize);
                let places = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
                places.map(|(i, j)| flow.state.velocity.z.at(i, j, -1)).collect()
            };
            let mut whole = bed(&folder(job, "steered"), Options::default());
            whole.run_to(0.004).unwrap();
            throttle(&mut whole);
            let moves = whole.dem().report.moves;
            // A step of the fluid ends where the other run is stopped.
            whole.run_to(0.008).unwrap();
            whole.run_to(0.012).unwrap();
            let results = folder(job, "steered-again");
            let mut first = bed(&results, Options::default());
            first.run_to(0.004).unwrap();
            throttle(&mut first);
            first.run_to(0.008).unwrap();
            first.close().unwrap();
            let mut second = bed(&results, restarted());
            throttle(&mut second);
            second.run_to(0.012).unwrap();
            let (wanted, found) = (state(&whole), state(&second));
            assert_eq!(wanted.len(), found.len());
            for (a, b) in wanted.iter().zip(&found) {
                let numbers = |row: &[u64; 7]| row.map(f64::from_bits);
                let (a, b) = (numbers(a), numbers(b));
                // Over the first step of the fluid after the restart the inflow goes from that of the case to that which is set.
                let is_near = |k: usize| (a[k] - b[k]).abs() < if k < 4 { 1e-6 } else { 1e-3 };
                assert!((0..7).all(is_near), "{a:?} {b:?}");
            }
            whole.run_to(0.028).unwrap();
            assert!(job.size() == 1 || whole.dem().report.moves > moves, "no border moved");
            assert!(inflow(&whole).iter().all(|w| (w - 0.3).abs() < 1e-12), "{:?}", inflow(&whole));
        },
    );
}

#[test]
fn a_stored_run_is_analysed() {
    on_ranks(&[1, 2], "a_stored_run_is_analysed", |job| {
        let results = folder(job, "analysed");
        let mut silo = Simulation::new(&case("silo.toml", &results), job, Options::default()).unwrap();
        silo.run_to(0.05).unwrap();
        silo.close().unwrap();
        let common = Common { run: results, time: Times::All, output: None, case: None };
        let region = RegionOptions::default();
        let options = mixing::Options { common, region, by: None, diameter: None, cell: None, min: 5 };
        let findings = analyse(&Analysis::Mixing(options), "test", job).unwrap();
        assert!(findings.folder.join(&findings.files[0]).exists());
        if job.transport().rank() == 0 {
            assert!(findings.lines[0].contains("Lacey"), "{:?}", findings.lines);
        }
    });
}
