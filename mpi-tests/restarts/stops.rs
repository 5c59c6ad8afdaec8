//! Runs that are stopped at every step, or killed.

use crate::common::files::assert_same_files;
use crate::common::results::{assert_same_state, checkpoints, last_step, series, step_of};
use crate::common::{folder, key, often, replaced, run, run_case, start};
use std::fs;
use std::path::Path;

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
fn a_packing_whose_stop_condition_is_met_is_at_its_end_after_restarts_too() {
    let text = often("shear.toml", (9, 2));
    let after = 3.5 * key(&text, "dt").parse::<f64>().unwrap();
    let stop = format!("\n[stop]\nkinetic_energy_below = 1e9\nafter = {after:e}\n");
    stopped_at_every_step("stop_condition", &(text + &stop), 1e-5);
}

#[test]
fn a_lid_under_a_load_stopped_at_every_step_goes_on_from_where_it_is() {
    let moved = "{ kind = \"translation\", velocity = [-0.4, 0, -0.6], end = 0.095 }";
    let load = "{ kind = \"load\", axis = [0, 0, -1], force = 0.6, mass = 0.02, velocity = [0.2, 0.1, 0] }\nwear = { coefficient = 1e-4, hardness = 1e9 }";
    let text = replaced(&often("shear.toml", (9, 1)), moved, load);
    stopped_at_every_step("lid", &text, 1e-5);
}

#[test]
fn a_block_stopped_at_every_step_is_bonded_once() {
    let clamps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/cases/clamps.csv");
    let made =
        [("clamps.csv", clamps.to_str().unwrap()), ("at = 2e-3", "at = 3e-5"), ("at = 6e-3", "at = 6e-5")];
    let text = made.iter().fold(often("bonded.toml", (9, 1)), |text, (old, new)| replaced(&text, old, new));
    stopped_at_every_step("bonded", &text, 1e-5);
}

#[test]
fn a_sheared_box_stopped_at_every_step_loses_no_part_of_its_stress() {
    at_every_step("sheared", 9, 1);
    at_every_step("sheared", 9, 4);
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
fn fixed_and_driven_bodies_stopped_at_every_step_lose_nothing() {
    at_every_step("fixed_and_driven", 7, 1);
    at_every_step("resolved_driven", 6, 1);
    at_every_step("resolved_driven", 7, 3);
}

#[test]
fn a_duct_stopped_at_every_step_loses_no_row_snapshot_profile_or_sample() {
    let text = replaced(&often("duct.toml", (12, 1)), "mean_from = 0.1", "mean_from = 0.04");
    stopped_at_every_step("duct", &text, 1e-5);
}

#[test]
fn a_file_of_the_results_that_is_removed_in_flight_is_missed() {
    let text = replaced(&often("shear.toml", (100_000, 1)), "checkpoint = 1e3", "checkpoint = 1e-3");
    type Harm = fn(&Path);
    let harms: [(&str, Harm); 4] = [
        ("series.csv", |file| fs::remove_file(file).unwrap()),
        ("particles.vtkhdf", |file| fs::remove_file(file).unwrap()),
        ("walls.vtkhdf", |file| {
            fs::write(file.with_extension("new"), "other")
                .and_then(|()| fs::rename(file.with_extension("new"), file))
                .unwrap()
        }),
        ("", |folder| fs::rename(folder, folder.with_file_name("elsewhere")).unwrap()),
    ];
    for (name, harm) in harms {
        let home = folder("restarts_removed");
        let results = home.join("results");
        fs::write(home.join("case.toml"), &text).unwrap();
        let mut running = start(2, &home, &["case.toml"], 0);
        let far = || results.exists() && last_step(&results) > 60 && !checkpoints(&results).is_empty();
        running.wait_until("60 steps", far);
        harm(&results.join(name));
        let ended = running.wait();
        let message = ended.only_error(4);
        let wanted = if name.is_empty() { "results" } else { name };
        let reason = if name.is_empty() { "has been renamed" } else { "while this run writes it" };
        assert!(message.contains(wanted) && message.contains(reason), "{message}");
        // What is left of the run goes on, and the file begins anew.
        if name == "series.csv" {
            let more = ["case.toml", "--restart", "latest", "--max-walltime", "0"];
            run(2, &home, &more).succeeded();
            assert_eq!(series(&results).rows.len(), 2);
        }
    }
}
