//! Writes and reads every file of the crate on any number of ranks and checks what comes back.
//!
//! `mpirun -n 2 output_roundtrip <task> <directory>`; `tests/roundtrip.rs` runs all tasks.

#![allow(clippy::unwrap_used)] // a test program: a failure is to end it

mod bench;
mod checkpoints;
mod snapshots;

use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::path::Path;

/// Code with which a run ends that cannot write its files.
const FILES: i32 = 4;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, task, directory] = &arguments[..] else {
        eprintln!("usage: output_roundtrip <task> <directory>");
        std::process::exit(2);
    };
    let Some(universe) = mpi::initialize() else {
        eprintln!("MPI does not start");
        std::process::exit(2);
    };
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        report(info);
        abort();
    }));
    let (world, directory) = (universe.world(), Path::new(directory));
    run(task, directory, &world);
    if world.rank() == 0 {
        println!("{task}: ok on {} ranks", world.size());
    }
    if task.starts_with("full-disk") {
        // HDF5 tries once more to write what it could not when MPI ends properly; it may hang or crash.
        world.barrier();
        world.abort(FILES);
    }
}

fn run(task: &str, directory: &Path, world: &SimpleCommunicator) {
    match task {
        "snapshots" => snapshots::write_all(directory, world),
        "resume" => snapshots::resume(directory, world),
        "killed" => snapshots::killed(directory, world),
        "missing-folder" => snapshots::missing_folder(directory, world),
        "full-disk" => checkpoints::full_disk(directory, world),
        "full-disk-particles" => snapshots::full_disk(directory, world),
        "checkpoint-write" => checkpoints::write(directory, world),
        "checkpoint-read" => checkpoints::read(directory, world),
        "checkpoint-fallback" => checkpoints::fallback(directory, world),
        "checkpoint-flips" => checkpoints::flips(directory, world),
        "bench" => bench::bench(directory, world),
        other => panic!("no task {other}"),
    }
}

/// Ends all ranks: one that panics alone would leave the others waiting.
fn abort() {
    SimpleCommunicator::world().abort(101);
}
