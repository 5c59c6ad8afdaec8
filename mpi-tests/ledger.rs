//! Claims of the ledger that cost seconds are repeated; a figure that is off, and a pattern that finds nothing, are told.

#![allow(clippy::unwrap_used)]

mod common;

use common::{ENVIRONMENT, folder};
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

/// Five claims of one command: as recorded, off, of other digits, not there, and the last value of a column.
const LEDGER: &str = r#"
[case.play]
command = "printf 'speed 1.25 m/s\n' && printf '# run\ntime,mass\n0,1\n1,3\n' > series.csv"
source_value = "1.3"
unit = "m/s"
result = 'speed ([\d.]+)'
[[claim]]
id = "play.same"
figure = "1.26"
tolerance = "1 %"
[[claim]]
id = "play.off"
figure = "1.27"
tolerance = "1 %"
[[claim]]
id = "play.bits"
figure = "1.250"
tolerance = "bits"
[[claim]]
id = "play.lost"
figure = "1.25"
tolerance = "0.1"
result = 'spin ([\d.]+)'
[[claim]]
id = "play.column"
figure = "3"
tolerance = "bits"
file = "series.csv"
column = "mass"
result = ""
"#;

/// Figures come from the output of the run: what is off and what is not there end with code 1.
#[test]
fn what_is_off_or_not_found_is_told() {
    let home = folder("ledger_off");
    fs::write(home.join("ledger.toml"), LEDGER).unwrap();
    let path = home.join("ledger.toml").display().to_string();
    let (said, code) = reproduce(&home, &["--ledger", &path, "play"]);
    assert_eq!(code, Some(1), "{said}");
    for line in [
        "as recorded: play.same: found 1.25 m/s, recorded 1.26 (1 %), source 1.3 (-3.8 %)",
        "OFF: play.off: found 1.25 m/s, recorded 1.27 (1 %)",
        "OFF: play.bits: found 1.25 m/s, recorded 1.250 (bits)",
        "failed: play.lost: `spin ([\\d.]+)` is not in the output",
        "as recorded: play.column: found 3 m/s",
    ] {
        assert!(said.contains(line), "{line}\n{said}");
    }
    let (said, code) = reproduce(&home, &["--ledger", &path, "play.same", "play.column"]);
    assert_eq!(code, Some(0), "{said}");
}
