//! Requests prepared once for messages of fixed lengths that are exchanged again and again.

#![allow(unsafe_code)] // rsmpi has no persistent requests

use crate::count::count;
use grains_domain::Channel;
use mpi::ffi;
use mpi::topology::SimpleCommunicator;
use mpi::traits::AsRaw;
use std::mem::MaybeUninit;

const TAG_CHANNEL: i32 = 3;

/// Persistent requests for the buffers of a channel.
pub(crate) struct Persistent {
    /// Those that receive come first.
    requests: Vec<ffi::MPI_Request>,
    receives: usize,
    /// How many of them are under way, from the first on.
    running: usize,
    /// Requests that send the heads of messages.
    heads: Vec<ffi::MPI_Request>,
}

impl Persistent {
    /// Prepares what is exchanged with each peer; empty messages are left out on either side.
    pub(crate) fn new(
        peers: &[usize],
        sent: &[Vec<f64>],
        received: &mut [Vec<f64>],
        communicator: &SimpleCommunicator,
    ) -> Self {
        let mut requests = Vec::new();
        for (&peer, buffer) in peers.iter().zip(received).filter(|(_, buffer)| !buffer.is_empty()) {
            let mut request = MaybeUninit::uninit();
            // SAFETY: the channel owns the buffer, keeps it in place, and drops this request first.
            unsafe {
                ffi::MPI_Recv_init(
                    buffer.as_mut_ptr().cast(),
                    count(buffer.len()),
                    ffi::RSMPI_DOUBLE,
                    peer as i32,
                    TAG_CHANNEL,
                    communicator.as_raw(),
                    request.as_mut_ptr(),
                );
                requests.push(request.assume_init());
            }
        }
        let receives = requests.len();
        for (&peer, buffer) in peers.iter().zip(sent).filter(|(_, buffer)| !buffer.is_empty()) {
            let mut request = MaybeUninit::uninit();
            // SAFETY: as above.
            unsafe {
                ffi::MPI_Send_init(
                    buffer.as_ptr().cast(),
                    count(buffer.len()),
                    ffi::RSMPI_DOUBLE,
                    peer as i32,
                    TAG_CHANNEL,
                    communicator.as_raw(),
                    request.as_mut_ptr(),
                );
                requests.push(request.assume_init());
            }
        }
        Self { requests, receives, running: 0, heads: Vec::new() }
    }

    pub(crate) fn start(&mut self) {
        self.start_first(self.requests.len());
    }

    /// Receives what the channel does, and sends the first `length` numbers of its messages: what receives them may be longer.
    pub(crate) fn start_heads(
        &mut self,
        (peers, sent): (&[usize], &[Vec<f64>]),
        length: usize,
        communicator: &SimpleCommunicator,
    ) {
        self.start_first(self.receives);
        for (&peer, buffer) in peers.iter().zip(sent).filter(|(_, buffer)| !buffer.is_empty()) {
            let (head, mut request) = (&buffer[..length.min(buffer.len())], MaybeUninit::uninit());
            // SAFETY: the channel owns the buffer and does not touch it before `finish` has completed the request.
            unsafe {
                ffi::MPI_Isend(
                    head.as_ptr().cast(),
                    count(head.len()),
                    ffi::RSMPI_DOUBLE,
                    peer as i32,
                    TAG_CHANNEL,
                    communicator.as_raw(),
                    request.as_mut_ptr(),
                );
                self.heads.push(request.assume_init());
            }
        }
    }

    fn start_first(&mut self, number: usize) {
        // SAFETY: the requests are persistent and not active.
        unsafe {
            ffi::MPI_Startall(count(number), self.requests.as_mut_ptr());
        }
        self.running = number;
    }

    /// Lets messages go on: MPI carries long ones on only while it is called.
    pub(crate) fn advance(&mut self) {
        let mut is_done = 0;
        // SAFETY: as for `finish`, which may follow whether or not this completes the requests.
        unsafe {
            ffi::MPI_Testall(
                count(self.running),
                self.requests.as_mut_ptr(),
                &mut is_done,
                ffi::RSMPI_STATUSES_IGNORE,
            );
        }
    }

    pub(crate) fn finish(&mut self) {
        // SAFETY: the requests are active; persistent ones stay valid.
        unsafe {
            ffi::MPI_Waitall(count(self.running), self.requests.as_mut_ptr(), ffi::RSMPI_STATUSES_IGNORE);
            ffi::MPI_Waitall(count(self.heads.len()), self.heads.as_mut_ptr(), ffi::RSMPI_STATUSES_IGNORE);
        }
        self.running = 0;
        self.heads.clear();
    }
}

impl Drop for Persistent {
    fn drop(&mut self) {
        if self.running > 0 || !self.heads.is_empty() {
            self.finish();
        }
        for request in &mut self.requests {
            // SAFETY: each request was made once and is freed once.
            unsafe {
                ffi::MPI_Request_free(request);
            }
        }
    }
}

/// The requests of a channel.
pub(crate) fn prepared_in(channel: &mut Channel) -> Option<&mut Persistent> {
    channel.parts().prepared.as_mut()?.downcast_mut()
}
