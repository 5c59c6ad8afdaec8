//! The messages of the solver: non-blocking, one per peer, no allocation once the buffers have grown.

#![allow(unsafe_code)] // raw non-blocking calls: rsmpi's request collections allocate at every use

use grains_domain::Transport;
use mpi::collective::SystemOperation;
use mpi::ffi;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, Communicator, CommunicatorCollectives};
use std::cell::RefCell;
use std::mem::MaybeUninit;

const TAG_SIZED: i32 = 1;
const TAG_UNSIZED: i32 = 2;

/// [`Transport`] over an MPI communicator.
pub struct MpiTransport {
    communicator: SimpleCommunicator,
    requests: RefCell<Vec<ffi::MPI_Request>>,
}

impl MpiTransport {
    /// Transport among the ranks of a communicator.
    pub fn new(communicator: SimpleCommunicator) -> Self {
        Self { communicator, requests: RefCell::new(Vec::new()) }
    }

    /// The communicator.
    pub fn communicator(&self) -> &SimpleCommunicator {
        &self.communicator
    }

    fn post_send(&self, peer: usize, tag: i32, message: &[f64], requests: &mut Vec<ffi::MPI_Request>) {
        let mut request = MaybeUninit::uninit();
        // SAFETY: the message outlives the request, which `wait` completes before the caller returns;
        // MPI fills the request.
        unsafe {
            ffi::MPI_Isend(
                message.as_ptr().cast(),
                message.len() as i32,
                ffi::RSMPI_DOUBLE,
                peer as i32,
                tag,
                self.communicator.as_raw(),
                request.as_mut_ptr(),
            );
            requests.push(request.assume_init());
        }
    }

    fn wait(requests: &mut Vec<ffi::MPI_Request>) {
        // SAFETY: all requests were started by this rank and are completed here once.
        unsafe {
            ffi::MPI_Waitall(requests.len() as i32, requests.as_mut_ptr(), ffi::RSMPI_STATUSES_IGNORE);
        }
        requests.clear();
    }
}

impl Transport for MpiTransport {
    fn rank(&self) -> usize {
        self.communicator.rank() as usize
    }

    fn size(&self) -> usize {
        self.communicator.size() as usize
    }

    fn exchange(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]) {
        let mut requests = self.requests.borrow_mut();
        for (&peer, buffer) in peers.iter().zip(received.iter_mut()) {
            let mut request = MaybeUninit::uninit();
            // SAFETY: the buffer is borrowed mutably until `wait` has completed the request.
            unsafe {
                ffi::MPI_Irecv(
                    buffer.as_mut_ptr().cast(),
                    buffer.len() as i32,
                    ffi::RSMPI_DOUBLE,
                    peer as i32,
                    TAG_SIZED,
                    self.communicator.as_raw(),
                    request.as_mut_ptr(),
                );
                requests.push(request.assume_init());
            }
        }
        for (&peer, message) in peers.iter().zip(sent) {
            self.post_send(peer, TAG_SIZED, message, &mut requests);
        }
        Self::wait(&mut requests);
    }

    fn exchange_unsized(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]) {
        let mut requests = self.requests.borrow_mut();
        for (&peer, message) in peers.iter().zip(sent) {
            self.post_send(peer, TAG_UNSIZED, message, &mut requests);
        }
        for (&peer, buffer) in peers.iter().zip(received.iter_mut()) {
            // SAFETY: the matched message is received once, into a buffer of just its length.
            unsafe {
                let (mut message, mut status) = (MaybeUninit::uninit(), MaybeUninit::uninit());
                ffi::MPI_Mprobe(
                    peer as i32,
                    TAG_UNSIZED,
                    self.communicator.as_raw(),
                    message.as_mut_ptr(),
                    status.as_mut_ptr(),
                );
                let mut count = 0;
                ffi::MPI_Get_count(status.as_ptr(), ffi::RSMPI_DOUBLE, &mut count);
                buffer.resize(count as usize, 0.0);
                ffi::MPI_Mrecv(
                    buffer.as_mut_ptr().cast(),
                    count,
                    ffi::RSMPI_DOUBLE,
                    message.as_mut_ptr(),
                    status.as_mut_ptr(),
                );
            }
        }
        Self::wait(&mut requests);
    }

    fn all_to_all(&self, sent: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let own = self.rank();
        let lengths: Vec<i64> = sent.iter().map(|s| s.len() as i64).collect();
        let mut expected = vec![0_i64; lengths.len()];
        self.communicator.all_to_all_into(&lengths[..], &mut expected[..]);
        let peers: Vec<usize> =
            (0..self.size()).filter(|&r| r != own && (lengths[r] > 0 || expected[r] > 0)).collect();
        let outgoing: Vec<Vec<f64>> = peers.iter().map(|&r| sent[r].clone()).collect();
        let mut incoming: Vec<Vec<f64>> = peers.iter().map(|&r| vec![0.0; expected[r] as usize]).collect();
        self.exchange(&peers, &outgoing, &mut incoming);
        let mut received = vec![Vec::new(); self.size()];
        received[own] = sent[own].clone();
        for (&peer, message) in peers.iter().zip(incoming) {
            received[peer] = message;
        }
        received
    }

    fn highest(&self, level: u8) -> u8 {
        let mut highest = 0_u8;
        self.communicator.all_reduce_into(&level, &mut highest, SystemOperation::max());
        highest
    }

    fn max(&self, values: &mut [f64]) {
        let own = values.to_vec();
        self.communicator.all_reduce_into(&own[..], values, SystemOperation::max());
    }

    fn sum(&self, values: &mut [f64]) {
        let own = values.to_vec();
        self.communicator.all_reduce_into(&own[..], values, SystemOperation::sum());
    }

    fn sum_counts(&self, values: &mut [u64]) {
        let own = values.to_vec();
        self.communicator.all_reduce_into(&own[..], values, SystemOperation::sum());
    }

    fn gather(&self, values: &[f64]) -> Vec<f64> {
        self.all_to_all(&vec![values.to_vec(); self.size()]).concat()
    }
}
