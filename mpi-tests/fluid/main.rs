//! The fluid in the program, alone and with particles: on any ranks, across restarts, and what is refused.

#![allow(clippy::unwrap_used)]
mod averaged;
mod averaged_walls;
#[path = "../common/mod.rs"]
mod common;
mod inlets;
mod iterations;
mod resolved;
mod rheology;
mod scalars;
mod steady;
mod walls;

use common::results::{checkpoints, series};
use common::{case, folder, replaced, run_case, run_case_on_nodes};
use hdf5::File;
use std::fs;
use std::path::{Path, PathBuf};

/// An array of doubles of a file.
fn array(path: &Path, name: &str) -> Vec<f64> {
    let read = || File::open(path)?.dataset(name)?.read_raw::<f64>();
    read().unwrap_or_else(|e| panic!("{} {name}: {e}", path.display()))
}

/// The results of a case that runs in a folder of its own.
fn results_of(home: &Path, label: &str, ranks: usize, text: &str) -> PathBuf {
    let own = home.join(label);
    fs::create_dir_all(&own).unwrap();
    run_case(ranks, &own, text, &[]).succeeded();
    own.join("results")
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
    let result = |label: &str, ranks: usize| results_of(&home, label, ranks, &text);
    let one = result("1", 1);
    for ranks in [2, 4] {
        assert_same_fluid(&one, &result(&ranks.to_string(), ranks), 1e-10);
    }
    assert_same_fluid(&one, &continued(&home, "2", 3, &text), 1e-10);
    // Two nodes, each a brick of 2 x 2 ranks: ranks 2 and 4 change places.
    let grid = replaced(&text, "[domain]\n", "[domain]\nranks = [4, 2, 1]\n");
    let own = home.join("bricks");
    fs::create_dir_all(&own).unwrap();
    run_case_on_nodes(8, 4, &own, &grid).succeeded();
    assert_same_fluid(&one, &own.join("results"), 1e-10);
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
