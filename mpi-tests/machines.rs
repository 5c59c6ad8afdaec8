//! The same bits on other processors: with AVX-512 or what this one has, with AVX2, and without either and without fused
//! multiplication. The others are emulated by QEMU; the C library takes its own variants there too.

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

/// Runs a case on one rank on an emulated processor.
fn run_on(processor: &str, folder: &Path, text: &str) {
    fs::write(folder.join("case.toml"), text).unwrap();
    let output = Command::new(EMULATOR)
        .args(["-cpu", processor, env!("CARGO_BIN_EXE_grains-mpi"), "case.toml"])
        .envs(ENVIRONMENT)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{processor}: {text}");
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
    for processor in PROCESSORS {
        let there = folder(&format!("machines_{name}_{processor}"));
        run_on(processor, &there, &text);
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
