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
    requests: Vec<ffi::MPI_Request>,
    is_running: bool,
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
        Self { requests, is_running: false }
    }

    pub(crate) fn start(&mut self) {
        // SAFETY: the requests are persistent and not active.
        unsafe {
            ffi::MPI_Startall(count(self.requests.len()), self.requests.as_mut_ptr());
        }
        self.is_running = true;
    }

    pub(crate) fn finish(&mut self) {
        // SAFETY: the requests are active; persistent ones stay valid.
        unsafe {
            let (count, requests) = (count(self.requests.len()), self.requests.as_mut_ptr());
            ffi::MPI_Waitall(count, requests, ffi::RSMPI_STATUSES_IGNORE);
        }
        self.is_running = false;
    }
}

impl Drop for Persistent {
    fn drop(&mut self) {
        if self.is_running {
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
