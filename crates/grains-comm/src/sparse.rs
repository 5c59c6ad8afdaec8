//! Messages among ranks that do not know who sends to them: the non-blocking consensus of Hoefler, Siebert & Lumsdaine
//! (2010, "Scalable communication protocols for dynamic sparse data exchange").
//!
//! A rank that knows all its messages to have been taken (synchronous sends tell) enters a barrier without waiting in
//! it; once all ranks have entered, no message is under way any more. Time and memory grow with the own messages and
//! the logarithm of the number of ranks.

#![allow(unsafe_code)] // rsmpi has no synchronous sends without its request scopes, and no non-blocking probe of a message

use crate::count::count;
use mpi::ffi;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, Communicator};
use std::cell::Cell;
use std::mem::MaybeUninit;

/// Tags of the exchanges, which no other messages may have, in turns: a rank that has left an exchange may send for the
/// next one while others still look for messages of this one. It cannot be two ahead, as all must have entered its next
/// barrier before.
const TAGS: [i32; 2] = [8, 9];

/// The exchanges of a communicator.
#[derive(Default)]
pub(crate) struct SparseExchange {
    done: Cell<usize>,
}

impl SparseExchange {
    /// Sends messages, (rank, message), and returns those sent here by rank of the sender; all ranks take part.
    pub fn exchange(
        &self,
        communicator: &SimpleCommunicator,
        sent: Vec<(usize, Vec<f64>)>,
    ) -> Vec<(usize, Vec<f64>)> {
        let tag = TAGS[self.done.get() % 2];
        self.done.set(self.done.get() + 1);
        let sent = sent.into_iter().filter(|(_, message)| !message.is_empty());
        let own = communicator.rank() as usize;
        let (mut received, sent): (Vec<_>, Vec<_>) = sent.partition(|(rank, _)| *rank == own);
        let mut sends: Vec<_> =
            sent.iter().map(|(rank, message)| send(communicator, *rank, tag, message)).collect();
        while !are_taken(&mut sends) {
            received.extend(probe(communicator, tag));
        }
        let mut barrier = enter_barrier(communicator);
        while !is_complete(&mut barrier) {
            received.extend(probe(communicator, tag));
        }
        received.sort_by_key(|(rank, _)| *rank);
        received
    }
}

/// Begins a send that is complete when the receiver has taken the message.
fn send(communicator: &SimpleCommunicator, rank: usize, tag: i32, message: &[f64]) -> ffi::MPI_Request {
    let mut request = MaybeUninit::uninit();
    // SAFETY: the message is neither moved nor dropped before `exchange` has seen the request complete; MPI fills the
    // request.
    unsafe {
        ffi::MPI_Issend(
            message.as_ptr().cast(),
            count(message.len()),
            ffi::RSMPI_DOUBLE,
            rank as i32,
            tag,
            communicator.as_raw(),
            request.as_mut_ptr(),
        );
        request.assume_init()
    }
}

/// The next message that has arrived, if any, and its sender.
fn probe(communicator: &SimpleCommunicator, tag: i32) -> Option<(usize, Vec<f64>)> {
    let (mut message, mut status) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    let (mut is_there, mut length) = (0, 0);
    // SAFETY: message and status are read only if there is a message, when MPI has filled both; the matched message is
    // received once, into a buffer of just its length.
    unsafe {
        ffi::MPI_Improbe(
            ffi::RSMPI_ANY_SOURCE,
            tag,
            communicator.as_raw(),
            &mut is_there,
            message.as_mut_ptr(),
            status.as_mut_ptr(),
        );
        if is_there == 0 {
            return None;
        }
        ffi::MPI_Get_count(status.as_ptr(), ffi::RSMPI_DOUBLE, &mut length);
        let sender = (*status.as_ptr()).MPI_SOURCE as usize;
        let mut buffer = vec![0.0_f64; length as usize];
        ffi::MPI_Mrecv(
            buffer.as_mut_ptr().cast(),
            length,
            ffi::RSMPI_DOUBLE,
            message.as_mut_ptr(),
            status.as_mut_ptr(),
        );
        Some((sender, buffer))
    }
}

fn are_taken(sends: &mut [ffi::MPI_Request]) -> bool {
    let mut flag = 0;
    // SAFETY: the requests are those of this rank; MPI sets complete ones to null, which it may be given again.
    unsafe {
        ffi::MPI_Testall(count(sends.len()), sends.as_mut_ptr(), &mut flag, ffi::RSMPI_STATUSES_IGNORE);
    }
    flag != 0
}

fn enter_barrier(communicator: &SimpleCommunicator) -> ffi::MPI_Request {
    let mut request = MaybeUninit::uninit();
    // SAFETY: MPI fills the request.
    unsafe {
        ffi::MPI_Ibarrier(communicator.as_raw(), request.as_mut_ptr());
        request.assume_init()
    }
}

fn is_complete(barrier: &mut ffi::MPI_Request) -> bool {
    let mut flag = 0;
    // SAFETY: the request is that of this rank's barrier, tested until it is complete.
    unsafe {
        ffi::MPI_Test(barrier, &mut flag, ffi::RSMPI_STATUS_IGNORE);
    }
    flag != 0
}
