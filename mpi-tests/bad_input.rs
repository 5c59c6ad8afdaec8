//! Mistakes of users: each ends all ranks, with the right exit code and one message that names the key, file
//! or particle and a remedy. With `--nocapture` the tests print mistake and message as a table.

#![allow(clippy::unwrap_used)]

mod common;

use common::{case, folder, python_with, replaced, run, run_case, skipped};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A mistake: what is done wrong, and what the answer must say.
struct Mistake {
    what: &'static str,
    /// Replacements in the base case.
    edits: &'static [(&'static str, &'static str)],
    ranks: usize,
    arguments: &'static [&'static str],
    code: i32,
    says: &'static [&'static str],
}

const fn mistake(
    what: &'static str,
    edits: &'static [(&'static str, &'static str)],
    code: i32,
    says: &'static [&'static str],
) -> Mistake {
    Mistake { what, edits, ranks: 2, arguments: &[], code, says }
}

const BOX: &str = "kind = \"box\"\nlower = [0.005, 0.005, 0.005]\nupper = [0.075, 0.059, 0.059]";
const LATTICE: &str =
    "{ kind = \"lattice\", lower = [0.02, 0.01, 0.02], upper = [0.07, 0.055, 0.05], spacing = 0.011 }";

/// Mistakes in the case or command line, found before the first step.
const BEFORE_THE_RUN: &[Mistake] = &[
    mistake(
        "a slip in a key",
        &[(
            "[[shape]]\nname = \"ball\"\nkind = \"sphere\"\nradius",
            "[[shape]]\nname = \"ball\"\nkind = \"sphere\"\nradios",
        )],
        2,
        &["case.toml:", "shape[0].radios", "did you mean `radius`?"],
    ),
    mistake(
        "a unit in a value",
        &[("radius = 5e-3", "radius = \"5 mm\"")],
        2,
        &["case.toml:34:", "radius", "SI units"],
    ),
    mistake(
        "a domain beyond all numbers",
        &[("lower = [0, 0, 0]\nupper = [0.08,", "lower = [-1e308, 0, 0]\nupper = [1e308,")],
        2,
        &["case.toml:", "domain.lower[0]", "beyond 1e30", "unit"],
    ),
    mistake(
        "a domain of planets",
        &[("upper = [0.08,", "upper = [4.3e9,")],
        2,
        &["case.toml:", "domain.upper", "too coarse for particles", "make the domain smaller"],
    ),
    mistake(
        "a particle of nothing",
        &[("radius = 5e-3", "radius = 1e-30")],
        2,
        &["case.toml:", "domain.upper", "too coarse for particles", "unit of the radius"],
    ),
    mistake(
        "a contact so stiff that rounded forces do not carry a particle",
        &[("\"wall\"]\nnormal_stiffness = 1e4", "\"wall\"]\nnormal_stiffness = 1e16"), ("dt = 4e-5", "")],
        2,
        &[
            "case.toml:",
            "contact[1].normal_stiffness",
            "weight of the smallest particle",
            "lower the stiffness",
        ],
    ),
    mistake(
        "millimetres for metres",
        &[("radius = 5e-3", "radius = 5")],
        2,
        &["radius = 5", "10 mm is 0.01 m"],
    ),
    mistake(
        "a sieve curve in per cent",
        &[(
            "material = \"glass\" }",
            "material = \"glass\", diameter = { kind = \"sieve\", by = \"mass\", passing = [[6e-3, 0], [8e-3, 40], [1e-2, 100]] } }",
        )],
        2,
        &[
            "insert[0].particles[0].diameter.passing",
            "fractions end at 1, not at 100",
            "divide per cent by 100",
        ],
    ),
    mistake(
        "no contact law",
        &[("between = [\"glass\", \"wall\"]", "between = [\"wall\", \"wall\"]")],
        2,
        &["no contact law between \"glass\" and \"wall\"", "add [[contact]]"],
    ),
    mistake(
        "an unknown material",
        &[("material = \"glass\" }", "material = \"Glas\" }")],
        2,
        &["insert[0].particles[0].material", "did you mean `glass`?"],
    ),
    mistake(
        "Hertz without elastic constants",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
            "\"glass\", \"glass\"]\nnormal = { kind = \"hertz\" }",
        )],
        2,
        &["contact[0].normal.kind", "youngs_modulus (Pa) and poissons_ratio of \"glass\""],
    ),
    mistake(
        "Hertz with a stiffness",
        &[
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal = { kind = \"hertz\" }\nnormal_stiffness = 1e4",
            ),
            ("density = 2500", "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.3"),
        ],
        2,
        &["contact[0].normal_stiffness", "belongs to a linear spring"],
    ),
    mistake(
        "Mindlin on a linear spring",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
            "\"glass\", \"glass\"]\ntangential = { kind = \"mindlin\" }\nnormal_stiffness = 1e4",
        )],
        2,
        &["contact[0].tangential.kind", "goes with Hertzian laws"],
    ),
    mistake(
        "JKR without surface energy",
        &[
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal = { kind = \"jkr\" }",
            ),
            ("density = 2500", "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.3"),
        ],
        2,
        &["contact[0].normal.kind", "surface_energy (J/m2)"],
    ),
    mistake(
        "SJKR without its area",
        &[
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal = { kind = \"sjkr\", energy_density = 1e4 }",
            ),
            ("density = 2500", "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.3"),
        ],
        2,
        &["contact[0].normal.area"],
    ),
    mistake(
        "a law that does not exist",
        &[
            (
                "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
                "\"glass\", \"glass\"]\nnormal = { kind = \"herz\" }",
            ),
            ("density = 2500", "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.3"),
        ],
        2,
        &["contact[0].normal.kind", "did you mean `hertz`?"],
    ),
    mistake(
        "adhesion of a linear spring",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
            "\"glass\", \"glass\"]\nwork_of_adhesion = 0.1\nnormal_stiffness = 1e4",
        )],
        2,
        &["contact[0].work_of_adhesion", "is not taken by this law"],
    ),
    mistake(
        "a softened linear spring",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
            "\"glass\", \"glass\"]\nsoftening = 100\nnormal_stiffness = 1e4",
        )],
        2,
        &["contact[0].softening", "is not taken by this law"],
    ),
    mistake(
        "rolling of a spring that is not there",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
            "\"glass\", \"glass\"]\ntangential = { kind = \"viscous\", gamma_t = 1e3 }\nrolling_friction = 0.1\nrolling = { kind = \"epsd2\" }\nnormal_stiffness = 1e4",
        )],
        2,
        &["contact[0].rolling.kind", "there is none"],
    ),
    mistake(
        "a dashpot beside plasticity",
        &[(
            "\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
            "\"glass\", \"glass\"]\nnormal = { kind = \"elastic_plastic\" }\ndamping = { kind = \"viscoelastic\", time = 1e-6 }\nnormal_stiffness = 1e4",
        )],
        2,
        &["contact[0].damping", "two stiffnesses"],
    ),
    mistake(
        "a contact angle in degrees",
        &[(
            "\"glass\", \"glass\"]\n",
            "\"glass\", \"glass\"]\nattraction = { kind = \"liquid_bridge\", volume = 1e-9, surface_tension = 0.07, contact_angle = 20 }\n",
        )],
        2,
        &["contact[0].attraction.contact_angle", "1.57"],
    ),
    mistake(
        "cut-offs the wrong way round",
        &[(
            "\"glass\", \"glass\"]\n",
            "\"glass\", \"glass\"]\nattraction = { kind = \"van_der_waals\", hamaker = 1e-19, inner = 1e-7, outer = 1e-8 }\n",
        )],
        2,
        &["contact[0].attraction.outer", "must be above inner"],
    ),
    mistake(
        "Poisson's ratio beyond one half",
        &[("density = 2500", "density = 2500\nyoungs_modulus = 1e7\npoissons_ratio = 0.7")],
        2,
        &["material[0].poissons_ratio", "0.5"],
    ),
    mistake(
        "a missing mesh file",
        &[(BOX, "kind = \"mesh\"\npath = \"hoper.stl\"")],
        2,
        &["wall[0].path", "no such file", "did you mean `hopper.stl`"],
    ),
    mistake(
        "a mesh file that is garbage",
        &[(BOX, "kind = \"mesh\"\npath = \"hopper.stl\"")],
        2,
        &["wall[0]", "hopper.stl"],
    ),
    mistake(
        "lobes that do not meet",
        &[(
            "kind = \"sphere\"\nradius = 5e-3",
            "kind = \"lobes\"\nlobes = 3\ndiameter = 0.01\nlength = 0.01\noffset = 3e-3",
        )],
        2,
        &[
            "shape[0]",
            "the 3 lobes do not meet",
            "an offset below 2.6795e-3 m, or an area_fraction of 0.6572 to 1",
        ],
    ),
    mistake(
        "a composite of two bodies",
        &[(
            "kind = \"sphere\"\nradius = 5e-3",
            "kind = \"glued\"\nparts = [{ kind = \"sphere\", radius = 2e-3 }, { kind = \"box\", edges = [2e-3, 2e-3, 2e-3], at = [4e-3, 0, 0] }]",
        )],
        2,
        &["shape[0]", "parts[1] (cuboid)", "the gap between", "1.0000e-3 m", "move them together"],
    ),
    mistake(
        "a particle mesh with a hole",
        &[("kind = \"sphere\"\nradius = 5e-3", "kind = \"mesh\"\npath = \"open.stl\"")],
        2,
        &["shape[0]", "not closed: 3 of 6 edges", "close its holes"],
    ),
    mistake(
        "a particle file with a bad number",
        &[(LATTICE, "{ kind = \"file\", path = \"balls.csv\" }"), ("count = 16\n", "")],
        2,
        &["balls.csv:3", "0.0x"],
    ),
    mistake(
        "a lattice whose particles overlap",
        &[("spacing = 0.011", "spacing = 0.0102, noise = 0.2")],
        2,
        &["insert[0].place", "particle ", "raise `spacing` or lower `noise`"],
    ),
    mistake(
        "particles inside a wall",
        &[("upper = [0.075, 0.059, 0.059]", "upper = [0.04, 0.059, 0.059]")],
        2,
        &["insert[0].place", "inside wall `box`", "move the insertion"],
    ),
    mistake(
        "particles outside the domain",
        &[("upper = [0.07, 0.055, 0.05]", "upper = [0.7, 0.055, 0.05]")],
        2,
        &["insert[0].place.upper", "outside the domain"],
    ),
    mistake(
        "a window without room",
        &[(
            LATTICE,
            "{ kind = \"window\", window = { kind = \"box\", lower = [0.03, 0.03, 0.03], upper = [0.04, 0.04, 0.04] } }",
        )],
        2,
        &["insert[0].place", "no room for particle", "enlarge the window"],
    ),
    mistake(
        "a time step of a third of the contact time",
        &[("dt = 4e-5", "dt = 2.5e-4")],
        2,
        &["time.dt = 2.5e-4", "steps per contact", "take \"auto\" or at most"],
    ),
    mistake(
        "domain.ranks of another product",
        &[("[domain]\n", "[domain]\nranks = [3, 1, 1]\n")],
        2,
        &["domain.ranks = [3, 1, 1]", "3 subdomains for 2 ranks", "-n 3"],
    ),
    Mistake {
        ranks: 7,
        ..mistake(
            "too many ranks for a small box",
            &[],
            2,
            &["7 subdomains along x", "thinner than the interaction range", "at most 5"],
        )
    },
    mistake(
        "a periodic axis that is too short",
        &[
            ("[domain]\n", "[domain]\nperiodic = [false, false, true]\n"),
            ("upper = [0.08, 0.06, 0.06]", "upper = [0.08, 0.06, 0.0530]"),
            ("radius = 5e-3", "radius = 0.013"),
            ("count = 16", "count = 1"),
        ],
        2,
        &["periodic length", "along z", "widen the domain along z"],
    ),
    Mistake {
        arguments: &["--restart", "results/checkpoint-7.h5"],
        ..mistake("an unknown restart file", &[], 4, &["results/checkpoint-7.h5", "No such file"])
    },
    Mistake {
        arguments: &["--restart", "latest"],
        ..mistake("a restart without checkpoint", &[], 4, &["results", "run without --restart"])
    },
    Mistake {
        arguments: &["--restrat", "latest"],
        ..mistake("a slip in an argument", &[], 2, &["--restrat", "'--restart'"])
    },
];

/// Mistakes that show when particles move.
const DURING_THE_RUN: &[Mistake] = &[
    mistake(
        "a wall that is missing",
        &[
            (BOX, "kind = \"plane\"\npoint = [0, 0, 0.001]\nnormal = [0, 0, 1]"),
            ("count = 16", "count = 1\nvelocity = [-2, 0, 0]"),
        ],
        3,
        &["particle 0 left the domain through -x", "step ", "domain.outlets"],
    ),
    mistake(
        "an impact too hard for the stiffness",
        &[("count = 16", "count = 16\nvelocity = [0, 0, -30]")],
        3,
        &["particle ", "overlaps wall `box`", "limits.overlap", "stiffness"],
    ),
    mistake(
        "a time step ten times too large",
        &[
            ("dt = 4e-5", "dt = 6e-4\naccept_coarse_dt = true"),
            ("end = 0.02", "end = 2"),
            ("count = 16", "count = 16\nvelocity = [0, 0, -1]"),
        ],
        3,
        &["particle ", "the time step is too large"],
    ),
];

/// Three of the four triangles of a tetrahedron.
const OPEN_MESH: &str = "solid open
facet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 0.01 0\nvertex 0.01 0 0\nendloop\nendfacet
facet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 0.01 0 0\nvertex 0 0 0.01\nendloop\nendfacet
facet normal -1 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 0.01\nvertex 0 0.01 0\nendloop\nendfacet
endsolid open
";

/// Makes the mistake and returns the message, which must have the right form.
fn message_of(mistake: &Mistake, home: &Path) -> String {
    let text = mistake.edits.iter().fold(case("base.toml"), |text, (old, new)| replaced(&text, old, new));
    let output = run_case(mistake.ranks, home, &text, mistake.arguments);
    let message = output.only_error(mistake.code).to_string();
    for word in mistake.says {
        assert!(message.contains(word), "{}: `{word}` is missing: {message}", mistake.what);
    }
    let is_about_a_file = mistake.code == 2 && mistake.arguments.is_empty();
    if is_about_a_file {
        assert!(
            [".toml:", ".csv:"].iter().any(|f| message.contains(f)),
            "{}: where? {message}",
            mistake.what
        );
    }
    if mistake.code == 3 {
        assert!(message.contains("rank "), "{}: which rank? {message}", mistake.what);
    }
    message
}

/// Makes all mistakes and prints the table; reports all wrong answers at once.
fn check_all(name: &str, mistakes: &[Mistake]) {
    let home = folder(name);
    fs::write(home.join("hopper.stl"), "solid\nno mesh at all\n").unwrap();
    fs::write(home.join("open.stl"), OPEN_MESH).unwrap();
    fs::write(home.join("balls.csv"), "x,y,z\n0.03,0.03,0.03\n0.05,0.0x,0.03\n").unwrap();
    run_case(2, &home, &case("base.toml"), &[]).succeeded();
    fs::remove_dir_all(home.join("results")).unwrap();
    let mut wrong = Vec::new();
    println!("| mistake | exit code | message |\n|---|---|---|");
    for mistake in mistakes {
        match std::panic::catch_unwind(|| message_of(mistake, &home)) {
            Ok(message) => {
                let message = message.replace('|', "\\|").replace('\n', "<br>");
                let message = message.replace(&format!("{}/", home.display()), "");
                println!("| {} | {} | {message} |", mistake.what, mistake.code);
            }
            Err(_) => wrong.push(mistake.what),
        }
    }
    assert!(wrong.is_empty(), "wrong answers to: {wrong:?}");
}

#[test]
fn mistakes_in_a_case_are_answered_before_the_run() {
    check_all("bad_input_before", BEFORE_THE_RUN);
}

#[test]
fn mistakes_that_show_during_a_run_end_it_and_name_the_particle() {
    check_all("bad_input_during", DURING_THE_RUN);
}

#[test]
fn a_case_file_that_is_missing_or_empty_is_named() {
    let home = folder("bad_input_file");
    fs::write(home.join("case.toml"), case("base.toml")).unwrap();
    fs::write(home.join("empty.toml"), "\n").unwrap();
    for (argument, says) in [("csae.toml", "did you mean `case.toml`"), ("empty.toml", "is empty")] {
        let output = run(2, &home, &[argument]);
        let message = output.only_error(2);
        assert!(message.contains(argument) && message.contains(says), "{message}");
        println!("| case file `{argument}` | 2 | {message} |");
    }
}

#[test]
fn outlets_make_leaving_legal() {
    let home = folder("bad_input_outlet");
    let edits = [
        (BOX, "kind = \"plane\"\npoint = [0, 0, 0.001]\nnormal = [0, 0, 1]"),
        ("count = 16", "count = 1\nvelocity = [-2, 0, 0]"),
        ("[domain]\n", "[domain]\noutlets = [\"-x\"]\n"),
    ];
    let text = edits.iter().fold(case("base.toml"), |text, (old, new)| replaced(&text, old, new));
    let output = run_case(2, &home, &text, &[]).succeeded();
    assert!(output.stdout.contains("1 inserted = 0 inside + 1 left"), "{}", output.text());
}

#[test]
fn an_editor_with_the_schema_names_a_typo_once() {
    let home = folder("bad_input_schema");
    let Some(python) = python_with("import jsonschema, tomllib") else {
        skipped("an_editor_with_the_schema_names_a_typo_once", "no Python with jsonschema");
        return;
    };
    let schema = run(1, &home, &["schema"]).succeeded().stdout;
    fs::write(home.join("schema.json"), schema).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let checked = Command::new(python)
        .arg(root.join("scripts/schema_typos.py"))
        .arg(home.join("schema.json"))
        .args(["cases", "mpi-tests/cases", "crates/grains-case/tests/good"].map(|folder| root.join(folder)))
        .output()
        .unwrap();
    assert!(
        checked.status.success(),
        "{}{}",
        String::from_utf8_lossy(&checked.stdout),
        String::from_utf8_lossy(&checked.stderr)
    );
}

#[test]
fn a_walltime_that_never_comes_is_refused() {
    let home = folder("bad_walltime");
    fs::write(home.join("case.toml"), case("base.toml")).unwrap();
    for time in ["nan", "-1", "inf", "-inf", "1 h"] {
        let output = run(1, &home, &["case.toml", &format!("--max-walltime={time}")]);
        assert_ne!(output.code, Some(0), "{time}: {}", output.text());
        assert!(output.stderr.contains("leave it out for no limit"), "{time}: {}", output.text());
        assert!(!home.join("results").exists(), "{time}");
    }
}
