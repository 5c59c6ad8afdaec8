//! Who writes what all ranks have a share of.
//!
//! On few ranks each writes its own rows. On many, the first rank of each node writes those of its node, which the others send to it: thousands
//! of writers with small pieces would wait for each other's locks of the file system, and collective transfers of Open MPI 4.1 hang on a full disk, as the
//! ranks that write leave and the others wait for them. Only compressed arrays, which know no other way, and blocks of grids on many ranks, which are
//! small pieces wherever they are, take such transfers.

use crate::collective::{Part, Participants, write_part, write_rows};
use crate::error::Shared;
use hdf5::{Dataset, H5Type};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, Destination, Equivalence, Source};

/// Bytes that the first rank of a node gathers before it writes them.
const GATHERED: usize = 16 << 20;
/// Values of a message.
const MESSAGE: usize = 1 << 20;

/// A number of an array.
pub(crate) trait Number: H5Type + Equivalence + Default + Clone {}

impl<T: H5Type + Equivalence + Default + Clone> Number for T {}

impl Shared {
    /// Writes this rank's rows of an array of `width` values per row, from row `first` on; all ranks take part.
    ///
    /// # Errors
    /// What HDF5 says, on the rank that writes.
    pub fn write_rows<T: Number>(
        &self,
        dataset: &Dataset,
        (first, width): (usize, usize),
        values: &[T],
    ) -> hdf5::Result<()> {
        match &self.node {
            _ if is_compressed(dataset) => write_rows(dataset, first, width, values, Participants::All),
            None => write_rows(dataset, first, width, values, Participants::ThisRank),
            Some(node) if node.rank() > 0 => {
                send(node, first, values);
                Ok(())
            }
            Some(node) => write_rows_of_node(node, dataset, (first, width), values),
        }
    }

    /// Writes this rank's block of an array; all ranks take part.
    ///
    /// # Errors
    /// What HDF5 says.
    pub fn write_block<T: H5Type>(&self, dataset: &Dataset, block: &Part, values: &[T]) -> hdf5::Result<()> {
        let who = match is_compressed(dataset) || self.node.is_some() {
            true => Participants::All,
            false => Participants::ThisRank,
        };
        write_part(dataset, block, values, who)
    }
}

fn is_compressed(dataset: &Dataset) -> bool {
    !dataset.filters().is_empty()
}

/// Sends rows to the first rank of the node.
fn send<T: Equivalence>(node: &SimpleCommunicator, first: usize, values: &[T]) {
    let writer = node.process_at_rank(0);
    writer.send(&[first as u64, values.len() as u64][..]);
    values.chunks(MESSAGE).for_each(|part| writer.send(part));
}

/// Writes the rows of all ranks of the node, those that follow one another at once.
fn write_rows_of_node<T: Number>(
    node: &SimpleCommunicator,
    dataset: &Dataset,
    (mut first, width): (usize, usize),
    values: &[T],
) -> hdf5::Result<()> {
    let mut gathered = values.to_vec();
    let mut outcome = Ok(());
    // All are taken even after a failure: the other ranks wait in their messages.
    let mut write = |first: usize, gathered: &[T]| {
        if outcome.is_ok() {
            outcome = write_rows(dataset, first, width, gathered, Participants::ThisRank);
        }
    };
    for rank in 1..node.size() {
        let (next, length) = length_from(node, rank);
        let follows = next == first + gathered.len() / width.max(1);
        if !follows || (gathered.len() + length) * size_of::<T>() > GATHERED {
            write(first, &gathered);
            first = next;
            gathered.clear();
        }
        let before = gathered.len();
        gathered.resize_with(before + length, T::default);
        for part in gathered[before..].chunks_mut(MESSAGE) {
            node.process_at_rank(rank).receive_into(part);
        }
    }
    write(first, &gathered);
    outcome
}

/// First row and number of values that a rank of the node sends.
fn length_from(node: &SimpleCommunicator, rank: i32) -> (usize, usize) {
    let mut head = [0_u64; 2];
    node.process_at_rank(rank).receive_into(&mut head[..]);
    (head[0] as usize, head[1] as usize)
}
