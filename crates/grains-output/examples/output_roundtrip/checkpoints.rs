//! Checkpoints: written on some ranks, read on others; damaged; on a full disk.

use crate::snapshots::{metadata, told};
use grains_output::{Array, CheckpointFile, FileError, Values, latest_valid, remove_old, write_checkpoint};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::path::Path;

const ROWS: usize = 101;

fn real(row: usize, column: usize, step: u64) -> f64 {
    (row as f64 + 0.1 * column as f64).sin() + step as f64
}

/// The state at a step: rows dealt out unevenly, none on the last rank.
fn arrays(step: u64, world: &SimpleCommunicator) -> Vec<Array> {
    let (rank, size) = (world.rank() as usize, world.size() as usize);
    let end =
        |r: usize| if r + 1 >= size.max(2) - 1 { ROWS } else { ROWS * (r + 1) * (r + 1) / (size * size) };
    let own = if rank == 0 { 0..end(0) } else { end(rank - 1)..end(rank) };
    let columns = |row: usize| (0..5).map(move |column| real(row, column, step));
    let particles = own.clone().flat_map(columns).collect();
    let table = if rank == 0 { vec![1.5, f64::NAN, -0.0] } else { Vec::new() };
    let array = |name, width, values| Array { name, unit: "m", width, values };
    vec![
        array("particle", 5, Values::Real(particles)),
        array("id", 1, Values::Integer(own.map(|row| row as i64 * 7 - 3).collect())),
        array("table", 1, Values::Real(table)),
        array("none", 3, Values::Real(Vec::new())),
    ]
}

/// Writes steps 10, 20 and 30 and keeps two; then 25, as a run restarted from 20 would.
pub fn write(directory: &Path, world: &SimpleCommunicator) {
    for step in [10, 20, 30] {
        write_checkpoint(directory, step, world, &arrays(step, world), &metadata(world))
            .expect("a checkpoint");
        if world.rank() == 0 {
            remove_old(directory, 2);
        }
    }
    world.barrier();
    let exists = |step: u64| directory.join(format!("checkpoint-{step:012}.h5")).exists();
    assert_eq!([10, 20, 30].map(exists), [false, true, true]);
    write_checkpoint(directory, 25, world, &arrays(25, world), &metadata(world)).expect("a checkpoint");
    assert_eq!([20, 25, 30].map(exists), [true, true, false]);
}

/// Reads what any number of ranks wrote.
pub fn read(directory: &Path, world: &SimpleCommunicator) {
    let (file, refused) = latest_valid(directory, world).expect("a valid checkpoint");
    assert!(refused.is_empty() && file.path.ends_with("checkpoint-000000000025.h5"));
    check(&file, 25, world);
    let missing = CheckpointFile::read(&directory.join("checkpoint-7.h5"), world);
    let message = told(world, missing.err());
    assert!(message.contains("checkpoint-7.h5") && message.contains("No such file"), "{message}");
}

fn check(file: &CheckpointFile, step: u64, world: &SimpleCommunicator) {
    let (rank, size) = (world.rank() as usize, world.size() as usize);
    let own = ROWS * rank / size..ROWS * (rank + 1) / size;
    let expected: Vec<f64> =
        own.clone().flat_map(|row| (0..5).map(move |column| real(row, column, step))).collect();
    assert_eq!(file.real("particle").unwrap(), expected);
    assert_eq!(file.shape("particle").unwrap(), [ROWS, 5]);
    assert_eq!(file.integer("id").unwrap(), own.map(|r| r as i64 * 7 - 3).collect::<Vec<_>>());
    let bits: Vec<u64> = file.all_real("table").unwrap().iter().map(|x| x.to_bits()).collect();
    assert_eq!(bits, [1.5, f64::NAN, -0.0].map(f64::to_bits));
    assert_eq!(file.integer_rows("id", 40..42).unwrap(), [277, 284]);
    assert!(file.all_real("none").unwrap().is_empty());
    assert_eq!(file.text("case"), Some(metadata(world)[3].1.as_str()));
    assert!(file.real("id").is_err() && file.integer_rows("id", 100..102).is_err());
    assert_eq!(file.names().collect::<Vec<_>>(), ["id", "none", "particle", "table"]);
}

/// The newest checkpoint damaged, the one before is taken, and rank 0 knows why.
pub fn fallback(directory: &Path, world: &SimpleCommunicator) {
    for step in [1, 2, 3] {
        write_checkpoint(directory, step, world, &arrays(step, world), &metadata(world))
            .expect("a checkpoint");
    }
    let path = |step: u64| directory.join(format!("checkpoint-{step:012}.h5"));
    if world.rank() == 0 {
        let bytes = std::fs::read(path(3)).unwrap();
        std::fs::write(path(3), &bytes[..bytes.len() * 2 / 3]).unwrap();
        let mut bytes = std::fs::read(path(2)).unwrap();
        // A byte in the middle of the particles.
        let needle = real(ROWS / 2, 3, 2).to_ne_bytes();
        let place = bytes.windows(8).position(|w| w == needle).expect("the value lies in the file");
        bytes[place + 2] ^= 4;
        std::fs::write(path(2), bytes).unwrap();
    }
    world.barrier();
    let (file, refused) = latest_valid(directory, world).expect("the oldest is valid");
    check(&file, 1, world);
    let texts: Vec<String> = refused.into_iter().map(|error| told(world, Some(error))).collect();
    assert!(texts[0].contains("000003.h5: is no valid checkpoint: it is truncated"), "{}", texts[0]);
    assert!(texts[1].contains("the checksum of `state/particle` is wrong"), "{}", texts[1]);
    assert!(texts[1].contains("--restart latest"));
}

/// Whichever byte is changed: the file is refused, or what is read is right all the same.
pub fn flips(directory: &Path, world: &SimpleCommunicator) {
    let few = [("seed".to_string(), "42".to_string())].to_vec();
    let path = write_checkpoint(directory, 5, world, &arrays(5, world), &few).expect("a checkpoint");
    let original = std::fs::read(&path).unwrap();
    let sound = CheckpointFile::read(&path, world).expect("it is valid");
    let damaged = directory.join("damaged.h5");
    let (mut refused, mut unharmed) = (0, 0);
    let stride = (original.len() / 700).max(1);
    for place in (0..original.len()).step_by(stride) {
        if world.rank() == 0 {
            let mut bytes = original.clone();
            bytes[place] ^= 1 << (place % 8);
            std::fs::write(&damaged, bytes).unwrap();
        }
        world.barrier();
        match CheckpointFile::read(&damaged, world) {
            Err(_) => refused += 1,
            Ok(file) => {
                unharmed += 1;
                let same = |name: &str| match file.real(name) {
                    Ok(values) => {
                        let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                        bits(values) == bits(sound.real(name).unwrap())
                    }
                    Err(_) => file.integer(name).ok() == sound.integer(name).ok(),
                };
                assert!(sound.names().all(same) && file.text("seed") == Some("42"), "byte {place}");
            }
        }
        world.barrier();
    }
    assert!(refused > unharmed, "{refused} refused, {unharmed} unharmed");
    if world.rank() == 0 {
        println!("{refused} damaged files refused, {unharmed} unharmed (unused bytes)");
    }
}

/// On a file system that takes little more: a clear error on all ranks, and the old checkpoint is intact.
pub fn full_disk(directory: &Path, world: &SimpleCommunicator) {
    write_checkpoint(directory, 1, world, &arrays(1, world), &metadata(world)).expect("a small one fits");
    let big = [Array { name: "big", unit: "m", width: 1, values: Values::Real(vec![1.0; 4_000_000]) }];
    let outcome = write_checkpoint(directory, 2, world, &big, &metadata(world));
    let message = told(world, outcome.err());
    assert!(message.contains("checkpoint-000000000002.h5"), "{message}");
    assert!(message.contains("earlier ones are intact"), "{message}");
    // The last: the limit on the size of a file that stands for a full disk lets a probe pass.
    let cause = ["No space left", "write failed"];
    assert!(cause.iter().any(|c| message.contains(c)), "{message}");
    let (file, refused): (CheckpointFile, Vec<FileError>) =
        latest_valid(directory, world).expect("the first");
    assert!(refused.is_empty());
    check(&file, 1, world);
    let left: Vec<_> = std::fs::read_dir(directory).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 1, "{left:?}");
    // The run may go on and write again once there is room.
    write_checkpoint(directory, 3, world, &arrays(3, world), &metadata(world)).expect("a small one fits");
}
