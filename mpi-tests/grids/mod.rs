//! Blocks of a grid and the values on them, the same on any ranks.

#![allow(clippy::unwrap_used, dead_code)] // each test program uses its own part

use grains_comm::Job;
use grains_output::GridBlock;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::fs;
use std::path::{Path, PathBuf};

/// Numbers of ranks of the tests.
pub const RANKS: [usize; 4] = [1, 2, 3, 8];
/// Cells of a grid.
pub const DEEP: [usize; 3] = [5, 6, 9];

/// The own rank.
pub fn rank(job: &Job) -> usize {
    job.world().rank() as usize
}

/// A folder of this test and these ranks, empty.
pub fn folder(job: &Job, test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}-{}", job.size()));
    if rank(job) == 0 {
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
    }
    job.world().barrier();
    path
}

/// This rank's block: x cut in two if the ranks are even, y among the rest; of more than two rows of ranks
/// the first has no cells.
pub fn block(job: &Job, all: [usize; 3]) -> GridBlock {
    let (rank, size) = (rank(job), job.size());
    let columns = if size.is_multiple_of(2) { 2 } else { 1 };
    let cut = |n: usize, k: usize, parts: usize| {
        let empty = usize::from(parts > 2);
        if k == parts { n } else { n * k.saturating_sub(empty) / (parts - empty) }
    };
    let ends = |n, k, parts| (cut(n, k, parts), cut(n, k + 1, parts));
    let (x, y) = (ends(all[0], rank % columns, columns), ends(all[1], rank / columns, size / columns));
    GridBlock { all, first: [x.0, y.0, 0], own: [x.1 - x.0, y.1 - y.0, all[2]] }
}

/// A number for every value of a field, in every place of the grid and every step.
pub fn value(step: usize, place: usize, component: usize) -> f64 {
    (place as f64 * 1.37 + component as f64 * 0.11).sin() + 10.0 * step as f64
}

/// Places in the whole array, in the order of a block's values.
pub fn places(block: &GridBlock) -> Vec<usize> {
    let GridBlock { all, first, own } = *block;
    let mut list = Vec::new();
    for k in first[2]..first[2] + own[2] {
        for j in first[1]..first[1] + own[1] {
            list.extend((first[0]..first[0] + own[0]).map(|i| (k * all[1] + j) * all[0] + i));
        }
    }
    list
}

/// Values of a field of `width` components on a block.
pub fn reals(block: &GridBlock, step: usize, width: usize) -> Vec<f64> {
    places(block).iter().flat_map(|&place| (0..width).map(move |c| value(step, place, c))).collect()
}

/// A text attribute.
pub fn text(object: &hdf5::Location, name: &str) -> String {
    let attribute = object.attr(name).unwrap();
    match attribute.dtype().unwrap().to_descriptor().unwrap() {
        hdf5::types::TypeDescriptor::FixedAscii(length) => {
            let text = attribute.read_scalar::<hdf5::types::FixedAscii<16>>().unwrap().to_string();
            assert_eq!(text.len(), length, "`{name}` is not padded: readers compare its bytes");
            text
        }
        _ => attribute.read_scalar::<hdf5::types::VarLenUnicode>().unwrap().to_string(),
    }
}
