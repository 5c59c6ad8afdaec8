//! What a rank holds and sends depends on its part of the system, not on how many other ranks there are.

#![allow(clippy::unwrap_used)]

mod common;

use common::{folder, run};
use std::collections::HashMap;
use std::fs;

/// Spheres along the edge of each rank's cube, and their spacing (m).
const EDGE: usize = 6;
const SPACING: f64 = 3.2e-3;

/// A gas of spheres, periodic in all directions, on `n` ranks per axis.
fn case(n: usize) -> String {
    let length = (n * EDGE) as f64 * SPACING;
    let count = (n * EDGE).pow(3);
    format!(
        r#"
name = "growth"
gravity = [0, 0, 0]

[domain]
lower = [0, 0, 0]
upper = [{length}, {length}, {length}]
periodic = [true, true, true]
ranks = [{n}, {n}, {n}]
balance = false

[time]
end = 1
dt = 1e-5

[[material]]
name = "glass"
density = 2500

[[contact]]
between = ["glass", "glass"]
normal_stiffness = 1e4
restitution = 0.9
friction = 0.3
tangential = {{ kind = "spring", stiffness_ratio = 0.3, damping_ratio = 0.5 }}

[[shape]]
name = "bead"
kind = "sphere"
radius = 1.5e-3

[[insert]]
name = "gas"
particles = [{{ shape = "bead", material = "glass" }}]
count = {count}
place = {{ kind = "lattice", lower = [0, 0, 0], upper = [{length}, {length}, {length}], spacing = {SPACING}, noise = 0.02 }}
"#
    )
}

/// Mean and largest over the ranks of what `bench` counts, by name.
fn counted(n: usize) -> HashMap<String, [f64; 2]> {
    let place = folder(&format!("growth_{n}"));
    fs::write(place.join("case.toml"), case(n)).unwrap();
    let bench = ["bench", "case.toml", "--warm", "1", "--steps", "4", "--segments", "1"];
    let output = run(n.pow(3), &place, &bench).succeeded();
    let lines = output.stdout.lines().filter_map(|line| line.strip_prefix("per_rank "));
    let numbers = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        (words[0].to_string(), [words[2], words[4]].map(|word| word.parse().unwrap()))
    };
    lines.map(numbers).collect()
}

/// From 27 ranks on every rank has 26 neighbours; 64 of them must not cost a rank more than 27.
#[test]
fn sixty_four_ranks_cost_a_rank_no_more_than_twenty_seven() {
    let [few, many] = [3, 4].map(counted);
    let own = EDGE.pow(3) as f64;
    for counts in [&few, &many] {
        assert_eq!(counts["owned"], [own, own]);
        assert_eq!(counts["neighbours"], [26.0, 26.0]);
        assert!((20.0..=26.0).contains(&counts["messages"][0]), "{:?}", counts["messages"]);
        assert!(counts["clones"][0] > own, "so small a cube has more clones than particles");
    }
    for name in ["clones", "bytes", "messages", "memory_bytes"] {
        let [[few, _], [many, most]] = [few[name], many[name]];
        assert!(many < 1.02 * few, "{name}: {many} on 64 ranks, {few} on 27");
        assert!(most < 1.15 * few, "{name}: {most} on the busiest of 64 ranks, {few} on 27");
    }
}
