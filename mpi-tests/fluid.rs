//! The fluid in the program: on any ranks, across restarts, alone and among particles, and what is refused.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{checkpoints, series, step_of};
use common::{case, folder, replaced, run_case};
use hdf5::File;
use std::fs;
use std::path::Path;

/// An array of doubles of a file.
fn array(path: &Path, name: &str) -> Vec<f64> {
    let read = || File::open(path)?.dataset(name)?.read_raw::<f64>();
    read().unwrap_or_else(|e| panic!("{} {name}: {e}", path.display()))
}

/// Asserts that two lists agree to a share of their largest size.
fn assert_close(wanted: &[f64], found: &[f64], share: f64, what: &str) {
    assert_eq!(wanted.len(), found.len(), "{what}");
    let size = wanted.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let worst = wanted.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst <= share * size, "{what}: differs by {:e} of {size:e}", worst / size);
}

/// Asserts that the last states and the files of two runs agree.
fn assert_same_fluid(wanted: &Path, found: &Path, share: f64) {
    let last = |folder: &Path| checkpoints(folder).last().unwrap().clone();
    let (a, b) = (last(wanted), last(found));
    assert_eq!(a.file_name(), b.file_name());
    for name in ["velocity_x", "velocity_y", "velocity_z", "pressure"] {
        let name = format!("grids/{name}");
        assert_close(&array(&a, &name), &array(&b, &name), share, &format!("{} {name}", b.display()));
    }
    let (a, b) = (wanted.join("fluid.vtkhdf"), found.join("fluid.vtkhdf"));
    for name in ["VTKHDF/Steps/Values", "VTKHDF/CellData/velocity", "VTKHDF/CellData/pressure"] {
        assert_close(&array(&a, name), &array(&b, name), share, &format!("{} {name}", b.display()));
    }
}

fn copy_files(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten().filter(|e| e.path().is_file()) {
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

/// Continues a run from its first checkpoint on other ranks, in a folder of its own.
fn continued(home: &Path, from: &str, ranks: usize, text: &str) -> std::path::PathBuf {
    let own = home.join(format!("from-{from}-on-{ranks}"));
    copy_files(&home.join(from).join("results"), &own.join("results"));
    checkpoints(&own.join("results"))[1..].iter().for_each(|later| fs::remove_file(later).unwrap());
    run_case(ranks, &own, text, &["--restart", "latest"]).succeeded();
    own.join("results")
}

#[test]
fn a_fluid_alone_is_the_same_on_any_ranks_and_across_restarts() {
    let (home, text) = (folder("fluid_duct"), case("duct.toml"));
    let result = |label: &str, ranks: usize| {
        let own = home.join(label);
        fs::create_dir_all(&own).unwrap();
        run_case(ranks, &own, &text, &[]).succeeded();
        own.join("results")
    };
    let one = result("1", 1);
    for ranks in [2, 4] {
        assert_same_fluid(&one, &result(&ranks.to_string(), ranks), 1e-10);
    }
    assert_same_fluid(&one, &continued(&home, "2", 3, &text), 1e-10);
    let table = series(&one);
    let inflow = |t: f64| (0.1 * 0.06 - 0.03 * 0.03) * 0.1 * (1.0 + (20.0 * t).sin()) + 0.03 * 0.03 * 0.3;
    for (t, flow) in table.column("time").iter().zip(table.column("middle_flow")).skip(1) {
        // The patch takes whole cells.
        assert!((flow / inflow(*t) - 1.0).abs() < 0.2, "{flow} against {} at {t}", inflow(*t));
    }
    let means = |folder: &Path| -> Vec<f64> {
        let text = fs::read_to_string(folder.join("profile-axis-mean.csv")).unwrap();
        let rows = text.lines().filter(|l| !l.starts_with('#')).skip(1);
        rows.flat_map(|row| row.split(',').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>()).collect()
    };
    assert_eq!(means(&one).len(), 9 * 7, "nine points of x, y, z, three velocities and a pressure");
    // No sample is lost or taken twice.
    assert_close(&means(&one), &means(&home.join("from-2-on-3/results")), 1e-10, "means after a restart");
    // A run may be made longer, and its snapshots come at the old times.
    let longer = replaced(&text, "end = 0.4", "end = 0.5");
    run_case(2, &home.join("2"), &longer, &["--restart", "latest"]).succeeded();
    let times = array(&home.join("2/results/fluid.vtkhdf"), "VTKHDF/Steps/Values");
    assert_close(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5], &times, 1e-12, "times");
}

/// Settling at zero flux of the mixture, in a periodic box: what the particles take down the fluid brings up, and the drive
/// carries their buoyant weight. Dense beads in a thick fluid, of a relaxation time far below the step, reach a given flux too.
#[test]
fn beads_settle_in_a_periodic_box_at_zero_flux_of_the_mixture() {
    let (home, text) = (folder("fluid_settling"), case("settling.toml"));
    let volume = 0.012 * 0.012 * 0.024;
    let flux = |home: &Path, axis: &str| -> Vec<f64> {
        let table = series(&home.join("results"));
        let fluid = table.column(&format!("superficial_{axis}"));
        let solid = table.column(&format!("momentum_{axis}"));
        fluid.iter().zip(solid).map(|(fluid, solid)| fluid + solid / (2500.0 * volume)).collect()
    };
    for ranks in [1, 4] {
        let own = home.join(ranks.to_string());
        fs::create_dir_all(&own).unwrap();
        let output = run_case(ranks, &own, &text, &[]).succeeded();
        assert!(!output.stderr.contains("accelerate for ever"), "{}", output.stderr);
        let table = series(&own.join("results"));
        let last = |name: &str| *table.column(name).last().unwrap();
        let (up, down) = (last("superficial_z"), -last("momentum_z") / (2500.0 * volume));
        assert!(up > 2e-3 && (up / down - 1.0).abs() < 1e-3, "{up} up, {down} down");
        for axis in ["x", "y", "z"] {
            let late = flux(&own, axis).into_iter().skip(8);
            let largest = late.fold(0.0, |most: f64, flux| most.max(flux.abs()));
            assert!(largest < 1e-3 * up, "{axis}: {largest} of {up}");
        }
        let weight = 1500.0 * 9.81 * last("solid_volume") / volume;
        assert!((last("drive_z") / weight - 1.0).abs() < 1e-3, "{} for {weight}", last("drive_z"));
        // Of the momentum that drag has moved.
        assert!(
            last("momentum_imbalance").abs() < 1e-9 * weight * volume * 0.15,
            "{}",
            last("momentum_imbalance")
        );
    }
    let edits = [
        ("count = 1000", "count = 3456"),
        ("spacing = 1.5e-3, noise = 0.02", "spacing = 1e-3"),
        ("radius = 0.5e-3", "radius = 0.497e-3"),
        ("viscosity = 0.01", "viscosity = 0.2"),
        ("velocity = [0, 0, 0], axes", "velocity = [1e-3, 0, 2e-3], axes"),
        ("series = 0.01", "series = 0.005"),
        ("end = 0.15", "end = 0.03"),
        ("dt = 1.2e-5", "dt = 4e-5"),
        ("normal_stiffness = 100", "normal_stiffness = 10"),
        ("checkpoint = 0.1", "checkpoint = 0"),
    ];
    let own = home.join("dense");
    fs::create_dir_all(&own).unwrap();
    let dense = edits.iter().fold(text, |text, (old, new)| replaced(&text, old, new));
    run_case(2, &own, &dense, &[]).succeeded();
    for (axis, wanted) in [("x", 1e-3), ("y", 0.0), ("z", 2e-3)] {
        let found = *flux(&own, axis).last().unwrap();
        assert!((found - wanted).abs() < 0.2 * 2e-3, "{axis}: {found} for {wanted}");
    }
}

/// A step of the fluid is shorter than the particle steps given where the CFL number asks for it, and says so once; where
/// one step of the particles is too long already the run says which key must change.
#[test]
fn the_cfl_number_is_kept_or_the_run_says_what_would_keep_it() {
    let home = folder("fluid_cfl");
    let with_steps = replaced(&case("bed.toml"), "model = \"A\", ", "model = \"A\", particle_steps = 300, ");
    let output = run_case(2, &home, &with_steps, &[]).succeeded();
    let told = output.stderr.matches("(fluid.coupling.particle_steps) would pass fluid.cfl = 0.25").count();
    assert_eq!(told, 1, "{}", output.stderr);
    // By the velocity at the beginning of a step; at its end that may be a little faster.
    let largest = series(&home.join("results")).column("fluid_cfl").into_iter().fold(0.0, f64::max);
    assert!(largest > 0.1 && largest < 0.3, "CFL number {largest}");
    let home = folder("fluid_cfl_refused");
    let too_long = replaced(&case("bed.toml"), "cells = [12, 4, 16]\n", "cells = [12, 4, 16]\ncfl = 1e-3\n");
    let output = run_case(2, &home, &too_long, &[]);
    let message = output.only_error(3);
    for words in ["t = ", "time.dt is 1.000e-5 s", "fluid.cfl = 0.001 allows", "take time.dt = "] {
        assert!(message.contains(words), "`{words}`: {message}");
    }
    // What it says does it.
    let most = message.split("take time.dt = ").nth(1).and_then(|rest| rest.split(',').next()).unwrap();
    let home = folder("fluid_cfl_followed");
    let shorter = replaced(&too_long, "dt = 1e-5", &format!("dt = {most}"));
    let shorter =
        replaced(&shorter, "end = 0.03", "end = 1e-5").replace("checkpoint = 0.015", "checkpoint = 0");
    run_case(2, &home, &shorter, &[]).succeeded();
}

#[test]
fn resolved_bodies_move_alike_on_any_ranks_and_across_restarts() {
    let (home, text) = (folder("fluid_resolved"), case("resolved.toml"));
    // Forces on all together, on one alone, and on one that is not there.
    let text = format!("{text}\n[fluid.output]\nbodies = [2, 9]\n");
    let result = |label: &str, ranks: usize, text: &str| {
        let own = home.join(label);
        fs::create_dir_all(&own).unwrap();
        run_case(ranks, &own, text, &[]).succeeded();
        own.join("results")
    };
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
    let result = |label: &str, ranks: usize, text: &str| {
        let own = home.join(label);
        fs::create_dir_all(&own).unwrap();
        run_case(ranks, &own, text, &[]).succeeded();
        own.join("results")
    };
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

/// The number after a phrase in what a run prints.
fn number_after(output: &str, phrase: &str) -> u32 {
    let (_, after) = output.split_once(phrase).unwrap();
    after.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn cells_and_what_is_known_of_them_follow_borders_that_move() {
    let home = folder("fluid_borders");
    // All particles begin in the lower half of a long box, in the subdomains of half of the ranks.
    let bed = replaced(&case("bed.toml"), "upper = [0.032,", "upper = [0.064,");
    let bed = replaced(&bed, "upper = [0.0317, 0.008, 0.03]", "upper = [0.013, 0.008, 0.035]");
    let bed = replaced(&bed, "point = [0.032,", "point = [0.064,");
    let bed = replaced(&bed, "cells = [12,", "cells = [24,");
    let line = "kind = \"line\"\nfrom = [0, 0.004, 0.01]\nto = [0.064, 0.004, 0.01]\npoints = 20";
    let means =
        format!("[fluid.output]\nmean_from = 2e-3\n\n[[fluid.profile]]\nname = \"low\"\n{line}\n\n[output]");
    let bed = replaced(&bed, "[output]", &means);
    let by_petsc = replaced(&bed, "[output]", "[fluid.pressure]\nmethod = \"petsc\"\n\n[output]");
    let bodies = replaced(&case("resolved.toml"), "upper = [1.5,", "upper = [3,");
    let bodies = replaced(&bodies, "cells = [30,", "cells = [60,");
    let bodies = replaced(&bodies, "end = 0.12", "end = 0.8");
    for (name, text, share) in [("bed", &bed, 1e-6), ("petsc", &by_petsc, 1e-6), ("bodies", &bodies, 1e-6)] {
        let result = |ranks: [usize; 3]| {
            let own = home.join(format!("{name}-{}", ranks.map(|n| n.to_string()).join("-")));
            fs::create_dir_all(&own).unwrap();
            let text = replaced(text, "periodic =", &format!("ranks = {ranks:?}\nperiodic ="));
            let output = run_case(ranks.iter().product(), &own, &text, &[]).succeeded();
            (own.join("results"), output.text())
        };
        let (one, _) = result([1; 3]);
        for ranks in [[2, 1, 1], [4, 1, 1]] {
            let (many, text) = result(ranks);
            assert!(number_after(&text, "borders moved ") > 0, "{name} {ranks:?}");
            // Of two ranks the other has got some of the many, and the cells about them.
            if ranks[0] == 2 && name != "bodies" {
                assert!(number_after(&text, "particles per rank: ") > 0, "{name}");
            }
            assert_same_fluid(&one, &many, share);
            let (a, b) = (series(&one), series(&many));
            for column in ["kinetic_translation", "pressure_drop", "fluid_kinetic", "superficial_z"] {
                assert_close(
                    &a.column(column),
                    &b.column(column),
                    share,
                    &format!("{name} {column} {ranks:?}"),
                );
            }
            if name != "bodies" {
                for array_name in ["velocity", "pressure", "void_fraction", "solid_velocity"] {
                    let path = format!("VTKHDF/CellData/{array_name}");
                    let of = |folder: &Path| array(&folder.join("fluid-mean.vtkhdf"), &path);
                    assert_close(&of(&one), &of(&many), share, &format!("mean {array_name} {ranks:?}"));
                }
                let imbalance = b.column("momentum_imbalance").iter().fold(0.0_f64, |m, x| m.max(*x));
                let largest = b.column("momentum_z").iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                assert!(imbalance < 1e-10 * largest, "{name} {imbalance} of {largest}");
            }
        }
    }
}

#[test]
fn resolved_bodies_may_leave_through_an_outlet() {
    let (home, text) = (folder("fluid_leaving"), case("leaving.toml"));
    let result = |ranks: usize| {
        let own = home.join(ranks.to_string());
        fs::create_dir_all(&own).unwrap();
        run_case(ranks, &own, &text, &[]).succeeded();
        own.join("results")
    };
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

#[test]
fn flow_between_plates_is_exact_and_stays() {
    let home = folder("fluid_plates");
    let text = r#"
gravity = [0, 0, 0]
[domain]
lower = [0, 0, 0]
upper = [0.4, 0.1, 0.2]
periodic = [true, false, true]
[time]
end = 20
[fluid]
density = 2
viscosity = 0.5
cells = [4, 10, 4]
drive = { kind = "pressure_gradient", gradient = [-3, 0, 0] }
initial = { velocity = ["3 / (2 * 0.5) * y * (0.1 - y)", 0, 0] }
[output]
directory = "results"
particles = 20
series = 1
"#;
    run_case(2, &home, text, &[]).succeeded();
    let velocity = array(&home.join("results/fluid.vtkhdf"), "VTKHDF/CellData/velocity");
    let cells = 4 * 10 * 4;
    let last = &velocity[velocity.len() - 3 * cells..];
    for (cell, u) in last.chunks_exact(3).enumerate() {
        let y = 0.1 * ((cell / 4 % 10) as f64 + 0.5) / 10.0;
        let exact = 3.0 * y * (0.1 - y);
        assert!((u[0] - exact).abs() < 1e-12 && u[1].abs() < 1e-14, "{u:?} against {exact} at y = {y}");
    }
}

#[test]
fn a_fluidised_bed_is_the_same_on_any_ranks_and_across_restarts() {
    let (home, text) = (folder("fluid_bed"), case("bed.toml"));
    let result = |label: &str, ranks: usize| {
        let own = home.join(label);
        fs::create_dir_all(&own).unwrap();
        run_case(ranks, &own, &text, &[]).succeeded();
        own.join("results")
    };
    let one = result("1", 1);
    let table = series(&one);
    let volumes = table.column("solid_volume");
    let given: f64 = volumes[0];
    // What the cells hold is what the particles are.
    let void = array(&one.join("fluid.vtkhdf"), "VTKHDF/CellData/void_fraction");
    let cells = 12 * 4 * 16;
    let cell = 0.032 * 0.008 * 0.04 / cells as f64;
    for step in void.chunks_exact(cells) {
        let solid: f64 = step.iter().map(|eps| (1.0 - eps) * cell).sum();
        assert!((solid / given - 1.0).abs() < 1e-12, "{solid} against {given}");
    }
    let largest = |name: &str| table.column(name).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(
        largest("momentum_imbalance") < 1e-10 * largest("momentum_z"),
        "{}",
        largest("momentum_imbalance")
    );
    assert!(largest("min_void_fraction") <= 1.0 && largest("pressure_drop") > 1.0);
    // Rounding grows with every collision.
    for ranks in [2, 4] {
        let found = series(&result(&ranks.to_string(), ranks));
        for name in ["kinetic_translation", "pressure_drop", "fluid_kinetic"] {
            assert_close(&table.column(name), &found.column(name), 1e-6, &format!("{name} on {ranks} ranks"));
        }
    }
    let found = series(&continued(&home, "2", 3, &text));
    assert_close(&table.column("pressure_drop"), &found.column("pressure_drop"), 1e-6, "after a restart");
    assert_close(&table.column("potential"), &found.column("potential"), 1e-9, "after a restart");
    let lost = found.column("momentum_imbalance").iter().fold(0.0_f64, |m, x| m.max(*x));
    assert!(lost < 1e-10 * largest("momentum_z"), "{lost} after a restart");
}

#[test]
fn particles_that_come_and_go_are_no_sources_of_fluid() {
    let (home, text) = (folder("fluid_rain"), case("rain.toml"));
    let result = |label: &str, ranks: usize, text: &str| {
        let own = home.join(label);
        fs::create_dir_all(&own).unwrap();
        run_case(ranks, &own, text, &[]).succeeded();
        own.join("results")
    };
    let one = result("1", 1, &text);
    let table = series(&one);
    let counts = table.column("particles");
    let came = counts.windows(2).filter(|n| n[1] > n[0]).count();
    let went = counts.windows(2).filter(|n| n[1] < n[0]).count();
    assert!(came >= 2 && went >= 10, "{came} batches after the first, {went} rows in which beads left");
    // Without them the jumps were 144 Pa and .35 m/s; after the start the drop is that of the beads' weight and less.
    let settled = || table.column("time").into_iter().enumerate().filter(|(_, t)| *t > 1e-3).map(|(k, _)| k);
    let range = |name: &str| {
        let column = table.column(name);
        settled().fold([f64::INFINITY, -f64::INFINITY], |[l, h], k| [l.min(column[k]), h.max(column[k])])
    };
    let ([least, most], [slowest, fastest]) = (range("pressure_drop"), range("superficial_z"));
    assert!(least > -1.0 && most < 3.0, "pressure drop from {least} to {most} Pa");
    assert!(slowest > 0.49 && fastest < 0.51, "superficial velocity from {slowest} to {fastest} m/s");
    let largest = |name: &str| table.column(name).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let (lost, moved) = (largest("momentum_imbalance"), largest("momentum_z"));
    assert!(lost < 1e-10 * moved, "{lost} N s of {moved} lost");
    let mut others = vec![result("2", 2, &text), result("4", 4, &text)];
    others.push(continued(&home, "2", 3, &text));
    // A run that stops wherever it may, also between two steps of the fluid and where a batch comes.
    let own = home.join("stops");
    fs::create_dir_all(&own).unwrap();
    run_case(2, &own, &text, &["--max-walltime", "0"]).succeeded();
    for ranks in [1, 3, 2] {
        run_case(ranks, &own, &text, &["--restart", "latest", "--max-walltime", "0.3"]).succeeded();
    }
    run_case(4, &own, &text, &["--restart", "latest"]).succeeded();
    others.push(own.join("results"));
    for other in &others {
        let found = series(other);
        let last = |table: &common::results::Series, name: &str| *table.column(name).last().unwrap();
        for name in ["pressure_drop", "fluid_kinetic", "kinetic_translation", "superficial_z"] {
            let (a, b) = (last(&table, name), last(&found, name));
            let size = largest(name);
            assert!((a - b).abs() < 1e-6 * size, "{} {name}: {a} and {b}", other.display());
        }
    }
    // A closed box stays closed: at the second batch it asked for an outlet.
    let closed = replaced(&text, "outlets = [\"-z\"]\n", "");
    let closed = replaced(&closed, "[true, true, false]", "[false, false, false]");
    let closed = replaced(
        &closed,
        "lower = [0, 0, 0.01], upper = [0.02, 0.02, 0.02]",
        "lower = [0.001, 0.001, 0.015], upper = [0.019, 0.019, 0.035]",
    );
    let closed = replaced(&closed, "end = 0.03", "end = 0.009");
    let closed = [
        closed.split("[[fluid.boundary]]").next().unwrap(),
        closed.split_once("[output]").map(|(_, rest)| ["[output]", rest].concat()).unwrap().as_str(),
    ]
    .concat();
    let found = series(&result("closed", 2, &closed));
    assert_eq!(found.column("particles").last(), Some(&80.0));
    assert!(
        found.column("superficial_z").iter().all(|u| u.abs() < 0.2),
        "{:?}",
        found.column("superficial_z")
    );
}

/// A body-centred cubic lattice of beads of 1 mm at a void fraction of 0.4 that are too heavy to move.
fn lattice(home: &Path, drag: &str, model: &str, velocity: f64) -> String {
    let edge = (2.0 * std::f64::consts::PI / 6.0 * 1e-9 / 0.6_f64).cbrt();
    let mut rows = String::from("x,y,z\n");
    for cell in 0..64 {
        let at = [cell % 4, cell / 4 % 4, cell / 16].map(f64::from);
        for shift in [0.0, 0.5] {
            let [x, y, z] = at.map(|c| (c + shift + 0.25) * edge);
            rows += &format!("{x},{y},{z}\n");
        }
    }
    fs::write(home.join("lattice.csv"), rows).unwrap();
    let length = 4.0 * edge;
    format!(
        r#"
gravity = [0, 0, 0]
[domain]
lower = [0, 0, 0]
upper = [{length}, {length}, {length}]
periodic = [true, true, true]
[time]
end = 0.02
dt = 1e-5
[[material]]
name = "lead"
density = 1e9
[[contact]]
between = ["lead", "lead"]
normal_stiffness = 1e6
restitution = 0.5
friction = 0
[[shape]]
name = "bead"
kind = "sphere"
radius = 0.5e-3
[[insert]]
name = "lattice"
particles = [{{ shape = "bead", material = "lead" }}]
place = {{ kind = "file", path = "lattice.csv" }}
[fluid]
density = 1.2
viscosity = 1.8e-5
cells = [4, 4, 4]
coupling = {{ drag = "{drag}", model = "{model}", particle_steps = 20 }}
drive = {{ kind = "mean_velocity", velocity = [0, 0, {velocity}], axes = [false, false, true] }}
[output]
directory = "results"
particles = 0
series = 0.02
"#
    )
}

#[test]
fn the_pressure_drop_of_a_lattice_is_that_of_the_law_in_both_models() {
    let cases = [
        ("beetstra", 1.0, 276.04),
        ("beetstra", 79.333, 46122.0),
        ("ergun", 1.0, 232.24),
        ("ergun", 79.333, 45952.0),
    ];
    for (drag, reynolds, wanted) in cases {
        for model in ["A", "B"] {
            let home = folder("fluid_lattice");
            let velocity = reynolds * 1.8e-5 / 1.2 / 1e-3;
            let text = lattice(&home, drag, model, velocity);
            run_case(1, &home, &text, &[]).succeeded();
            let gradient = *series(&home.join("results")).column("drive_z").last().unwrap();
            assert!((gradient / wanted - 1.0).abs() < 5e-3, "{drag} {model} Re {reynolds}: {gradient} Pa/m");
        }
    }
}

#[test]
fn a_bed_at_rest_loses_no_momentum_but_through_its_boundaries() {
    let (end, rate) = ("end = 0.03", "velocity = [0, 0, 1.0]");
    for (model, kernel) in
        [("A", "smooth\", half_width = 1.5"), ("B", "smooth\", half_width = 1.5"), ("A", "cube\"")]
    {
        let home = folder("fluid_rest");
        let text = replaced(&replaced(&case("bed.toml"), end, "end = 0.3"), rate, "velocity = [0, 0, 0.2]");
        let text = replaced(&text, "restitution = 0.8", "restitution = 0.3");
        let text = replaced(
            &text,
            "model = \"A\", kernel = { kind = \"smooth\", half_width = 1.5 }",
            &format!("model = \"{model}\", kernel = {{ kind = \"{kernel} }}"),
        );
        run_case(2, &home, &text, &[]).succeeded();
        let table = series(&home.join("results"));
        let last = |name: &str| *table.column(name).last().unwrap();
        let weight = (2500.0 - 1.2) * 9.81 * last("solid_volume");
        let carried = last("pressure_drop") * 0.032 * 0.008
            - last("distributor_fz")
            - last("left_fz")
            - last("right_fz");
        assert!(last("kinetic_translation") < 1e-9, "the bed rests: {}", last("kinetic_translation"));
        assert!(last("pressure_drop") > 1.0, "the air is felt");
        assert!(
            (carried / weight - 1.0).abs() < 2e-3,
            "{model} {kernel}: {} of the weight",
            carried / weight
        );
    }
}

#[test]
fn a_quiet_fluid_over_a_settled_bed_stays_quiet() {
    let inlet = "[[fluid.boundary]]\nface = \"-z\"\nkind = \"inlet\"\nvelocity = [0, 0, 1.0]\n";
    for model in ["A", "B"] {
        let home = folder("fluid_quiet");
        let text = replaced(&replaced(&case("bed.toml"), "end = 0.03", "end = 0.3"), inlet, "");
        let text = replaced(&text, "restitution = 0.8", "restitution = 0.3");
        let text = replaced(&text, "model = \"A\"", &format!("model = \"{model}\""));
        run_case(2, &home, &text, &[]).succeeded();
        let table = series(&home.join("results"));
        let (time, energy, drop) =
            (table.column("time"), table.column("fluid_kinetic"), table.column("pressure_drop"));
        let most = energy.iter().fold(0.0_f64, |m, e| m.max(*e));
        // From here on all grains lie; the air that they drove loses its motion to its own friction.
        let rest = time.iter().position(|t| *t >= 0.2).unwrap();
        assert!(energy[rest..].windows(2).all(|e| e[1] < e[0]), "{model}: {:?}", &energy[rest..]);
        let last = energy.len() - 1;
        assert!(
            energy[last] < 0.02 * most && energy[last] < 0.5 * energy[rest],
            "{} of {most}",
            energy[last]
        );
        assert!(
            drop[last].abs() < 1e-3 * drop.iter().fold(0.0_f64, |m, p| m.max(p.abs())),
            "{} Pa",
            drop[last]
        );
    }
}

#[test]
fn a_grain_settles_at_the_terminal_speed_of_its_law() {
    let home = folder("fluid_terminal");
    let text = r#"
[domain]
lower = [0, 0, 0]
upper = [0.08, 0.08, 0.24]
periodic = [true, true, false]
[time]
end = 0.6
dt = 2e-5
[[material]]
name = "glass"
density = 2500
[[contact]]
between = ["glass", "glass"]
normal_stiffness = 100
restitution = 0.5
friction = 0
[[shape]]
name = "bead"
kind = "sphere"
radius = 0.5e-3
[[insert]]
name = "bead"
particles = [{ shape = "bead", material = "glass" }]
count = 1
place = { kind = "lattice", lower = [0.03, 0.03, 0.2], upper = [0.05, 0.05, 0.221], spacing = 0.02 }
[fluid]
density = 1000
viscosity = 1e-3
cells = [4, 4, 12]
coupling = { drag = "schiller_naumann" }
[[fluid.boundary]]
face = "+z"
kind = "outlet"
[output]
directory = "results"
particles = 0
series = 0.05
"#;
    run_case(2, &home, text, &[]).succeeded();
    // Weight against drag: v = (rho_p − rho) g d² / (18 mu (1 + 0.15 Re^0.687)).
    let mut speed = 0.1_f64;
    for _ in 0..200 {
        speed = 1500.0 * 9.81 * 1e-6 / (18.0 * 1e-3 * (1.0 + 0.15 * (1000.0 * speed).powf(0.687)));
    }
    let found = *series(&home.join("results")).column("max_speed").last().unwrap();
    assert!((found / speed - 1.0).abs() < 5e-3, "{found} against {speed} m/s");
}

/// The message of a bed or duct with a passage replaced.
fn refused(name: &str, file: &str, (old, new): (&str, &str), code: i32) -> String {
    let home = folder(name);
    let text = replaced(&case(file), old, new);
    run_case(2, &home, &text, &[]).only_error(code).to_string()
}

#[test]
fn what_cannot_be_computed_is_refused_with_one_message() {
    let outlet = "[[fluid.boundary]]\nface = \"+z\"\nkind = \"outlet\"\n";
    let closed = refused("fluid_closed", "duct.toml", (outlet, ""), 2);
    assert!(closed.contains("outlet"), "{closed}");
    let narrow = ("kernel = { kind = \"smooth\", half_width = 1.5 }", "min_void_fraction = 0.7");
    let jammed = refused("fluid_jammed", "bed.toml", narrow, 3);
    assert!(jammed.contains("void fraction") && jammed.contains("min_void_fraction"), "{jammed}");
    let petsc = "[fluid.pressure]\nmethod = \"petsc\"\noptions = \"-ksp_tpye cg\"\n\n[fluid.output]\n";
    let option = refused("fluid_option", "duct.toml", ("[fluid.output]\n", petsc), 2);
    assert!(option.contains("ksp_tpye"), "{option}");
    let formula = "\"0.05 * sin(2 * pi * z / 0.2) * x / 0.1\"";
    let none = refused("fluid_no_number", "duct.toml", (formula, "\"sqrt(x - 0.05)\""), 2);
    assert!(none.contains("fluid.initial.velocity[1]") && none.contains("the formula is NaN at ["), "{none}");
    let few = "[fluid.pressure]\nmethod = \"petsc\"\ntolerance = 1e-12\niterations = 1\n\n[fluid.output]\n";
    let stuck = refused("fluid_stuck", "duct.toml", ("[fluid.output]\n", few), 3);
    assert!(stuck.contains("after 1 iterations"), "{stuck}");
}
