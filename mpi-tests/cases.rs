//! Short forms of the repository's cases: fewer bodies and less time, through the same files and analyses.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::series;
use common::{folder, replaced, run, run_case};
use std::fs;
use std::path::Path;

/// A case of the repository with some passages replaced.
fn shortened(name: &str, changes: &[(&str, &str)]) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases").join(name);
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    changes.iter().fold(text, |text, (old, new)| replaced(&text, old, new))
}

/// A column of the table of an analysis of `results`.
fn analysed(home: &Path, what: &str, options: &[&str], column: &str) -> Vec<f64> {
    run(2, home, &[&["analyse", what, "results", "--output", "analysis"], options].concat()).succeeded();
    let text = fs::read_to_string(home.join("analysis").join(format!("{what}.csv"))).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let at = lines.next().unwrap().split(',').position(|name| name == column).unwrap();
    lines.map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

const OUTPUT: &str = "directory = \"results\"";

#[test]
fn sheared_spheres_are_as_agitated_as_kinetic_theory_says() {
    let home = folder("case_shear_flow");
    let text = shortened(
        "shear-flow/shear.toml",
        &[
            ("upper = [0.012039, 0.012039, 0.012039]\n", "upper = [7.041e-3, 7.041e-3, 7.041e-3]\n"),
            ("upper = [0.012039, 0.012039, 0.012039] }", "upper = [7.041e-3, 7.041e-3, 7.041e-3] }"),
            ("count = 1000", "count = 200"),
            ("normal_stiffness = 1e4", "normal_stiffness = 1e3"),
            ("dt = 1.25e-6", "dt = 4e-6"),
            ("end = 3", "end = 1.5"),
        ],
    );
    run_case(2, &home, &text, &[]).succeeded();
    let series = series(&home.join("results"));
    let steady = |name: &str| {
        let column = series.column(name);
        let late = &column[column.len() * 2 / 5..];
        late.iter().sum::<f64>() / late.len() as f64
    };
    let unit = f64::powi(10.0 * 1e-3, 2);
    let pressure = ["xx", "yy", "zz"].map(|part| steady(&format!("stress_{part}"))).iter().sum::<f64>() / 3.0;
    let found = [
        steady("granular_temperature") / unit,
        pressure / (2500.0 * unit),
        -steady("stress_xz") / (2500.0 * unit),
    ];
    for (found, theory) in found.into_iter().zip([1.236, 1.419, 0.393]) {
        assert!((found / theory - 1.0).abs() < 0.15, "{found} for {theory}");
    }
}

#[test]
fn packing_of_cubes_is_as_dense_as_a_packing() {
    let home = folder("case_packing");
    let text = shortened(
        "packing/spheres.toml",
        &[
            ("upper = [0.018, 0.018, 0.14]", "upper = [0.012, 0.012, 0.06]"),
            (
                "lower = [0, 0, 0.135], upper = [0.018, 0.018, 0.138]",
                "lower = [0, 0, 0.053], upper = [0.012, 0.012, 0.056]",
            ),
            ("count = 1000", "count = 120"),
            ("kind = \"sphere\"\nradius = 1.5e-3", "kind = \"box\"\nedges = [2.418e-3, 2.418e-3, 2.418e-3]"),
            ("end = 2.5", "end = 0.45"),
            ("\n[stop]\nkinetic_energy_below = 5e-8\nafter = 0.8\n", ""),
            ("directory = \"results/packing\"", OUTPUT),
        ],
    );
    run_case(2, &home, &text, &[]).succeeded();
    let void = analysed(&home, "void-fraction", &["--cells", "1e6", "--crop", "1"], "void_fraction")[0];
    assert!((0.25..0.5).contains(&void), "{void}");
}

#[test]
fn a_fixed_bed_of_trilobes_is_looser_than_one_of_cylinders() {
    let bed = |name: &str, shape: &str| {
        let home = folder(name);
        let text = shortened(
            "fixed-bed/bed.toml",
            &[
                ("lower = [-0.009, -0.009, 0]", "lower = [-0.005, -0.005, 0]"),
                ("upper = [0.009, 0.009, 0.09]", "upper = [0.005, 0.005, 0.03]"),
                ("[-0.003, -0.003, 0.085]", "[-0.003, -0.003, 0.026]"),
                ("[0.003, 0.003, 0.085]", "[0.003, 0.003, 0.026]"),
                ("kind = \"cylinder\"\nradius = 0.75e-3\nheight = 3e-3", shape),
                ("count = 1000", "count = 100"),
                ("end = 0.6", "end = 0.15"),
                ("directory = \"results/fixed-bed\"", OUTPUT),
            ],
        );
        run_case(2, &home, &text, &[]).succeeded();
        analysed(&home, "void-fraction", &["--cells", "1e6", "--crop", "1"], "void_fraction")[0]
    };
    let cylinders = bed("case_cylinders", "kind = \"cylinder\"\nradius = 0.75e-3\nheight = 3e-3");
    let lobes = "kind = \"lobes\"\nlobes = 3\ndiameter = 1.5e-3\nlength = 3e-3\narea_fraction = 0.69";
    let trilobes = bed("case_trilobes", lobes);
    assert!(0.25 < cylinders && cylinders < trilobes && trilobes < 0.7, "{cylinders} {trilobes}");
}

#[test]
fn crosses_in_a_drum_are_carried_and_fall_back() {
    let home = folder("case_drum");
    let text = shortened(
        "drum/drum.toml",
        &[
            ("count = 3000", "count = 60"),
            (
                "kind = \"sphere\"\nradius = 1.5e-3",
                "kind = \"cross\"\nbeams = 3\nbeam_width = 1.03e-3\nbeam_length = 5.15e-3",
            ),
            ("normal_stiffness = 1e5", "normal_stiffness = 1e4"),
            ("tangential = { kind = \"viscous\", gamma_t = 1e5 }", ""),
            ("dt = 2e-6", "dt = 4e-6\naccept_coarse_dt = true"),
            ("angular_velocity = 2.0943951, start = 1", "angular_velocity = 8.4, start = 0.1"),
            ("end = 7", "end = 0.4"),
            ("directory = \"results/drum/20-rpm\"", OUTPUT),
        ],
    );
    run_case(2, &home, &text, &[]).succeeded();
    let speed = analysed(&home, "drum", &["--time", "0.3:0.4"], "speed");
    assert!(speed.iter().all(|of_rim| (0.05..1.5).contains(of_rim)), "{speed:?}");
}

#[test]
fn a_small_column_collapses_and_all_of_it_is_found() {
    let home = folder("case_dam");
    let text = shortened(
        "dam-break/size1.toml",
        &[
            ("upper = [0.6, 0.024, 0.4]", "upper = [0.6, 0.01, 0.15]"),
            (
                "lower = [0.002, 0, 0.3], upper = [0.023, 0.024, 0.305]",
                "lower = [0.002, 0, 0.1], upper = [0.023, 0.01, 0.105]",
            ),
            ("count = 4704", "count = 200"),
            ("until = 0.75", "until = 0.3"),
            ("end = 2\n", "end = 0.6\n"),
            ("\n[stop]\nkinetic_energy_below = 5e-6\nafter = 1\n", ""),
            ("directory = \"results/dam-break/size1\"", OUTPUT),
        ],
    );
    run_case(2, &home, &text, &[]).succeeded();
    let options = ["--length", "0.025", "--time", "all"];
    let out = analysed(&home, "run-out", &options, "run_out_0.1");
    assert!(out.first().unwrap() < &0.2 && out.last().unwrap() > &0.5, "{out:?}");
    assert_eq!(series(&home.join("results")).column("particles").last(), Some(&200.0));
}

#[test]
fn a_bonded_row_of_beads_swings_to_twice_the_deflection_of_a_beam() {
    const BEADS: usize = 7;
    let home = folder("case_bonds");
    let text = shortened(
        "bonds/cantilever.toml",
        &[
            ("end = 0.5", "end = 0.008"),
            ("count = 19", "count = 7"),
            ("upper = [0.039, 0.001, 0.001]", "upper = [0.015, 0.001, 0.001]"),
            ("upper = [0.045, 0.01, 0.01]", "upper = [0.02, 0.01, 0.01]"),
            ("particles = 5e-4", "particles = 4e-5"),
            ("directory = \"results/bonds/cantilever\"", OUTPUT),
        ],
    );
    run_case(2, &home, &text, &[]).succeeded();
    let series = series(&home.join("results"));
    assert!(series.column("bonds").iter().all(|&bonds| bonds == BEADS as f64));
    let file = hdf5::File::open(home.join("results/particles.vtkhdf")).unwrap();
    let points = file.dataset("VTKHDF/Points").unwrap().read_raw::<f64>().unwrap();
    let ids = file.dataset("VTKHDF/PointData/id").unwrap().read_raw::<i64>().unwrap();
    let heights = points.chunks_exact(3).map(|point| point[2]);
    let tip = heights.zip(ids).filter(|(_, id)| *id == BEADS as i64).map(|(z, _)| z);
    let lowest = tip.fold(0.0, f64::min);
    let (area, young) = (1e-6 * std::f64::consts::PI, 2e7);
    let bending = young * area * 0.25e-6;
    let weight = 2500.0 * 4.0 / 3.0 * 1e-3 * area * 9.81;
    let (span, shearing) = (2e-3 * BEADS as f64, 0.9 * young / 2.5 * area);
    let static_deflection: f64 = (1..=BEADS)
        .map(|k| 2e-3 * k as f64)
        .map(|x| weight * (x * x * (3.0 * span - x) / (6.0 * bending) + x / shearing))
        .sum();
    let ratio = -lowest / static_deflection;
    assert!((1.97..2.06).contains(&ratio), "{ratio} times the static deflection");
}

#[test]
fn rolling_resistance_and_cohesion_leave_more_of_a_heap_on_its_plate() {
    let left = |name: &str, law: (&str, &str)| {
        let home = folder(name);
        let text = shortened(
            "angle-of-repose/spheres.toml",
            &[
                ("lower = [-0.052, 0, -0.006]", "lower = [-0.022, 0, -0.006]"),
                ("upper = [0.052, 0.01, 0.066]\n", "upper = [0.022, 0.006, 0.066]\n"),
                (
                    "lower = [-0.052, 0, 0], upper = [0.052, 0.01, 0.066] }",
                    "lower = [-0.022, 0, 0], upper = [0.022, 0.006, 0.04] }",
                ),
                ("count = 3600", "count = 400"),
                ("point = [-0.052, 0, 0]", "point = [-0.022, 0, 0]"),
                ("point = [0.052, 0, 0]", "point = [0.022, 0, 0]"),
                (
                    "[-0.04, -0.004, 0], [0.04, -0.004, 0], [0.04, 0.014, 0], [-0.04, 0.014, 0]]",
                    "[-0.014, -0.004, 0], [0.014, -0.004, 0], [0.014, 0.01, 0], [-0.014, 0.01, 0]]",
                ),
                (
                    "[-0.052, -0.004, 0], [-0.04, -0.004, 0], [-0.04, 0.014, 0], [-0.052, 0.014, 0]",
                    "[-0.022, -0.004, 0], [-0.014, -0.004, 0], [-0.014, 0.01, 0], [-0.022, 0.01, 0]",
                ),
                (
                    "[0.04, -0.004, 0], [0.052, -0.004, 0], [0.052, 0.014, 0], [0.04, 0.014, 0]",
                    "[0.014, -0.004, 0], [0.022, -0.004, 0], [0.022, 0.01, 0], [0.014, 0.01, 0]",
                ),
                ("softening = 2e4", "softening = 1e5"),
                ("impact_speed = 0.8", "impact_speed = 0.6"),
                ("until = 0.25", "until = 0.12"),
                ("end = 1.5", "end = 0.5"),
                ("after = 0.6", "after = 0.4"),
                ("directory = \"results/angle-of-repose/spheres\"", OUTPUT),
                law,
            ],
        );
        run_case(2, &home, &text, &[]).succeeded();
        *series(&home.join("results")).column("particles").last().unwrap()
    };
    let hertz = "normal = { kind = \"hertz\" }";
    let neither = left("case_heap", (hertz, hertz));
    let rolling = left("case_heap_rolling", (hertz, "normal = { kind = \"hertz\" }\nrolling_friction = 0.1"));
    let cohesion =
        left("case_heap_cohesion", (hertz, "normal = { kind = \"jkr\" }\nwork_of_adhesion = 0.04"));
    assert!(neither > 40.0, "{neither}");
    assert!(rolling > 1.3 * neither && cohesion > 1.3 * neither, "{neither} {rolling} {cohesion}");
}

#[test]
fn wet_beads_climb_higher_in_a_drum_than_dry_ones() {
    let bridge = "attraction = { kind = \"liquid_bridge\", volume = 2.6e-10, surface_tension = 0.0728 }\n";
    let angle = |name: &str, attraction: &str| {
        let home = folder(name);
        let text = shortened(
            "wet-drum/drum.toml",
            &[
                ("lower = [-0.046, 0, -0.046]", "lower = [-0.035, 0, -0.035]"),
                ("upper = [0.046, 0.02, 0.046]", "upper = [0.035, 0.02, 0.035]"),
                ("count = 275", "count = 130"),
                (
                    "lower = [-0.03, 0, -0.029], upper = [0.03, 0.02, 0.029]",
                    "lower = [-0.02, 0, -0.02], upper = [0.02, 0.02, 0.02]",
                ),
                ("radius = 0.045", "radius = 0.033"),
                ("start = 0.3", "start = 0.2"),
                ("end = 3\n", "end = 1.7\n"),
                ("impact_speed = 0.6", "impact_speed = 0.4"),
                (bridge, attraction),
                ("directory = \"results/wet-drum/0.0728\"", OUTPUT),
            ],
        );
        run_case(2, &home, &text, &[]).succeeded();
        let angles = analysed(&home, "drum", &["--time", "0.7:1.7"], "angle");
        angles.iter().sum::<f64>() / angles.len() as f64
    };
    let dry = angle("case_drum_dry", "");
    let wet = angle("case_drum_wet", &bridge.replace("0.0728", "0.15"));
    assert!((15.0..45.0).contains(&dry) && wet > dry + 4.0, "{dry} {wet}");
}
