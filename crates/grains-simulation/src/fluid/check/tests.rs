//! The lines against closed forms.

use super::*;
use crate::system::catalogue;
use grains_domain::SerialTransport;
use std::path::Path;

/// A bed of light grains in a thick fluid, in which all laws are linear.
const BED: &str = r#"
    [domain]
    lower = [0, 0, 0]
    upper = [0.04, 0.02, 0.1]
    periodic = [true, false, false]
    [time]
    end = 2
    dt = 1e-6
    [[material]]
    name = "grain"
    density = 1500
    [[contact]]
    between = ["grain", "grain"]
    normal_stiffness = 1e4
    restitution = 0.9
    friction = 0.3
    [[shape]]
    name = "ball"
    kind = "sphere"
    radius = 5e-4
    [[insert]]
    name = "bed"
    particles = [{ shape = "ball", material = "grain" }]
    count = 1000
    place = { kind = "lattice", lower = [0, 0, 0], upper = [0.04, 0.02, 0.1] }
    [fluid]
    density = 1000
    viscosity = 10
    cells = [10, 5, 20]
    refinement = [0, 0, 0]
    courant = 0.5
    longest_step = 0.1
    [[fluid.boundary]]
    face = "-z"
    kind = "inlet"
    velocity = [0, 0, "0.02*(1 + (x/0.04)^2)*t"]
    [[fluid.boundary]]
    face = "+z"
    kind = "outlet"
    [fluid.coupling]
    drag = "ergun"
    particle_steps = 50
"#;

fn explained(text: &str) -> String {
    let case = Case::parse(text, "bed.toml", Path::new("")).unwrap();
    let catalogue = catalogue(&case).unwrap();
    let population = Population::read(&case, &catalogue, &SerialTransport).unwrap();
    explain(&case, &catalogue, &population).unwrap().join("\n")
}

/// The number that stands in a line after some words.
fn after(text: &str, words: &str) -> f64 {
    let (_, rest) = text.split_once(words).unwrap_or_else(|| panic!("`{words}` is missing: {text}"));
    rest.split_whitespace().next().unwrap().trim_end_matches([':', ',', ';', ')']).parse().unwrap()
}

fn assert_close(found: f64, wanted: f64) {
    assert!((found / wanted - 1.0).abs() < 6e-4, "{found} instead of {wanted}");
}

#[test]
fn a_bed_in_a_thick_fluid_has_the_speeds_of_stokes_and_ergun() {
    let text = explained(BED);
    let (d, mu, difference, e) = (1e-3_f64, 10.0, 500.0, SETTLED);
    let terminal = difference * 9.81 * d * d / (18.0 * mu);
    assert_close(after(&text, "terminal velocity "), terminal);
    assert_close(after(&text, "relaxation time m/beta "), 1500.0 * d * d / (18.0 * mu));
    let fluidisation = difference * 9.81 * e.powi(3) * d * d / (150.0 * mu * (1.0 - e));
    assert_close(after(&text, "minimum fluidisation at "), fluidisation);
    // β per particle from 150 μ (1−ε)² U/(ε³ d²) = n β U/ε /ε, U the superficial velocity.
    let beta = 150.0 * mu * (1.0 - e) * std::f64::consts::PI * d / (6.0 * e);
    let mass = 1500.0 * std::f64::consts::PI * d.powi(3) / 6.0;
    assert_close(after(&text, "Wen and Yu; relaxation time "), mass / beta);
    let weight = 1000.0 * mass / 1500.0 * difference * 9.81;
    assert_close(after(&text, "pressure drop "), weight / (0.04 * 0.02));
    assert!(text.contains("= 1000 cells of 4.0000e-3 x 4.0000e-3 x 5.0000e-3 m"), "{text}");
    assert!(text.contains("cells of 4.00 x 4.00 x 5.00 diameters"), "{text}");
    // The inlet's formula reaches 0.02 · 2 · 2 m/s at its corner and the end of the run.
    assert_close(after(&text, "at the "), 0.08);
    assert_close(after(&text, "fluid step     at most "), 0.5 * 5e-3 / 0.08);
    assert_close(after(&text, "(fluid.courant = 0.5), "), SETTLED * 0.5 * 5e-3 / 0.08);
    assert_close(after(&text, "relaxation   fluid step "), 5e-5);
    assert!(!text.contains("warning"), "{text}");
}

#[test]
fn sizes_are_told_apart() {
    let mixed = BED.replace(
        "particles = [{ shape = \"ball\", material = \"grain\" }]",
        "particles = [{ shape = \"ball\", material = \"grain\", scale = { kind = \"uniform\", min = 0.5, max = 1.5 } }]",
    );
    let text = explained(&mixed);
    assert_eq!(text.matches("  particles    ball of grain").count(), 2, "{text}");
    assert!(text.contains("cells of 2.67 x 2.67 x 3.33 diameters"), "{text}");
    let light = explained(&BED.replace("density = 1500", "density = 900"));
    assert!(
        light.contains("neither settle nor fluidise: the particles (900 kg/m3) are not heavier"),
        "{light}"
    );
}

#[test]
fn a_fluid_alone_has_cells_and_a_step() {
    let start = BED.find("[[material]]").unwrap();
    let fluid = BED.find("[fluid]").unwrap();
    let alone = BED[..start].to_owned() + &BED[fluid..BED.find("[fluid.coupling]").unwrap()];
    let alone =
        alone.replace("dt = 1e-6", "dt = 1e-3").replace("refinement = [0, 0, 0]", "refinement = [0, 1, 0]");
    let text = explained(&alone);
    assert_close(after(&text, "Courant number "), 0.08 * 1e-3 / 5e-3);
    // Nodes at ξ = 0.2, 0.6 and 1.
    let node = |xi: f64| 0.01 * xi.tanh() / 1.0_f64.tanh();
    let widths = format!("{:.4e} to {:.4e}", node(1.0) - node(0.6), 2.0 * node(0.2));
    assert!(text.contains(&widths), "{widths}: {text}");
    let automatic = explained(&alone.replace("dt = 1e-3", "dt = \"auto\""));
    assert_close(after(&automatic, "fluid step     at most "), 0.5 * 5e-3 / 0.08);
}
