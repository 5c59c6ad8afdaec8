//! Long runs that are continued again and again, many ranks for an hour, and more ranks than particles.

use crate::common::results::{assert_same_state, checkpoints, last_step, series, state};
use crate::common::{folder, run_case, start};
use crate::repeated;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Beads that fall in at the top, bounce on a plate and leave at the side, until `end` (s).
fn shower(end: f64, every: f64) -> String {
    format!(
        r#"name = "shower"
seed = 2
[domain]
lower = [0, 0, 0]
upper = [0.06, 0.02, 0.03]
periodic = [false, true, false]
outlets = ["+x", "-x"]
[time]
end = {end:e}
dt = 2e-5
impact_speed = 2
[[material]]
name = "glass"
density = 2500
[[contact]]
between = ["glass", "glass"]
normal_stiffness = 500
restitution = 0.8
friction = 0.2
[[shape]]
name = "bead"
kind = "sphere"
radius = 1e-3
[[insert]]
name = "shower"
particles = [{{ shape = "bead", material = "glass", scale = {{ kind = "uniform", min = 0.8, max = 1 }} }}]
count = 100000
batch = 2
interval = 0.02
velocity = [0.1, 0, 0]
place = {{ kind = "window", window = {{ kind = "box", lower = [0.005, 0, 0.02], upper = [0.03, 0.02, 0.028] }}, retry = 1e-3 }}
[[wall]]
name = "plate"
material = "glass"
kind = "plane"
point = [0.06, 0, 0.003]
normal = [0.15, 0, 1]
[output]
directory = "results"
particles = 0
series = {every:e}
checkpoint = {every:e}
keep_checkpoints = 2
"#
    )
}

/// Memory of the largest rank (MB) as the end of a run tells it.
fn memory(output: &str) -> f64 {
    let (_, after) = output.split_once("MB in all, ").unwrap();
    after.split_once(" MB").unwrap().0.parse().unwrap()
}

#[test]
fn a_long_run_continued_again_and_again_loses_nobody_and_takes_no_more_memory() {
    let (parts, steps) = (repeated(6, 100), repeated(5_000, 100_000));
    let part = 2e-5 * steps as f64;
    let home = folder("torture_endurance");
    let results = home.join("results");
    let (mut ids, mut megabytes, mut energies) = (BTreeSet::new(), Vec::new(), Vec::new());
    let mut next = 0;
    for k in 1..=parts {
        let arguments: &[&str] = if k == 1 { &[] } else { &["--restart", "latest"] };
        let text = shower(part * k as f64, part / 10.0);
        let output = run_case([2, 1, 3][k % 3], &home, &text, arguments).succeeded();
        megabytes.push(memory(&output.stdout));
        assert_eq!(last_step(&results), (steps * k) as u64);
        let own: BTreeSet<u64> =
            state(checkpoints(&results).last().unwrap()).iter().map(|particle| particle.id).collect();
        // Who has left does not come back, and no number is given twice.
        assert!(own.iter().all(|id| *id >= next || ids.contains(id)), "part {k}: {own:?}");
        next = next.max(own.last().map_or(0, |last| last + 1));
        ids = own;
    }
    let table = series(&results);
    let [inserted, left, inside] = ["inserted", "left", "particles"].map(|name| table.column(name));
    for (row, inside) in inside.iter().enumerate() {
        assert_eq!(inserted[row] - left[row], *inside, "row {row}: nobody is lost");
    }
    assert!(left.last().is_some_and(|&left| left > 10.0), "{left:?}");
    energies.extend(table.column("kinetic_translation"));
    // As bounded at the end as in the first tenth.
    let largest = |rows: &[f64]| rows.iter().copied().fold(0.0, f64::max);
    let (first, all) = (largest(&energies[energies.len() / 10..energies.len() / 3]), largest(&energies));
    assert!(all < 2.0 * first, "kinetic energy {first:e} J, later {all:e} J");
    let (early, late) = (largest(&megabytes[..3]), largest(&megabytes[parts - 3..]));
    assert!(late <= 1.1 * early, "memory of the largest rank: {megabytes:?} MB");
    println!(
        "attack: {} steps in {parts} parts | {} inserted, {} left | memory {early} to {late} MB, kinetic energy at most {all:.2e} J",
        parts * steps,
        inserted.last().unwrap(),
        left.last().unwrap()
    );
}

#[test]
fn many_ranks_on_few_cores_for_an_hour_end_where_one_rank_ends() {
    let (ranks, steps) = if repeated(0, 1) == 1 { ([4, 4, 4], 400_000) } else { ([3, 2, 2], 2_000) };
    let patience = repeated(150, 20_000) as u64;
    let end = 2e-5 * steps as f64;
    let text = shower(end, end / 20.0).replace("batch = 2", "batch = 20");
    let run = |name: &str, ranks: [usize; 3]| {
        let home = folder(&format!("torture_hour_{name}"));
        let text = text.replace("[time]", &format!("ranks = {ranks:?}\n[time]"));
        fs::write(home.join("case.toml"), text).unwrap();
        start(ranks.iter().product(), &home, &["case.toml"], 0).wait_at_most(patience).succeeded();
        home
    };
    let begin = Instant::now();
    let many = run("many", ranks);
    let minutes = begin.elapsed().as_secs_f64() / 60.0;
    let alone = run("alone", [1, 1, 1]);
    assert_same_state(&newest(&alone), &newest(&many));
    let (table, same) = (series(&many.join("results")), series(&alone.join("results")));
    for name in ["time", "inserted", "left", "particles", "kinetic_translation"] {
        assert_eq!(table.column(name), same.column(name), "{name}");
    }
    let count: usize = ranks.iter().product();
    let inserted = table.column("inserted").last().copied().unwrap();
    println!(
        "attack: {count} ranks for {minutes:.0} min | {steps} steps, {inserted} beads | the same bits as on one"
    );
}

/// Runs the shower on ranks most of which have no particle.
fn on_many(ranks: [usize; 3], name: &str, count: usize) -> std::path::PathBuf {
    let home = folder(&format!("torture_ranks_{name}"));
    let text = shower(0.004, 0.002)
        .replace("count = 100000\nbatch = 2", &format!("count = {count}\nbatch = {count}"));
    let text = text.replace("[time]", &format!("ranks = {ranks:?}\nbalance = false\n[time]"));
    run_case(ranks.iter().product(), &home, &text, &[]).succeeded();
    newest(&home)
}

fn newest(home: &Path) -> std::path::PathBuf {
    fs::canonicalize(checkpoints(&home.join("results")).last().unwrap()).unwrap()
}

#[test]
fn one_particle_on_many_ranks_is_the_same_as_on_one() {
    let ranks = if repeated(0, 1) == 1 { [16, 2, 2] } else { [12, 1, 1] };
    for count in [1, 3] {
        let alone = on_many([1, 1, 1], &format!("alone_{count}"), count);
        let many = on_many(ranks, &format!("many_{count}"), count);
        assert_same_state(&alone, &many);
    }
    let all: usize = ranks.iter().product();
    println!("attack: 1 and 3 particles on {all} ranks | once | the same bits as on one");
}
