//! Restarts: nothing is lost or doubled wherever a run is stopped.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{Series, assert_same_state, checkpoints, last_step, series, snapshots, step_of};
use common::{case, folder, replaced, run, run_case, signal, start};
use std::fs;
use std::path::Path;

/// Columns that a fluid's iterations or rounding make, which are others on other ranks.
const ROUNDING: [&str; 4] = ["iterations", "divergence", "imbalance", "cores_met"];

/// Asserts that the files of two runs hold the same steps, and values that are the same but for the sums over ranks and the
/// tolerance of the fluid's solvers, `share` of the largest of a column.
fn assert_same_files(wanted: &Path, found: &Path, share: f64) {
    for file in ["particles.vtkhdf", "walls.vtkhdf", "surfaces.vtkhdf"] {
        if wanted.join(file).exists() {
            assert_eq!(snapshots(&wanted.join(file)), snapshots(&found.join(file)), "{file}");
        }
    }
    for file in ["fluid.vtkhdf", "fluid-mean.vtkhdf"] {
        if wanted.join(file).exists() {
            assert_eq!(times(&wanted.join(file)), times(&found.join(file)), "{file}");
        }
    }
    assert_same_rows(&series(wanted), &series(found), share);
    for entry in fs::read_dir(wanted).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.starts_with("profile-") && name.ends_with(".csv") {
            let [a, b] = [wanted, found].map(|folder| table(&folder.join(&name)));
            assert_same_rows(&a, &b, share);
        }
    }
}

fn times(file: &Path) -> Vec<f64> {
    let steps = hdf5::File::open(file).unwrap().group("VTKHDF/Steps").unwrap();
    let count = steps.attr("NSteps").unwrap().read_scalar::<i64>().unwrap() as usize;
    let mut times = steps.dataset("Values").unwrap().read_raw::<f64>().unwrap();
    times.truncate(count);
    times
}

fn table(path: &Path) -> Series {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns = lines.next().unwrap().split(',').map(String::from).collect();
    let rows = lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    Series { columns, rows }
}

fn assert_same_rows(wanted: &Series, found: &Series, share: f64) {
    assert_eq!(wanted.columns, found.columns);
    let first = &wanted.columns[0];
    assert_eq!(wanted.column(first), found.column(first), "column {first}");
    // Components of a vector are measured by the largest of them.
    let vector = |name: &str| name.trim_end_matches(['x', 'y', 'z']).to_string();
    for name in wanted.columns.iter().filter(|name| !ROUNDING.iter().any(|r| name.contains(r))) {
        let alike = wanted.columns.iter().filter(|other| vector(other) == vector(name));
        let largest = alike.flat_map(|n| wanted.column(n)).filter(|x| x.is_finite()).map(f64::abs);
        let tolerance = share * largest.fold(0.0, f64::max);
        for (row, (a, b)) in wanted.column(name).into_iter().zip(found.column(name)).enumerate() {
            let same = (a - b).abs() <= tolerance || a.is_nan() && b.is_nan();
            assert!(same, "column {name}, row {row}: {b:e} for {a:e}, within {tolerance:e}");
        }
    }
}

/// What is written of a case at every `every`th of its `steps` steps.
fn often(name: &str, (steps, every): (u32, u32)) -> String {
    let text = case(name);
    let dt: f64 = key(&text, "dt").parse().unwrap();
    let interval = format!("{:e}", dt * f64::from(every));
    let end = format!("{:e}", dt * f64::from(steps));
    let text = replaced(&text, &format!("\nend = {}\n", key(&text, "end")), &format!("\nend = {end}\n"));
    // The checkpoints are those of stops alone.
    let values = [("particles", &*interval), ("series", &interval), ("checkpoint", "1e3")];
    let (before, output) = text.split_once("\n[output]\n").unwrap();
    let output = values.iter().fold(format!("\n{output}"), |text, (name, value)| {
        let old = format!("\n{name} = {}\n", key(&text, name));
        replaced(&text, &old, &format!("\n{name} = {value}\n"))
    });
    format!("{before}\n[output]{output}")
}

/// Value of the first key of a name in a case.
fn key(text: &str, name: &str) -> String {
    let line = text.lines().find(|line| line.starts_with(&format!("{name} = "))).unwrap();
    line.split_once(" = ").unwrap().1.to_string()
}

/// Stops a run at each of its steps in turn, on other ranks each time, and compares its files with those of one that was not.
fn stopped_at_every_step(name: &str, text: &str, share: f64) {
    let undisturbed = folder(&format!("restarts_{name}_undisturbed"));
    run_case(2, &undisturbed, text, &[]).succeeded();
    let stopped = folder(&format!("restarts_{name}_stopped"));
    let results = stopped.join("results");
    fs::write(stopped.join("case.toml"), text).unwrap();
    let end = last_step(&undisturbed.join("results"));
    let mut arguments = vec!["case.toml", "--max-walltime", "0"];
    let mut reached = 0;
    // Three ranks are too many for the few large bodies.
    let ranks = if name.starts_with("resolved") { [2, 1, 4] } else { [2, 1, 3] };
    for ranks in ranks.into_iter().cycle() {
        let output = run(ranks, &stopped, &arguments).succeeded();
        let step = step_of(checkpoints(&results).last().unwrap());
        assert!(step > reached, "{}", output.text());
        reached = step;
        arguments = vec!["case.toml", "--max-walltime", "0", "--restart", "latest"];
        if step >= end {
            break;
        }
    }
    // Once more at the end: nothing is left to do, and nothing is written twice.
    run(2, &stopped, &arguments).succeeded();
    let wanted = undisturbed.join("results");
    assert_same_files(&wanted, &results, share);
    if share == 0.0 || !results.join("fluid.vtkhdf").exists() {
        assert_same_state(checkpoints(&wanted).last().unwrap(), checkpoints(&results).last().unwrap());
    }
}

/// With the output `every` steps, of `steps`.
fn at_every_step(name: &str, steps: u32, every: u32) {
    let text = often(&format!("{name}.toml"), (steps, every));
    stopped_at_every_step(&format!("{name}_{every}"), &text, 1e-5);
}

#[test]
fn a_sheared_packing_stopped_at_every_step_loses_no_row_and_no_snapshot() {
    at_every_step("shear", 9, 1);
    at_every_step("shear", 9, 4);
}

#[test]
fn a_fluidised_bed_stopped_at_every_step_loses_no_row_and_no_snapshot() {
    at_every_step("bed", 9, 1);
}

#[test]
fn a_bed_stopped_between_the_steps_of_its_fluid_tells_the_same_of_it() {
    at_every_step("bed", 9, 4);
}

#[test]
fn bodies_in_a_flow_stopped_at_every_step_lose_no_row_and_no_snapshot() {
    at_every_step("resolved", 6, 1);
    at_every_step("resolved", 7, 3);
}

#[test]
fn a_duct_stopped_at_every_step_loses_no_row_snapshot_profile_or_sample() {
    let text = replaced(&often("duct.toml", (12, 1)), "mean_from = 0.1", "mean_from = 0.04");
    stopped_at_every_step("duct", &text, 1e-5);
}

/// Kills all ranks of a run `times` times, wherever it is, and continues it on others from the checkpoint before.
fn killed(name: &str, text: &str, times: u64) {
    let undisturbed = folder(&format!("restarts_{name}_alive"));
    run_case(2, &undisturbed, text, &[]).succeeded();
    let end = last_step(&undisturbed.join("results"));
    let home = folder(&format!("restarts_{name}_killed"));
    let results = home.join("results");
    fs::write(home.join("case.toml"), text).unwrap();
    let mut arguments = vec!["case.toml"];
    for (kill, ranks) in (1..=times).zip([2, 3, 1].into_iter().cycle()) {
        let mut running = start(ranks, &home, &arguments, 0);
        let from = end * kill / (times + 1);
        let has_come =
            || results.exists() && last_step(&results) >= from && !checkpoints(&results).is_empty();
        running.wait_until("far enough", has_come);
        signal("KILL", &running.ranks());
        assert_ne!(running.wait().code, Some(0));
        arguments = vec!["case.toml", "--restart", "latest"];
    }
    run(2, &home, &arguments).succeeded();
    assert_same_files(&undisturbed.join("results"), &results, 1e-5);
}

#[test]
fn runs_that_are_killed_lose_and_double_nothing() {
    for (name, steps, saved) in [("bed", 90, 7), ("duct", 120, 3), ("shear", 300, 10)] {
        let text = often(&format!("{name}.toml"), (steps, 1));
        let dt: f64 = key(&text, "dt").parse().unwrap();
        let interval = format!("checkpoint = {:e}", dt * f64::from(saved));
        killed(name, &replaced(&text, "checkpoint = 1e3", &interval), 2);
    }
}
