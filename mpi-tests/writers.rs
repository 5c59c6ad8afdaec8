//! What the first ranks of nodes write for the others is what each would write for itself.

#![allow(clippy::unwrap_used)]
#![allow(unsafe_code)] // the environment of a test program that has one thread

mod grids;
mod ranks;

use grains_comm::Job;
use grains_output::{
    Array, CheckpointFile, Data, FieldSpec, GridArray, Metadata, PolyDataFile, Precision, SnapshotFile, Step,
    Values, write_checkpoint,
};
use grids::{DEEP, block, folder, rank, reals};
use mpi::traits::CommunicatorCollectives;
use ranks::on_ranks;
use std::ops::Range;
use std::path::Path;

const NODES: &str = "GRAINS_RANKS_PER_NODE";
/// Values that take a rank several messages, and its node several writes.
const MANY: usize = 1_300_000;

/// This rank's share of some rows: none, few or many.
fn share(rows: usize, job: &Job) -> Range<usize> {
    let (rank, size) = (rank(job), job.size());
    rows * rank * rank / (size * size)..rows * (rank + 1) * (rank + 1) / (size * size)
}

fn value(place: usize) -> f64 {
    (0.3 + 1.7 * place as f64).sin()
}

/// Writes snapshots and a checkpoint.
fn write(folder: &Path, rows: [usize; 3], precision: Precision, job: &Job) {
    let specs = [FieldSpec::integer("id"), FieldSpec::real("velocity", "m/s", 3)];
    let (path, metadata) = (folder.join("particles.vtkhdf"), Metadata::new());
    let mut file =
        PolyDataFile::create(&path, job.world(), &specs, false, (precision, false), &metadata).unwrap();
    for (step, rows) in rows.into_iter().enumerate() {
        let own = share(rows, job);
        let threes: Vec<f64> = (3 * own.start..3 * own.end).map(value).collect();
        let ids: Vec<i64> = own.map(|place| 7 * place as i64).collect();
        let fields = [Data::Integer(&ids), Data::Real(&threes)];
        file.append(&Step { time: step as f64, points: &threes, triangles: &[], fields: &fields }).unwrap();
    }
    let own = share(rows[1], job);
    let arrays = [
        Array {
            name: "number",
            unit: "-",
            width: 1,
            values: Values::Integer(own.clone().map(|k| k as i64).collect()),
        },
        Array {
            name: "state",
            unit: "SI",
            width: 2,
            values: Values::Real((2 * own.start..2 * own.end).map(value).collect()),
        },
    ];
    let block = block(job, DEEP);
    let cells = GridArray { name: "pressure", unit: "Pa", width: 1, block, values: reals(&block, 0, 1) };
    write_checkpoint(folder, 1, job.world(), &arrays, [cells], &metadata).unwrap();
}

/// Bits of all that is read back, which the checksums in the files verify.
fn read(folder: &Path, job: &Job) -> Vec<Vec<u64>> {
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    let file = SnapshotFile::open(&folder.join("particles.vtkhdf"), job.world()).unwrap();
    let mut found = Vec::new();
    for step in 0..file.times().len() {
        found.push(bits(file.points(step).unwrap()));
        found.push(bits(file.real(step, "velocity").unwrap()));
        found.push(file.integer(step, "id").unwrap().into_iter().map(i64::cast_unsigned).collect());
    }
    let file = CheckpointFile::read(&folder.join("checkpoint-000000000001.h5"), job.world()).unwrap();
    found.push(bits(file.real("state").unwrap().to_vec()));
    found.push(file.integer("number").unwrap().iter().map(|n| n.cast_unsigned()).collect());
    found.push(bits(file.grid("pressure", 1, &block(job, DEEP)).unwrap()));
    found
}

#[test]
fn files_are_the_same_however_ranks_lie_on_nodes() {
    on_ranks(&[1, 3, 7], "files_are_the_same_however_ranks_lie_on_nodes", |job| {
        let folder = folder(job, "writers");
        let mut tries = vec![([40, 0, 1234], Precision::F64), ([40, 5, 1234], Precision::F32)];
        if job.size() == 3 {
            tries.push(([2, MANY, 3], Precision::F64));
        }
        for (rows, precision) in tries {
            // SAFETY: no other thread reads the environment.
            unsafe { std::env::remove_var(NODES) };
            write(&folder, rows, precision, job);
            let alone = read(&folder, job);
            for per_node in [1, 2, 3, job.size()] {
                // SAFETY: as above.
                unsafe { std::env::set_var(NODES, per_node.to_string()) };
                write(&folder, rows, precision, job);
                assert!(read(&folder, job) == alone, "{rows:?} {precision:?}, nodes of {per_node}");
            }
        }
        job.world().barrier();
        if rank(job) == 0 {
            std::fs::remove_dir_all(&folder).unwrap();
        }
    });
}
