//! The same bits on other processors: with AVX-512 or what this one has, with AVX2, and without either and without fused
//! multiplication. The others are emulated by QEMU; the C library takes its own variants there too. And by other builds of the program:
//! with `GRAINS_OTHER_PROGRAM=target/release/grains-mpi` (full paths, several parted by `:`) these are compared as well. And in pages of
//! either size, where Linux lets the program choose.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{assert_same_state, checkpoints};
use common::{ENVIRONMENT, case, folder, replaced, run_case, skipped};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const EMULATOR: &str = "qemu-x86_64";

/// Processors with AVX2, and with SSE 4.2 alone, as QEMU calls them.
const PROCESSORS: [&str; 2] = ["Haswell", "Nehalem"];

/// What glibc is told about huge pages, and that it shall not ask for them.
const TUNABLES: &str = "GLIBC_TUNABLES";
const SMALL_PAGES: &str = "glibc.malloc.hugetlb=0";

/// Runs a case on one rank by a command.
///
/// It must not begin anew for huge pages, which the emulator would leave to the processor itself.
fn run_by(command: &mut Command, folder: &Path, text: &str) {
    fs::write(folder.join("case.toml"), text).unwrap();
    command.envs(ENVIRONMENT).env(TUNABLES, SMALL_PAGES);
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

/// The tunables that a process begins with, and those that it has after it began anew, as its environment shows them while it runs.
fn tunables_seen(process: &mut std::process::Child) -> Vec<String> {
    let mut seen = Vec::new();
    while process.try_wait().unwrap().is_none() {
        let environment = fs::read(format!("/proc/{}/environ", process.id())).unwrap_or_default();
        let environment = String::from_utf8_lossy(&environment).into_owned();
        // glibc parts the tunables by zeros where they were parted by colons.
        let parts = environment.split('\0').map(|part| part.trim_start_matches(&format!("{TUNABLES}=")));
        let told = parts.filter(|part| part.starts_with("glibc.")).collect::<Vec<_>>().join(":");
        // Between two programs a process has no environment for a moment.
        if !told.is_empty() && seen.last() != Some(&told) {
            seen.push(told);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(process.wait().unwrap().success());
    seen
}

/// A run begins anew in its own process, once, and keeps what else glibc was told; who does not want huge pages is not asked; and the
/// state has the same bits.
#[test]
fn runs_ask_for_huge_pages_once_unless_told_not_to() {
    let mode = fs::read_to_string("/sys/kernel/mm/transparent_hugepage/enabled").unwrap_or_default();
    if !mode.contains("[madvise]") {
        return skipped("huge pages", "Linux does not give them to those that ask");
    }
    let text = replaced(&case("silo.toml"), "\nend = 0.24\n", "\nend = 0.08\n");
    let other = "glibc.malloc.arena_max=3";
    let both = format!("{other}:glibc.malloc.hugetlb=1");
    let states = [("asked", other, vec![other, &both]), ("not_wanted", SMALL_PAGES, vec![SMALL_PAGES])].map(
        |(name, told, wanted)| {
            let home = folder(&format!("machines_pages_{name}"));
            fs::write(home.join("case.toml"), &text).unwrap();
            let mut command = Command::new(env!("CARGO_BIN_EXE_grains-mpi"));
            command
                .envs(ENVIRONMENT)
                .env(TUNABLES, told)
                .arg("case.toml")
                .current_dir(&home)
                .stdout(Stdio::null());
            let seen = tunables_seen(&mut command.spawn().unwrap());
            // What was told first is seen only if it is looked for before the program begins anew.
            assert!(
                wanted.ends_with(&seen.iter().map(String::as_str).collect::<Vec<_>>()) && !seen.is_empty(),
                "{seen:?}"
            );
            checkpoints(&home.join("results"))
        },
    );
    assert_same_state(states[0].last().unwrap(), states[1].last().unwrap());
}
