//! Claims of the ledger that cost seconds are repeated; a figure that is off, and a pattern that finds nothing, are told.

#![allow(clippy::unwrap_used)]

mod common;

use common::{ENVIRONMENT, folder, replaced};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// What `scripts/reproduce` prints of some claims, and its exit code; no Python beyond the standard library is needed.
fn reproduce(home: &Path, arguments: &[&str]) -> (String, Option<i32>) {
    let output = Command::new("python3")
        .arg(root().join("scripts/reproduce"))
        .arg("--folder")
        .arg(home.join("run"))
        .args(arguments)
        .env("GRAINS_MPI", env!("CARGO_BIN_EXE_grains-mpi"))
        .envs(ENVIRONMENT)
        .output()
        .expect("python3 starts");
    let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    (said, output.status.code())
}

#[test]
fn cheap_claims_are_as_recorded() {
    let home = folder("ledger");
    let laws = ["rows", "closed-forms", "bridges", "restitution-of-hertz", "jkr-pull-off"]
        .map(|law| format!("laws.{law}"));
    let mut names: Vec<&str> = laws.iter().map(String::as_str).collect();
    names.push("array-sphere.one-case");
    let (said, code) = reproduce(&home, &names);
    assert_eq!(code, Some(0), "{said}");
    for name in names {
        assert!(said.contains(&format!("as recorded: {name}: found ")), "{said}");
    }
}

/// Figures come from the output of the run: another recorded figure, and a pattern that finds nothing, end with code 1.
#[test]
fn what_is_off_or_not_found_is_told() {
    let home = folder("ledger_off");
    let ledger = fs::read_to_string(root().join("cases/ledger.toml")).unwrap();
    let other = replaced(&ledger, "figure = \"105\"", "figure = \"104\"");
    let other = replaced(&other, "result = '^bridge .* (\\S+) +\\S+$'", "result = '^no such law (\\S+)'");
    fs::write(home.join("ledger.toml"), other).unwrap();
    let path = home.join("ledger.toml").display().to_string();
    let (said, code) =
        reproduce(&home, &["--ledger", &path, "laws.rows", "laws.bridges", "laws.closed-forms"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("OFF: laws.rows: found 105 rows, recorded 104"), "{said}");
    assert!(said.contains("failed: laws.bridges: `^no such law (\\S+)` is not in the output"), "{said}");
    assert!(said.contains("as recorded: laws.closed-forms: "), "{said}");
}
