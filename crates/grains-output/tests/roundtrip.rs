//! Runs the example `output_roundtrip` under mpirun on 1 to 4 ranks and reads its files with other programs.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const LIMIT: Duration = Duration::from_secs(120);

/// A folder of results that vanishes with the test, unless it fails.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("grains-output-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }
}

/// The example: cargo builds it before the tests, in `examples` beside `deps`.
fn program() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let program = test.parent().and_then(Path::parent).unwrap().join("examples/output_roundtrip");
    assert!(program.exists(), "{} is missing: run `cargo test -p grains-output`", program.display());
    program
}

/// Runs a command to its end, or kills it when the time is up.
fn finished(mut command: Command) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > LIMIT {
            let _ = child.kill();
            let output = child.wait_with_output().unwrap();
            panic!("{command:?} hangs: {}", String::from_utf8_lossy(&output.stderr));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

fn mpirun(ranks: usize) -> Command {
    let mut command = Command::new("mpirun");
    command.args(["--allow-run-as-root", "--oversubscribe", "-n", &ranks.to_string()]);
    command
}

/// Does a task of the example and returns what it says.
fn task(ranks: usize, task: &str, folder: &Folder) -> String {
    let mut command = mpirun(ranks);
    command.arg(program()).arg(task).arg(&folder.0);
    said(finished(command), &format!("{task} on {ranks} ranks"))
}

fn said(output: Output, what: &str) -> String {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{what} failed:\n{text}{errors}");
    text
}

/// Whether Python can check the files; says so if not.
fn has_python() -> bool {
    let can = |module: &str| {
        let output = Command::new("python3").args(["-c", &format!("import {module}")]).output();
        output.is_ok_and(|o| o.status.success())
    };
    let missing: Vec<&str> = ["h5py", "numpy", "vtk"].into_iter().filter(|m| !can(m)).collect();
    if !missing.is_empty() {
        eprintln!("skipped: reading back, as python3 lacks {}", missing.join(", "));
    }
    !missing.contains(&"h5py") && !missing.contains(&"numpy")
}

fn readback(folder: &Folder, file: &str, option: &str, other: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readback.py");
    let mut command = Command::new("python3");
    command.arg(script).arg(folder.0.join(file)).arg(option).arg(folder.0.join(other));
    print!("{}", said(finished(command), file));
}

#[test]
fn snapshots_are_read_by_vtk_and_h5py() {
    for ranks in 1..=4 {
        let folder = Folder::new("snapshots");
        task(ranks, "snapshots", &folder);
        if !has_python() {
            continue;
        }
        for name in ["particles", "short", "compressed", "walls", "surfaces"] {
            readback(&folder, &format!("{name}.vtkhdf"), "--expect", &format!("{name}.json"));
        }
    }
}

#[test]
fn a_continued_file_equals_an_uninterrupted_one() {
    for ranks in 1..=4 {
        let folder = Folder::new("resume");
        task(ranks, "resume", &folder);
        if !has_python() {
            continue;
        }
        for (last, compressed) in [(0, false), (2, false), (4, true), (8, true)] {
            let (name, whole) =
                (format!("resumed-{last}-{compressed}.vtkhdf"), format!("whole-{compressed}.vtkhdf"));
            readback(&folder, &name, "--same", &whole);
        }
    }
}

#[test]
fn a_killed_run_leaves_readable_files() {
    for ranks in [1, 2, 3] {
        let folder = Folder::new("killed");
        let mut command = mpirun(ranks);
        command.arg(program()).arg("killed").arg(&folder.0);
        assert!(!finished(command).status.success());
        if has_python() {
            readback(&folder, "killed.vtkhdf", "--expect", "killed.json");
        }
    }
}

#[test]
fn a_missing_folder_is_named() {
    for ranks in 1..=4 {
        task(ranks, "missing-folder", &Folder::new("missing"));
    }
}

#[test]
fn a_checkpoint_is_read_on_another_number_of_ranks() {
    for written in 1..=4 {
        let folder = Folder::new("checkpoint");
        task(written, "checkpoint-write", &folder);
        for read in 1..=4 {
            task(read, "checkpoint-read", &folder);
        }
    }
}

#[test]
fn a_damaged_checkpoint_is_refused_and_an_older_one_taken() {
    for ranks in 1..=4 {
        task(ranks, "checkpoint-fallback", &Folder::new("fallback"));
    }
    let said = task(2, "checkpoint-flips", &Folder::new("flips"));
    print!("{said}");
}

/// A limit on the size of files stands for the full disk: it needs no rights to mount one.
#[test]
fn a_full_disk_leaves_what_was_written_before() {
    for ranks in 1..=4 {
        for task in ["full-disk", "full-disk-particles"] {
            let (folder, program) = (Folder::new(task), program());
            let (program, path) = (program.display(), folder.0.display());
            let script = format!("trap '' XFSZ; ulimit -f 40000; exec {program} {task} {path}");
            let mut command = mpirun(ranks);
            command.args(["sh", "-c", &script]);
            let output = finished(command);
            let [text, errors] =
                [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned());
            assert!(text.contains("ok on"), "{task} on {ranks} ranks:\n{text}{errors}");
            if task == "full-disk-particles" && has_python() {
                readback(&folder, "full.vtkhdf", "--expect", "full.json");
            }
        }
    }
}
