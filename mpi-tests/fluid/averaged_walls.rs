//! Averaged flows between walls that cut cells: volume, momentum, any ranks, and restarts wherever a run stops.

use super::{array, assert_close, continued, results_of};
use crate::common::results::series;
use crate::common::{case, folder, replaced, run_case};
use std::fs;

/// A bed in a round column with a tube across it, whose walls cut the cells.
#[test]
fn a_bed_between_walls_that_cut_cells_keeps_volume_and_momentum_on_any_ranks() {
    let (home, text) = (folder("fluid_column"), case("column.toml"));
    let result = |label: &str, ranks: usize, text: &str| results_of(&home, label, ranks, text);
    let one = result("1", 1, &text);
    let table = series(&one);
    let largest = |name: &str| table.column(name).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // What cells hold is what walls leave open less what the particles are.
    let void = array(&one.join("fluid.vtkhdf"), "VTKHDF/CellData/void_fraction");
    let times = array(&one.join("fluid.vtkhdf"), "VTKHDF/Steps/Values");
    let (cells, volume) = (9 * 9 * 18, 0.02 * 0.021 * 0.04);
    let open: Vec<f64> = void
        .chunks_exact(cells)
        .zip(times)
        .map(|(step, time)| {
            let row = table.column("time").iter().position(|t| (t - time).abs() < 1e-9).unwrap();
            volume * step.iter().sum::<f64>() / cells as f64 + table.column("solid_volume")[row]
        })
        .collect();
    let tube = std::f64::consts::PI * 0.0021_f64.powi(2) * 0.0191;
    let exact = std::f64::consts::PI * 0.0097_f64.powi(2) * 0.04 - tube;
    assert!((open[0] / exact - 1.0).abs() < 3e-3, "{} of {exact}", open[0]);
    assert!(open.iter().all(|v| (v / open[0] - 1.0).abs() < 1e-12), "{open:?}");
    // Above the bed what comes in goes through.
    let flow = table.column("high_flow");
    let section = std::f64::consts::PI * 0.0097_f64.powi(2);
    assert!((flow[1] / section - 1.0).abs() < 2e-3, "{} of {section}", flow[1]);
    assert!(flow[1..].iter().all(|q| (q / flow[1] - 1.0).abs() < 1e-9), "{flow:?}");
    let (lost, moved) = (largest("momentum_imbalance"), largest("momentum_z"));
    assert!(lost < 1e-10 * moved, "{lost} N s of {moved} lost");
    assert!(table.column("min_void_fraction").iter().all(|eps| (0.3..=1.0).contains(eps)));
    let iterations = largest("pressure_iterations");
    assert!(iterations < 40.0, "{iterations} iterations");
    let mut others = vec![result("2", 2, &text), result("4", 4, &text)];
    others.push(continued(&home, "2", 3, &text));
    // Another solver finds the same, and so do stops wherever the run may.
    let petsc = replaced(&text, "tolerance = 1e-12", "tolerance = 1e-12, method = \"petsc\"");
    others.push(result("petsc", 2, &petsc));
    let own = home.join("stops");
    fs::create_dir_all(&own).unwrap();
    run_case(2, &own, &text, &["--max-walltime", "0"]).succeeded();
    run_case(1, &own, &text, &["--restart", "latest", "--max-walltime", "0.2"]).succeeded();
    run_case(4, &own, &text, &["--restart", "latest"]).succeeded();
    others.push(own.join("results"));
    for other in &others {
        let found = series(other);
        for name in ["pressure_drop", "fluid_kinetic", "kinetic_translation", "low_flow", "superficial_z"] {
            assert_close(
                &table.column(name),
                &found.column(name),
                1e-6,
                &format!("{name} of {}", other.display()),
            );
        }
    }
}

/// Air and particles through a funnel, past a cone and a ring that turns: what flows in flows through its neck.
#[test]
fn a_funnel_of_surfaces_of_revolution_bounds_a_flow_and_its_particles() {
    let home = folder("fluid_funnel");
    let text = replaced(&case("funnel.toml"), "[0.04, 0.0095]]", "[0.04, 0.0095]]\nfluid = \"inside\"");
    let text = replaced(&text, "height = 0.005", "height = 0.005\nfluid = \"particles\"");
    let text = replaced(&text, "[-0.001, 0.006]]", "[-0.001, 0.006]]\nfluid = \"outside\"");
    let text = replaced(&text, "end = 0.05", "end = 0.006")
        + r#"
[fluid]
density = 1.2
viscosity = 1.8e-5
cells = [12, 12, 20]
coupling = { drag = "beetstra", model = "A", kernel = { kind = "smooth", half_width = 1.5 } }
pressure = { tolerance = 1e-12 }

[[fluid.boundary]]
face = "+z"
kind = "inlet"
velocity = [0, 0, -0.5]

[[fluid.boundary]]
face = "-z"
kind = "outlet"

[[fluid.profile]]
name = "high"
kind = "plane"
axis = "z"
at = 0.035

[[fluid.profile]]
name = "neck"
kind = "plane"
axis = "z"
at = 0.0085
"#;
    let result = |ranks: usize| series(&results_of(&home, &ranks.to_string(), ranks, &text));
    let table = result(1);
    let [high, neck] = ["high_flow", "neck_flow"].map(|name| *table.column(name).last().unwrap());
    let inflow = 0.5 * std::f64::consts::PI * 0.0095_f64.powi(2);
    assert!((neck / -inflow - 1.0).abs() < 5e-3, "{neck} of {inflow} through the neck");
    // Among the particles, which fall too, some less.
    assert!((0.97..1.0).contains(&(high / neck)), "{high} of {neck}");
    let largest = |name: &str| table.column(name).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(largest("momentum_imbalance") < 1e-10 * largest("momentum_z"), "momentum is lost");
    let mut others = vec![result(2), result(4)];
    others.push(series(&continued(&home, "2", 3, &text)));
    // Within the last 2 ms two cubes are wedged between the ring and others: one rank alone, given 2e-14 more inflow, turns them by
    // hundreds of rad/s faster or slower. Until 4 ms, when particles have begun to touch, ranks agree.
    for (k, found) in others.iter().enumerate() {
        for name in ["pressure_drop", "fluid_kinetic", "kinetic_translation", "funnel_flow_fz"] {
            let [wanted, found] = [&table, found].map(|table| table.column(name)[..3].to_vec());
            assert_close(&wanted, &found, 1e-6, &format!("{name} of {k}"));
        }
    }
}

/// A closed column whose paddle turns, with a gate in the fluid that vanishes.
#[test]
fn a_bed_that_is_stirred_is_the_same_on_any_ranks_and_wherever_it_stops() {
    let home = folder("fluid_stirred");
    let text = case("column.toml")
        .replace("name = \"column\"\nmaterial", "name = \"column\"\nslip = true\nmaterial");
    let text = replaced(&text, "velocity = [0, 0, 1.0]", "velocity = [0, 0, 0]");
    let text = replaced(&text, "kind = \"outlet\"", "kind = \"wall\"");
    let text = replaced(
        &text,
        "side = \"outside\"\nfluid = \"particles\"",
        r#"side = "outside"
fluid = "particles"
motion = { kind = "rotation", point = [0.01, 0.0106, 0.034], axis = [0, 0, 1], angular_velocity = 40 }

[[wall]]
name = "gate"
material = "glass"
kind = "box"
side = "outside"
lower = [-0.001, 0.004, 0.0075]
upper = [0.021, 0.0125, 0.0115]
until = 0.0151
fluid = "particles""#,
    );
    let text = replaced(&text, "lower = [0.0012, 0.0076, 0.0006]", "lower = [0.0012, 0.0076, 0.013]");
    let text = replaced(&text, "count = 800", "count = 400");
    let text = replaced(&text, "end = 0.03", "end = 0.021");
    let result = |label: &str, ranks: usize| results_of(&home, label, ranks, &text);
    let one = series(&result("1", 1));
    let largest = |name: &str| one.column(name).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(largest("momentum_imbalance") < 1e-9 * largest("momentum_z"));
    assert!(largest("fluid_kinetic") > 0.0 && largest("max_speed") < 3.0, "{}", largest("max_speed"));
    assert!(largest("fluid_divergence") < 1e-6, "{}", largest("fluid_divergence"));
    let gate = one.column("gate_flow_fz");
    assert!(gate[10].is_finite() && gate[20].is_nan(), "{gate:?}");
    let mut others = vec![result("2", 2), result("4", 4)];
    others.push(continued(&home, "2", 3, &text));
    let own = home.join("stops");
    fs::create_dir_all(&own).unwrap();
    run_case(2, &own, &text, &["--max-walltime", "0"]).succeeded();
    run_case(1, &own, &text, &["--restart", "latest", "--max-walltime", "0.3"]).succeeded();
    run_case(4, &own, &text, &["--restart", "latest"]).succeeded();
    others.push(own.join("results"));
    for other in &others {
        let found = series(other);
        // Loads are what is left of pressures that cancel.
        let loads = [("column_flow_fz", 1e-7), ("tube_flow_tz", 1e-7)];
        let others = ["fluid_kinetic", "kinetic_translation", "low_flow"].map(|name| (name, 1e-9));
        for (name, tolerance) in others.into_iter().chain(loads) {
            let about = format!("{name} of {}", other.display());
            assert_close(&one.column(name), &found.column(name), tolerance, &about);
        }
    }
}

/// A plate that comes over an inlet of a stated flow ends the run with one message.
#[test]
fn a_wall_that_comes_to_cover_an_inlet_of_a_stated_flow_is_an_error() {
    let home = folder("fluid_covered_inlet");
    let text = replaced(
        &case("heated.toml"),
        "kind = \"inlet\"\nvelocity = [0, 0, 0.6]",
        "kind = \"flow_inlet\"\nvolume_flow = 2e-4",
    );
    let text = replaced(&text, "count = 700\n", "count = 20\n");
    let text = replaced(&text, "lower = [0.0012, 0.0006, 0.0006]", "lower = [0.0012, 0.0006, 0.02]");
    let plate = "[[wall]]\nname = \"plate\"\nmaterial = \"glass\"\nkind = \"box\"\nside = \"outside\"\nfluid = \"particles\"\n\
                 lower = [-0.01, -0.01, -0.02]\nupper = [0.03, 0.03, -0.001]\n\
                 motion = { kind = \"translation\", velocity = [0, 0, 3] }\n\n[fluid]";
    let text = replaced(&text, "[fluid]", plate);
    let scalars = text.find("[[fluid.scalar]]").unwrap();
    let text = format!("{}[output]\ndirectory = \"results\"\n", &text[..scalars]);
    let failed = run_case(2, &home, &text, &[]);
    let message = failed.only_error(3);
    for word in ["t = ", "has nothing to go through", "move the inlet"] {
        assert!(message.contains(word), "{word} in {message}");
    }
}
