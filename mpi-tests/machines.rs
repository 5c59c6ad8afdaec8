//! The same bits on other processors: with AVX-512 or what this one has, with AVX2, and without either and without fused
//! multiplication. The others are emulated by QEMU; the C library takes its own variants there too. And by other builds of the program:
//! with `GRAINS_OTHER_PROGRAM=target/release/grains-mpi` (full paths, several parted by `:`) these are compared as well.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{assert_same_state, checkpoints};
use common::{ENVIRONMENT, case, folder, replaced, run_case, skipped};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

const EMULATOR: &str = "qemu-x86_64";

/// Processors with AVX2, and with SSE 4.2 alone, as QEMU calls them.
const PROCESSORS: [&str; 2] = ["Haswell", "Nehalem"];

/// Runs a case on one rank by a command.
///
/// It must not begin anew for huge pages, which the emulator would leave to the processor itself.
fn run_by(command: &mut Command, folder: &Path, text: &str) {
    fs::write(folder.join("case.toml"), text).unwrap();
    command.envs(ENVIRONMENT).env("GLIBC_TUNABLES", "glibc.malloc.hugetlb=0");
    let output = command.arg("case.toml").current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// The program on other processors, and other builds of it, by names.
fn others() -> Vec<(String, Command)> {
    let emulated = PROCESSORS.map(|processor| {
        let mut command = Command::new(EMULATOR);
        command.args(["-cpu", processor, env!("CARGO_BIN_EXE_grains-mpi")]);
        (processor.to_string(), command)
    });
    let builds = std::env::var("GRAINS_OTHER_PROGRAM").unwrap_or_default();
    let builds = builds.split(':').filter(|path| !path.is_empty()).enumerate();
    emulated.into_iter().chain(builds.map(|(k, path)| (format!("build_{k}"), Command::new(path)))).collect()
}

fn same_on_all(name: &str, end: &str, shorter: &str) {
    let version = Command::new(EMULATOR).arg("--version").stdout(Stdio::null()).status();
    if !version.is_ok_and(|status| status.success()) {
        return skipped(name, "no qemu-x86_64 (Debian package qemu-user)");
    }
    let clamps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/cases/clamps.csv");
    let text = replaced(
        &case(&format!("{name}.toml")),
        &format!("\nend = {end}\n"),
        &format!("\nend = {shorter}\n"),
    );
    let text = text.replace("\"clamps.csv\"", &format!("{:?}", clamps.display().to_string()));
    let here = folder(&format!("machines_{name}"));
    run_case(2, &here, &text, &[]).succeeded();
    for (other, mut command) in others() {
        let there = folder(&format!("machines_{name}_{other}"));
        run_by(&mut command, &there, &text);
        let [wanted, found] = [&here, &there].map(|home| checkpoints(&home.join("results")));
        assert_same_state(wanted.last().unwrap(), found.last().unwrap());
    }
}

#[test]
fn beads_and_cubes_in_a_turning_funnel() {
    same_on_all("funnel", "0.05", "0.01");
}

#[test]
fn balls_and_solids_in_a_turning_drum() {
    same_on_all("drum", "0.24", "0.05");
}

#[test]
fn gravel_of_all_kinds_of_sizes() {
    same_on_all("gravel", "0.02", "0.01");
}

#[test]
fn bonded_bodies_that_break() {
    same_on_all("bonded", "0.06", "0.01");
}

#[test]
fn spheres_of_many_sizes_behind_a_plate() {
    same_on_all("silo", "0.24", "0.08");
}
