//! What keeps clones up to date between two sortings: the strategies of the thesis (ch. 5, section 3) and ours.
//!
//! All of them end in the same bits. They differ in how many messages of what length are sent to whom:
//!
//! | strategy | message | to | by |
//! | --- | --- | --- | --- |
//! | all-gather, global | all buffer particles | every rank | one collective |
//! | all-gather, local | all buffer particles | neighbours | neighbourhood collective |
//! | the same, non-blocking | all buffer particles | neighbours | sends that do not wait, probes |
//! | GEOLOC | what the neighbour needs | neighbours | sends that do not wait, probes |
//! | persistent | what the neighbour needs | neighbours | requests prepared once per sorting |
//!
//! Persistent requests are started before the contacts and waited for after those that need no clone.

use crate::Particles;
use crate::dem::bytes;
use crate::exchange::Link;
use crate::record::{read_motion, read_orientation};
use grains_domain::{Channel, Transport};
use grains_geometry::Vec3;
use std::ops::Range;
use std::time::Instant;

/// How clones are brought up to date in every step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExchangeStrategy {
    /// Everything to everybody (AllGatherGlobal).
    AllGatherGlobal,
    /// Everything to the neighbours (AllGatherLocal).
    AllGatherLocal,
    /// The same by non-blocking sends.
    AllGatherLocalNonblocking,
    /// To each neighbour what it needs (SendRecv_Local_Geoloc).
    SendRecvLocalGeoloc,
    /// The same by persistent requests, while contacts without clones are worked on.
    #[default]
    Persistent,
}

/// What updates of clones cost one rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Updates since the start.
    pub updates: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
    /// Time (s) in which nothing else was done.
    pub wait: f64,
}

/// Where the news of a clone stand in a message about all buffer particles of its owner, and its shift (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    pub(crate) slot: u32,
    pub(crate) shift: Vec3,
}

/// The updates of one rank's clones until they are made anew.
#[derive(Debug, Default)]
pub(crate) struct Updates {
    pub(crate) strategy: ExchangeStrategy,
    pub(crate) traffic: Traffic,
    /// Neighbour ranks other than the own one, ascending.
    peers: Vec<usize>,
    /// Owned particles that other ranks have clones of.
    pub(crate) buffer: Vec<u32>,
    /// Per peer, the clones its messages fill, in order.
    pub(crate) filled: Vec<Range<usize>>,
    /// Per peer, where they stand if it tells of all its buffer particles.
    pub(crate) origins: Vec<Vec<Origin>>,
    /// Numbers that tell of a clone.
    length: usize,
    channel: Channel,
    /// The message about all buffer particles.
    own: Vec<f64>,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
    is_pending: bool,
}

impl Updates {
    pub(crate) fn new(peers: &[usize], strategy: ExchangeStrategy) -> Self {
        let buffers = vec![Vec::new(); peers.len()];
        Self {
            strategy,
            peers: peers.to_vec(),
            filled: vec![0..0; peers.len()],
            origins: vec![Vec::new(); peers.len()],
            sent: buffers.clone(),
            received: buffers,
            ..Self::default()
        }
    }

    /// Whether messages tell of all buffer particles and not of those the receiver needs.
    pub(crate) fn gathers(&self) -> bool {
        !matches!(self.strategy, ExchangeStrategy::SendRecvLocalGeoloc | ExchangeStrategy::Persistent)
    }

    /// Prepares the messages for the clones just made.
    pub(crate) fn prepare(&mut self, links: &[Link], length: usize, transport: &impl Transport) {
        self.length = length;
        let sent: Vec<usize> = self.peers.iter().map(|&peer| length * sent_to(links, peer).count()).collect();
        match self.strategy {
            ExchangeStrategy::Persistent => {
                let filled: Vec<usize> = self.filled.iter().map(|clones| length * clones.len()).collect();
                self.channel = Channel::new(&self.peers, &sent, &filled);
                transport.prepare(&mut self.channel);
            }
            ExchangeStrategy::SendRecvLocalGeoloc => {
                self.sent.iter_mut().zip(sent).for_each(|(message, n)| message.resize(n, 0.0));
            }
            _ => self.own.resize(1 + length * self.buffer.len(), 0.0),
        }
    }

    /// Sends off what neighbours need, if the strategy can do so before it must wait.
    pub(crate) fn start(&mut self, links: &[Link], particles: &Particles, transport: &impl Transport) {
        self.traffic.updates += 1;
        self.is_pending = true;
        if self.strategy == ExchangeStrategy::Persistent {
            for (k, &peer) in self.peers.iter().enumerate() {
                fill(self.channel.outgoing(k), self.length, particles, sent_to(links, peer));
            }
            transport.start(&mut self.channel);
            self.count(self.channel.messages_sent(), self.channel.numbers_sent());
        }
    }

    /// Waits for the news of all clones from other ranks, and takes them.
    pub(crate) fn finish(&mut self, links: &[Link], particles: &mut Particles, transport: &impl Transport) {
        if !std::mem::take(&mut self.is_pending) {
            return;
        }
        match self.strategy {
            ExchangeStrategy::Persistent => {
                self.timed(|updates| transport.finish(&mut updates.channel));
                for (k, clones) in self.filled.iter().enumerate() {
                    let records = self.channel.incoming(k).chunks_exact(self.length);
                    records.zip(clones.clone()).for_each(|(record, clone)| take(particles, clone, record));
                }
            }
            ExchangeStrategy::SendRecvLocalGeoloc => {
                for (message, &peer) in self.sent.iter_mut().zip(&self.peers) {
                    fill(message, self.length, particles, sent_to(links, peer));
                }
                self.count(self.sent.len(), self.sent.iter().map(Vec::len).sum());
                self.timed(|u| transport.exchange_unsized(&u.peers, &u.sent, &mut u.received));
                for (message, clones) in self.received.iter().zip(&self.filled) {
                    let records = message.chunks_exact(self.length);
                    records.zip(clones.clone()).for_each(|(record, clone)| take(particles, clone, record));
                }
            }
            _ => self.gather(particles, transport),
        }
    }

    /// The strategies that tell of all buffer particles; a message begins with its length.
    fn gather(&mut self, particles: &mut Particles, transport: &impl Transport) {
        self.own[0] = self.own.len() as f64;
        fill(&mut self.own[1..], self.length, particles, self.buffer.iter().map(|&i| (i, Vec3::zeros())));
        let mut receivers = self.peers.len();
        match self.strategy {
            ExchangeStrategy::AllGatherGlobal => {
                receivers = transport.size() - 1;
                let mut all = Vec::new();
                self.timed(|u| all = transport.gather(&u.own));
                let (mut rest, mut rank) = (&all[..], 0);
                while let Some(&length) = rest.first() {
                    let (message, after) = rest.split_at(length as usize);
                    if let Ok(k) = self.peers.binary_search(&rank) {
                        self.pick(k, message, particles);
                    }
                    (rest, rank) = (after, rank + 1);
                }
            }
            ExchangeStrategy::AllGatherLocal => {
                self.timed(|u| transport.gather_near(&u.peers, &u.own, &mut u.received));
            }
            _ => {
                let Self { sent, own, .. } = self;
                sent.iter_mut().for_each(|message| message.clone_from(own));
                self.timed(|u| transport.exchange_unsized(&u.peers, &u.sent, &mut u.received));
            }
        }
        self.count(receivers, receivers * self.own.len());
        if self.strategy != ExchangeStrategy::AllGatherGlobal {
            (0..self.peers.len()).for_each(|k| self.pick(k, &self.received[k], particles));
        }
    }

    /// Takes the news of the clones of peer `k` out of those of all its buffer particles.
    fn pick(&self, k: usize, message: &[f64], particles: &mut Particles) {
        for (origin, clone) in self.origins[k].iter().zip(self.filled[k].clone()) {
            let at = 1 + origin.slot as usize * self.length;
            let mut record = [0.0; LONGEST];
            record[..self.length].copy_from_slice(&message[at..at + self.length]);
            (0..3).for_each(|a| record[a] += origin.shift[a]);
            take(particles, clone, &record[..self.length]);
        }
    }

    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let messages = self.sent.iter().chain(&self.received).map(bytes).sum::<usize>() + bytes(&self.own);
        let origins = self.origins.iter().map(bytes).sum::<usize>() + bytes(&self.buffer);
        messages + origins + 8 * self.channel.numbers_held()
    }

    fn count(&mut self, messages: usize, numbers: usize) {
        self.traffic.messages += messages as u64;
        self.traffic.bytes += 8 * numbers as u64;
    }

    fn timed(&mut self, wait: impl FnOnce(&mut Self)) {
        let begun = Instant::now();
        wait(self);
        self.traffic.wait += begun.elapsed().as_secs_f64();
    }
}

/// Most numbers that tell of a clone: position, velocity, angular velocity, orientation.
const LONGEST: usize = 13;

/// Numbers that tell of a clone.
pub(crate) fn record_length(particles: &Particles) -> usize {
    if particles.turns() { LONGEST } else { 9 }
}

/// Owned particles that a peer has clones of, and the shifts (m) of these.
fn sent_to(links: &[Link], peer: usize) -> impl Iterator<Item = (u32, Vec3)> {
    let links = links.iter().filter(move |link| link.rank == peer);
    links.flat_map(|link| link.sent.iter().map(|&i| (i, link.shift)))
}

/// Writes the news of particles into a message.
fn fill(message: &mut [f64], length: usize, particles: &Particles, whom: impl Iterator<Item = (u32, Vec3)>) {
    for (record, (i, shift)) in message.chunks_exact_mut(length).zip(whom) {
        let i = i as usize;
        let body = &particles.bodies[i];
        record[..3].copy_from_slice((body.position + shift).as_slice());
        record[3..6].copy_from_slice(body.velocity.as_slice());
        record[6..9].copy_from_slice(body.angular_velocity.as_slice());
        if length == LONGEST {
            let q = particles.orientations[i].quaternion();
            record[9..].copy_from_slice(&[q.w, q.i, q.j, q.k]);
        }
    }
}

/// Takes the news of a clone.
#[inline]
fn take(particles: &mut Particles, clone: usize, record: &[f64]) {
    let before = particles.bodies[clone].position;
    read_motion(&mut particles.bodies[clone], record);
    if record.len() == LONGEST {
        particles.turn_to(clone, &before, read_orientation(&record[9..]));
    }
}
