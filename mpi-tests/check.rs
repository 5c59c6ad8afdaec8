//! `grains-mpi check` explains a case before it runs, and `schema` describes the case files.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Output, case, folder, replaced, run};
use std::fs;
use std::path::{Path, PathBuf};

fn check(home: &Path, text: &str, arguments: &[&str]) -> Output {
    fs::write(home.join("case.toml"), text).unwrap();
    run(1, home, &[&["check", "case.toml"], arguments].concat())
}

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases")
}

/// Numbers of the row of a pair: e_n, m_ij, γ, T_c, largest overlap, its ratio, T_c/dt.
fn row(text: &str, pair: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.trim().starts_with(pair));
    let line = line.unwrap_or_else(|| panic!("no row {pair}: {text}"));
    line.trim()[pair.len()..].split_whitespace().map(|x| x.parse().unwrap()).collect()
}

/// Asserts damping rate (1/s), contact time (s) and largest overlap (m) of a pair to 1 %.
fn assert_row(text: &str, pair: &str, wanted: [f64; 3]) {
    let row = row(text, pair);
    for (found, wanted) in [row[2], row[3], row[4]].into_iter().zip(wanted) {
        assert!((found / wanted - 1.0).abs() < 0.01, "{pair}: {found} instead of {wanted}");
    }
}

#[test]
fn the_silo_has_the_contact_times_and_overlaps_of_the_thesis() {
    let home = folder("check_silo");
    let text = fs::read_to_string(cases().join("silo/discharge.toml")).unwrap();
    let output = check(&home, &text, &["--ranks", "2"]).succeeded();
    // Table 5.1 prints 1.87e3, 1.55e-4 and 1.92e-4.
    assert_row(&output.stdout, "glass - glass", [1.866e3, 1.542e-4, 1.921e-4]);
    // With the restitution as stated; the table's own numbers belong to 0.7144 (errata R16-9).
    assert_row(&output.stdout, "glass - wall (wall)", [2.565e3, 1.864e-4, 2.127e-4]);
    let obtained = text.replace("restitution = 0.62", "restitution = 0.7144");
    let output = check(&home, &obtained, &["--ranks", "2"]).succeeded();
    assert_row(&output.stdout, "glass - wall (wall)", [1.815e3, 1.853e-4, 2.256e-4]);
    let row = row(&output.stdout, "glass - glass");
    assert!((row[6] - row[3] / 1e-5).abs() < 0.01, "T_c/dt");
    for word in [
        "particles      14000",
        "mass           4.816",
        "decomposition  ",
        "interaction range",
        "memory         about",
        "T_c/dt = 15.42",
        "recommended",
        "time needed    about",
        "disk           about",
    ] {
        assert!(output.stdout.contains(word), "`{word}` is missing: {}", output.stdout);
    }
}

#[test]
fn table_5_4_of_the_thesis_is_reproduced() {
    let home = folder("check_table_5_4");
    let edits = [
        ("radius = 5e-3", "radius = 1.5e-3"),
        ("dt = 4e-5", "dt = 2e-6\nimpact_speed = 4.2"),
        ("spacing = 0.011", "spacing = 0.004"),
    ];
    let text = edits.iter().fold(case("base.toml"), |text, (old, new)| replaced(&text, old, new));
    let text = text.replace("normal_stiffness = 1e4", "normal_stiffness = 1e5");
    let text = text.replace("restitution = 0.7", "restitution = 0.75");
    let output = check(&home, &text, &[]).succeeded();
    assert_row(&output.stdout, "glass - glass", [6.86e3, 4.194e-5, 4.876e-5]);
    assert_row(&output.stdout, "glass - wall (wall)", [4.851e3, 5.931e-5, 6.895e-5]);
}

/// Off-centre hits of a needle are shorter than those of a ball, also of a ball that is lighter.
#[test]
fn a_needle_beside_a_lighter_ball_decides_the_time_step() {
    let home = folder("check_needle");
    let needle = "[[shape]]\nname = \"needle\"\nkind = \"box\"\nedges = [4e-3, 4e-3, 16e-3]\n\n[[insert]]";
    let text = replaced(&case("base.toml"), "[[insert]]", needle);
    let text = replaced(&replaced(&text, "radius = 5e-3", "radius = 3e-3"), "dt = 4e-5", "dt = \"auto\"");
    let text = replaced(&replaced(&text, "count = 16", "count = 2"), "spacing = 0.011", "spacing = 0.02");
    let step = |particles: &str| {
        let text = replaced(&text, "[{ shape = \"ball\", material = \"glass\" }]", particles);
        let output = check(&home, &text, &[]).succeeded();
        let line = output.stdout.lines().find(|l| l.starts_with("time step")).unwrap().to_string();
        line.split_whitespace().nth(2).unwrap().parse::<f64>().unwrap()
    };
    let (ball, needle) =
        ("{ shape = \"ball\", material = \"glass\" }", "{ shape = \"needle\", material = \"glass\" }");
    let alone = step(&format!("[{needle}]"));
    assert_eq!(step(&format!("[{ball}, {needle}]")), alone);
    assert!(alone < 0.8 * step(&format!("[{ball}]")));
}

#[test]
fn coarse_time_steps_are_warned_of_and_then_refused() {
    let home = folder("check_dt");
    // T_c of the pair is 8.1e-4 s.
    let with = |dt: &str| replaced(&case("base.toml"), "dt = 4e-5", dt);
    let fine = check(&home, &with("dt = 4e-5"), &[]).succeeded();
    assert!(!fine.stdout.contains("warning: "), "{}", fine.text());
    let coarse = check(&home, &with("dt = 1e-4"), &[]).succeeded();
    assert!(coarse.stdout.contains("case.toml:10:6: time.dt = 1e-4: "), "{}", coarse.text());
    assert!(coarse.stdout.contains("below the usual 10"), "{}", coarse.text());
    let refused = check(&home, &with("dt = 2e-4"), &[]);
    assert!(refused.only_error(2).contains("below 5"), "{}", refused.text());
    let accepted = check(&home, &with("dt = 2e-4\naccept_coarse_dt = true"), &[]).succeeded();
    assert!(accepted.stdout.contains("time.dt = 2e-4: "), "{}", accepted.text());
    let automatic = check(&home, &with("dt = \"auto\""), &[]).succeeded();
    assert!(automatic.stdout.contains("(auto)"), "{}", automatic.text());
    assert!(automatic.stdout.contains("over 20 steps"), "it says why: {}", automatic.text());
    let steps = row(&automatic.stdout, "glass - glass")[6];
    assert!((20.0..22.1).contains(&steps), "T_c/dt = {steps}");
}

#[test]
fn an_impact_beyond_the_limit_of_overlap_is_foreseen() {
    let home = folder("check_impact");
    let text = replaced(&case("base.toml"), "dt = 4e-5", "dt = 4e-5\nimpact_speed = 20");
    let output = check(&home, &text, &[]).succeeded();
    assert!(output.stdout.contains("beyond limits.overlap"), "{}", output.text());
    assert!(output.stdout.contains("raise normal_stiffness by"), "{}", output.text());
}

/// All case files below a folder.
fn case_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            case_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "toml") {
            found.push(path);
        }
    }
}

#[test]
fn every_case_of_the_repository_is_right() {
    let home = folder("check_cases");
    let mut files = Vec::new();
    case_files(&cases(), &mut files);
    case_files(&cases().join("../mpi-tests/cases"), &mut files);
    assert!(files.len() >= 6, "{files:?}");
    for file in files {
        let output = run(2, &home, &["check", file.to_str().unwrap()]).succeeded();
        assert!(output.stderr.is_empty(), "{}: {}", file.display(), output.text());
        println!("{}: ok", file.display());
    }
}

#[test]
fn the_schema_is_valid_and_knows_every_section() {
    let home = folder("check_schema");
    // On two ranks it is printed once.
    let output = run(2, &home, &["schema"]).succeeded();
    let schema: serde_json::Value = serde_json::from_str(&output.stdout).expect("the schema is JSON");
    let sections = schema["properties"].as_object().unwrap();
    for name in
        ["domain", "time", "material", "contact", "shape", "insert", "wall", "fluid", "output", "stop"]
    {
        let section = &sections[name];
        assert!(section.get("description").is_some() || section.get("$ref").is_some(), "{name}: {section}");
    }
    let needs =
        |place: &serde_json::Value, name: &str| place["required"].as_array().unwrap().contains(&name.into());
    for name in ["domain", "time"] {
        assert!(needs(&schema, name), "{name} is required");
    }
    for name in ["material", "shape", "insert"] {
        assert!(needs(&schema["then"], name), "{name} is required without a fluid");
    }
    assert!(needs(&schema["if"]["not"], "fluid"));
}

#[test]
fn the_version_bears_the_git_hash() {
    let output = run(2, &folder("check_version"), &["--version"]).succeeded();
    let hash = output.stdout.trim().split("(git ").nth(1).unwrap_or_default().trim_end_matches(')');
    assert_eq!(output.stdout.lines().count(), 1, "{}", output.text());
    assert!(hash.len() >= 7 && hash.starts_with(|c: char| c.is_ascii_hexdigit()), "{}", output.text());
}

#[test]
fn hard_collisions_are_explained_and_their_step_follows_the_way_of_an_impact() {
    let home = folder("check_hard");
    let plastic = "[[material]]\nname = \"plastic\"";
    let hard = "[collisions]\nmodel = \"hard\"\nscheme = \"sequential\"\n\n[[material]]\nname = \"plastic\"";
    let text = replaced(&case("drum.toml"), plastic, hard);
    let text = text.replace("normal_stiffness = 3e3\n", "");
    let auto = replaced(&text, "dt = 4e-5", "dt = \"auto\"\nimpact_speed = 0.5");
    let output = check(&home, &auto, &[]).succeeded();
    // 2 % of the inscribed radius of the dodecahedra, 0.7947 of 4 mm, at 0.5 m/s.
    for word in [
        "hard collisions: impulses, sequential scheme, 1 sweep(s) per step, restitution 0 below",
        "plastic - steel (wall)",
        "time step      1.2e-4 s (auto); 1.89 % of the smallest radius at impact_speed",
    ] {
        assert!(output.stdout.contains(word), "`{word}` is missing: {}", output.stdout);
    }
    let coarse = replaced(&text, "dt = 4e-5", "dt = 1e-3\nimpact_speed = 1");
    let output = check(&home, &coarse, &[]);
    assert!(output.only_error(2).contains("get 31.5 % of the smallest radius into each other in one step"));
    let output = check(&home, &text.replace("model = \"hard\"\nscheme = \"sequential\"", ""), &[]);
    assert!(output.only_error(2).contains("Only collisions.model = \"hard\" does without it"));
}

/// A bed of 64,000 beads or, with `edits`, something else.
fn bed(edits: &[(&str, &str)]) -> String {
    let text = "[domain]
lower = [0, 0, 0]
upper = [0.084, 0.084, 0.1]
periodic = [true, true, false]

[time]
end = 1e-3
dt = 1e-4
accept_coarse_dt = true

[[material]]
name = \"glass\"
density = 2500

[[contact]]
between = [\"glass\", \"glass\"]
normal_stiffness = 1000
restitution = 0.9
friction = 0.1

[[shape]]
name = \"bead\"
kind = \"sphere\"
radius = 1e-3

[[insert]]
name = \"beads\"
particles = [{ shape = \"bead\", material = \"glass\" }]
count = 64000
orientation = \"aligned\"
place = { kind = \"lattice\", lower = [0, 0, 0], upper = [0.084, 0.084, 0.09], spacing = 0.00205 }

[[wall]]
name = \"floor\"
material = \"glass\"
kind = \"plane\"
point = [0, 0, 0]
normal = [0, 0, 1]

[output]
directory = \"results\"
particles = 5e-4
series = 1e-4
checkpoint = 5e-4
";
    edits.iter().fold(text.to_string(), |text, (old, new)| replaced(&text, old, new))
}

const LATTICE: &str =
    "{ kind = \"lattice\", lower = [0, 0, 0], upper = [0.084, 0.084, 0.09], spacing = 0.00205 }";

/// The number before a unit in the line of a text that begins with `start`.
fn number(text: &str, start: &str, unit: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(start));
    let line = line.unwrap_or_else(|| panic!("no line `{start}`: {text}"));
    let before = line.split(unit).next().unwrap().trim_end();
    before.rsplit(' ').next().unwrap().parse().unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn bytes_below(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries
        .map(|e| if e.path().is_dir() { bytes_below(&e.path()) } else { e.metadata().unwrap().len() })
        .sum()
}

/// Memory within a factor of 1.5, disk within 1.4, steps exactly.
#[test]
fn a_run_takes_what_check_says() {
    let air = "[fluid]\ndensity = 1.2\nviscosity = 1.8e-5\ncells = [40, 40, 48]\n";
    let (coupled, means) = (
        format!("{air}coupling = {{ drag = \"beetstra\" }}\n\n[output]"),
        format!("{air}output = {{ mean_from = 0 }}\n\n[output]"),
    );
    let resolved = format!(
        "{}resolved = {{ motion = \"fixed\" }}\n\n[output]",
        air.replace("[40, 40, 48]", "[84, 84, 100]")
    );
    let cube = ("kind = \"sphere\"\nradius = 1e-3", "kind = \"box\"\nedges = [2.04e-3, 2.04e-3, 2.04e-3]");
    let few = ("count = 64000", "count = 3000");
    let surfaces = ("series = 1e-4", "series = 1e-4\nsurfaces = 5e-4");
    let small = ("[output]", "[output]\nprecision = \"f32\"");
    let cases: [(&str, usize, String); 8] = [
        ("beads", 1, bed(&[])),
        ("beads on two ranks", 2, bed(&[])),
        (
            "touching cubes",
            1,
            bed(&[
                cube,
                ("count = 64000\n", ""),
                (LATTICE, "{ kind = \"file\", path = \"../cubes.csv\" }"),
                ("end = 1e-3\ndt = 1e-4", "end = 5e-5\ndt = 5e-6"),
                ("series = 1e-4", "series = 5e-6"),
                ("particles = 5e-4", "particles = 2.5e-5"),
                ("checkpoint = 5e-4", "checkpoint = 2.5e-5"),
            ]),
        ),
        ("surfaces of beads", 1, bed(&[few, surfaces])),
        ("surfaces of cubes in 32 bits", 2, bed(&[cube, few, surfaces, small])),
        ("beads in air", 1, bed(&[("[output]", &coupled)])),
        (
            "means of air",
            1,
            bed(&[
                few,
                ("[output]", &means.replace("output = ", "coupling = { drag = \"beetstra\" }\noutput = ")),
            ]),
        ),
        (
            "air around fixed beads",
            1,
            bed(&[
                ("count = 64000", "count = 300"),
                ("radius = 1e-3", "radius = 4e-3"),
                ("spacing = 0.00205", "spacing = 0.0082"),
                ("[output]", &resolved),
            ]),
        ),
    ];
    let home = folder("check_cost");
    let mut rows = String::from("x,y,z\n");
    for k in 0..20_000 {
        let [x, y, z] = [k % 40, k / 40 % 40, k / 1600].map(|n| 1.1e-3 + 2.0395e-3 * f64::from(n));
        rows += &format!("{x},{y},{z}\n");
    }
    fs::write(home.join("cubes.csv"), rows).unwrap();
    let mut wrong = Vec::new();
    println!("| case | memory of the run over that of check | disk | steps |\n|---|---|---|---|");
    for (name, ranks, text) in cases {
        let home = home.join(name.replace(' ', "_"));
        fs::create_dir(&home).unwrap();
        let said = check(&home, &text, &["--ranks", &ranks.to_string()]).succeeded().stdout;
        let ran = run(ranks, &home, &["case.toml"]).succeeded().stdout;
        let memory = number(&ran, "memory:", "MB") / number(&said, "memory  ", "MB");
        let disk = bytes_below(&home.join("results")) as f64 / 1e6 / number(&said, "disk", "MB");
        let last = ran.lines().rfind(|line| line.starts_with("step ")).unwrap();
        let steps =
            last.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / number(&said, "steps", "to t");
        println!("| {name} | {memory:.2} | {disk:.2} | {steps} |");
        let is_near = |ratio: f64, factor: f64| (1.0 / factor..=factor).contains(&ratio);
        if !is_near(memory, 1.5) || !is_near(disk, 1.4) || !is_near(steps, 1.000_001) {
            wrong.push(name);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A mistake that is no error: the case it is made in, what is changed there, the key named, and words of the answer.
type Oddity =
    (&'static str, &'static str, &'static [(&'static str, &'static str)], &'static str, &'static str);

const STL: &str =
    "[[wall]]\nname = \"plate\"\nmaterial = \"wall\"\nkind = \"mesh\"\npath = \"../plate.stl\"\n";
const BOX: &str = "kind = \"box\"\nlower = [0.005, 0.005, 0.005]\nupper = [0.075, 0.059, 0.059]";
const COUNT: &str = "count = 16";
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
        "an oscillation in kHz",
        "base.toml",
        &[(BOX, "SHAKEN")],
        "wall[0].motion.frequency",
        "5.0 time steps per period",
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
