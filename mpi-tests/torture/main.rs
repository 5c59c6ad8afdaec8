//! Runs that are killed, run out of disk and are disturbed, and what they have lost then: nothing.
//!
//! `scripts/torture` repeats each attack as often as its long form says; the tests repeat it a few times.

#![allow(clippy::unwrap_used)]
#[path = "../common/mod.rs"]
mod common;
mod disks;
mod disturbances;
mod endurance;
mod kills;

use common::files::assert_same_files;
use common::results::{assert_same_state, checkpoints};
use common::{Draw, Output, folder, often, replaced, run, run_case};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// How often an attack is repeated: a few times in the tests, more by `scripts/torture`.
fn repeated(few: usize, many: usize) -> usize {
    if std::env::var_os("GRAINS_TORTURE").is_some() { many } else { few }
}

/// Builds a library of this folder and returns its path, for `LD_PRELOAD`.
fn preloaded(name: &str) -> String {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/torture").join(name);
    let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("lib{name}-{}.so", std::process::id()));
    if !library.exists() {
        let mut compile = Command::new("cc");
        compile.args(["-O1", "-Wall", "-Werror", "-shared", "-fPIC", "-o"]);
        let status = compile.arg(&library).arg(source.with_extension("c")).status();
        assert!(status.is_ok_and(|status| status.success()), "{name} is built");
    }
    library.display().to_string()
}

/// A run that nothing disturbs, against which disturbed ones are compared.
struct Subject {
    name: &'static str,
    text: String,
    home: PathBuf,
    has_fluid: bool,
}

impl Subject {
    /// A case until `steps`, written at every `every`th and saved at every `saved`th step; it is run.
    fn new(attack: &str, name: &'static str, steps: u32, every: u32, saved: u32) -> Self {
        let (file, edit) = match name {
            "hard" => ("drum.toml", Some("[collisions]\nmodel = \"hard\"\nsweeps = 2\n\n")),
            name => (&*format!("{name}.toml"), None),
        };
        let text = often(file, (steps, every));
        let dt: f64 = common::key(&text, "dt").parse().unwrap();
        let text = replaced(&text, "checkpoint = 1e3", &format!("checkpoint = {:e}", dt * f64::from(saved)));
        let text = match edit {
            Some(section) => text.replacen("[[material]]", &format!("{section}[[material]]"), 1),
            None => text,
        };
        let home = folder(&format!("torture_{attack}_{name}_undisturbed"));
        run_case(2, &home, &text, &[]).succeeded();
        let has_fluid = text.contains("\n[fluid]\n");
        Self { name, text, home, has_fluid }
    }

    /// Some number of ranks; three are too many for a few large bodies.
    fn ranks(&self, draw: &mut Draw) -> usize {
        let all = if self.name == "resolved" { [2, 1, 4] } else { [2, 1, 3] };
        all[draw.of(all.len())]
    }

    /// A folder with the case alone.
    fn begin(&self, attack: &str) -> PathBuf {
        let home = folder(&format!("torture_{attack}_{}", self.name));
        fs::write(home.join("case.toml"), &self.text).unwrap();
        home
    }

    /// Continues a disturbed run to its end, from the beginning if nothing was saved.
    fn continued(&self, ranks: usize, home: &Path) -> Output {
        run(ranks, home, arguments(home)).succeeded()
    }

    /// Asserts that a disturbed run has the files and the state of the one that was not.
    fn assert_nothing_lost(&self, home: &Path) {
        let (wanted, found) = (self.home.join("results"), home.join("results"));
        assert_same_files(&wanted, &found, 1e-5);
        if !self.has_fluid {
            assert_same_state(checkpoints(&wanted).last().unwrap(), checkpoints(&found).last().unwrap());
        }
    }
}

/// Arguments that continue the run of a folder, if it can be continued.
fn arguments(home: &Path) -> &'static [&'static str] {
    let results = home.join("results");
    match results.exists() && !checkpoints(&results).is_empty() {
        true => &["case.toml", "--restart", "latest"],
        false => &["case.toml"],
    }
}

/// Asserts that what a run has written so far can be read, and holds each step once.
fn assert_readable(results: &Path) {
    if !results.exists() {
        return;
    }
    if results.join("series.csv").exists() {
        let text = fs::read_to_string(results.join("series.csv")).unwrap();
        // The last row may not be complete.
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        let steps = whole.lines().filter_map(|line| line.split(',').next()?.parse::<u64>().ok());
        let steps: Vec<u64> = steps.collect();
        assert!(steps.is_sorted_by(|a, b| a < b), "{}: {steps:?}", results.display());
    }
    for checkpoint in checkpoints(results) {
        assert!(hdf5::File::open(&checkpoint).is_ok(), "{}", checkpoint.display());
    }
}
