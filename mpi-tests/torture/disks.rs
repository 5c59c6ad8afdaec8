//! Disks that are full, fail or are slow, at any byte.

use crate::common::results::checkpoints;
use crate::common::start_with;
use crate::{Draw, Subject, assert_readable, preloaded, repeated};
use std::fs;
use std::path::{Path, PathBuf};

/// A full disk, a quota that is used up, a device that fails (errno of Linux, and what the system says).
const ERRORS: [(i32, &str); 3] =
    [(28, "No space left on device"), (122, "Disk quota exceeded"), (5, "Input/output error")];

/// A disk with room for a number of bytes.
struct FaultyDisk {
    state: PathBuf,
    error: i32,
    microseconds: u32,
    /// Whether the first of two ranks writes for both, as on nodes of two.
    on_nodes: bool,
}

impl FaultyDisk {
    fn new(home: &Path, room: u64, error: i32) -> Self {
        let state = home.join("disk");
        fs::write(&state, [0_u64.to_ne_bytes(), room.to_ne_bytes()].concat()).unwrap();
        Self { state, error, microseconds: 0, on_nodes: false }
    }

    fn environment(&self) -> Vec<(&'static str, String)> {
        let mut environment = vec![
            ("LD_PRELOAD", preloaded("faulty_disk")),
            ("FAULT_FOLDER", "/results/".into()),
            // What the program tries out before it writes: the disk fails after that.
            ("FAULT_SPARED", ".probe-".into()),
            ("FAULT_STATE", self.state.display().to_string()),
            ("FAULT_ERROR", self.error.to_string()),
            ("GRAINS_WRITE_TIMEOUT", "4".into()),
            ("FAULT_SLOW", self.microseconds.to_string()),
        ];
        environment.extend(self.on_nodes.then(|| ("GRAINS_RANKS_PER_NODE", "2".into())));
        environment
    }

    /// Bytes written, or refused.
    fn written(&self) -> u64 {
        u64::from_ne_bytes(fs::read(&self.state).unwrap()[..8].try_into().unwrap())
    }
}

/// Lets a run write so many bytes only; then it must end with one message, and go on where there is room.
fn filled(subject: &Subject, (room, on_nodes): (u64, bool), (error, words): (i32, &str), ranks: [usize; 2]) {
    let home = subject.begin("disks");
    let disk = FaultyDisk { on_nodes, ..FaultyDisk::new(&home, room, error) };
    let output = start_with(ranks[0], &home, &["case.toml"], (0, &disk.environment())).wait();
    let what = format!("{}: room for {room} bytes, error {error}", subject.name);
    if output.code == Some(0) {
        // What is not needed to go on, such as the page about the run, is warned of.
        let is_said = output.stderr.contains("warning") || disk.written() <= room;
        assert!(is_said, "{what}: nothing is said\n{}", output.text());
    } else {
        let message = output.only_error(4);
        let is_named = message.contains("results/") || message.contains("results:");
        let is_explained = message.contains(words) || message.contains("look for a full disk, a quota");
        assert!(is_named && is_explained, "{what}: {message}");
    }
    assert_readable(&home.join("results"));
    subject.continued(ranks[1], &home);
    subject.assert_nothing_lost(&home);
}

/// Bytes that a run of a case writes.
fn bytes_of(subject: &Subject) -> u64 {
    let home = subject.begin("disks");
    let disk = FaultyDisk::new(&home, u64::MAX / 2, 28);
    start_with(2, &home, &["case.toml"], (0, &disk.environment())).wait().succeeded();
    disk.written()
}

/// Lets the disk fail at bytes all over what a run writes.
fn fails_anywhere(name: &'static str, (steps, every, saved): (u32, u32, u32), few: usize, many: usize) {
    let subject = Subject::new("disks", name, steps, every, saved);
    let all = bytes_of(&subject);
    let (count, mut draw) = (repeated(few, many), Draw(u64::from(steps)));
    for k in 0..count {
        // Evenly over the run, somewhere in each part.
        let room = (all as f64 * (k as f64 + draw.next()) / count as f64) as u64;
        let ranks = [subject.ranks(&mut draw), subject.ranks(&mut draw)];
        filled(&subject, (room, k % 2 == 1), ERRORS[k % ERRORS.len()], ranks);
    }
    println!("attack: {name} on a disk that fails | {count} of {all} bytes | one message each, nothing lost");
}

#[test]
fn a_disk_that_fails_at_any_byte_of_a_packing_costs_nothing() {
    fails_anywhere("shear", (40, 4, 12), 8, 120);
}

#[test]
fn a_disk_that_fails_at_any_byte_of_a_bed_costs_nothing() {
    fails_anywhere("bed", (24, 3, 6), 5, 60);
}

#[test]
fn a_disk_that_fails_at_any_byte_of_a_duct_costs_nothing() {
    fails_anywhere("duct", (30, 3, 6), 3, 20);
}

#[test]
fn a_slow_disk_changes_nothing() {
    let subject = Subject::new("slow", "shear", 40, 4, 12);
    let home = subject.begin("slow");
    let disk = FaultyDisk { microseconds: 2000, ..FaultyDisk::new(&home, u64::MAX / 2, 28) };
    start_with(3, &home, &["case.toml"], (0, &disk.environment())).wait().succeeded();
    subject.assert_nothing_lost(&home);
    assert_eq!(checkpoints(&home.join("results")).len(), checkpoints(&subject.home.join("results")).len());
}
