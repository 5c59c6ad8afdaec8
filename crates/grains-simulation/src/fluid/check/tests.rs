//! The report against closed forms.

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
    cfl = 0.5
    max_dt = 0.1
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

fn found(text: &str) -> FluidReport {
    let case = Case::parse(text, "bed.toml", Path::new("")).unwrap();
    let catalogue = catalogue(&case).unwrap();
    let insertions = Insertions::read(&case, &catalogue, &SerialTransport).unwrap();
    report(&case, &catalogue, &insertions, &SerialTransport).unwrap().unwrap()
}

fn assert_close(found: f64, wanted: f64) {
    assert!((found / wanted - 1.0).abs() < 6e-4, "{found} instead of {wanted}");
}

#[test]
fn a_bed_in_a_thick_fluid_has_the_speeds_of_stokes_and_ergun() {
    let fluid = found(BED);
    let bed = fluid.coupling.as_ref().unwrap();
    let [grain] = &bed.kinds[..] else { panic!("one kind of one size: {:?}", bed.kinds) };
    let motion = grain.motion.as_ref().unwrap();
    let (d, mu, difference, e) = (1e-3_f64, 10.0, 500.0, SETTLED);
    assert_close(motion.terminal, difference * 9.81 * d * d / (18.0 * mu));
    assert_close(motion.relaxation, 1500.0 * d * d / (18.0 * mu));
    assert_close(motion.fluidisation, difference * 9.81 * e.powi(3) * d * d / (150.0 * mu * (1.0 - e)));
    // β per particle from 150 μ (1−ε)² U/(ε³ d²) = n β U/ε /ε, U the superficial velocity.
    let beta = 150.0 * mu * (1.0 - e) * std::f64::consts::PI * d / (6.0 * e);
    let mass = 1500.0 * std::f64::consts::PI * d.powi(3) / 6.0;
    assert_close(motion.relaxation_in_bed, mass / beta);
    let weight = 1000.0 * mass / 1500.0 * difference * 9.81;
    assert_close(bed.pressure_drop.unwrap().pressure, weight / (0.04 * 0.02));
    assert_eq!(fluid.cells, [10, 5, 20]);
    for (a, width) in [4e-3, 4e-3, 5e-3].into_iter().enumerate() {
        fluid.widths[a].iter().for_each(|&w| assert_close(w, width));
        assert_close(grain.cells[a], width / d);
    }
    // The inlet's formula reaches 0.02 · 2 · 2 m/s at its corner and the end of the run.
    let FluidStep::Limited { max, limit: FluidStepLimit::Imposed { speed }, max_in_bed: Some(in_bed) } =
        fluid.step
    else {
        panic!("a step by the CFL number: {:?}", fluid.step)
    };
    assert_close(speed, 0.08);
    assert_close(max, 0.5 * 5e-3 / 0.08);
    assert_close(in_bed, SETTLED * 0.5 * 5e-3 / 0.08);
    assert_close(bed.step, 5e-5);
}

#[test]
fn sizes_are_told_apart() {
    let mixed = BED.replace(
        "particles = [{ shape = \"ball\", material = \"grain\" }]",
        "particles = [{ shape = \"ball\", material = \"grain\", scale = { kind = \"uniform\", min = 0.5, max = 1.5 } }]",
    );
    let kinds = found(&mixed).coupling.unwrap().kinds;
    assert_eq!(kinds.iter().map(|k| k.name.as_str()).collect::<Vec<_>>(), ["ball of grain"; 2]);
    let [x, y, z] = kinds[1].cells;
    [(x, 4.0 / 1.5), (y, 4.0 / 1.5), (z, 5.0 / 1.5)]
        .iter()
        .for_each(|&(found, wanted)| assert_close(found, wanted));
    let light = found(&BED.replace("density = 1500", "density = 900")).coupling.unwrap();
    let reason = light.kinds[0].motion.as_ref().unwrap_err();
    assert!(reason.contains("the particles (900 kg/m3) are not heavier"), "{reason}");
}

#[test]
fn a_fluid_alone_has_cells_and_a_step() {
    let start = BED.find("[[material]]").unwrap();
    let fluid = BED.find("[fluid]").unwrap();
    let alone = BED[..start].to_owned() + &BED[fluid..BED.find("[fluid.coupling]").unwrap()];
    let alone =
        alone.replace("dt = 1e-6", "dt = 1e-3").replace("refinement = [0, 0, 0]", "refinement = [0, 1, 0]");
    let given = found(&alone);
    let FluidStep::Given { cfl, .. } = given.step else { panic!("{:?}", given.step) };
    assert_close(cfl, 0.08 * 1e-3 / 5e-3);
    // Nodes at ξ = 0.2, 0.6 and 1.
    let node = |xi: f64| 0.01 * xi.tanh() / 1.0_f64.tanh();
    assert_close(given.widths[1][0], node(1.0) - node(0.6));
    assert_close(given.widths[1][1], 2.0 * node(0.2));
    let automatic = found(&alone.replace("dt = 1e-3", "dt = \"auto\"")).step;
    let FluidStep::Limited { max, max_in_bed: None, .. } = automatic else { panic!("{automatic:?}") };
    assert_close(max, 0.5 * 5e-3 / 0.08);
}
