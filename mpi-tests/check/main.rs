//! `grains-mpi check` explains a case before it runs, and `schema` describes the case files.

#![allow(clippy::unwrap_used)]
#[path = "../common/mod.rs"]
mod common;
mod oddities;
mod ranks;
mod resources;

use common::{Output, case, folder, replaced, run, run_alone};
use std::fs;
use std::path::{Path, PathBuf};

fn check(home: &Path, text: &str, arguments: &[&str]) -> Output {
    fs::write(home.join("case.toml"), text).unwrap();
    run_alone(home, &[&["check", "case.toml"], arguments].concat())
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

/// A sieve curve comes back as quantiles by mass, its means are sums over its classes.
#[test]
fn a_sieve_curve_is_explained_by_its_means_and_quantiles() {
    let home = folder("check_sizes");
    let output = check(&home, &case("gravel.toml"), &[]).succeeded();
    let rows = [[2.0, 0.0], [2.8, 0.1], [4.0, 0.55], [5.6, 0.9], [8.0, 1.0]];
    let classes = || rows.windows(2).map(|pair| (pair[0][0], pair[1][0], pair[1][1] - pair[0][1]));
    let by_mass: f64 = classes().map(|(a, b, share)| share * (a + b) / 2.0).sum();
    // Means of d⁻² and d⁻³ over a class.
    let lengths: f64 = classes().map(|(a, b, share)| share / (a * b)).sum();
    let numbers: f64 = classes().map(|(a, b, share)| share * (a + b) / (2.0 * a * a * b * b)).sum();
    let means =
        format!("mean {:.4e} m by number, {:.4e} m by mass", 1e-3 * lengths / numbers, 1e-3 * by_mass);
    for words in [
        "gravel: pebble of stone, sieve curve by mass, 2.0000e-3 to 8.0000e-3 m",
        &means,
        // 45 % of the mass are between 2.8 and 4 mm.
        "d10 2.8000e-3 m, d50 3.8667e-3 m, d90 5.6000e-3 m by mass",
        "normal by mass, 2.0484e-3 to 6.1451e-3 m; the cut-offs keep 98.76 % of the mass",
    ] {
        assert!(output.stdout.contains(words), "`{words}` is missing: {}", output.text());
    }
}

/// The contact time of spheres of a linear law goes with the root of their mass.
#[test]
fn what_the_finest_tenth_costs_in_time_step_is_said() {
    let home = folder("check_fines");
    let sizes = "{ shape = \"ball\", material = \"glass\", diameter = { kind = \"uniform\", by = \"mass\", min = 6e-3, max = 1e-2 } }";
    let text = replaced(&case("base.toml"), "{ shape = \"ball\", material = \"glass\" }", sizes);
    let output = check(&home, &text, &[]).succeeded();
    // A tenth of the mass is below 6.4 mm.
    let gain = format!("{:.2} times that", (6.4_f64 / 6.0).powf(1.5));
    assert!(output.stdout.contains(&gain), "{gain}: {}", output.text());
}

#[test]
fn an_impact_beyond_the_limit_of_overlap_is_foreseen() {
    let home = folder("check_impact");
    let text = replaced(&case("base.toml"), "dt = 4e-5", "dt = 4e-5\nimpact_speed = 20");
    let output = check(&home, &text, &[]).succeeded();
    assert!(output.stdout.contains("beyond limits.overlap"), "{}", output.text());
    assert!(output.stdout.contains("raise normal_stiffness by"), "{}", output.text());
}

#[test]
fn a_contact_that_was_softened_too_much_is_to_be_softened_less() {
    let home = folder("check_softened");
    let text = replaced(&case("base.toml"), "dt = 4e-5", "dt = \"auto\"\nimpact_speed = 20");
    let text =
        replaced(&text, "density = 2500", "density = 2500\nyoungs_modulus = 1e9\npoissons_ratio = 0.3");
    let hertz = "\"glass\", \"glass\"]\nnormal = { kind = \"hertz\" }\nsoftening = 100";
    let text = replaced(&text, "\"glass\", \"glass\"]\nnormal_stiffness = 1e4", hertz);
    let output = check(&home, &text, &[]).succeeded();
    assert!(output.stdout.contains("lower softening by"), "{}", output.text());
}

/// The parts of a law are named as the case names them, those of a wall beside it.
#[test]
fn every_part_of_a_law_is_named() {
    let home = folder("check_law_parts");
    let wet = "\"glass\", \"glass\"]\nrolling_friction = 0.125\nrolling = { kind = \"constant\" }\nattraction = { kind = \"liquid_bridge\", volume = 1e-10, surface_tension = 0.07 }";
    let output = check(&home, &replaced(&case("base.toml"), "\"glass\", \"glass\"]", wet), &[]).succeeded();
    for words in ["glass - glass: linear, friction ", "rolling friction 0.125 (constant), liquid_bridge"] {
        assert!(output.stdout.contains(words), "`{words}` is missing: {}", output.text());
    }
}

/// All case files below a folder; the ledger of claims is none.
fn case_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            case_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "toml") && !path.ends_with("ledger.toml") {
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
    let look_at = |file: &PathBuf| {
        let path = file.to_str().unwrap();
        if path.ends_with("-study.toml") {
            run_alone(&home, &["sweep", path, "--dry-run"]).succeeded();
            return;
        }
        // On two ranks as well, of every fifth: what is said is said once.
        if files.iter().position(|other| other == file).unwrap().is_multiple_of(5) {
            let output = run(2, &home, &["check", path]).succeeded();
            assert!(output.stderr.is_empty(), "{}: {}", file.display(), output.text());
        }
        let output = run_alone(&home, &["check", path]).succeeded();
        assert!(output.stderr.is_empty(), "{}: {}", file.display(), output.text());
        println!("{}: ok", file.display());
    };
    let halves = files.split_at(files.len() / 2);
    std::thread::scope(|scope| {
        for half in [halves.0, halves.1] {
            scope.spawn(|| half.iter().for_each(look_at));
        }
    });
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
