//! Fluids whose viscosity varies, in whole runs: closed profiles, on any ranks, across restarts, with walls and bodies.

use super::{array, assert_close, continued, results_of};
use crate::common::{case, folder, replaced, run};
use std::fs;
use std::path::{Path, PathBuf};

const ALL: [&str; 3] = ["velocity", "pressure", "viscosity"];

/// Runs a case on 1, 2 and 4 ranks, and from its first checkpoint on 3 more; asserts that fields agree to a share of their largest
/// values in all snapshots, and returns the results of one rank.
fn same_on_any_ranks(name: &str, text: &str, fields: &[&str], share: f64) -> PathBuf {
    let home = folder(name);
    let result = |ranks: usize| results_of(&home, &ranks.to_string(), ranks, text);
    let one = result(1);
    let mut others = vec![result(2), result(4)];
    others.push(continued(&home, "2", 3, text));
    for (other, field) in others.iter().flat_map(|other| fields.iter().map(move |field| (other, field))) {
        let found = |results: &Path| snapshots(results, field);
        assert_close(&found(&one), &found(other), share, &format!("{} {field}", other.display()));
    }
    one
}

/// A field of all snapshots.
fn snapshots(results: &Path, field: &str) -> Vec<f64> {
    array(&results.join("fluid.vtkhdf"), &format!("VTKHDF/CellData/{field}"))
}

/// A channel with walls 1 m apart under 8 Pa/m.
fn channel(rheology: &str) -> String {
    format!(
        "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [100, 1, 1]\nperiodic = [true, false, true]\n\
         [time]\nend = 100\n[fluid]\ndensity = 1\nrheology = {{ {rheology} }}\ncells = [4, 40, 1]\nmax_dt = 0.5\n\
         drive = {{ kind = \"pressure_gradient\", gradient = [-8, 0, 0] }}\n[fluid.output]\nfields = [\"velocity\", \
         \"pressure\", \"viscosity\"]\n[output]\ndirectory = \"results\"\nparticles = 50\nseries = 50\ncheckpoint = 50\n"
    )
}

/// Largest errors, over the largest values, of velocity and of shear stress by viscosity and velocity, at the end of a channel flow
/// of τ = τ_y + γ̇ⁿ: u = n/(n + 1) Gᵐ ((H − y_p)^(m + 1) − (|y| − y_p)₊^(m + 1)), m = 1/n, y_p = τ_y/G; the stress is G y.
fn channel_errors(results: &Path, yield_stress: f64, index: f64) -> [f64; 2] {
    let (gradient, half, n) = (8.0_f64, 0.5_f64, 40);
    let (velocity, viscosity) = (snapshots(results, "velocity"), snapshots(results, "viscosity"));
    // The first cells along x of the last snapshot.
    let first = viscosity.len() - 4 * n;
    let at = |j: usize| (j as f64 + 0.5) / n as f64 - half;
    let column = |j: usize| velocity[3 * (first + 4 * j)];
    let (plug, power) = (yield_stress / gradient, 1.0 / index + 1.0);
    let part = |y: f64| (y - plug).max(0.0).powf(power);
    let profile = |y: f64| gradient.powf(power - 1.0) / power * (part(half) - part(y.abs()));
    let off = (0..n).map(|j| (column(j) - profile(at(j))).abs() / profile(0.0)).fold(0.0, f64::max);
    let stress = |j: usize| viscosity[first + 4 * j] * (column(j + 1) - column(j - 1)) * 0.5 * n as f64;
    let yielded = (1..n - 1).filter(|&j| at(j).abs() > plug + 2.0 / n as f64);
    let wrong = yielded.map(|j| (stress(j) + gradient * at(j)).abs() / (gradient * half)).fold(0.0, f64::max);
    [off, wrong]
}

#[test]
fn channels_of_mud_and_of_thinning_fluid_have_their_profiles_on_any_ranks() {
    let regularisation = "{ kind = \"papanastasiou\", exponent = 1000 }";
    let mud = format!(
        "kind = \"bingham\", yield_stress = 1, plastic_viscosity = 1, regularisation = {regularisation}"
    );
    let thinning = "kind = \"power_law\", consistency = 1, index = 0.6, max_viscosity = 1e4";
    for (name, rheology, yield_stress, index) in
        [("mud", &mud[..], 1.0, 1.0), ("thinning", thinning, 0.0, 0.6)]
    {
        let results =
            same_on_any_ranks(&format!("fluid_{name}"), &channel(rheology), &["velocity", "viscosity"], 1e-9);
        let [velocity, stress] = channel_errors(&results, yield_stress, index);
        println!("{name}: velocity {velocity:.2e}, stress {stress:.2e}");
        assert!(velocity < 0.01 && stress < 0.02, "{name}: {velocity} {stress}");
    }
}

#[test]
fn check_tells_the_law_as_the_case_file_has_it_and_what_it_makes() {
    let mud = |exponent: f64| {
        channel(&format!(
            "kind = \"bingham\", yield_stress = 1, plastic_viscosity = 1, regularisation = {{ kind = \"papanastasiou\", exponent = {exponent} }}"
        ))
    };
    let home = folder("fluid_mud_checked");
    let told = |exponent: f64| {
        fs::write(home.join("case.toml"), mud(exponent)).unwrap();
        run(1, &home, &["check", "case.toml"]).succeeded().text()
    };
    let text = told(1000.0);
    // At a stress of 4 Pa the walls shear fluid at 3 1/s.
    for words in [
        "rheology = { kind = \"bingham\", yield_stress = 1.0, plastic_viscosity = 1.0, regularisation = { kind = \"papanastasiou\", \
         exponent = 1000.0 } }",
        "sheared    1.3333e0 Pa s at the 3.000e0 1/s",
        "at rest    at most 1.0010e3 Pa s",
        "creeps at up to",
        "may drift",
    ] {
        assert!(text.contains(words), "`{words}` in {text}");
    }
    assert!(!told(10.0).contains("may drift"));
}

#[test]
fn large_eddies_are_the_same_on_any_ranks() {
    let text = "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, -1]\nupper = [4, 2, 1]\nperiodic = [true, true, false]\n\
        [time]\nend = 0.4\n[fluid]\ndensity = 1\nviscosity = 0.01\nturbulence = { kind = \"wale\" }\ncells = [20, 16, 16]\n\
        refinement = [0, 0, 1.5]\nmax_dt = 0.01\n\
        drive = { kind = \"mean_velocity\", velocity = [1, 0, 0], axes = [true, false, false] }\n\
        initial = { velocity = [\"1 + sin(3*pi*y)*(1 - z^2)\", \"cos(pi*x)*(1 - z^2)\", \"sin(pi*(x + y))*(1 - z^2)\"] }\n\
        [fluid.output]\nfields = [\"velocity\", \"pressure\", \"viscosity\"]\n\
        [output]\ndirectory = \"results\"\nparticles = 0.2\nseries = 0.1\ncheckpoint = 0.2\n";
    let viscosity = snapshots(&same_on_any_ranks("fluid_eddies", text, &ALL, 1e-9), "viscosity");
    let [min, max] =
        [viscosity.iter().fold(f64::MAX, |m, x| m.min(*x)), viscosity.iter().fold(0.0, |m, x| x.max(m))];
    assert!(min >= 0.01 && max > 0.011, "{min} to {max}");
}

#[test]
fn a_ball_and_walls_in_mud_are_the_same_on_any_ranks() {
    let mud = "rheology = { kind = \"bingham\", yield_stress = 100, plastic_viscosity = 20, regularisation = \
               { kind = \"papanastasiou\", exponent = 1 } }";
    let text = replaced(&case("walls_of_fluid.toml"), "viscosity = 20", mud);
    let text = replaced(&text, "\"void_fraction\"]", "\"void_fraction\", \"viscosity\"]");
    same_on_any_ranks("fluid_walls_of_mud", &text, &ALL, 1e-8);
}
