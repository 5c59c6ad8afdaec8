//! Mistakes that are no errors: warned of once, by `check` and by the run.

mod fluids;
mod particles;
mod units;

use super::check;
use crate::common::{Output, case, folder, replaced, run};
use std::fs;

/// A mistake that is no error: the case it is made in, what is changed there, the key named, and words of the answer.
type Oddity =
    (&'static str, &'static str, &'static [(&'static str, &'static str)], &'static str, &'static str);

const STL: &str =
    "[[wall]]\nname = \"plate\"\nmaterial = \"wall\"\nkind = \"mesh\"\npath = \"../plate.stl\"\n";
const BOX: &str = "kind = \"box\"\nlower = [0.005, 0.005, 0.005]\nupper = [0.075, 0.059, 0.059]";

const COUNT: &str = "count = 16";

const BALLS: &str = "{ shape = \"ball\", material = \"glass\" }";

const PULSE: &str = "kind = \"inlet\"\nvelocity = [0, 0, \"0.1 * (1 + sin(20 * t))\"]";

const JET: &str = "kind = \"inlet\"\nvelocity = [0.05, 0, 0.3]";

const INITIAL: &str =
    "initial = { velocity = [0, \"0.05 * sin(2 * pi * z / 0.2) * x / 0.1\", 0.1], pressure = \"20 * z\" }";

const SMOOTH: &str = "kernel = { kind = \"smooth\", half_width = 1.5 }";

const ODDITIES: &[Oddity] = &[
    (
        "a mesh in micrometres",
        "base.toml",
        &[("[output]", "SCALED 1e4")],
        "wall[1].scale",
        "scale is metres per unit",
    ),
    (
        "a mesh in kilometres",
        "base.toml",
        &[("[output]", "SCALED 1e-3")],
        "wall[1].scale",
        "times smaller than the domain",
    ),
    (
        "a mesh beside the domain",
        "base.toml",
        &[("[output]", "MOVED")],
        "wall[1].translate",
        "no particle meets it",
    ),
    ("a wall after the end", "base.toml", &[(BOX, "FROM")], "wall[1].from", "never exists"),
    (
        "a wall that moves after the end",
        "base.toml",
        &[(BOX, "START")],
        "wall[0].motion.start",
        "never moves",
    ),
    (
        "a flow plane outside",
        "base.toml",
        &[("[output]", "[[flow_plane]]\nname = \"low\"\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n\n[output]")],
        "flow_plane[0].point",
        "nothing is ever counted",
    ),
    (
        "a stop at once",
        "base.toml",
        &[("[output]", "[stop]\nkinetic_energy_below = 1e-9\n\n[output]")],
        "stop.kinetic_energy_below",
        "stop.after",
    ),
    (
        "a domain in millimetres",
        "base.toml",
        &[("upper = [0.08, 0.06, 0.06]", "upper = [80, 0.06, 0.06]")],
        "domain.upper[0]",
        "times the particles' region",
    ),
    (
        "an outlet behind a wall",
        "base.toml",
        &[("[domain]\n", "[domain]\noutlets = [\"-z\"]\n")],
        "domain.outlets[0]",
        "wall \"box\" closes this face",
    ),
    (
        "no floor",
        "base.toml",
        &[(BOX, "kind = \"plane\"\npoint = [0, 0, 0.06]\nnormal = [0, 0, -1]")],
        "domain",
        "at -z",
    ),
    (
        "a bed without sides",
        "base.toml",
        &[
            (BOX, "kind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]"),
            ("radius = 5e-3", "radius = 2e-3"),
            ("spacing = 0.011", "spacing = 0.005"),
            (COUNT, "count = 200"),
        ],
        "domain",
        "at -x, +x, -y, +y",
    ),
    (
        "a slow impact",
        "base.toml",
        &[(COUNT, "count = 16\nvelocity = [0, 0, -3]"), ("dt = 4e-5", "dt = 4e-5\nimpact_speed = 0.1")],
        "time.impact_speed",
        "30.0 times",
    ),
    (
        "a velocity in mm/s",
        "base.toml",
        &[(COUNT, "count = 16\nvelocity = [0, 0, -300]")],
        "insert[0].velocity",
        "radii per time step",
    ),
    (
        "a wall in mm/s",
        "base.toml",
        &[(BOX, "FAST")],
        "wall[0].motion.velocity",
        "radii of the smallest particle",
    ),
    (
        "sizes of a ratio of 25",
        "base.toml",
        &[
            (
                BALLS,
                "{ shape = \"ball\", material = \"glass\", diameter = { kind = \"uniform\", by = \"mass\", min = 4e-4, max = 1e-2 } }",
            ),
            ("dt = 4e-5", "dt = \"auto\""),
        ],
        "insert[0].particles[0]",
        "a ratio of 25: the smallest decide the time step",
    ),
    (
        "cut-offs that leave little",
        "base.toml",
        &[(
            BALLS,
            "{ shape = \"ball\", material = \"glass\", scale = { kind = \"log_normal\", by = \"mass\", median = 1, geometric_deviation = 1.5, min = 0.9, max = 1.05 } }",
        )],
        "insert[0].particles[0]",
        "the cut-offs keep 15.0 % of the log-normal distribution",
    ),
    (
        "a lid lighter than what it lies on",
        "shear.toml",
        &[(
            "{ kind = \"translation\", velocity = [-0.4, 0, -0.6], end = 0.095 }",
            "{ kind = \"load\", axis = [0, 0, -1], pressure = 1, mass = 1e-3, damping = 0.1 }",
        )],
        "wall[1].motion.mass",
        // 2π √(m/(N k)) of m = 1 g, N = 65 and k = 10 kN/m, in steps of 25 µs.
        "on 65 contacts, as many as its area holds, the wall swings with a period of 9.9 time steps",
    ),
    (
        "a sheared lattice",
        "sheared.toml",
        &[
            (
                "kind = \"window\", window = { kind = \"box\", lower = [0, 0, 0], upper = [0.056, 0.048, 0.056] }, attempts = 10000",
                "kind = \"lattice\", lower = [0, 0, 0], upper = [0.056, 0.048, 0.056], spacing = 8e-3",
            ),
            ("count = 300", "count = 200"),
        ],
        "insert[0].place",
        "without a contact",
    ),
    (
        "an oscillation in kHz",
        "base.toml",
        &[(BOX, "SHAKEN")],
        "wall[0].motion.frequency",
        "5.0 time steps per period",
    ),
    (
        "viscous rolling without damping",
        "silo.toml",
        &[
            ("restitution = 0.62", "restitution = 1.0"),
            ("rolling_friction = 0.01", "rolling_friction = 0.01\nrolling = { kind = \"viscous\" }"),
        ],
        "contact[1].rolling.kind",
        "tangential damping, which is zero",
    ),
    (
        "elastic constants that no law takes",
        "base.toml",
        &[("density = 2500", "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.3")],
        "material[0].youngs_modulus",
        "no contact of \"glass\" has a law that takes it",
    ),
    (
        "adhesion of thousands of weights",
        "base.toml",
        &[
            (
                "density = 2500",
                "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.3\nsurface_energy = 0.1",
            ),
            ("dt = 4e-5", "dt = \"auto\""),
            ("[domain]", "gravity = [0, 0, -1e-4]\n[domain]"),
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal = { kind = \"jkr\" }",
            ),
        ],
        "contact",
        "weights of the smallest particle",
    ),
    (
        "a step longer than a Rayleigh wave",
        "base.toml",
        &[
            ("density = 2500", "density = 2500\nyoungs_modulus = 1e9\npoissons_ratio = 0.3"),
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal = { kind = \"hertz\" }",
            ),
            ("dt = 4e-5", "dt = 2e-5\nimpact_speed = 1e-3"),
            ("[domain]", "gravity = [0, 0, 0]\n[domain]"),
        ],
        "time.dt",
        "of the Rayleigh time",
    ),
    (
        "restitution beside viscoelasticity",
        "base.toml",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
            "\"glass\", \"glass\"]\ndamping = { kind = \"viscoelastic\", time = 1e-5 }\nnormal_stiffness = 1e4",
        )],
        "contact[0].restitution",
        "acts on tangential damping alone",
    ),
    (
        "softened adhesion",
        "base.toml",
        &[
            (
                "density = 2500",
                "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.3\nsurface_energy = 0.01",
            ),
            ("dt = 4e-5", "dt = \"auto\""),
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal = { kind = \"jkr\" }\nsoftening = 10",
            ),
        ],
        "contact[0].softening",
        "energy to part grows 4.6 times",
    ),
    ("a step in nanoseconds", "base.toml", &[("dt = 4e-5", "dt = 1e-9")], "time.dt", "shorter than \"auto\""),
    (
        "an inlet that sucks",
        "duct.toml",
        &[(PULSE, "kind = \"parabolic_inlet\"\nmean = -0.1")],
        "fluid.boundary[0].mean",
        "blows out of the domain",
    ),
    (
        "an outlet alone",
        "duct.toml",
        &[(PULSE, "kind = \"wall\""), (JET, "kind = \"wall\""), (INITIAL, "")],
        "fluid.boundary[2].kind",
        "nothing lets fluid in",
    ),
    (
        "cells of half a diameter",
        "bed.toml",
        &[("cells = [12, 4, 16]", "cells = [64, 16, 80]")],
        "fluid.cells",
        "0.50 diameters wide",
    ),
    (
        "cubes in cells of two diameters",
        "bed.toml",
        &[(SMOOTH, "kernel = { kind = \"cube\" }")],
        "fluid.coupling.kernel",
        "here some are 2.00",
    ),
    (
        "particle steps beyond the Courant number",
        "bed.toml",
        &[("half_width = 1.5 }", "half_width = 1.5 }, particle_steps = 1000")],
        "fluid.coupling.particle_steps",
        "would do",
    ),
    (
        "a step beyond the Courant number",
        "duct.toml",
        &[("cfl = 0.7", "cfl = 0.2")],
        "time.dt",
        "beyond fluid.cfl",
    ),
    (
        "a mixture that falls for ever",
        "rain.toml",
        &[
            ("periodic = [true, true, false]\noutlets = [\"-z\"]", "periodic = [true, true, true]"),
            ("[[fluid.boundary]]\nface = \"-z\"\nkind = \"inlet\"\nvelocity = [0, 0, 0.5]\n", ""),
            ("[[fluid.boundary]]\nface = \"+z\"\nkind = \"outlet\"\n", ""),
        ],
        "gravity[2]",
        "accelerate for ever",
    ),
    (
        "a body wider than the tube around it",
        "walls_of_fluid.toml",
        &[("motion = \"free\"", "motion = \"fixed\""), ("radius = 0.45", "radius = 0.14")],
        "wall[0].radius",
        "blocks the section",
    ),
    (
        "a body wider than the cone around it",
        "walls_of_fluid.toml",
        &[
            ("motion = \"free\"", "motion = \"fixed\""),
            (
                "kind = \"cylinder\"\ncenter = [0, 0.51, 0.49]\naxis = [1, 0, 0]\nradius = 0.45",
                "kind = \"revolution\"\norigin = [0, 0.51, 0.49]\naxis = [1, 0, 0]\nprofile = [[0, 0.1], [0.5, 0.14], [1.5, 0.1]]",
            ),
        ],
        "wall[0].profile",
        "blocks the section",
    ),
    (
        "an end of years",
        "base.toml",
        &[
            ("end = 0.02", "end = 1e8"),
            ("series = 0.001", "series = 1e6"),
            ("particles = 0.01", "particles = 1e6"),
            ("checkpoint = 0.01", "checkpoint = 1e6"),
        ],
        "time.end",
        "take years",
    ),
];

/// The text of a case with an oddity; words for longer passages are spelt out.
fn odd(case_name: &str, edits: &[(&str, &str)]) -> String {
    let plate = |more: &str| format!("{STL}{more}\n\n[output]");
    let moved = |motion: &str| format!("{BOX}\nmotion = {{ {motion} }}");
    edits.iter().fold(case(case_name), |text, &(old, new)| {
        let new = match new.split_once(' ').unwrap_or((new, "")) {
            ("SCALED", scale) => plate(&format!("scale = {scale}")),
            ("MOVED", _) => plate("translate = [1, 0, 0]"),
            ("FROM", _) => format!("{BOX}\n\n[[wall]]\nname = \"late\"\nmaterial = \"wall\"\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nfrom = 0.03"),
            ("START", _) => moved("kind = \"translation\", velocity = [0, 0, 0.01], start = 1"),
            ("FAST", _) => moved("kind = \"translation\", velocity = [0, 0, -200], start = 0.01"),
            ("SHAKEN", _) => moved("kind = \"oscillation\", amplitude = [0, 0, 1e-6], frequency = 5e3"),
            _ => new.to_string(),
        };
        replaced(&text, old, &new)
    })
}

/// That there are none in good cases: [`every_case_of_the_repository_is_right`].
#[test]
fn every_oddity_is_warned_of_once_by_check_and_by_the_run() {
    let home = folder("check_odd");
    let corner = "solid plate\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 0.01 0\nvertex 0.01 0 0\nendloop\nendfacet\nendsolid plate\n";
    fs::write(home.join("plate.stl"), corner).unwrap();
    let warnings = |output: &Output| -> Vec<String> {
        output.stderr.lines().filter(|line| line.starts_with("warning: ")).map(str::to_string).collect()
    };
    let mut wrong = Vec::new();
    println!("| mistake | warning |\n|---|---|");
    for (what, name, edits, key, words) in ODDITIES {
        let home = home.join(what.replace(['/', ' '], "_"));
        fs::create_dir(&home).unwrap();
        let said = warnings(&check(&home, &odd(name, edits), &[]).succeeded());
        let ran = warnings(&run(2, &home, &["case.toml", "--max-walltime", "0"]));
        println!("| {what} | {} |", said.join("<br>").replace('|', "\\|"));
        let is_right = matches!(&said[..], [one] if one.contains(&format!(" {key}")) && one.contains(words));
        if !is_right || ran.iter().filter(|line| said.contains(line)).count() != said.len() {
            wrong.push((what, said, ran));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// As above, by `check` alone, whose rules are those of a run.
#[test]
fn further_oddities_are_warned_of_with_key_consequence_and_remedy() {
    let home = folder("check_further_oddities");
    units::TABLES.iter().for_each(|(name, text)| fs::write(home.join(name), text).unwrap());
    let mut wrong = Vec::new();
    println!("| mistake | warning |\n|---|---|");
    for (what, name, edits, key, words) in [particles::ODDITIES, fluids::ODDITIES, units::ODDITIES].concat() {
        let output = check(&home, &odd(name, edits), &[]).succeeded();
        let said: Vec<&str> = output.stderr.lines().filter(|line| line.starts_with("warning: ")).collect();
        println!("| {what} | {} |", said.join("<br>").replace('|', "\\|"));
        if !matches!(&said[..], [one] if one.contains(&format!(" {key} = ")) || one.contains(&format!(" {key}:")))
            || !said[0].contains(words)
        {
            wrong.push((what, output.stderr.clone()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
