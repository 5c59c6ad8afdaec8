//! Iterations for the pressure grow neither with ranks nor with resolution.

use crate::common::{folder, run};
use std::fs;

const PRESSURE: &str = "pressure = { method = \"conjugate_gradients\", tolerance = 1e-8 }\n";

/// A closed box with a moving lid.
fn closed_box(cells: usize) -> String {
    format!(
        "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nend = 1000\ndt = {}\n\
         [fluid]\ndensity = 1\nviscosity = 0.01\ncells = [{cells}, {cells}, {cells}]\n{PRESSURE}\
         [[fluid.boundary]]\nface = \"+z\"\nkind = \"wall\"\nvelocity = [1, 0, 0]\n",
        0.25 / cells as f64
    )
}

/// A bed in a column whose wall cuts the cells, averaged over particles.
fn column(cells: usize) -> String {
    format!(
        "[domain]\nlower = [0, 0, 0]\nupper = [0.02, 0.02, 0.02]\nbalance = false\n[time]\nend = 1000\ndt = 1e-5\naccept_coarse_dt = true\n\
         [[material]]\nname = \"glass\"\ndensity = 2500\n\
         [[contact]]\nbetween = [\"glass\", \"glass\"]\nnormal_stiffness = 10\nrestitution = 0.8\nfriction = 0.3\n\
         [[shape]]\nname = \"bead\"\nkind = \"sphere\"\nradius = 3e-4\n[[insert]]\nname = \"bed\"\n\
         particles = [{{ shape = \"bead\", material = \"glass\" }}]\ncount = 1500\n\
         place = {{ kind = \"lattice\", lower = [0.0035, 0.0035, 0.001], upper = [0.0165, 0.0165, 0.016], spacing = 9e-4, noise = 0.05 }}\n\
         [[wall]]\nname = \"column\"\nmaterial = \"glass\"\nkind = \"cylinder\"\ncenter = [0.01, 0.0101, 0.01]\n\
         axis = [0, 0, 1]\nradius = 0.0095\nfluid = \"particles\"\n\
         [fluid]\ndensity = 1.2\nviscosity = 1.8e-5\ncells = [{cells}, {cells}, {cells}]\n{PRESSURE}\
         coupling = {{ drag = \"beetstra\", particle_steps = 1 }}\n\
         [[fluid.boundary]]\nface = \"-z\"\nkind = \"inlet\"\nvelocity = [0, 0, 0.3]\n\
         [[fluid.boundary]]\nface = \"+z\"\nkind = \"outlet\"\n"
    )
}

/// Iterations of four steps after some.
fn iterations(label: &str, ranks: usize, text: &str) -> f64 {
    let place = folder(&format!("fluid_iterations_{label}"));
    fs::write(place.join("case.toml"), text).unwrap();
    let bench = ["bench", "case.toml", "--warm", "3", "--steps", "4", "--segments", "1"];
    let output = run(ranks, &place, &bench).succeeded().stdout;
    let line = output.lines().find(|line| line.starts_with("fluid_ns_per_cell_step")).unwrap();
    let [.., steps, _, count] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
    count.parse::<f64>().unwrap() / steps.parse::<f64>().unwrap()
}

#[test]
fn iterations_grow_neither_with_ranks_nor_with_resolution() {
    for (name, text) in [("box", closed_box(32)), ("column", column(32))] {
        let [one, many] = [1, 16].map(|ranks| iterations(&format!("{name}_{ranks}"), ranks, &text));
        println!("measured {name}: {one} iterations, {many} on 16 ranks");
        assert!(many <= one + 2.0, "{name}: {one} iterations, {many} on 16 ranks");
    }
    let [coarse, fine] = [16, 64].map(|n| iterations(&format!("box_of_{n}"), 1, &closed_box(n)));
    println!("measured box: {coarse} iterations of 16 cells along an edge, {fine} of 64");
    assert!(fine <= coarse + 2.0, "{coarse} iterations of 16 cells along an edge, {fine} of 64");
}
