//! Inlets of stated flow and pressure on parts of faces: on any ranks, across restarts, and what is refused.

use super::{assert_close, assert_same_fluid, continued, results_of};
use crate::common::results::series;
use crate::common::{case, folder, replaced, run_case};
use std::fs;

#[test]
fn inlets_let_in_what_is_stated_on_any_ranks_and_across_restarts() {
    let (home, text) = (folder("fluid_inlets"), case("inlets.toml"));
    let result = |ranks: usize| results_of(&home, &ranks.to_string(), ranks, &text);
    let one = result(1);
    let table = series(&one);
    let flow = |name: &str| table.column(&format!("{name}_flow"));
    let triangle = 0.5 * (0.03 * 0.04 - 0.01 * 0.01);
    let (fan, outlet) = (flow("fan"), flow("outlet"));
    for (k, t) in table.column("time").iter().enumerate().skip(1) {
        let stated = 0.02 / 800.0 * (1.0 + (30.0 * t).sin());
        let [annulus, polygon] = ["annulus", "polygon"].map(|name| flow(name)[k]);
        assert!((annulus - stated).abs() < 1e-12 * stated.max(1e-5), "{t}: {annulus} for {stated}");
        assert!((-polygon / (0.05 * triangle) - 1.0).abs() < 1e-12, "{t}: {polygon}");
        let net = outlet[k] - fan[k] - annulus + polygon;
        assert!(net.abs() < 1e-8 * outlet[k], "{t}: {net} of {}", outlet[k]);
    }
    assert!(*fan.last().unwrap() > 1e-5, "the fan blows: {fan:?}");
    let mut others = vec![result(2), result(4)];
    others.push(continued(&home, "2", 3, &text));
    for other in others {
        assert_same_fluid(&one, &other, 1e-7);
        assert_close(&fan, &series(&other).column("fan_flow"), 1e-7, "flow of the fan");
    }
}

/// A tube with a plate across it, in a flow averaged over a particle and in one resolved about it.
#[test]
fn what_walls_shut_off_is_refused_with_a_place() {
    let home = folder("fluid_shut_off");
    let text = |of_particles: &str, plate: &str| {
        format!(
            "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [0.1, 0.04, 0.04]\n[time]\nend = 1e-3\n\
             [[material]]\nname = \"glass\"\ndensity = 2500\n\
             [[contact]]\nbetween = [\"glass\", \"glass\"]\nnormal_stiffness = 1000\nrestitution = 0.8\nfriction = 0.3\n\
             {of_particles}{plate}\
             [[fluid.boundary]]\nface = \"-x\"\nkind = \"flow_inlet\"\nvolume_flow = 1e-5\n\
             [[fluid.boundary]]\nface = \"+x\"\nkind = \"outlet\"\n[output]\ndirectory = \"results\"\n"
        )
    };
    let averaged = "[[shape]]\nname = \"bead\"\nkind = \"sphere\"\nradius = 5e-4\n\
         [[insert]]\nname = \"bead\"\nparticles = [{ shape = \"bead\", material = \"glass\" }]\ncount = 1\n\
         place = { kind = \"window\", window = { kind = \"point\", at = [0.02, 0.02, 0.02] } }\n\
         [fluid]\ndensity = 1.2\nviscosity = 1.8e-5\ncells = [20, 8, 8]\n\
         coupling = { drag = \"beetstra\", model = \"A\", kernel = { kind = \"smooth\" } }\n";
    let resolved = "[fluid]\ndensity = 1.2\nviscosity = 1.8e-3\ncells = [40, 16, 16]\n";
    let plate = |reaches: f64| {
        format!(
            "[[wall]]\nname = \"plate\"\nmaterial = \"glass\"\nkind = \"box\"\nlower = [0.05, -0.01, -0.01]\n\
             upper = [0.065, {reaches}, 0.05]\nside = \"outside\"\nfluid = \"outside\"\n"
        )
    };
    for (label, of_particles) in [("averaged", averaged), ("resolved", resolved)] {
        for ranks in [1, 3] {
            let own = home.join(format!("{label}-{ranks}"));
            fs::create_dir_all(&own).unwrap();
            let failed = run_case(ranks, &own, &text(of_particles, &plate(0.05)), &[]);
            let message = failed.only_error(2);
            for words in ["shut an inlet off", "1.0000e-5 m³/s enter", "give this region an outlet"] {
                assert!(message.contains(words), "{label}: `{words}` in {message}");
            }
        }
        let own = home.join(format!("{label}-open"));
        fs::create_dir_all(&own).unwrap();
        run_case(2, &own, &text(of_particles, &plate(0.03)), &[]).succeeded();
    }
}

#[test]
fn fluid_that_comes_back_through_an_outlet_is_told_once() {
    let home = folder("fluid_backflow");
    let text = replaced(&case("inlets.toml"), "end = 0.2", "end = 0.1");
    let text = replaced(
        &text,
        "cfl = 0.5",
        "cfl = 0.5\ninitial = { velocity = [\"2 * (z - 0.03) / 0.03\", 0, \"-2 * (x - 0.1) / 0.1\"] }",
    );
    let output = run_case(2, &home, &text, &[]).succeeded();
    assert_eq!(output.stderr.matches("comes back in").count(), 1, "{}", output.stderr);
    let shares = series(&home.join("results")).column("outlet_backflow");
    assert!(
        shares.iter().any(|share| *share > 0.01) && shares.iter().all(|share| (0.0..1.0).contains(share))
    );
    assert!(shares.last().unwrap() < &(0.9 * shares[0]), "it dies down: {shares:?}");
}
