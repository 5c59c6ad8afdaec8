//! Particles in an averaged flow: momentum, volume and pressure drops in the program.

use super::{array, assert_close, continued, results_of};
use crate::common::results::series;
use crate::common::{case, folder, replaced, run_alone, run_case};
use std::fs;
use std::path::Path;

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

#[test]
fn a_fluidised_bed_is_the_same_on_any_ranks_and_across_restarts() {
    let (home, text) = (folder("fluid_bed"), case("bed.toml"));
    let result = |label: &str, ranks: usize| results_of(&home, label, ranks, &text);
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
    let result = |label: &str, ranks: usize, text: &str| results_of(&home, label, ranks, text);
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
        let last = |table: &crate::common::results::Series, name: &str| *table.column(name).last().unwrap();
        for name in ["pressure_drop", "fluid_kinetic", "kinetic_translation", "superficial_z"] {
            let (a, b) = (last(&table, name), last(&found, name));
            let size = largest(name);
            assert!((a - b).abs() < 1e-6 * size, "{} {name}: {a} and {b}", other.display());
        }
    }
}

/// Batches of beads thrown into a closed box of gas at rest.
fn closed() -> String {
    let text = replaced(&case("rain.toml"), "outlets = [\"-z\"]\n", "");
    let edits = [
        ("[true, true, false]", "[false, false, false]"),
        (
            "lower = [0, 0, 0.01], upper = [0.02, 0.02, 0.02]",
            "lower = [0.001, 0.001, 0.015], upper = [0.019, 0.019, 0.035]",
        ),
        ("end = 0.03", "end = 0.009"),
        ("particles = 0.01", "particles = 0.002"),
        ("checkpoint = 0.01", "checkpoint = 0.003"),
        // Far below what the batches are asked to leave of the divergence.
        ("[fluid]\n", "[fluid]\npressure = { tolerance = 1e-12 }\n"),
    ];
    let text = edits.iter().fold(text, |text, (old, new)| replaced(&text, old, new));
    let (before, rest) = text.split_once("[[fluid.boundary]]").unwrap();
    [before, "[output]", rest.split_once("[output]").unwrap().1].concat()
}

#[test]
fn batches_inserted_into_a_closed_box_displace_no_fluid_by_motion() {
    let (home, text) = (folder("fluid_closed"), closed());
    let result = |ranks: usize| results_of(&home, &ranks.to_string(), ranks, &text);
    let one = result(1);
    let table = series(&one);
    assert_eq!(table.column("particles").last(), Some(&80.0));
    // The mixture as a whole keeps its volume in every cell, also in the step after the second batch came.
    let rates = table.column("fluid_cfl").into_iter().zip(table.column("fluid_dt")).map(|(cfl, dt)| cfl / dt);
    let fastest = rates.filter(|rate| rate.is_finite()).fold(0.0, f64::max);
    let divergence = table.column("fluid_divergence").into_iter().fold(0.0, f64::max);
    assert!(divergence < 1e-9 * fastest, "{divergence:e} 1/s of {fastest} 1/s");
    assert!(table.column("superficial_z").iter().all(|u| u.abs() < 0.2));
    // What the cells hold is what the particles are: a batch replaces its volume of fluid.
    let solid = |name: &str| table.column(name);
    let void = array(&one.join("fluid.vtkhdf"), "VTKHDF/CellData/void_fraction");
    let times = array(&one.join("fluid.vtkhdf"), "VTKHDF/Steps/Values");
    let (cells, volume) = (6 * 6 * 12, 0.02 * 0.02 * 0.04);
    for (step, time) in void.chunks_exact(cells).zip(times) {
        let row = solid("time").iter().position(|t| (t - time).abs() < 1e-9).unwrap();
        let held = volume * (1.0 - step.iter().sum::<f64>() / cells as f64);
        let given = solid("solid_volume")[row];
        assert!((held - given).abs() < 1e-12 * volume, "{held} against {given} at {time} s");
    }
    // On any ranks, and across a restart before the second batch.
    let mut others = vec![result(2), result(4)];
    others.push(continued(&home, "2", 3, &text));
    for other in &others {
        let found = series(other);
        for name in ["fluid_kinetic", "kinetic_translation", "superficial_z", "solid_volume"] {
            assert_close(
                &table.column(name),
                &found.column(name),
                1e-6,
                &format!("{name} of {}", other.display()),
            );
        }
    }
}

#[test]
fn fixed_particles_inserted_into_a_fluid_at_rest_leave_it_at_rest() {
    let home = folder("fluid_closed_fixed");
    let text = closed();
    let (begin, end) = (text.find("[[insert]]").unwrap(), text.find("[fluid]").unwrap());
    let insert = |name: &str, start: f64, [lower, upper]: [f64; 2]| {
        format!(
            r#"
[[insert]]
name = "{name}"
motion = "fixed"
start = {start}
particles = [{{ shape = "bead", material = "glass" }}]
count = 50
place = {{ kind = "lattice", lower = [0.001, 0.001, {lower}], upper = [0.019, 0.019, {upper}], spacing = 0.002 }}

"#
        )
    };
    let inserts = [insert("first", 0.0, [0.001, 0.01]), insert("second", 0.0041, [0.025, 0.039])].concat();
    let text = ["gravity = [0, 0, 0]\n", &text[..begin], &inserts, &text[end..]].concat();
    run_case(2, &home, &text, &[]).succeeded();
    let table = series(&home.join("results"));
    let volumes = table.column("solid_volume");
    assert!((volumes.last().unwrap() / volumes[0] - 2.0).abs() < 1e-12, "{volumes:?}");
    // To rounding of void fractions, over a step.
    let kinetic = table.column("fluid_kinetic").into_iter().fold(0.0, f64::max);
    let speed = (2.0 * kinetic / (1.2 * 0.02 * 0.02 * 0.04)).sqrt();
    assert!(speed < 1e-12 * 0.02 / 1e-4, "{speed:e} m/s");
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
    let of_model = &|model: &str| {
        for (drag, reynolds, wanted) in cases {
            let home = folder(&format!("fluid_lattice_{model}"));
            let velocity = reynolds * 1.8e-5 / 1.2 / 1e-3;
            fs::write(home.join("case.toml"), lattice(&home, drag, model, velocity)).unwrap();
            run_alone(&home, &["case.toml"]).succeeded();
            let gradient = *series(&home.join("results")).column("drive_z").last().unwrap();
            assert!((gradient / wanted - 1.0).abs() < 5e-3, "{drag} {model} Re {reynolds}: {gradient} Pa/m");
        }
    };
    std::thread::scope(|scope| {
        for model in ["A", "B"] {
            scope.spawn(move || of_model(model));
        }
    });
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
        let text = replaced(&text, "dt = 1e-5", "dt = 2e-5");
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
        let text = replaced(&text, "dt = 1e-5", "dt = 2e-5");
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
