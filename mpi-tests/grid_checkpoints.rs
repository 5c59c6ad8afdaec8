//! Arrays on grids in checkpoints: written by blocks on some ranks, read by others on others.

#![allow(clippy::unwrap_used)]

mod grids;
mod ranks;

use grains_comm::Job;
use grains_output::{
    Array, CheckpointFile, GridArray, GridBlock, Metadata, Values, agree, latest_valid, write_checkpoint,
};
use grids::{DEEP, RANKS, block, folder, rank, reals, text};
use ranks::on_ranks;
use std::fs;
use std::path::Path;

/// Arrays of a checkpoint: of cells, and of the faces normal to x, one more than cells.
fn grids(job: &Job) -> Vec<GridArray> {
    let array = |name, unit, width, all, step| {
        let block = block(job, all);
        GridArray { name, unit, width, block, values: reals(&block, step, width) }
    };
    vec![
        array("pressure", "Pa", 1, DEEP, 0),
        array("velocity_x", "m/s", 1, [DEEP[0] + 1, DEEP[1], DEEP[2]], 1),
        array("mean_velocity", "m/s", 3, DEEP, 2),
    ]
}

#[test]
fn arrays_on_grids_are_read_by_any_block_on_other_ranks() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("grid-checkpoints");
    on_ranks(&RANKS, "arrays_on_grids_are_read_by_any_block_on_other_ranks", |job| {
        let world = job.world();
        if job.size() == 1 {
            let _ = fs::remove_dir_all(&folder);
            fs::create_dir_all(&folder).unwrap();
        } else {
            // What the number of ranks before has written.
            let (file, refused) = latest_valid(&folder, world).unwrap();
            assert!(refused.is_empty(), "{refused:?}");
            assert_eq!(file.text("note"), Some("a grid"));
            for (step, array) in grids(job).into_iter().enumerate() {
                let read = agree(world, file.grid(array.name, array.width, &array.block)).unwrap();
                assert_eq!(read, array.values, "{}", array.name);
                // Any rank may ask for any block.
                let all = array.block.all;
                let one = GridBlock { all, first: [3, 2, 7], own: [2, 1, 2] };
                let read = file.grid(array.name, array.width, &one).unwrap();
                assert_eq!(read, reals(&one, step, array.width));
                let other = GridBlock { all: [all[0] + 1, all[1], all[2]], ..one };
                let message = file.grid(array.name, array.width, &other).unwrap_err().to_string();
                assert!(message.contains("another grid"), "{message}");
            }
            assert!(file.has_grid("velocity_x") && !file.has_grid("velocity_y"));
            assert!(file.grid("velocity_y", 1, &block(job, DEEP)).is_err());
            let (rank, size) = (rank(job), job.size());
            assert_eq!(file.real("rows").unwrap().len(), 12 * (rank + 1) / size - 12 * rank / size);
            // A rank may also take as many rows as it likes, if together they take all of them.
            let count = if rank + 1 == size { 12 - rank } else { 1 };
            assert_eq!(file.next_rows("rows", count, world).unwrap(), vec![0.5; count]);
            assert!(file.next_rows("rows", count + 1, world).is_err());
        }
        let rows = if rank(job) == 0 { vec![0.5; 12] } else { Vec::new() };
        let rows = [Array { name: "rows", unit: "-", width: 1, values: Values::Real(rows) }];
        let texts = vec![("note".to_string(), "a grid".to_string())];
        write_checkpoint(&folder, job.size() as u64, world, &rows, grids(job), &texts).unwrap();
    });
    if std::env::var_os("GRAINS_TEST_ON_RANKS").is_some() {
        return;
    }
    // All ranks wrote the same bytes of state.
    let stored = |ranks: usize| {
        let file = hdf5::File::open(folder.join(format!("checkpoint-{ranks:012}.h5"))).unwrap();
        let checksum =
            |name| file.dataset(name).unwrap().attr("checksum").unwrap().read_scalar::<u64>().unwrap();
        let checksums = ["state/rows", "grids/pressure", "grids/mean_velocity"].map(checksum);
        let velocity = file.dataset("grids/velocity_x").unwrap();
        assert_eq!((velocity.shape(), text(&velocity, "unit")), (vec![9, 6, 6], "m/s".to_string()));
        assert_eq!(file.dataset("grids/mean_velocity").unwrap().shape(), [9, 6, 5, 3]);
        (checksums, velocity.read_raw::<f64>().unwrap())
    };
    let first = stored(1);
    assert!(RANKS.iter().all(|&ranks| stored(ranks) == first));
}

#[test]
fn overlapping_blocks_are_found() {
    on_ranks(&[1, 3], "overlapping_blocks_are_found", |job| {
        let (folder, world) = (folder(job, "overlapping-grids"), job.world());
        let good = write_checkpoint(&folder, 1, world, &[], grids(job), &Metadata::new()).unwrap();
        assert!(CheckpointFile::read(&good, world).is_ok());
        // They are as many places as the grid has, but the sum of the hashes is another.
        let mut overlapping = grids(job);
        if rank(job) == 2 {
            overlapping[0].block.first[1] -= 1;
        }
        let path = write_checkpoint(&folder, 2, world, &[], overlapping, &Metadata::new()).unwrap();
        match CheckpointFile::read(&path, world) {
            Ok(_) => assert_eq!(job.size(), 1),
            Err(error) => {
                let message = error.to_string();
                assert!(rank(job) > 0 || message.contains("the checksum of `grids/pressure`"), "{message}");
            }
        }
        // A checkpoint without arrays on grids has no group of them.
        let path = write_checkpoint(&folder, 3, world, &[], [], &Metadata::new()).unwrap();
        assert!(!hdf5::File::open(&path).unwrap().link_exists("grids"));
        assert!(CheckpointFile::read(&path, world).is_ok_and(|file| !file.has_grid("pressure")));
    });
}

#[test]
fn every_flipped_bit_and_every_truncation_of_a_checkpoint_is_refused_by_name() {
    on_ranks(&[1], "every_flipped_bit_and_every_truncation_of_a_checkpoint_is_refused_by_name", |job| {
        let (folder, world) = (folder(job, "damaged-checkpoints"), job.world());
        let rows = [Array {
            name: "particle",
            unit: "1",
            width: 2,
            values: Values::Real(vec![0.5, -2.0, 3.0, 4.0]),
        }];
        let texts = vec![("case".to_string(), "end = 1".to_string())];
        write_checkpoint(&folder, 1, world, &rows, [], &texts).unwrap();
        let path = write_checkpoint(&folder, 2, world, &rows, [], &texts).unwrap();
        let whole = fs::read(&path).unwrap();
        let refusal = |bytes: &[u8], what: &str| {
            fs::write(&path, bytes).unwrap();
            let message = CheckpointFile::read(&path, world).expect_err(what).to_string();
            assert!(message.contains("checkpoint-000000000002.h5: is no valid checkpoint"), "{message}");
        };
        for bit in 0..8 * whole.len() {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            refusal(&damaged, "a flip");
        }
        for length in 0..whole.len() {
            refusal(&whole[..length], "a truncation");
        }
        println!("measured: {} flips and {} truncations refused", 8 * whole.len(), whole.len());
        let (file, refused) = latest_valid(&folder, world).unwrap();
        assert!(file.path.ends_with("checkpoint-000000000001.h5") && refused.len() == 1);
        fs::write(&path, &whole).unwrap();
        assert_eq!(latest_valid(&folder, world).unwrap().0.path, path);
    });
}
