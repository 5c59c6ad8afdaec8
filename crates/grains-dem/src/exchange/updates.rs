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

use super::link::Link;
use super::notice::Notice;
use crate::films::{BodyFilm, FILM_UPDATE_LENGTH};
use crate::memory_use::heap_bytes;
use crate::particles::{
    Image, Particles, SPHERE_UPDATE_LENGTH, UPDATE_LENGTH, clone_update, read_motion, read_orientation,
};
use grains_domain::{Channel, Transport};
use grains_geometry::Rotation;
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
    /// Times that messages of other ranks were waited for, those of rebuilds among them.
    pub waits: u64,
    /// Time (s) in which nothing else was done.
    pub wait: f64,
}

/// Where the update of a clone stands in a message about all buffer particles of its owner, and the link of which its image is
/// the opposite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    pub(crate) slot: u32,
    pub(crate) link: u32,
}

/// The updates of one rank's clones until they are made anew.
#[derive(Debug, Default)]
pub(crate) struct Updates {
    pub(super) strategy: ExchangeStrategy,
    pub(crate) traffic: Traffic,
    /// Neighbour ranks other than the own one, ascending.
    pub(super) peers: Vec<usize>,
    /// Owned particles that other ranks have clones of.
    pub(crate) buffer: Vec<u32>,
    /// Per peer, the clones its messages fill, in order.
    pub(crate) filled: Vec<Range<usize>>,
    /// Per peer, where they stand if it tells of all its buffer particles.
    pub(crate) origins: Vec<Vec<Origin>>,
    /// What each peer has told of its lists with the last update.
    pub(super) notices: Vec<Notice>,
    /// Numbers that do so in a message: none where all ranks rebuild their lists together.
    notice_length: usize,
    /// Numbers that tell of a clone.
    pub(super) length: usize,
    channel: Channel,
    /// The message about all buffer particles.
    pub(super) own: Vec<f64>,
    pub(super) sent: Vec<Vec<f64>>,
    pub(super) received: Vec<Vec<f64>>,
    is_pending: bool,
}

impl Updates {
    pub(crate) fn new(peers: &[usize], strategy: ExchangeStrategy, are_apart: bool) -> Self {
        let buffers = vec![Vec::new(); peers.len()];
        Self {
            strategy,
            notices: vec![Notice::default(); peers.len()],
            notice_length: if are_apart { Notice::LENGTH } else { 0 },
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
        let notice = self.notice_length;
        let of_peer = |&peer: &usize| notice + length * sent_to(links, peer).count();
        let sent: Vec<usize> = self.peers.iter().map(of_peer).collect();
        match self.strategy {
            ExchangeStrategy::Persistent => {
                let filled = self.filled.iter().map(|clones| notice + length * clones.len());
                let filled: Vec<usize> = filled.collect();
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
    pub(crate) fn start(
        &mut self,
        links: &[Link],
        particles: &Particles,
        notice: impl Fn(usize) -> Notice,
        transport: &impl Transport,
    ) {
        self.traffic.updates += 1;
        self.is_pending = true;
        if self.strategy == ExchangeStrategy::Persistent {
            self.write_notices(notice);
            for (k, &peer) in self.peers.iter().enumerate() {
                let records = &mut self.channel.outgoing(k)[self.notice_length..];
                fill(records, self.length, particles, sent_to(links, peer));
            }
            transport.start(&mut self.channel);
            self.count(self.channel.messages_sent(), self.channel.numbers_sent());
        }
    }

    /// Tells neighbours that new clones follow, in place of updates.
    pub(crate) fn start_notices(&mut self, notice: impl Fn(usize) -> Notice, transport: &impl Transport) {
        self.traffic.updates += 1;
        self.is_pending = true;
        self.write_notices(notice);
        transport.start_heads(&mut self.channel, self.notice_length);
        self.count(self.peers.len(), self.peers.len() * self.notice_length);
    }

    fn write_notices(&mut self, notice: impl Fn(usize) -> Notice) {
        for k in (0..self.peers.len()).filter(|_| self.notice_length > 0) {
            notice(k).write(&mut self.channel.outgoing(k)[..self.notice_length]);
        }
    }

    /// Lets the updates that are under way go on.
    pub(crate) fn advance(&mut self, transport: &impl Transport) {
        if self.is_pending && self.strategy == ExchangeStrategy::Persistent {
            transport.advance(&mut self.channel);
        }
    }

    /// Waits for the updates of all clones from other ranks, and applies them; returns whether there were any under way.
    pub(crate) fn finish(
        &mut self,
        links: &[Link],
        particles: &mut Particles,
        transport: &impl Transport,
    ) -> bool {
        if !std::mem::take(&mut self.is_pending) {
            return false;
        }
        match self.strategy {
            ExchangeStrategy::Persistent => {
                self.timed(|updates| transport.finish(&mut updates.channel));
                for (k, clones) in self.filled.iter().enumerate() {
                    let (head, records) = self.channel.incoming(k).split_at(self.notice_length);
                    if !head.is_empty() {
                        self.notices[k] = Notice::read(head);
                    }
                    // New clones follow from who rebuilds its lists.
                    if !self.notices[k].rebuilds {
                        take_all(records, self.length, clones.clone(), particles);
                    }
                }
            }
            ExchangeStrategy::SendRecvLocalGeoloc => {
                for (message, &peer) in self.sent.iter_mut().zip(&self.peers) {
                    fill(message, self.length, particles, sent_to(links, peer));
                }
                self.count(self.sent.len(), self.sent.iter().map(Vec::len).sum());
                self.timed(|u| transport.exchange_unsized(&u.peers, &u.sent, &mut u.received));
                for (message, clones) in self.received.iter().zip(&self.filled) {
                    take_all(message, self.length, clones.clone(), particles);
                }
            }
            _ => self.gather(links, particles, transport),
        }
        true
    }

    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let messages =
            self.sent.iter().chain(&self.received).map(heap_bytes).sum::<usize>() + heap_bytes(&self.own);
        let origins = self.origins.iter().map(heap_bytes).sum::<usize>() + heap_bytes(&self.buffer);
        messages + origins + 8 * self.channel.numbers_held()
    }

    pub(super) fn count(&mut self, messages: usize, numbers: usize) {
        self.traffic.messages += messages as u64;
        self.traffic.bytes += 8 * numbers as u64;
    }

    pub(super) fn timed(&mut self, wait: impl FnOnce(&mut Self)) {
        let begun = Instant::now();
        self.traffic.waits += 1;
        wait(self);
        self.traffic.wait += begun.elapsed().as_secs_f64();
    }
}

/// Owned particles that a peer has clones of, and which images these are.
fn sent_to(links: &[Link], peer: usize) -> impl Iterator<Item = (u32, Image)> {
    let links = links.iter().filter(move |link| link.rank == peer);
    links.flat_map(|link| link.sent.iter().map(|&i| (i, link.image)))
}

/// Numbers that tell of a clone.
pub(crate) fn record_length(particles: &Particles) -> usize {
    motion_length(particles) + film_length(particles) + usize::from(particles.is_warm())
}

/// Those of them that tell of its film.
fn film_length(particles: &Particles) -> usize {
    if particles.is_wet() { FILM_UPDATE_LENGTH } else { 0 }
}

/// Those of them that tell of its motion; its film and its temperature follow.
fn motion_length(particles: &Particles) -> usize {
    if particles.has_orientations() { UPDATE_LENGTH } else { SPHERE_UPDATE_LENGTH }
}

/// Largest number of numbers that tell of a clone.
pub(super) const LONGEST_UPDATE: usize = UPDATE_LENGTH + FILM_UPDATE_LENGTH + 1;

/// Writes the updates of particles into a message.
pub(super) fn fill(
    message: &mut [f64],
    length: usize,
    particles: &Particles,
    whom: impl Iterator<Item = (u32, Image)>,
) {
    let (identity, of_motion) = (Rotation::identity(), motion_length(particles));
    for (record, (i, image)) in message.chunks_exact_mut(length).zip(whom) {
        let i = i as usize;
        let orientation = particles.orientations.get(i).unwrap_or(&identity);
        let motion = clone_update(&particles.bodies[i], orientation, &image);
        record[..of_motion].copy_from_slice(&motion[..of_motion]);
        if let Some(film) = particles.films.get(i) {
            record[of_motion..of_motion + FILM_UPDATE_LENGTH].copy_from_slice(&film.update());
        }
        if let (Some(temperature), Some(last)) = (particles.temperatures.get(i), record.last_mut()) {
            *last = *temperature;
        }
    }
}

/// Applies the updates of clones in a message.
fn take_all(message: &[f64], length: usize, clones: Range<usize>, particles: &mut Particles) {
    let records = message.chunks_exact(length);
    records.zip(clones).for_each(|(record, clone)| take(particles, clone, record));
}

/// Applies the update of a clone.
#[inline]
pub(super) fn take(particles: &mut Particles, clone: usize, record: &[f64]) {
    let before = particles.bodies[clone].position;
    read_motion(&mut particles.bodies[clone], record);
    if particles.has_orientations() {
        particles.turn_to(clone, &before, read_orientation(record));
    }
    let of_motion = motion_length(particles);
    if let Some(film) = particles.films.get_mut(clone) {
        *film = BodyFilm::of_update(&record[of_motion..]);
    }
    if let (Some(temperature), Some(last)) = (particles.temperatures.get_mut(clone), record.last()) {
        *temperature = *last;
    }
}
