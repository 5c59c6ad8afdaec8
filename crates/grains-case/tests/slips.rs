//! Slips of those who know other formats: each is refused, and the message says what to write instead.

#![allow(clippy::unwrap_used)]

use grains_case::{Case, ParticleColumns};
use std::path::Path;

/// What is done, the passage of the case, what stands in its place, the key or line named, and words of the remedy.
type Slip = (&'static str, &'static str, &'static str, &'static str, &'static str);

const SLIPS: &[Slip] = &[
    ("a comma for the point", "radius = 5e-3", "radius = 0,005", "case.toml:34:", "decimals have a point"),
    ("arithmetic in a value", "radius = 5e-3", "radius = 0.01/2", "case.toml:34:", "a number stands alone"),
    ("a unit behind a number", "radius = 5e-3", "radius = 5mm", "case.toml:34:", "without unit"),
    ("a Fortran exponent", "radius = 5e-3", "radius = 5D-3", "case.toml:34:", "exponent after e"),
    (
        "no digit before the point",
        "radius = 5e-3",
        "radius = .005",
        "case.toml:34:",
        "both sides of the point",
    ),
    ("no digit after the point", "radius = 5e-3", "radius = 1.", "case.toml:34:", "both sides of the point"),
    ("a comment of C++", "radius = 5e-3", "radius = 5e-3 // 5 mm", "case.toml:34:", "comments begin with #"),
    ("a comment of LaTeX", "radius = 5e-3", "radius = 5e-3 % 5 mm", "case.toml:34:", "comments begin with #"),
    ("a semicolon at the end", "radius = 5e-3", "radius = 5e-3;", "case.toml:34:", "without a semicolon"),
    ("a colon for the sign of equality", "radius = 5e-3", "radius: 5e-3", "case.toml:34:", "after ="),
    ("a word without quotes", "kind = \"sphere\"", "kind = sphere", "case.toml:33:", "texts stand in quotes"),
    (
        "quotes of a word processor",
        "kind = \"sphere\"",
        "kind = “sphere”",
        "case.toml:33:",
        "straight quotes",
    ),
    ("a blank of a word processor", "radius = 5e-3", "radius =\u{a0}5e-3", "case.toml:34:", "type it anew"),
    ("a minus of a word processor", "radius = 5e-3", "radius = 5e\u{2212}3", "case.toml:34:", "type it anew"),
    ("a count with a leading 0", "count = 16", "count = 016", "case.toml:39:", "begin with no 0"),
    (
        "truth values of Python",
        "[domain]\n",
        "[domain]\nperiodic = [True, False, False]\n",
        "case.toml:5:",
        "small letters",
    ),
    (
        "a vector of OpenFOAM",
        "upper = [0.08, 0.06, 0.06]",
        "upper = (0.08 0.06 0.06)",
        "case.toml:6:",
        "in brackets with commas",
    ),
    (
        "a vector without commas",
        "upper = [0.08, 0.06, 0.06]",
        "upper = [0.08 0.06 0.06]",
        "case.toml:6:",
        "in brackets with commas",
    ),
    ("a section twice", "[output]", "[time]\nend = 4\n\n[output]", "case.toml:49:", "given once"),
    (
        "gravity in a section",
        "[domain]\n",
        "[domain]\ngravity = [0, 0, -9.81]\n",
        "domain.gravity",
        "before the first section",
    ),
    ("the seed below a section", "[time]\n", "[time]\nseed = 4\n", "time.seed", "before the first section"),
    (
        "an end among the outputs",
        "checkpoint = 0.01",
        "checkpoint = 0.01\nend = 3",
        "output.end",
        "is a key of [time]",
    ),
    (
        "outlets of the outputs",
        "checkpoint = 0.01",
        "checkpoint = 0.01\noutlets = [\"-z\"]",
        "output.outlets",
        "is a key of [domain]",
    ),
    (
        "an impact speed of the domain",
        "[time]\n",
        "impact_speed = 1\n[time]\n",
        "domain.impact_speed",
        "is a key of [time]",
    ),
];

/// What is done in a table of particles, its text, the column named, and words of the remedy.
const TABLES: &[(&str, &str, &str, &str)] = &[
    ("no header", "0.02,0.02,0.02\n0.04,0.02,0.02\n", "0.02", "a number where the header should be"),
    ("semicolons", "x;y;z\n0.02;0.02;0.02\n", "x;y;z", "separated by commas"),
    ("tabs", "x\ty\tz\n0.02\t0.02\t0.02\n", "x\ty\tz", "separated by commas"),
    ("spaces", "x y z\n0.02 0.02 0.02\n", "x y z", "separated by commas"),
    ("units in the header", "x (m),y (m),z (m)\n0.02,0.02,0.02\n", "x (m)", "without units"),
    ("numbers of particles", "id,x,y,z\n1,0.02,0.02,0.02\n", "id", "remove this column"),
    ("types of LAMMPS", "type,x,y,z\n1,0.02,0.02,0.02\n", "type", "remove this column"),
    ("diameters", "x,y,z,d\n0.02,0.02,0.02,0.01\n", "d", "half the diameter"),
    ("a radius called r", "x,y,z,r\n0.02,0.02,0.02,0.005\n", "r", "name it `radius`"),
    ("an empty file", "", "p.csv:1", "the header is empty"),
    ("decimal commas", "x,y,z\n0,02,0,02,0,02\n", "p.csv:2", "decimals have a point"),
];

#[test]
fn slips_of_other_formats_are_answered_with_what_to_write() {
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/cases");
    let good = std::fs::read_to_string(base.join("base.toml")).unwrap();
    assert!(Case::parse(&good, "case.toml", &base).is_ok());
    for (what, old, new, place, remedy) in SLIPS {
        assert_eq!(good.matches(old).count(), 1, "{what}: `{old}` is in the case once");
        let errors = Case::parse(&good.replace(old, new), "case.toml", &base).expect_err(what).to_string();
        println!("| {what} | {} |", errors.replace('\n', "<br>"));
        let is_answered = |line: &str| line.contains(place) && line.contains(remedy);
        assert!(errors.lines().any(is_answered), "{what}: {errors}");
    }
}

/// What stands in the place of a case, its text, and words of the remedy.
const OTHERS: &[(&str, &str, &str)] = &[
    ("JSON", "{\"domain\": {\"lower\": [0, 0, 0]}}\n", "JSON, not TOML"),
    ("YAML", "domain:\n  lower: [0, 0, 0]\n", "YAML, not TOML"),
    ("XML", "<?xml version=\"1.0\"?>\n<case/>\n", "XML, not TOML"),
    ("a mesh", "solid hopper\nfacet normal 0 0 1\n", "path of a [[wall]] of kind \"mesh\""),
    ("a dictionary of OpenFOAM", "FoamFile\n{\n    version 2.0;\n}\n", "OpenFOAM"),
    ("a script of LAMMPS", "# in.hopper\nunits si\natom_style sphere\n", "`grains-mpi import FILE`"),
    ("a dump of LAMMPS", "ITEM: TIMESTEP\n0\n", "`grains-mpi import FILE`"),
    ("a table of particles", "x,y,z\n0.1,0.1,0.1\n", "insert.place = { kind = \"file\""),
    (
        "a study",
        "case = \"a.toml\"\n[vary]\na = { key = \"seed\", values = [1] }\n",
        "`grains-mpi sweep case.toml`",
    ),
];

#[test]
fn files_of_other_formats_are_answered_once_with_what_to_do() {
    for (what, text, remedy) in OTHERS {
        let errors = Case::parse(text, "case.toml", Path::new("")).expect_err(what);
        println!("| {what} | {errors} |");
        assert_eq!(errors.0.len(), 1, "{what}: {errors}");
        assert!(errors.to_string().contains(remedy), "{what}: {errors}");
    }
}

#[test]
fn slips_in_tables_of_particles_are_answered_with_what_to_write() {
    for (what, text, column, remedy) in TABLES {
        let errors = ParticleColumns::parse_csv(text, "p.csv").expect_err(what).to_string();
        println!("| {what} | {} |", errors.replace('\n', "<br>"));
        let is_answered = |line: &str| line.contains(column) && line.contains(remedy);
        assert!(errors.lines().any(is_answered), "{what}: {errors}");
    }
}
