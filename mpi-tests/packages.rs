//! What packages carry beside the program: the schema for editors, the manual page, the completions, and their list.

use super::ask;
use crate::common::{folder, replaced, skipped};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The top of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All case files below a folder; studies and the ledger of claims have keys of their own.
fn cases(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // Results hold resolved cases, which no one writes.
        if path.is_dir() && path.file_name().unwrap() != "results" {
            found.extend(cases(&path));
        } else if path.extension().is_some_and(|end| end == "toml")
            && !["-study.toml", "ledger.toml"].iter().any(|end| path.to_string_lossy().ends_with(end))
        {
            found.push(path);
        }
    }
    found
}

/// The file that a case names to editors.
fn named_schema(case: &Path) -> PathBuf {
    let text = fs::read_to_string(case).unwrap();
    let name = text.lines().next().unwrap().strip_prefix("#:schema ");
    let name = name.unwrap_or_else(|| panic!("{}: the first line names no schema", case.display()));
    case.with_file_name(name).canonicalize().unwrap()
}

/// What a command says of its standard input: its code and all of its words, or nothing if it is not installed.
fn said(command: &[&str], at: &Path, input: &str) -> Option<(bool, String)> {
    let mut run = Command::new(command[0]);
    run.args(&command[1..]).current_dir(at).env("MANWIDTH", "80");
    run.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = run.spawn().ok()?;
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    Some((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

/// Cases of the repository name its schema, those of `new` the one beside them, and both are what the program reads by.
#[test]
fn every_case_names_the_schema_that_the_program_reads_by() {
    let home = folder("newcomer_schema");
    let printed = ask(&home, &["schema"]).succeeded().stdout;
    let kept = root().join("schema/grains-mpi.schema.json").canonicalize().unwrap();
    assert!(
        fs::read_to_string(&kept).unwrap() == printed,
        "out of date; run: cargo run --release -p grains-mpi -- schema >schema/grains-mpi.schema.json"
    );
    let found = cases(&root().join("cases"));
    assert!(found.len() > 50, "{} cases", found.len());
    found.iter().for_each(|case| assert_eq!(named_schema(case), kept, "{}", case.display()));
    ask(&home, &["new", "drum"]).succeeded();
    let beside = named_schema(&home.join("drum.toml"));
    assert!(beside.starts_with(home.canonicalize().unwrap()));
    assert_eq!(fs::read_to_string(beside).unwrap(), printed);
}

/// What editors are built on takes every case of the repository, and finds a typo in one of `new`.
#[test]
fn taplo_takes_every_case_and_finds_a_typo() {
    let home = folder("newcomer_taplo");
    ask(&home, &["new", "silo"]).succeeded();
    // Installed by pip it lies beside its Python.
    let python = std::env::var("GRAINS_PYTHON").unwrap_or_default();
    let beside = Path::new(&python).with_file_name("taplo");
    let taplo = if beside.is_file() { &beside } else { Path::new("taplo") };
    let lint = |at: &Path, with: &[&str]| said(&[&[taplo.to_str().unwrap(), "lint"], with].concat(), at, "");
    // The folder of the test may lie within the repository, whose settings are not for it.
    let alone = ["--no-auto-config", "silo.toml"];
    let Some((is_right, words)) = lint(&root(), &[]) else {
        return skipped("taplo_takes_every_case_and_finds_a_typo", "no taplo");
    };
    assert!(is_right, "{words}");
    assert!(lint(&home, &alone).unwrap().0);
    let text = fs::read_to_string(home.join("silo.toml")).unwrap();
    fs::write(home.join("silo.toml"), replaced(&text, "restitution", "restitutoin")).unwrap();
    let (is_right, words) = lint(&home, &alone).unwrap();
    assert!(!is_right && words.contains("'restitutoin' was unexpected"), "{words}");
}

/// The shells parse their completions, and `man` has nothing to say about the page.
#[test]
fn shells_and_man_read_what_is_made_for_them() {
    let home = folder("newcomer_shells");
    for command in
        [&["bash", "-n"][..], &["zsh", "-n"], &["fish", "--no-execute"], &["man", "--warnings", "-l", "-"]]
    {
        let made = if command[0] == "man" { vec!["man"] } else { vec!["completions", command[0]] };
        let text = ask(&home, &made).succeeded().stdout;
        match said(command, &home, &text) {
            Some((is_right, words)) => assert!(is_right && words.is_empty(), "{command:?}: {words}"),
            None => skipped("shells_and_man_read_what_is_made_for_them", command[0]),
        }
    }
}

/// The list of the Debian package is that of files which are there, or which `scripts/package-deb` makes.
#[test]
fn everything_in_the_debian_package_is_there() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest: toml::Table = fs::read_to_string(home.join("Cargo.toml")).unwrap().parse().unwrap();
    let script = fs::read_to_string(root().join("scripts/package-deb")).unwrap();
    let assets = manifest["package"]["metadata"]["deb"]["assets"].as_array().unwrap();
    for asset in assets {
        let from = asset[0].as_str().unwrap();
        let is_there = match from.strip_prefix("target/release/texts/") {
            Some(name) => script.contains(&format!(">\"$texts/{name}\"\n")),
            None if from == "target/release/grains-mpi" => true,
            None => match from.strip_suffix("**/*.md").or(from.strip_suffix("*.toml")) {
                Some(folder) => home.join(folder).is_dir(),
                None => home.join(from).is_file(),
            },
        };
        assert!(is_there, "{from}");
    }
}
