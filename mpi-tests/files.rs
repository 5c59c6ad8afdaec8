//! The files of a run: continued, moved aside, refused when damaged, intact on a full disk and after signals.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{
    assert_same_series, assert_same_state, checkpoints, last_step, series, snapshots, state, step_of,
};
use common::{case, folder, python, replaced, run, run_case, signal, skipped, start};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The silo until `end` (s), with a checkpoint every 0.02 s (500 steps).
fn silo(end: f64) -> String {
    let text = replaced(&case("silo.toml"), "end = 0.24", &format!("end = {end}"));
    replaced(&text, "checkpoint = 0.08", "checkpoint = 0.02")
}

#[test]
fn a_restart_continues_the_files_and_a_new_run_moves_them_aside() {
    let home = folder("files_continue");
    let results = home.join("results");
    let silo = |end: f64| replaced(&silo(end), "[domain]\n", "[domain]\nbalance = false\n");
    run_case(2, &home, &silo(0.06), &[]).succeeded();
    let first = series(&results);
    // Longer than before, on other ranks, from the end and from the middle.
    run_case(3, &home, &silo(0.12), &["--restart", "latest"]).succeeded();
    let middle = "results/checkpoint-000000001000.h5";
    run_case(2, &home, &silo(0.12), &["--restart", middle]).succeeded();
    let continued = series(&results);
    assert_eq!(continued.column("step"), (0..=30).map(|k| 100.0 * f64::from(k)).collect::<Vec<_>>());
    // Borders that moved lie elsewhere after a restart, and sums over particles are taken in another order: here they stay.
    assert_eq!(first.rows[..], continued.rows[..first.rows.len()], "rows of the first run");
    let header = |text: &str| text.lines().filter(|l| l.starts_with("step,")).count();
    assert_eq!(header(&fs::read_to_string(results.join("series.csv")).unwrap()), 1);
    let (times, _) = snapshots(&results.join("particles.vtkhdf"));
    assert_eq!(times.len(), 7);
    assert!(times.iter().zip(0..).all(|(t, k)| (t - 0.02 * f64::from(k)).abs() < 1e-12), "{times:?}");
    // A run without --restart begins anew, and loses nothing.
    fs::write(results.join("notes.txt"), "mine").unwrap();
    let output = run_case(2, &home, &silo(0.12), &[]).succeeded();
    assert!(output.stdout.contains("results.1"), "{}", output.text());
    // The log says what a user asks of it.
    for words in [
        "time step 4e-5 s: T_c/dt = ",
        "left ",
        "time by phase (s)",
        "particles per rank: ",
        "largest overlap ",
    ] {
        assert!(output.stdout.contains(words), "`{words}` is missing: {}", output.text());
    }
    let lines = output.stdout.lines().skip_while(|line| !line.starts_with("time by phase"));
    let lines = lines.take_while(|line| !line.starts_with("memory"));
    let share = |line: &str| line.strip_suffix(" %")?.rsplit(' ').next()?.parse::<f64>().ok();
    let shares: f64 = lines.filter_map(share).sum();
    assert!((shares - 100.0).abs() < 1.0, "shares of {shares} %: {}", output.text());
    let aside = home.join("results.1");
    assert_eq!(fs::read_to_string(aside.join("notes.txt")).unwrap(), "mine");
    assert_same_series(&series(&aside), &series(&results));
    assert_same_state(checkpoints(&aside).last().unwrap(), checkpoints(&results).last().unwrap());
    assert!(!results.join("notes.txt").exists());
}

#[test]
fn a_stop_condition_writes_the_last_state() {
    let home = folder("files_stop");
    let results = home.join("results");
    let text = silo(0.24) + "\n[stop]\nkinetic_energy_below = 1e3\nafter = 0.05\n";
    let output = run_case(2, &home, &text, &[]).succeeded();
    assert!(output.stdout.contains("stop condition met at t = 0.05"), "{}", output.text());
    // The row after 0.05 s meets it, and the step after that is the last.
    let last = step_of(checkpoints(&results).last().unwrap());
    assert_eq!((last, last_step(&results)), (1301, 1301));
    let (times, _) = snapshots(&results.join("particles.vtkhdf"));
    assert!((times.last().unwrap() - 1301.0 * 4e-5).abs() < 1e-12, "{times:?}");
}

/// Overwrites bytes in the middle of the particles of a checkpoint.
fn flip_a_bit(checkpoint: &Path) {
    let first = state(checkpoint)[0].state[4].to_le_bytes();
    let mut bytes = fs::read(checkpoint).unwrap();
    let at = bytes.windows(8).position(|w| w == first).expect("the position of a particle is in the file");
    bytes[at + 2] ^= 1;
    fs::write(checkpoint, bytes).unwrap();
}

fn truncate(checkpoint: &Path) {
    let bytes = fs::read(checkpoint).unwrap();
    fs::write(checkpoint, &bytes[..bytes.len() * 2 / 3]).unwrap();
}

#[test]
fn a_damaged_checkpoint_is_refused_by_name_and_the_previous_one_serves() {
    let home = folder("files_damaged");
    let results = home.join("results");
    run_case(2, &home, &silo(0.08), &[]).succeeded();
    let saved = checkpoints(&results);
    assert_eq!(saved.iter().map(|p| step_of(p)).collect::<Vec<_>>(), [500, 1000, 1500, 2000]);
    let end = home.join("end.h5");
    fs::copy(&saved[3], &end).unwrap();
    for (damage, newest, reason) in
        [(flip_a_bit as fn(&Path), 3, "its checksum is wrong"), (truncate, 2, "truncated")]
    {
        damage(&saved[newest]);
        let name = saved[newest].file_name().unwrap().to_str().unwrap();
        let explicit = format!("results/{name}");
        let refused = run_case(2, &home, &silo(0.08), &["--restart", &explicit]);
        let message = refused.only_error(4);
        assert!(message.contains(name) && message.contains(reason), "{message}");
    }
    // Two are damaged: the third from the end serves, and the run arrives at the same end.
    let output = run_case(3, &home, &silo(0.08), &["--restart", "latest"]).succeeded();
    for damaged in &saved[2..] {
        let name = damaged.file_name().unwrap().to_str().unwrap();
        assert!(output.stderr.contains(name), "{name} is named: {}", output.text());
    }
    assert!(
        output.stdout.contains("continuing from results/checkpoint-000000001000.h5"),
        "{}",
        output.text()
    );
    assert_same_state(&end, checkpoints(&results).last().unwrap());
    checkpoints(&results).iter().for_each(|path| truncate(path));
    let refused = run_case(2, &home, &silo(0.08), &["--restart", "latest"]);
    assert!(refused.only_error(4).contains("no valid checkpoint"), "{}", refused.text());
}

#[test]
fn a_checkpoint_of_other_particles_or_another_box_is_refused_with_the_key() {
    let home = folder("files_other_case");
    run_case(2, &home, &silo(0.04), &[]).succeeded();
    let before = checkpoints(&home.join("results"));
    let edits = [
        ("upper = [0.05, 0.05, 0.13]", "upper = [0.05, 0.05, 0.131]", "domain.upper"),
        ("density = 2500", "density = 2400", "material.glass.density"),
        ("radius = 4e-3", "radius = 3.9e-3", "shape.bead.radius"),
    ];
    for (old, new, key) in edits {
        let refused = run_case(2, &home, &replaced(&silo(0.04), old, new), &["--restart", "latest"]);
        let message = refused.only_error(2);
        assert!(message.contains(key) && message.contains("cannot be continued"), "{new}: {message}");
    }
    assert_eq!(before, checkpoints(&home.join("results")), "the checkpoints are untouched");
}

#[test]
fn a_directory_that_cannot_be_written_is_named() {
    let home = folder("files_unwritable");
    fs::write(home.join("blocker"), "a file").unwrap();
    for directory in ["blocker/results", "/proc/grains/results"] {
        let text = replaced(&silo(0.02), "\"results\"", &format!("\"{directory}\""));
        let refused = run_case(2, &home, &text, &[]);
        let message = refused.only_error(4);
        assert!(message.contains(directory) && message.contains("output.directory"), "{message}");
    }
    let refused = run_case(2, &home, &silo(0.02), &["--restart", "latest"]);
    assert!(refused.only_error(4).contains("no checkpoint"), "{}", refused.text());
}

/// A small file system, unmounted when dropped.
struct Disk<'a>(&'a Path);

impl Disk<'_> {
    fn mount(&self, options: &str) -> bool {
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(self.0);
        mount.output().is_ok_and(|output| output.status.success())
    }
}

impl Drop for Disk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(self.0).output();
    }
}

#[test]
fn a_full_disk_ends_the_run_with_one_message_and_leaves_the_checkpoints() {
    let home = folder("files_full_disk");
    let path = home.join("disk");
    fs::create_dir_all(&path).unwrap();
    let disk = Disk(&path);
    if !disk.mount("size=6m") {
        return skipped("full disk", "no file system can be mounted here (not root?)");
    }
    let undisturbed = folder("files_large_disk");
    let text = replaced(&silo(0.12), "keep_checkpoints = 100", "keep_checkpoints = 2");
    run_case(2, &undisturbed, &text, &[]).succeeded();
    // Snapshots so often that they fill the disk.
    let text = replaced(&text, "\"results\"", "\"disk/results\"");
    let often = replaced(&text, "particles = 0.02", "particles = 0.0008");
    let output = run_case(2, &home, &often, &[]);
    let message = output.only_error(4);
    assert!(message.contains("disk/results/") && message.contains("No space left"), "{message}");
    println!("a full disk: {message}");
    let saved = checkpoints(&path.join("results"));
    assert!(!saved.is_empty(), "{}", output.text());
    saved.iter().for_each(|checkpoint| assert!(!state(checkpoint).is_empty()));
    // With more space the run goes on from there to the same end.
    assert!(disk.mount("remount,size=64m"), "the disk grows");
    let output = run_case(3, &home, &often, &["--restart", "latest"]).succeeded();
    assert!(output.stdout.contains("continuing from"), "{}", output.text());
    let (wanted, found) = (checkpoints(&undisturbed.join("results")), checkpoints(&path.join("results")));
    assert_same_state(wanted.last().unwrap(), found.last().unwrap());
}

/// Who gets a signal.
#[derive(Clone, Copy, Debug)]
enum Receiver {
    Ranks,
    LastRank,
    Mpirun,
}

/// The shear box until `end` (s), with a row every 20 steps.
fn shear(end: f64) -> String {
    let text = replaced(&case("shear.toml"), "end = 0.16", &format!("end = {end:?}"));
    replaced(&text, "series = 0.002", "series = 0.0005")
}

#[test]
fn signals_and_the_walltime_write_a_checkpoint_that_continues_bit_for_bit() {
    const DT: f64 = 2.5e-5;
    let home = folder("files_signals");
    let results = home.join("results");
    let stages = [
        (2, "TERM", Receiver::Ranks),
        (1, "INT", Receiver::Ranks),
        (3, "USR1", Receiver::LastRank),
        (2, "USR1", Receiver::Mpirun),
        (4, "TERM", Receiver::Mpirun),
        (2, "INT", Receiver::Mpirun),
    ];
    fs::write(home.join("case.toml"), shear(10.0)).unwrap();
    let mut arguments = vec!["case.toml"];
    let mut reached = 0;
    for (ranks, name, receiver) in stages {
        let mut running = start(ranks, &home, &arguments, 1);
        running.wait_until("200 steps on", || last_step(&results) >= reached + 200);
        let processes = match receiver {
            Receiver::Ranks => running.ranks(),
            Receiver::LastRank => running.ranks().into_iter().max().into_iter().collect(),
            Receiver::Mpirun => vec![running.mpirun()],
        };
        signal(name, &processes);
        let output = running.wait();
        let step = checkpoints(&results).last().map_or(0, |path| step_of(path));
        println!("SIG{name} to {receiver:?} on {ranks}: exit code {:?}, checkpoint at {step}", output.code);
        assert!(step > reached, "a checkpoint: {}", output.text());
        state(checkpoints(&results).last().unwrap());
        let hint = format!("stopped at step {step}");
        let has_hint = output.stdout.contains(&hint) && output.stdout.contains("--restart latest");
        assert!(has_hint, "{name} {receiver:?}: {}", output.text());
        if !matches!((receiver, name), (Receiver::Mpirun, "TERM" | "INT")) {
            assert_eq!(output.code, Some(0), "{}", output.text());
        }
        reached = step;
        arguments = vec!["case.toml", "--restart", "latest"];
    }
    let output = run(2, &home, &[&arguments[..], &["--max-walltime", "0.3"]].concat()).succeeded();
    assert!(output.stdout.contains("--restart latest"), "{}", output.text());
    let step = step_of(checkpoints(&results).last().unwrap());
    assert!(step > reached, "{}", output.text());
    let end = (step + 200) as f64 * DT;
    run_case(3, &home, &shear(end), &["--restart", "latest"]).succeeded();
    // The same without interruption.
    let undisturbed = folder("files_no_signals");
    run_case(2, &undisturbed, &shear(end), &[]).succeeded();
    let wanted = undisturbed.join("results");
    assert_same_state(checkpoints(&wanted).last().unwrap(), checkpoints(&results).last().unwrap());
    assert_same_series(&series(&wanted), &series(&results));
    assert_eq!(snapshots(&wanted.join("particles.vtkhdf")), snapshots(&results.join("particles.vtkhdf")));
}

#[test]
fn a_killed_run_leaves_files_that_can_be_read_and_continued() {
    let home = folder("files_killed");
    let results = home.join("results");
    fs::write(home.join("case.toml"), silo(0.24)).unwrap();
    let mut running = start(2, &home, &["case.toml"], 0);
    running.wait_until("two checkpoints", || results.exists() && checkpoints(&results).len() >= 2);
    signal("KILL", &running.ranks());
    assert_ne!(running.wait().code, Some(0));
    let (times, counts) = snapshots(&results.join("particles.vtkhdf"));
    assert!(times.len() >= 2 && counts.iter().all(|&n| n > 0), "{times:?} {counts:?}");
    run_case(3, &home, &silo(0.24), &["--restart", "latest"]).succeeded();
    let undisturbed = folder("files_not_killed");
    run_case(2, &undisturbed, &silo(0.24), &[]).succeeded();
    let wanted = undisturbed.join("results");
    assert_same_state(checkpoints(&wanted).last().unwrap(), checkpoints(&results).last().unwrap());
    assert_eq!(snapshots(&wanted.join("particles.vtkhdf")), snapshots(&results.join("particles.vtkhdf")));
}

/// Reads the files of a finished run back with VTK and h5py.
fn read_back(test: &str, results: &Path) {
    let Some(python) = python() else {
        return skipped(test, "no Python with vtk and h5py: snapshots are not read back");
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/readback.py");
    let output = Command::new(python).arg(script).arg(results).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    print!("{}", text(&output.stdout));
    assert!(output.status.success(), "{}\n{}", text(&output.stdout), text(&output.stderr));
}

#[test]
fn snapshots_of_spheres_that_leave_are_read_back() {
    let home = folder("files_read_silo");
    run_case(3, &home, &case("silo.toml"), &[]).succeeded();
    let (_, counts) = snapshots(&home.join("results/particles.vtkhdf"));
    assert!(counts.first() > counts.last(), "{counts:?}");
    read_back("silo", &home.join("results"));
}

#[test]
fn snapshots_of_periodic_bodies_and_their_surfaces_are_read_back() {
    let home = folder("files_read_shear");
    let text = replaced(&case("shear.toml"), "series = 0.002", "series = 0.002\nsurfaces = 0.016");
    run_case(4, &home, &text, &[]).succeeded();
    read_back("shear", &home.join("results"));
}

#[test]
fn fields_of_a_fluid_are_read_back() {
    for (ranks, name) in [(3, "duct.toml"), (2, "bed.toml"), (2, "resolved.toml")] {
        let home = folder("files_read_fluid");
        run_case(ranks, &home, &case(name), &[]).succeeded();
        read_back(name, &home.join("results"));
    }
}

#[test]
fn compressed_snapshots_with_empty_steps_and_ranks_are_read_back() {
    let home = folder("files_read_drum");
    let format = "series = 0.003\nsurfaces = 0.024\nprecision = \"f32\"\ncompress = true";
    let text = replaced(&case("drum.toml"), "series = 0.003", format);
    // Eight slices along x: those at the ends hold nothing at first.
    let text = replaced(&text, "[domain]\n", "[domain]\nranks = [8, 1, 1]\n");
    let text = replaced(&text, "[-0.045, -0.03, -0.045]", "[-0.05, -0.03, -0.045]");
    let text = replaced(&text, "[0.045, 0.03, 0.045]", "[0.05, 0.03, 0.045]");
    run_case(8, &home, &text, &[]).succeeded();
    let (_, counts) = snapshots(&home.join("results/particles.vtkhdf"));
    assert_eq!((counts[0], counts.last()), (0, Some(&64)));
    read_back("drum", &home.join("results"));
}

/// What a run of one process in a folder says; unlike [`run`] it may run beside another.
fn beside(home: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_grains-mpi"));
    let output = command.args(arguments).current_dir(home).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_second_run_in_the_directory_is_refused_and_leaves_the_first_alone() {
    let home = folder("files_two_runs");
    let results = home.join("results");
    fs::write(home.join("case.toml"), shear(10.0)).unwrap();
    let mut first = start(2, &home, &["case.toml"], 0);
    first.wait_until("a checkpoint", || results.exists() && !checkpoints(&results).is_empty());
    for arguments in [&["case.toml"][..], &["case.toml", "--restart", "latest"]] {
        let (code, text) = beside(&home, arguments);
        assert_eq!(code, Some(4), "{text}");
        assert!(
            text.contains("results: another run (process ") && text.contains("output.directory"),
            "{text}"
        );
    }
    assert!(!home.join("results.1").exists());
    // A crash leaves no lock behind.
    signal("KILL", &first.ranks());
    assert_ne!(first.wait().code, Some(0));
    let step = step_of(checkpoints(&results).last().unwrap());
    let end = (step + 200) as f64 * 2.5e-5;
    run_case(3, &home, &shear(end), &["--restart", "latest"]).succeeded();
    let undisturbed = folder("files_one_run");
    run_case(2, &undisturbed, &shear(end), &[]).succeeded();
    let wanted = undisturbed.join("results");
    assert_same_state(checkpoints(&wanted).last().unwrap(), checkpoints(&results).last().unwrap());
    assert_same_series(&series(&wanted), &series(&results));
}

#[test]
fn a_directory_that_is_renamed_under_a_run_ends_it_and_keeps_what_was_written() {
    let home = folder("files_renamed");
    let (results, aside) = (home.join("results"), home.join("moved"));
    fs::write(home.join("case.toml"), shear(10.0)).unwrap();
    let mut first = start(2, &home, &["case.toml"], 0);
    first.wait_until("a checkpoint", || results.exists() && !checkpoints(&results).is_empty());
    fs::rename(&results, &aside).unwrap();
    let output = first.wait();
    assert!(output.only_error(4).contains("results: has been renamed"), "{}", output.text());
    assert!(!checkpoints(&aside).is_empty() && !results.exists());
    checkpoints(&aside).iter().for_each(|path| drop(state(path)));
}
