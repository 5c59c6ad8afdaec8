//! Walls that bound the fluid, with and without bodies: on any ranks, across restarts, and what is refused.

use super::{array, assert_close, assert_same_fluid, continued, results_of};
use crate::common::results::series;
use crate::common::{case, folder, replaced, run_case};
use std::fs;
use std::path::Path;

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

/// A paddle off the axis of a round tank between floor and lid: what walls take of momentum and its moment the fluid loses.
#[test]
fn momentum_in_a_stirred_tank_is_what_its_walls_gave() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/stirred-tank/tank.toml");
    let lid = "[[wall]]\nname = \"lid\"\nmaterial = \"steel\"\nkind = \"plane\"\npoint = [0, 0, 1]\nnormal = [0, 0, -1]\nfluid = \"particles\"\n\n[fluid]";
    let changes = [
        ("upper = [0.5625, 0.5625, 1]", "upper = [0.5625, 0.5625, 1.0625]"),
        ("end = 2", "end = 0.3"),
        ("lower = [-0.25, -0.03, 0.4]", "lower = [-0.17, -0.07, 0.3]"),
        ("upper = [0.25, 0.03, 0.6]", "upper = [0.33, 0.07, 0.6]"),
        ("point = [0, 0, 0], axis", "point = [0.08, 0, 0], axis"),
        ("cells = [36, 36, 34]", "cells = [18, 18, 18]"),
        ("[fluid]", lid),
        ("[[fluid.boundary]]\nface = \"+z\"\nkind = \"symmetry\"\n", ""),
        ("series = 1e-3", "series = 2.5e-3"),
        ("directory = \"results/stirred-tank\"", "directory = \"results\""),
    ];
    let text = fs::read_to_string(path).unwrap();
    let text = changes.iter().fold(text, |text, (old, new)| replaced(&text, old, new));
    let results = results_of(&folder("fluid_stirred_tank"), "tank", 1, &text);
    let table = series(&results);
    let times = table.column("time");
    let [velocity, void, states] = ["CellData/velocity", "CellData/void_fraction", "Steps/Values"]
        .map(|name| array(&results.join("fluid.vtkhdf"), &format!("VTKHDF/{name}")));
    let (width, cells) = (0.0625, [18, 18, 18]);
    let number: usize = cells.iter().product();
    let place = |cell: usize| {
        let index = [cell % 18, cell / 18 % 18, cell / 324];
        [0, 1, 2].map(|a| [-0.5625, -0.5625, -0.0625][a] + width * (index[a] as f64 + 0.5))
    };
    let of_state = |k: usize, state: usize| -> f64 {
        let [b, c] = [(k + 1) % 3, (k + 2) % 3];
        let of_cell = |cell: usize| {
            let at = state * number + cell;
            let (x, u) = (place(cell), &velocity[3 * at..3 * at + 3]);
            width.powi(3) * void[at] * if k < 3 { u[k] } else { x[b] * u[c] - x[c] * u[b] }
        };
        (0..number).map(of_cell).sum()
    };
    for (k, load) in ["fx", "fy", "fz", "tx", "ty", "tz"].into_iter().enumerate() {
        let loads =
            ["tank", "floor", "lid", "paddle"].map(|wall| table.column(&format!("{wall}_flow_{load}")));
        // From when the first steps, in which the paddle starts at once, are over; 16 cells across close to 6 %.
        let begin = states[1];
        for (state, end) in states.iter().enumerate().skip(2) {
            let gained = of_state(k, state) - of_state(k, 1);
            let (mut taken, mut exchanged) = (0.0, 0.0);
            for row in (1..times.len()).filter(|&k| (begin + 1e-9..end + 1e-9).contains(&times[k])) {
                let step = times[row] - times[row - 1];
                taken += step * loads.iter().map(|load| load[row]).sum::<f64>();
                exchanged += step * loads.iter().map(|load| load[row].abs()).sum::<f64>();
            }
            let lost = (gained + taken) / exchanged;
            assert!(lost.abs() < 0.08, "{load} at {end}: {gained} {taken}, {lost} of {exchanged}");
        }
    }
    let gained = of_state(5, states.len() - 1);
    assert!(gained > 0.02, "the fluid turns: {gained}");
}
