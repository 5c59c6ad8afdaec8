//! Resolved bodies in a flow: free, fixed and driven, on any ranks and across restarts.

use super::{array, assert_close, assert_same_fluid, continued, number_after, results_of};
use crate::common::results::{checkpoints, series, step_of};
use crate::common::{case, folder, replaced, run_case};
use hdf5::File;
use std::fs;
use std::path::Path;

#[test]
fn resolved_bodies_move_alike_on_any_ranks_and_across_restarts() {
    let (home, text) = (folder("fluid_resolved"), case("resolved.toml"));
    // Forces on all together, on one alone, and on one that is not there.
    let text = format!("{text}\n[fluid.output]\nbodies = [2, 9]\n");
    let result = |label: &str, ranks: usize, text: &str| results_of(&home, label, ranks, text);
    let one = result("1", 1, &text);
    let table = series(&one);
    for column in ["momentum_x", "momentum_z", "kinetic_rotation", "superficial_z"] {
        assert!(table.column(column).last().unwrap().abs() > 1e-10, "{column} says nothing");
    }
    let mut others = vec![result("2", 2, &text), result("4", 4, &text)];
    others.push(continued(&home, "2", 4, &text));
    for other in &others {
        assert_same_fluid(&one, other, 1e-9);
        for column in ["momentum_x", "momentum_y", "momentum_z", "kinetic_rotation", "superficial_z"] {
            let (a, b) = (table.column(column), series(other).column(column));
            assert_close(&a, &b, 1e-9, &format!("{} {column}", other.display()));
        }
        for load in ["fx", "fy", "fz", "tx", "ty", "tz"] {
            for column in [format!("bodies_{load}"), format!("body_2_{load}")] {
                let (a, b) = (table.column(&column), series(other).column(&column));
                assert_close(&a, &b, 1e-8, &format!("{} {column}", other.display()));
            }
            assert!(series(other).column(&format!("body_9_{load}")).iter().all(|x| x.is_nan()), "{load}");
        }
    }
    assert_series_have_the_loads(&one);
    // A run that leaves whenever it may stops between two steps of the fluid, in one that the particles have not gone through.
    let own = home.join("step by step");
    fs::create_dir_all(&own).unwrap();
    run_case(2, &own, &text, &["--max-walltime", "0"]).succeeded();
    for ranks in [1, 4, 2, 1] {
        run_case(ranks, &own, &text, &["--restart", "latest", "--max-walltime", "0"]).succeeded();
    }
    let last = step_of(checkpoints(&own.join("results")).last().unwrap());
    assert!(last == 5 && table.column("time")[1] > 5e-3, "{last}");
    run_case(2, &own, &text, &["--restart", "latest"]).succeeded();
    others.push(own.join("results"));
    for other in &others {
        assert_same_fluid(&one, other, 1e-9);
    }
    // Held fast they may be as close and as large as they like, and there are no contacts to describe.
    let fixed = replaced(&text, "motion = \"free\"", "motion = \"fixed\"");
    let fixed = replaced(&fixed, "radius = 0.15", "radius = 0.28");
    let one = result("fixed-1", 1, &fixed);
    assert_same_fluid(&one, &result("fixed-4", 4, &fixed), 1e-9);
    assert_same_fluid(&one, &continued(&home, "fixed-4", 2, &fixed), 1e-9);
    assert!(series(&one).column("drive_x").last().unwrap() > &0.0);
    // Bodies that stay do not bring the velocities they were inserted with.
    assert!(series(&one).column("momentum_x").iter().all(|&p| p == 0.0));
}

#[test]
fn free_fixed_and_driven_bodies_share_a_flow_on_any_ranks_and_across_restarts() {
    let home = folder("fluid_driven");
    let text = format!("{}\n[fluid.output]\nbodies = [2]\n", case("resolved_driven.toml"));
    let result = |label: &str, ranks: usize, text: &str| results_of(&home, label, ranks, text);
    let one = result("1", 1, &text);
    let table = series(&one);
    let mut others = vec![result("2", 2, &text), result("4", 4, &text)];
    others.push(continued(&home, "2", 4, &text));
    let loads = ["fx", "fy", "fz", "tx", "ty", "tz"];
    for other in &others {
        assert_same_fluid(&one, other, 1e-9);
        for name in ["post", "swing", "mill"] {
            for load in loads {
                let column = format!("insert_{name}_flow_{load}");
                let (a, b) = (table.column(&column), series(other).column(&column));
                assert_close(&a, &b, 1e-8, &format!("{} {column}", other.display()));
            }
        }
    }
    assert_series_have_the_loads(&one);
    // Those of prescribed motion are where it is, those that are free have been moved by weight and flow.
    let path = one.join("particles.vtkhdf");
    let (times, points) = (array(&path, "VTKHDF/Steps/Values"), array(&path, "VTKHDF/Points"));
    let ids = File::open(&path).unwrap().dataset("VTKHDF/PointData/id").unwrap().read_raw::<i64>().unwrap();
    let place = |step: usize, id: i64| -> Vec<f64> {
        let row = (6 * step..6 * step + 6).find(|&k| ids[k] == id).unwrap();
        points[3 * row..3 * row + 3].to_vec()
    };
    for (step, time) in times.iter().enumerate() {
        let swing = (std::f64::consts::TAU * 4.0 * time).sin();
        for (id, way) in [(3, [0.0; 3]), (4, [0.05 * swing, 0.0, 0.02 * swing]), (5, [0.0; 3])] {
            let wanted: Vec<f64> = place(0, id).iter().zip(way).map(|(x, d)| x + d).collect();
            assert_close(&wanted, &place(step, id), 1e-12, &format!("place of {id} at {time}"));
        }
    }
    let last = times.len() - 1;
    assert!(place(last, 0)[2] < place(0, 0)[2] - 1e-3, "the brick sinks");
    // The mill is braked by the fluid, the post is pushed along it.
    let brake = table.column("insert_mill_flow_tx");
    assert!(brake[2..].iter().all(|&t| t < 0.0), "{brake:?}");
}

/// A step of the fluid is as long as a contact here. Were it told of contacts a step late, they would shake the cubes without end: their
/// energy of rotation would stay above 0.2 J.
#[test]
fn packed_cubes_come_to_rest_on_any_ranks_and_across_restarts() {
    let (home, text) = (folder("fluid_packing"), case("resolved_packing.toml"));
    let shared = |ranks: &str| replaced(&text, "[domain]\n", &format!("[domain]\nranks = {ranks}\n"));
    let four = results_of(&home, "4", 4, &shared("[1, 2, 2]"));
    for result in [&four, &continued(&home, "4", 2, &shared("[1, 2, 1]"))] {
        let table = series(result);
        let (turning, moving) = (table.column("kinetic_rotation"), table.column("kinetic_translation"));
        let largest = |energy: &[f64]| energy.iter().copied().fold(0.0, f64::max);
        assert!(largest(&moving) > 5.0 && largest(&turning) > 0.3, "they fall and tumble");
        let (turning, moving) = (largest(&turning[80..]), largest(&moving[80..]));
        assert!(turning < 0.05 && moving < 0.2, "{}: {turning} and {moving} J", result.display());
    }
    // Until rounding has grown, the first contacts included.
    let one = series(&results_of(&home, "1", 1, &replaced(&text, "end = 5", "end = 0.75")));
    for column in ["kinetic_rotation", "kinetic_translation", "contacts"] {
        let a = one.column(column);
        assert_close(&a, &series(&four).column(column)[..a.len()], 1e-6, column);
    }
    assert!(one.column("contacts").iter().any(|&n| n > 2.0), "some touch by then");
}

/// Borders between ranks follow the bodies at any of their steps, also where these have left velocities of the fluid for a moment.
#[test]
fn borders_that_move_amid_a_step_of_the_fluid_change_nothing() {
    let home = folder("fluid_moved_borders");
    let changes = [
        ("upper = [2.3, 3.9, 3.9]", "upper = [3.9, 3.9, 5.9]"),
        ("cells = [18, 30, 30]", "cells = [30, 30, 45]"),
        ("count = 18", "count = 40"),
        ("end = 5", "end = 0.4"),
        ("checkpoint = 2.5", "checkpoint = 0.2"),
    ];
    // The box of the domain is that of the wall.
    let larger = case("resolved_packing.toml").replace("upper = [2.4, 4, 4]", "upper = [4, 4, 6]");
    let text = changes.iter().fold(larger, |text, (old, new)| replaced(&text, old, new));
    let dye = "[[fluid.scalar]]\nname = \"dye\"\nkind = \"concentration\"\ndiffusivity = 0.02\n\
               initial = \"step(z - 3)\"\nparticles = { value = 2 }\n";
    let shared = |ranks: &str| {
        replaced(&format!("{text}{dye}"), "[domain]\n", &format!("[domain]\nranks = {ranks}\n"))
    };
    let one = results_of(&home, "1", 1, &shared("[1, 1, 1]"));
    let table = series(&one);
    let content = table.column("dye_content")[0];
    for (label, ranks, grid) in [("4", 4, "[1, 2, 2]"), ("8", 8, "[2, 2, 2]")] {
        let own = home.join(label);
        fs::create_dir_all(&own).unwrap();
        let output = run_case(ranks, &own, &shared(grid), &[]).succeeded();
        assert!(number_after(&output.stdout, "borders moved ") > 0, "{}", output.stdout);
        for result in [&own.join("results"), &continued(&home, label, 3, &shared("[1, 1, 3]"))] {
            for column in
                ["kinetic_rotation", "kinetic_translation", "fluid_kinetic", "contacts", "dye_from_particles"]
            {
                assert_close(&table.column(column), &series(result).column(column), 1e-8, column);
            }
            let unaccounted = series(result).column("dye_unaccounted");
            assert!(unaccounted.iter().all(|x| x.abs() < 1e-12 * content), "{unaccounted:?} of {content}");
        }
    }
}

#[test]
fn multipliers_give_the_same_flow_on_any_ranks_and_across_restarts() {
    let multipliers = "motion = \"free\", method = \"multiplier\", tolerance = 1e-11";
    // Bodies between walls and a periodic side, and many that fall close to each other.
    let falling = [("end = 5", "end = 0.1"), ("checkpoint = 2.5", "checkpoint = 0.05")];
    let falling =
        falling.iter().fold(case("resolved_packing.toml"), |text, (old, new)| replaced(&text, old, new));
    let few = ("few", case("resolved.toml"), ["[2, 1, 1]", "[2, 2, 1]"]);
    for (name, text, grids) in [few, ("many", falling, ["[1, 1, 2]", "[1, 2, 2]"])] {
        let text = replaced(&text, "motion = \"free\"", multipliers);
        let shared = |ranks: &str| replaced(&text, "[domain]\n", &format!("[domain]\nranks = {ranks}\n"));
        let home = folder(&format!("fluid_multipliers_{name}"));
        let one = results_of(&home, "1", 1, &text);
        let table = series(&one);
        assert!(table.column("multiplier_iterations").last().unwrap() > &3.0);
        let [two, four] = grids.map(shared);
        let others = [
            results_of(&home, "2", 2, &two),
            results_of(&home, "4", 4, &four),
            continued(&home, "2", 4, &four),
            continued(&home, "4", 1, &text),
        ];
        for other in &others {
            assert_same_fluid(&one, other, 1e-8);
            for column in ["momentum_x", "momentum_y", "momentum_z", "kinetic_rotation", "fluid_kinetic"] {
                let (a, b) = (table.column(column), series(other).column(column));
                assert_close(&a, &b, 1e-8, &format!("{} {column}", other.display()));
            }
        }
    }
}

/// Asserts that the time series has the forces and torques of the snapshots, summed and of the particle with id 2.
fn assert_series_have_the_loads(results: &Path) {
    let (table, path) = (series(results), results.join("particles.vtkhdf"));
    let times = array(&path, "VTKHDF/Steps/Values");
    let ids = File::open(&path).unwrap().dataset("VTKHDF/PointData/id").unwrap().read_raw::<i64>().unwrap();
    let per_step = ids.len() / times.len();
    for (quantity, letter) in [("fluid_force", 'f'), ("fluid_torque", 't')] {
        let values = array(&path, &format!("VTKHDF/PointData/{quantity}"));
        for (step, time) in times.iter().enumerate() {
            let row = table.column("time").iter().position(|t| (t - time).abs() < 1e-9).unwrap();
            for (a, axis) in ["x", "y", "z"].iter().enumerate() {
                let own = step * per_step..(step + 1) * per_step;
                let of = |k: usize| values[3 * k + a];
                let size = own.clone().map(|k| of(k).abs()).fold(0.0, f64::max);
                let (sum, one) =
                    (own.clone().map(of).sum::<f64>(), own.clone().find(|&k| ids[k] == 2).map(of).unwrap());
                for (name, wanted) in [("bodies", sum), ("body_2", one)] {
                    let found = table.column(&format!("{name}_{letter}{axis}"))[row];
                    assert!(
                        (found - wanted).abs() <= 1e-12 * size,
                        "{name} {quantity} {axis}: {found} {wanted}"
                    );
                }
            }
        }
    }
}

#[test]
fn cells_inside_bodies_have_their_velocity() {
    let home = folder("fluid_inside");
    run_case(2, &home, &case("resolved.toml"), &[]).succeeded();
    let (results, layers) = (home.join("results"), [30, 25, 20]);
    let steps = array(&results.join("fluid.vtkhdf"), "VTKHDF/Steps/Values").len();
    let all = |name: &str| array(&results.join("fluid.vtkhdf"), &format!("VTKHDF/CellData/{name}"));
    let (void, fluid, solid) = (all("void_fraction"), all("velocity"), all("solid_velocity"));
    let cells: usize = layers.iter().product();
    let mut inside = 0;
    for step in 1..steps {
        for cell in 0..cells {
            let [i, j, k] = [cell % layers[0], cell / layers[0] % layers[1], cell / layers[0] / layers[1]];
            // The faces of full cells beside cells that are half full lie inside bodies.
            let around = [
                [(i + 1) % 30, j, k],
                [(i + 29) % 30, j, k],
                [i, j + 1, k],
                [i, j.wrapping_sub(1), k],
                [i, j, k + 1],
                [i, j, k.wrapping_sub(1)],
            ];
            let void_of = |[i, j, k]: [usize; 3]| match j < layers[1] && k < layers[2] {
                true => void[step * cells + (k * layers[1] + j) * layers[0] + i],
                false => 1.0,
            };
            if void_of([i, j, k]) > 0.0 || around.into_iter().any(|cell| void_of(cell) > 0.6) {
                continue;
            }
            inside += 1;
            for a in 0..3 {
                let place = 3 * (step * cells + cell) + a;
                let (u, v) = (fluid[place], solid[place]);
                assert!((u - v).abs() < 1e-6 * (v.abs() + 0.1), "{step} {i} {j} {k} {a}: {u} {v}");
            }
        }
    }
    assert!(inside > 50, "{inside}");
}

#[test]
fn resolved_bodies_may_leave_through_an_outlet() {
    let (home, text) = (folder("fluid_leaving"), case("leaving.toml"));
    let result = |ranks: usize| results_of(&home, &ranks.to_string(), ranks, &text);
    let one = result(1);
    let table = series(&one);
    let (left, energy) = (table.column("left"), table.column("fluid_kinetic"));
    let gone = left.iter().position(|&n| n == 2.0).unwrap();
    assert_eq!(left.last(), Some(&2.0));
    // Nothing drives the flow any more: it comes to rest.
    assert!(energy[gone..].windows(2).all(|pair| pair[1] < pair[0]), "{:?}", &energy[gone..]);
    assert!(table.column("fluid_divergence")[gone + 1..].iter().all(|&d| d < 1e-12));
    assert_same_fluid(&one, &result(4), 1e-9);
}
