//! Mistakes of users: each ends all ranks, with the right exit code and one message that names the key, file
//! or particle and a remedy. With `--nocapture` the tests print mistake and message as a table.

#![allow(clippy::unwrap_used)]

mod common;

use common::{case, folder, replaced, run, run_case, skipped};
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
        &["case.toml:", "domain.lower[0]", "within -1e30 and 1e30", "unit"],
    ),
    mistake(
        "a domain of planets",
        &[("upper = [0.08,", "upper = [4.3e9,")],
        2,
        &["case.toml:", "shape[0].radius", "more than 2097151", "lengths are in metres"],
    ),
    mistake(
        "a particle of nothing",
        &[("radius = 5e-3", "radius = 1e-30")],
        2,
        &["case.toml:", "radius", "more than 2097151", "enlarge the particle"],
    ),
    mistake(
        "millimetres for metres",
        &[("radius = 5e-3", "radius = 5")],
        2,
        &["radius = 5", "10 mm is 0.01 m"],
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

/// A number of a case and where it is.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let is_part = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
    let mut found = Vec::new();
    let mut line_begin = 0;
    for line in text.split_inclusive('\n') {
        // Names and comments hold digits as well.
        let code = &line[..line.find('#').unwrap_or(line.len())];
        let Some(equals) = code.find('=') else {
            line_begin += line.len();
            continue;
        };
        let mut at = equals + 1;
        let mut in_text = false;
        while at < code.len() {
            let c = code.as_bytes()[at] as char;
            in_text ^= c == '"';
            let end = at + code[at..].find(|c| !is_part(c)).unwrap_or(code.len() - at);
            let before = code.as_bytes()[at - 1] as char;
            if !in_text && end > at && " [".contains(before) && code[at..end].parse::<f64>().is_ok() {
                found.push(line_begin + at..line_begin + end);
                at = end;
            } else {
                at += 1;
            }
        }
        line_begin += line.len();
    }
    found
}

/// Every number in turn of another order of magnitude: `check` ends soon, with a table or with messages that name the
/// file, and never by a panic.
#[test]
fn no_order_of_magnitude_panics_or_hangs() {
    let mut state = std::env::var("SEED").map_or(7_u64, |text| text.parse().unwrap());
    let mut draw = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    let draws: usize = std::env::var("DRAWS").map_or(24, |text| text.parse().unwrap());
    let cases =
        ["silo.toml", "bed.toml", "drum.toml", "resolved.toml", "shear.toml"].map(|name| (name, case(name)));
    let home = folder("bad_magnitudes");
    for _ in 0..draws {
        let (name, text) = &cases[draw(5) as usize];
        let places = numbers(text);
        let place = places[draw(places.len() as u64) as usize].clone();
        let is_whole = text[place.clone()].parse::<i64>().is_ok();
        let sign = if draw(4) == 0 { "-" } else { "" };
        let number = match is_whole {
            true => format!("{sign}{}", 10_i64.pow(draw(19) as u32)),
            false => format!("{sign}{}e{}", 1 + draw(9), draw(640) as i64 - 320),
        };
        let mut changed = text.clone();
        changed.replace_range(place.clone(), &number);
        let line = text[..place.start].matches('\n').count() + 1;
        let what = format!("{name}, line {line}: {number}");
        fs::write(home.join("case.toml"), &changed).unwrap();
        let begun = std::time::Instant::now();
        let output = run(1, &home, &["check", "case.toml"]);
        let seconds = begun.elapsed().as_secs_f64();
        assert!(!output.stderr.contains("panicked"), "{what}: {}", output.text());
        assert!(seconds < 60.0, "{what}: {seconds} s");
        match output.code {
            Some(0) => (),
            Some(2..=4) => assert!(output.stderr.contains("case.toml"), "{what}: {}", output.text()),
            _ => panic!("{what}: {}", output.text()),
        }
        println!("{seconds:.1} s, code {:?}: {what}", output.code);
    }
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

/// Misspells every key of some cases, one at a time, and adds one to every table: prints most complaints of a validator
/// about one, counting every alternative.
const SLIPS: &str = r#"
import copy, json, sys, tomllib
from jsonschema import Draft202012Validator

schema = json.load(open(sys.argv[1]))
Draft202012Validator.check_schema(schema)
validator = Draft202012Validator(schema)

def leaves(errors):
    return sum(leaves(e.context) if e.context else 1 for e in errors)

def tables(data, path=()):
    if isinstance(data, dict):
        yield path
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield from tables(value, path + (key,))

def copied(case, path):
    case = copy.deepcopy(case)
    table = case
    for key in path:
        table = table[key]
    return case, table

slips, added, named = 0, 0, set()
for name in sys.argv[2:]:
    case = tomllib.load(open(name, "rb"))
    assert validator.is_valid(case), name
    for path in tables(case):
        changed, table = copied(case, path)
        table["extra_slip"] = 1
        added = max(added, leaves(validator.iter_errors(changed)))
        for key in list(table):
            if key == "extra_slip" or not path and key == "fluid":
                continue
            changed, table = copied(case, path)
            table[key + "_slip"] = table.pop(key)
            named.add(sum(key + "_slip" in e.message for e in validator.iter_errors(changed)))
            slips += 1
print(slips, added, *sorted(named))
"#;

#[test]
fn a_slip_is_one_complaint_of_an_editor() {
    let home = folder("bad_slips");
    let schema = run(1, &home, &["schema"]).succeeded().stdout;
    fs::write(home.join("schema.json"), schema).unwrap();
    let names = ["silo", "bed", "duct", "resolved", "drum", "shear"].map(|name| format!("{name}.toml"));
    names.iter().for_each(|name| fs::write(home.join(name), case(name)).unwrap());
    let python = std::env::var("GRAINS_PYTHON").unwrap_or("python3".into());
    let probe = Command::new(&python).args(["-c", "import jsonschema, tomllib"]).output();
    if !probe.is_ok_and(|probe| probe.status.success()) {
        return skipped("schema", "no Python with jsonschema: the schema is not put to a validator");
    }
    let output =
        Command::new(&python).args(["-c", SLIPS, "schema.json"]).args(names).current_dir(&home).output();
    let output = output.unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    let numbers: Vec<u32> = text.split_whitespace().map(|x| x.parse().unwrap()).collect();
    assert!(
        numbers[0] > 100 && numbers[1..] == [1, 1],
        "slips, complaints, times the key is named: {numbers:?}"
    );
}
