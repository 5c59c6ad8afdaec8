//! Walls that bound the fluid, with and without bodies: on any ranks, across restarts, and what is refused.

use super::{array, assert_close, assert_same_fluid, continued, results_of};
use crate::common::results::series;
use crate::common::{case, folder, replaced, run_case};
use std::fs;

/// What of the case is about the ball in it.
fn without_ball(text: &str) -> String {
    let [from, to] = ["[[shape]]", "[[wall]]"].map(|section| text.find(section).unwrap());
    let text = format!("{}{}", &text[..from], &text[to..]);
    let text = replaced(&text, "resolved = { motion = \"free\" }\n", "");
    replaced(&text, "dt = 1e-3\n", "")
}

#[test]
fn flow_between_walls_is_the_same_on_any_ranks_and_across_restarts() {
    let (home, with_ball) = (folder("fluid_walls"), case("walls_of_fluid.toml"));
    for (label, text) in [("ball", with_ball.clone()), ("alone", without_ball(&with_ball))] {
        let home = home.join(label);
        let result = |label: &str, ranks: usize| results_of(&home, label, ranks, &text);
        let one = result("1", 1);
        let table = series(&one);
        let mut others = vec![result("2", 2), result("4", 4)];
        others.push(continued(&home, "2", 4, &text));
        for other in &others {
            assert_same_fluid(&one, other, 1e-9);
            for wall in ["pipe", "stirrer"] {
                for load in ["fx", "fy", "fz", "tx", "ty", "tz"] {
                    let column = format!("{wall}_flow_{load}");
                    let (a, b) = (table.column(&column), series(other).column(&column));
                    assert_close(&a, &b, 1e-7, &format!("{} {column}", other.display()));
                }
            }
        }
        assert!(table.column("pipe_flow_fx").last().unwrap() > &1.0, "the flow pulls at the pipe");
        // The gate is there for a while.
        let time = table.column("time");
        for (t, force) in time.iter().zip(table.column("gate_flow_fx")).skip(1) {
            assert_eq!(force.is_nan(), *t > 0.0499, "{t}: {force}");
        }
        let void = array(&one.join("fluid.vtkhdf"), "VTKHDF/CellData/void_fraction");
        let [first, last] =
            [&void[..12_000], &void[void.len() - 12_000..]].map(|v| v.iter().sum::<f64>() / 12_000.0);
        let pipe = std::f64::consts::PI * 0.45 * 0.45;
        assert!(last < pipe && last > 0.97 * pipe && first < last - 0.01, "{first} {last} of {pipe}");
    }
}

#[test]
fn walls_that_cannot_bound_the_fluid_are_refused_with_place_and_remedy() {
    let text = without_ball(&case("walls_of_fluid.toml"));
    let home = folder("fluid_walls_refused");
    let refused = |label: &str, text: &str, words: &[&str]| {
        let own = home.join(label);
        fs::create_dir_all(&own).unwrap();
        let failed = run_case(2, &own, text, &[]);
        let message = failed.only_error(2);
        words.iter().for_each(|word| assert!(message.contains(word), "{label}: {word} in {message}"));
    };
    let leaking = replaced(&text, ", [2, 0, 3]]", "]");
    refused("leaking", &leaking, &["wall[1]", "not closed", "3 of 6 edges", "one of them at [1.2"]);
    let inverted = replaced(
        &text,
        "[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]",
        "[[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]",
    );
    refused("inverted", &inverted, &["wall[1]", "inside out", "flip its normals"]);
    let open = replaced(&text, "periodic = [true, false, false]", "periodic = [false, false, false]");
    let open = replaced(&open, "drive = { kind = \"pressure_gradient\", gradient = [-1000, 0, 0] }\n", "");
    let inlet = "[[fluid.boundary]]\nface = \"-x\"\nkind = \"inlet\"\nvelocity = [0.1, 0, 0]\n[[fluid.boundary]]\nface = \"+x\"\nkind = \"outlet\"\n";
    let blowing = replaced(&open, "[fluid.output]", &format!("{inlet}[fluid.output]"));
    refused("blowing", &blowing, &["fluid.boundary[0]", "blows into a wall", "step("]);
}
