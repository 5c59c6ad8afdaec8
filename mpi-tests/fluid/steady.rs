//! Steady flow past fixed bodies: the same as marching in time leads to, on any ranks and after a restart.

use super::{assert_close, continued};
use crate::common::results::{checkpoints, series};
use crate::common::{folder, replaced, run_case};
use std::fs;
use std::path::Path;

/// Tolerance of the searches.
const TOLERANCE: f64 = 1e-4;

/// Eight bodies, 0.4 across or so, a little off a lattice, in a fluid with ν = 1.
struct Bed {
    shape: &'static str,
    /// Of a diameter of 0.4 and the superficial velocity.
    reynolds: f64,
    is_periodic: bool,
    seed: u64,
}

const SPHERE: &str = "kind = \"sphere\"\nradius = 0.2";
const CYLINDER: &str = "kind = \"cylinder\"\nradius = 0.15\nheight = 0.3";
const BOX: &str = "kind = \"box\"\nedges = [0.26, 0.22, 0.28]";

impl Bed {
    /// The case with an end (s) and a key of the fluid.
    fn text(&self, end: f64, key: &str) -> String {
        let Self { shape, reynolds, is_periodic, seed } = self;
        let speed = if *reynolds == 0.0 { 1e-3 } else { reynolds / 0.4 };
        let (ends, cells, flow) = match is_periodic {
            true => {
                let drive = format!(
                    "drive = {{ kind = \"mean_velocity\", velocity = [{speed}, 0, 0], axes = [true, false, false] }}"
                );
                ([0.0, 1.0], 20, drive)
            }
            false => {
                let inlet = format!("face = \"-x\"\nkind = \"inlet\"\nvelocity = [{speed}, 0, 0]");
                let outlet = "face = \"+x\"\nkind = \"outlet\"";
                ([-0.4, 1.4], 36, format!("[[fluid.boundary]]\n{inlet}\n[[fluid.boundary]]\n{outlet}"))
            }
        };
        format!(
            "seed = {seed}\ngravity = [0, 0, 0]\n[domain]\nlower = [{}, 0, 0]\nupper = [{}, 1, 1]\n\
             periodic = [{is_periodic}, true, true]\n[time]\nend = {end}\n[[material]]\nname = \"solid\"\ndensity = 2000\n\
             [[shape]]\nname = \"body\"\n{shape}\n[[insert]]\nname = \"bed\"\n\
             particles = [{{ shape = \"body\", material = \"solid\" }}]\ncount = 8\norientation = \"random\"\n\
             place = {{ kind = \"lattice\", lower = [0, 0, 0], upper = [1, 1, 1], spacing = 0.5, noise = 0.03 }}\n\
             [output]\ndirectory = \"results\"\nparticles = {end}\nseries = {end}\ncheckpoint = {end}\n\
             [fluid]\ndensity = 1\nviscosity = 1\ncells = [{cells}, 20, 20]\nresolved = {{ motion = \"fixed\" }}\n{key}\n{flow}\n",
            ends[0], ends[1]
        )
    }
}

/// Force, pressure drop and mean velocity along the flow at the end of a run.
fn ends(results: &Path) -> [f64; 3] {
    let table = series(results);
    let sum = |a: &str, b: &str| table.column(a).last().unwrap() + table.column(b).last().unwrap();
    [
        sum("bodies_fx", "bodies_fx") / 2.0,
        sum("drive_x", "pressure_drop"),
        sum("superficial_x", "superficial_x") / 2.0,
    ]
}

fn run(home: &Path, label: &str, ranks: usize, text: &str, options: &[&str]) -> (std::path::PathBuf, String) {
    let own = home.join(label);
    fs::create_dir_all(&own).unwrap();
    let output = run_case(ranks, &own, text, options).succeeded();
    (own.join("results"), output.text())
}

#[test]
fn a_steady_flow_is_that_which_marching_in_time_leads_to() {
    let beds =
        [(SPHERE, 0.0, true, 1), (BOX, 0.0, false, 2), (CYLINDER, 20.0, true, 3), (SPHERE, 50.0, false, 4)];
    for (shape, reynolds, is_periodic, seed) in beds {
        let bed = Bed { shape, reynolds, is_periodic, seed };
        let home = folder(&format!("fluid_steady_{seed}"));
        let (found, told) =
            run(&home, "steady", 1, &bed.text(30.0, &format!("steady = {{ tolerance = {TOLERANCE} }}")), &[]);
        assert!(told.contains("steady flow settled after"), "{told}");
        // Slow modes settle at marching steps of ν Δt/Δx² = 1 in hundreds of them.
        let end = if reynolds == 0.0 { 1.2 } else { 3.0 / reynolds };
        let (marched, _) = run(&home, "marched", 2, &bed.text(end, ""), &[]);
        let (wanted, here) = (ends(&marched), ends(&found));
        for ((wanted, here), what) in wanted.iter().zip(here).zip(["force", "drop", "velocity"]) {
            assert!(
                (here / wanted - 1.0).abs() < 2.0 * TOLERANCE,
                "{seed} {what}: {here} instead of {wanted}"
            );
        }
        // What is said to be left is below what was asked for.
        for column in ["unsettled_force", "unsettled_gradient", "unsettled_velocity"] {
            let left = *series(&found).column(column).last().unwrap();
            assert!((0.0..TOLERANCE).contains(&left), "{column} {left}");
        }
    }
}

#[test]
fn a_steady_flow_is_the_same_on_any_ranks_and_after_a_restart() {
    let home = folder("fluid_steady_ranks");
    let bed = Bed { shape: CYLINDER, reynolds: 10.0, is_periodic: true, seed: 5 };
    let text = |end: f64, checkpoint: f64| {
        let key = "steady = { tolerance = 1e-7, history = 5 }";
        bed.text(end, key).replace(&format!("checkpoint = {end}"), &format!("checkpoint = {checkpoint}"))
    };
    let whole = text(3.0, 3.0);
    let (one, _) = run(&home, "1", 1, &whole, &[]);
    let wanted = ends(&one);
    for ranks in [2, 4] {
        let (other, _) = run(&home, &ranks.to_string(), ranks, &whole, &[]);
        assert_close(&wanted[..2], &ends(&other)[..2], 4e-7, &format!("{ranks} ranks"));
    }
    // From a checkpoint on the way.
    let stopped = text(3.0, 0.005);
    run(&home, "way", 2, &stopped, &[]);
    assert!(checkpoints(&home.join("way/results")).len() > 1, "no checkpoint on the way");
    let restarted = continued(&home, "way", 4, &stopped);
    assert_close(&wanted[..2], &ends(&restarted)[..2], 4e-7, "after a restart");
}

/// Two bodies in a pipe that follows no grid line, and a baffle that meets its wall: walls bound steady flows as those in time.
#[test]
fn walls_bound_a_steady_flow_as_they_do_one_in_time() {
    let home = folder("fluid_steady_walls");
    let wall =
        |name: &str, rest: &str| format!("[[wall]]\nname = \"{name}\"\nmaterial = \"solid\"\n{rest}\n");
    let walls = wall(
        "pipe",
        "kind = \"revolution\"\norigin = [0, 0.507, 0.493]\naxis = [1, 0, 0]\nprofile = [[-9, 0.41], [0.6, 0.41], [0.8, 0.47], [9, 0.47]]\nfluid = \"inside\"",
    ) + &wall(
        "baffle",
        "kind = \"box\"\nlower = [0.61, -1, -1]\nupper = [0.77, 0.32, 2]\nside = \"outside\"\nfluid = \"particles\"",
    );
    let text = |reynolds: f64, end: f64, key: &str| {
        let bed = Bed { shape: SPHERE, reynolds, is_periodic: false, seed: 6 };
        let text = bed.text(end, key);
        let place = "place = { kind = \"lattice\", lower = [0, 0.28, 0.28], upper = [0.44, 0.72, 0.72], spacing = 0.44, noise = 0.02 }";
        let old = "place = { kind = \"lattice\", lower = [0, 0, 0], upper = [1, 1, 1], spacing = 0.5, noise = 0.03 }";
        let speed = if reynolds == 0.0 { 1e-3 } else { reynolds / 0.4 };
        let inlet = format!("\"{speed} * step(0.41^2 - (y - 0.507)^2 - (z - 0.493)^2)\"");
        replaced(&replaced(&text, old, place), "count = 8", "count = 1")
            .replace("periodic = [false, true, true]", "periodic = [false, false, false]")
            .replace(&format!("velocity = [{speed}, 0, 0]"), &format!("velocity = [{inlet}, 0, 0]"))
            .replace("[output]", &format!("{walls}[output]"))
    };
    let reynolds = 10.0;
    let tolerance = 1e-6;
    let steady = text(reynolds, 30.0, &format!("steady = {{ tolerance = {tolerance} }}"));
    let (found, told) = run(&home, "steady", 1, &steady, &[]);
    assert!(told.contains("steady flow settled after"), "{told}");
    let (shared, _) = run(&home, "shared", 2, &steady, &[]);
    let (marched, _) = run(&home, "marched", 2, &text(reynolds, 0.1, ""), &[]);
    for name in ["pipe_flow_fx", "baffle_flow_fx", "bodies_fx", "pressure_drop"] {
        let [here, of_ranks, wanted] =
            [&found, &shared, &marched].map(|results| *series(results).column(name).last().unwrap());
        assert!((here / wanted - 1.0).abs() < 4.0 * tolerance, "{name}: {here} instead of {wanted}");
        assert!((of_ranks / here - 1.0).abs() < tolerance, "{name}: {of_ranks} on two ranks, {here} on one");
    }
}
