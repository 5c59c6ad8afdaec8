//! The messages of the solver: non-blocking, one per peer; those of a step allocate nothing once they have been prepared.

#![allow(unsafe_code)] // raw non-blocking calls: rsmpi's request collections allocate at every use

use crate::count::count;
use crate::graph::Graph;
use crate::persistent::{Persistent, prepared_in};
use crate::reductions::Reductions;
use crate::sparse::SparseExchange;
use grains_domain::{Channel, ChannelParts, Transport};
use mpi::collective::SystemOperation;
use mpi::datatype::PartitionMut;
use mpi::ffi;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, Communicator, CommunicatorCollectives};
use std::cell::RefCell;
use std::mem::MaybeUninit;

const TAG_SIZED: i32 = 1;
const TAG_UNSIZED: i32 = 2;

/// [`Transport`] over an MPI communicator.
pub struct MpiTransport {
    /// Dropped, and so completed, before the communicator.
    reductions: RefCell<Reductions>,
    communicator: SimpleCommunicator,
    requests: RefCell<Vec<ffi::MPI_Request>>,
    sparse: SparseExchange,
    /// The graph of [`Transport::gather_near`].
    near: RefCell<Option<Graph>>,
}

impl MpiTransport {
    /// Transport among the ranks of a communicator, which no other transport may use: their messages could mix.
    pub fn new(communicator: SimpleCommunicator) -> Self {
        let sparse = SparseExchange::default();
        Self {
            reductions: RefCell::default(),
            communicator,
            requests: RefCell::default(),
            sparse,
            near: RefCell::default(),
        }
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
                count(message.len()),
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
            ffi::MPI_Waitall(count(requests.len()), requests.as_mut_ptr(), ffi::RSMPI_STATUSES_IGNORE);
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
        for (&peer, buffer) in peers.iter().zip(received.iter_mut()).filter(|(_, buffer)| !buffer.is_empty())
        {
            let mut request = MaybeUninit::uninit();
            // SAFETY: the buffer is borrowed mutably until `wait` has completed the request.
            unsafe {
                ffi::MPI_Irecv(
                    buffer.as_mut_ptr().cast(),
                    count(buffer.len()),
                    ffi::RSMPI_DOUBLE,
                    peer as i32,
                    TAG_SIZED,
                    self.communicator.as_raw(),
                    request.as_mut_ptr(),
                );
                requests.push(request.assume_init());
            }
        }
        for (&peer, message) in peers.iter().zip(sent).filter(|(_, message)| !message.is_empty()) {
            self.post_send(peer, TAG_SIZED, message, &mut requests);
        }
        Self::wait(&mut requests);
    }

    fn prepare(&self, channel: &mut Channel) {
        let ChannelParts { peers, sent, received, prepared } = channel.parts();
        *prepared = Some(Box::new(Persistent::new(peers, sent, received, &self.communicator)));
    }

    fn start(&self, channel: &mut Channel) {
        channel.set_open(true);
        if let Some(persistent) = prepared_in(channel) {
            persistent.start();
        }
    }

    fn start_heads(&self, channel: &mut Channel, length: usize) {
        channel.set_open(true);
        let ChannelParts { peers, sent, prepared, .. } = channel.parts();
        if let Some(persistent) = prepared.as_mut().and_then(|prepared| prepared.downcast_mut::<Persistent>())
        {
            persistent.start_heads((peers, sent), length, &self.communicator);
        }
    }

    fn advance(&self, channel: &mut Channel) {
        if let Some(persistent) = prepared_in(channel) {
            persistent.advance();
        }
    }

    fn finish(&self, channel: &mut Channel) {
        if let Some(persistent) = prepared_in(channel) {
            persistent.finish();
        }
        channel.set_open(false);
    }

    fn gather_near(&self, peers: &[usize], own: &[f64], received: &mut [Vec<f64>]) {
        let mut near = self.near.borrow_mut();
        let graph = match near.take() {
            Some(graph) if graph.peers == peers => graph,
            _ => Graph::new(peers, &self.communicator),
        };
        let length = count(own.len());
        let (mut lengths, mut starts) = (vec![0_i32; peers.len()], vec![0_i32; peers.len()]);
        // SAFETY: one length comes from each peer.
        unsafe {
            ffi::MPI_Neighbor_allgather(
                (&raw const length).cast(),
                1,
                ffi::RSMPI_INT32_T,
                lengths.as_mut_ptr().cast(),
                1,
                ffi::RSMPI_INT32_T,
                graph.communicator,
            );
        }
        let mut all = 0;
        for (start, &length) in starts.iter_mut().zip(&lengths) {
            *start = count(all);
            all += length as usize;
        }
        let mut gathered = vec![0.0_f64; all];
        // SAFETY: `gathered` has room for all messages at their starts.
        unsafe {
            ffi::MPI_Neighbor_allgatherv(
                own.as_ptr().cast(),
                length,
                ffi::RSMPI_DOUBLE,
                gathered.as_mut_ptr().cast(),
                lengths.as_ptr(),
                starts.as_ptr(),
                ffi::RSMPI_DOUBLE,
                graph.communicator,
            );
        }
        for ((message, &start), &length) in received.iter_mut().zip(&starts).zip(&lengths) {
            message.clear();
            message.extend_from_slice(&gathered[start as usize..(start + length) as usize]);
        }
        *near = Some(graph);
    }

    fn send_and_receive(
        &self,
        (receivers, sent): (&[usize], &[Vec<f64>]),
        (senders, received): (&[usize], &mut [Vec<f64>]),
    ) {
        let mut requests = self.requests.borrow_mut();
        for (&peer, message) in receivers.iter().zip(sent) {
            self.post_send(peer, TAG_UNSIZED, message, &mut requests);
        }
        for (&peer, buffer) in senders.iter().zip(received) {
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
                let mut length = 0;
                ffi::MPI_Get_count(status.as_ptr(), ffi::RSMPI_DOUBLE, &mut length);
                buffer.resize(length as usize, 0.0);
                ffi::MPI_Mrecv(
                    buffer.as_mut_ptr().cast(),
                    length,
                    ffi::RSMPI_DOUBLE,
                    message.as_mut_ptr(),
                    status.as_mut_ptr(),
                );
            }
        }
        Self::wait(&mut requests);
    }

    fn exchange_sparse(&self, sent: Vec<(usize, Vec<f64>)>) -> Vec<(usize, Vec<f64>)> {
        self.sparse.exchange(&self.communicator, sent)
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

    fn begin_max(&self, values: &[f64]) {
        self.reductions.borrow_mut().begin_max(values, &self.communicator);
    }

    fn end_max(&self, values: &mut [f64]) {
        self.reductions.borrow_mut().end(values);
    }

    fn sum(&self, values: &mut [f64]) {
        let own = values.to_vec();
        self.communicator.all_reduce_into(&own[..], values, SystemOperation::sum());
    }

    fn sum_counts(&self, values: &mut [u64]) {
        let own = values.to_vec();
        self.communicator.all_reduce_into(&own[..], values, SystemOperation::sum());
    }

    fn counts_before(&self, values: &mut [u64]) {
        let own = values.to_vec();
        values.fill(0);
        self.communicator.exclusive_scan_into(&own[..], values, SystemOperation::sum());
        if self.rank() == 0 {
            // MPI leaves the answer of the first rank open.
            values.fill(0);
        }
    }

    fn gather(&self, values: &[f64]) -> Vec<f64> {
        let mut counts = vec![0_i32; self.size()];
        self.communicator.all_gather_into(&count(values.len()), &mut counts[..]);
        let total: usize = counts.iter().map(|&count| count as usize).sum();
        let _ = count(total);
        let mut starts = vec![0_i32; counts.len()];
        (1..counts.len()).for_each(|rank| starts[rank] = starts[rank - 1] + counts[rank - 1]);
        let mut all = vec![0.0; total];
        self.communicator
            .all_gather_varcount_into(values, &mut PartitionMut::new(&mut all[..], &counts[..], &starts[..]));
        all
    }
}
