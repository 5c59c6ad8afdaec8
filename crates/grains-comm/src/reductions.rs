//! Reductions that nobody waits for when they begin.

#![allow(unsafe_code)] // rsmpi's requests borrow their buffers from the caller

use crate::count::count;
use mpi::collective::SystemOperation;
use mpi::ffi;
use mpi::topology::SimpleCommunicator;
use mpi::traits::AsRaw;
use std::collections::VecDeque;
use std::mem::MaybeUninit;

/// Reductions under way, in the order in which they were begun.
#[derive(Default)]
pub(crate) struct Reductions {
    running: VecDeque<Reduction>,
    idle: Vec<Reduction>,
}

/// Buffers of a reduction; MPI uses them while it is under way.
struct Reduction {
    request: ffi::MPI_Request,
    own: Vec<f64>,
    largest: Vec<f64>,
}

impl Reductions {
    /// Begins the maximum over the ranks, entry by entry; collective.
    pub(crate) fn begin_max(&mut self, values: &[f64], communicator: &SimpleCommunicator) {
        let (mut own, mut largest) =
            self.idle.pop().map_or_else(Default::default, |idle| (idle.own, idle.largest));
        own.clear();
        own.extend_from_slice(values);
        largest.resize(values.len(), 0.0);
        let mut request = MaybeUninit::uninit();
        // SAFETY: neither buffer is touched, moved in memory or freed before the request is completed in `end` or on drop.
        let request = unsafe {
            ffi::MPI_Iallreduce(
                own.as_ptr().cast(),
                largest.as_mut_ptr().cast(),
                count(own.len()),
                ffi::RSMPI_DOUBLE,
                SystemOperation::max().as_raw(),
                communicator.as_raw(),
                request.as_mut_ptr(),
            );
            request.assume_init()
        };
        self.running.push_back(Reduction { request, own, largest });
    }

    /// Waits for the one that was begun first, if any, and takes what came of it.
    pub(crate) fn end(&mut self, values: &mut [f64]) {
        let Some(mut reduction) = self.running.pop_front() else { return };
        reduction.wait();
        values.copy_from_slice(&reduction.largest);
        self.idle.push(reduction);
    }
}

impl Reduction {
    fn wait(&mut self) {
        // SAFETY: the request was begun once and is completed here once.
        unsafe {
            ffi::MPI_Wait(&mut self.request, ffi::RSMPI_STATUS_IGNORE);
        }
    }
}

impl Drop for Reductions {
    fn drop(&mut self) {
        self.running.iter_mut().for_each(Reduction::wait);
    }
}
