//! The communicator of a rank's neighbourhood.

#![allow(unsafe_code)] // rsmpi has no graph topologies

use crate::count::count;
use mpi::ffi;
use mpi::topology::SimpleCommunicator;
use mpi::traits::AsRaw;
use std::mem::MaybeUninit;

/// A communicator that knows whose neighbour this rank is, for neighbourhood collectives.
pub(crate) struct Graph {
    pub(crate) peers: Vec<usize>,
    pub(crate) communicator: ffi::MPI_Comm,
}

impl Graph {
    /// The neighbourhood of ranks that all name each other; collective.
    pub(crate) fn new(peers: &[usize], communicator: &SimpleCommunicator) -> Self {
        let list: Vec<i32> = peers.iter().map(|&peer| peer as i32).collect();
        let (count, weights) = (count(list.len()), vec![1; list.len()]);
        let mut graph = MaybeUninit::uninit();
        // SAFETY: the arrays have `count` entries and are only read; MPI fills the communicator.
        let communicator = unsafe {
            ffi::MPI_Dist_graph_create_adjacent(
                communicator.as_raw(),
                count,
                list.as_ptr(),
                weights.as_ptr(),
                count,
                list.as_ptr(),
                weights.as_ptr(),
                ffi::RSMPI_INFO_NULL,
                0,
                graph.as_mut_ptr(),
            );
            graph.assume_init()
        };
        Self { peers: peers.to_vec(), communicator }
    }
}

impl Drop for Graph {
    fn drop(&mut self) {
        // SAFETY: the communicator was made once and is freed once, while MPI runs.
        unsafe {
            ffi::MPI_Comm_free(&mut self.communicator);
        }
    }
}
