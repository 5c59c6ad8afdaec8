//! Clones of particles near a border: their creation and their updates.

use super::link::Link;
use super::messages::Exchange;
use super::notice::Notice;
use super::updates::{Origin, record_length};
use crate::films::{BodyFilm, FILM_UPDATE_LENGTH};
use crate::particles::{Body, CLONE_LENGTH, Particles, read_clone, write_clone};
use crate::verlet::{Reference, References};
use grains_domain::{Direction, Transport};
use grains_geometry::{Rotation, Vec3};
use std::ops::Range;

/// Numbers that tell of the reference of a clone.
const REFERENCE_LENGTH: usize = 4;

/// Clones taken off before some of them are made anew, and where they stood.
pub(crate) struct KeptClones {
    particles: Particles,
    references: References,
    /// Per peer, those of its particles.
    filled: Vec<Range<usize>>,
}

impl Exchange {
    /// Takes off all clones.
    pub(crate) fn take_clones(
        &mut self,
        particles: &mut Particles,
        references: &mut References,
    ) -> KeptClones {
        let owned = particles.owned;
        let in_tail = |filled: &Range<usize>| filled.start - owned..filled.end - owned;
        KeptClones {
            filled: self.updates.filled.iter().map(in_tail).collect(),
            references: references.split_off(owned),
            particles: particles.split_off_clones(),
        }
    }

    /// Creates the clones of this rank after its particles were sorted by cell, for all neighbours, and takes those of the peers that
    /// rebuild their lists too; the others' are as `kept`. Returns whether bonded particles have left the box.
    ///
    /// `ranges` (m) are how far from each owned particle's reference another's may be that it acts on before the next sorting;
    /// `have_left` tells whether bonded particles of this rank have left.
    pub(crate) fn create_clones(
        &mut self,
        (particles, references): (&mut Particles, &mut References),
        ranges: &[f64],
        (rebuilding, kept): (&[bool], Option<&KeptClones>),
        have_left: bool,
        transport: &impl Transport,
    ) -> bool {
        self.choose_sent(particles, references, ranges);
        self.write_clones(particles, references, have_left);
        self.exchange_clones(true, rebuilding, transport);
        let own = self.links.iter().filter(|l| l.rank == self.own_rank).map(|l| l.sent.len()).sum::<usize>();
        self.make_room(own, particles, references);
        self.push_own_clones(particles, references);
        let others_have_left = self.push_clones_of_others((particles, references), rebuilding, kept);
        self.updates.prepare(&self.links, record_length(particles), transport);
        have_left || others_have_left
    }

    /// Takes the new clones of the peers that rebuild their lists, where this rank does not; the others are as `kept`. Returns whether
    /// bonded particles have left the box.
    pub(crate) fn take_new_clones(
        &mut self,
        (particles, references): (&mut Particles, &mut References),
        (rebuilding, kept): (&[bool], &KeptClones),
        transport: &impl Transport,
    ) -> bool {
        self.exchange_clones(false, rebuilding, transport);
        let first = kept.filled.iter().map(|filled| filled.start).min();
        let own = first.unwrap_or(kept.particles.bodies.len());
        self.make_room(own, particles, references);
        for k in 0..own {
            particles.push_clone_from(&kept.particles, k);
            references.push_from(&kept.references, k);
        }
        let have_left = self.push_clones_of_others((particles, references), rebuilding, Some(kept));
        self.updates.prepare(&self.links, record_length(particles), transport);
        have_left
    }

    /// Sends the clones written for all peers, if `sends`, and receives those of the peers that rebuild their lists.
    fn exchange_clones(&mut self, sends: bool, rebuilding: &[bool], transport: &impl Transport) {
        let senders = rebuilding.iter().enumerate().filter(|(_, rebuilds)| **rebuilds).map(|(k, _)| k);
        let senders: Vec<usize> = senders.collect();
        let ranks: Vec<usize> = senders.iter().map(|&k| self.peers[k]).collect();
        let mut messages: Vec<Vec<f64>> =
            senders.iter().map(|&k| std::mem::take(&mut self.received[k])).collect();
        self.updates.traffic.waits += u64::from(!ranks.is_empty());
        let to: (&[usize], &[Vec<f64>]) = if sends { (&self.peers, &self.sent) } else { (&[], &[]) };
        transport.send_and_receive(to, (&ranks, &mut messages));
        senders.iter().zip(messages).for_each(|(&k, message)| self.received[k] = message);
    }

    /// Makes room for clones of own particles and for as many of others as there are.
    fn make_room(&self, own: usize, particles: &mut Particles, references: &mut References) {
        let of_others = self.received.iter().map(|message| message.len() / self.clone_length(particles));
        let kept = self.updates.filled.iter().map(Range::len);
        let clones = own + of_others.zip(kept).map(|(new, kept)| new.max(kept)).sum::<usize>();
        particles.make_room(clones);
        references.make_room(clones);
    }

    /// Number of f64 that create a clone.
    fn clone_length(&self, particles: &Particles) -> usize {
        let of_film = if particles.is_wet() { FILM_UPDATE_LENGTH } else { 0 };
        CLONE_LENGTH
            + REFERENCE_LENGTH
            + of_film
            + usize::from(particles.is_warm())
            + usize::from(self.updates.gathers())
    }

    /// Writes the clones that other ranks get into their messages; each begins with whether bonded particles have left.
    fn write_clones(&mut self, particles: &Particles, references: &References, have_left: bool) {
        let identity = Rotation::identity();
        let gathers = self.updates.gathers();
        let buffer = &self.updates.buffer;
        for message in &mut self.sent {
            message.clear();
            message.push(f64::from(u8::from(have_left)));
        }
        for link in self.links.iter().filter(|l| l.rank != self.own_rank) {
            let Ok(peer) = self.peers.binary_search(&link.rank) else { continue };
            for &i in &link.sent {
                let i = i as usize;
                let orientation = particles.orientations.get(i).unwrap_or(&identity);
                let message = &mut self.sent[peer];
                write_clone(particles.ids[i], &particles.bodies[i], orientation, &link.image, message);
                let Reference { position, allowance } = references.places[i];
                let position = position + link.image.shift;
                message.extend([position.x, position.y, position.z, allowance]);
                message.extend(particles.films.get(i).map(BodyFilm::update).into_iter().flatten());
                message.extend(particles.temperatures.get(i));
                if gathers {
                    // Where the receiver finds it among all buffer particles, and by which way it came.
                    let slot = buffer.binary_search(&(i as u32)).unwrap_or(0);
                    message.push((slot * Direction::COUNT + link.direction.index()) as f64);
                }
            }
        }
    }

    /// Appends the periodic images of own particles.
    fn push_own_clones(&mut self, particles: &mut Particles, references: &mut References) {
        let identity = Rotation::identity();
        self.own_clones.clear();
        for (index, link) in self.links.iter().enumerate().filter(|(_, l)| l.rank == self.own_rank) {
            self.own_clones.push((index, particles.len()));
            for &i in &link.sent {
                let i = i as usize;
                let mut body = particles.bodies[i];
                (body.position, body.velocity) = link.image.motion_of(&body);
                let orientation = *particles.orientations.get(i).unwrap_or(&identity);
                particles.push_clone(particles.ids[i], body, orientation);
                let Reference { position, allowance } = references.places[i];
                let reference = Reference { position: position + link.image.shift, allowance };
                references.push(reference, particles.has_orientations().then_some(orientation));
                if let Some(clone) = particles.films.len().checked_sub(1) {
                    particles.films[clone] = particles.films[i];
                }
                if let Some(clone) = particles.temperatures.len().checked_sub(1) {
                    particles.temperatures[clone] = particles.temperatures[i];
                }
            }
        }
    }

    /// Appends the clones of other ranks' particles: those received from the peers that rebuild their lists, of the others those kept.
    /// Returns whether bonded particles of the former have left the box.
    fn push_clones_of_others(
        &mut self,
        (particles, references): (&mut Particles, &mut References),
        rebuilding: &[bool],
        kept: Option<&KeptClones>,
    ) -> bool {
        let mut have_left = false;
        for (k, &rebuilds) in rebuilding.iter().enumerate() {
            let first = particles.len();
            if rebuilds {
                have_left |= self.received[k].first().is_some_and(|&flag| flag != 0.0);
                self.read_clones(k, particles, references);
            } else if let Some(kept) = kept {
                for clone in kept.filled[k].clone() {
                    particles.push_clone_from(&kept.particles, clone);
                    references.push_from(&kept.references, clone);
                }
            }
            self.updates.filled[k] = first..particles.len();
        }
        have_left
    }

    /// Appends the clones received from a peer.
    fn read_clones(&mut self, k: usize, particles: &mut Particles, references: &mut References) {
        let length = self.clone_length(particles);
        self.updates.origins[k].clear();
        for record in self.received[k][1..].chunks_exact(length) {
            let (id, body, orientation) = read_clone(record);
            particles.push_clone(id, body, orientation);
            let (reference, mut rest) = record[CLONE_LENGTH..].split_at(REFERENCE_LENGTH);
            let position = Vec3::new(reference[0], reference[1], reference[2]);
            let reference = Reference { position, allowance: reference[3] };
            references.push(reference, particles.has_orientations().then_some(orientation));
            if let Some(film) = particles.films.last_mut() {
                let (update, after) = rest.split_at(FILM_UPDATE_LENGTH);
                (*film, rest) = (BodyFilm::of_update(update), after);
            }
            if let (Some(temperature), Some((own, after))) =
                (particles.temperatures.last_mut(), rest.split_first())
            {
                (*temperature, rest) = (*own, after);
            }
            if let Some(&code) = rest.first() {
                let (slot, way) = (code as usize / Direction::COUNT, code as usize % Direction::COUNT);
                // Its way back is one of ours, with the opposite image.
                let back = self.links.iter().position(|l| l.direction.opposite().index() == way);
                let link = back.unwrap_or(0) as u32;
                self.updates.origins[k].push(Origin { slot: slot as u32, link });
            }
        }
    }

    /// Lists the owned particles of each direction: those nearer to the border than what can act across it.
    fn choose_sent(&mut self, particles: &Particles, references: &References, ranges: &[f64]) {
        let (lower, upper) = (self.decomposition.lower(), self.decomposition.upper());
        self.links.iter_mut().for_each(|l| l.sent.clear());
        self.updates.buffer.clear();
        for (i, (reference, &range)) in references.places[..particles.owned].iter().zip(ranges).enumerate() {
            let position = &reference.position;
            let low = std::array::from_fn(|a| position[a] - lower[a] < range);
            let high = std::array::from_fn(|a| upper[a] - position[a] < range);
            if low == [false; 3] && high == [false; 3] {
                continue;
            }
            let is_near = |link: &Link| match link.image.sliding {
                Some((flow, _)) => {
                    // Where its image lies along the flow decides, not where it lies itself.
                    let x = position[flow] + link.image.shift[flow];
                    let is_there = x >= lower[flow] - range && x < upper[flow] + range;
                    is_there && link.direction.without(flow).needs_clone(low, high)
                }
                None => link.direction.needs_clone(low, high),
            };
            for link in self.links.iter_mut().filter(|link| is_near(link)) {
                link.sent.push(i as u32);
            }
            let links = &self.links;
            if links.iter().any(|l| l.rank != self.own_rank && l.sent.last() == Some(&(i as u32))) {
                self.updates.buffer.push(i as u32);
            }
        }
    }

    /// Brings clones of own particles up to date, and requests the updates of the others.
    ///
    /// `notice` tells each peer, by number, of this rank's lists.
    pub(crate) fn start_update(
        &mut self,
        particles: &mut Particles,
        notice: impl Fn(usize) -> Notice,
        transport: &impl Transport,
    ) {
        let turning = particles.has_orientations();
        for &(index, first) in &self.own_clones {
            let link = &self.links[index];
            for (&i, clone) in link.sent.iter().zip(first..) {
                let (i, before) = (i as usize, particles.bodies[clone].position);
                let owner = particles.bodies[i];
                let (position, velocity) = link.image.motion_of(&owner);
                particles.bodies[clone] = Body { position, velocity, ..owner };
                if turning {
                    particles.turn_to(clone, &before, particles.orientations[i]);
                }
                if particles.is_wet() {
                    particles.films[clone] = particles.films[i];
                }
                if particles.is_warm() {
                    particles.temperatures[clone] = particles.temperatures[i];
                }
            }
        }
        if !self.peers.is_empty() {
            self.updates.start(&self.links, particles, notice, transport);
        }
    }

    /// Tells neighbours of the lists of this rank as it rebuilds them, and requests the updates of their clones.
    pub(crate) fn start_notices(&mut self, notice: impl Fn(usize) -> Notice, transport: &impl Transport) {
        if !self.peers.is_empty() {
            self.updates.start_notices(notice, transport);
        }
    }

    /// Lets the updates of clones that are under way go on, without waiting for them.
    pub(crate) fn advance_update(&mut self, transport: &impl Transport) {
        self.updates.advance(transport);
    }

    /// Brings the clones of other ranks' particles up to date; returns whether that had been begun.
    pub(crate) fn finish_update(&mut self, particles: &mut Particles, transport: &impl Transport) -> bool {
        self.updates.finish(&self.links, particles, transport)
    }

    /// What each peer has told of its lists with its last update.
    pub(crate) fn notices(&self) -> &[Notice] {
        &self.updates.notices
    }

    /// The ranks that own the clones here, or have clones from here.
    pub(crate) fn peers(&self) -> &[usize] {
        &self.peers
    }

    /// Number of the peer that owns the particle of a clone; none of the clones of own particles.
    pub(crate) fn peer_of_clone(&self, clone: usize) -> Option<usize> {
        self.updates.filled.iter().position(|filled| filled.contains(&clone))
    }

    /// Tells every peer some numbers, and hears those it tells; peers by their number.
    pub(crate) fn tell_peers(
        &mut self,
        write: impl Fn(usize, &mut Vec<f64>),
        mut read: impl FnMut(usize, &[f64]),
        transport: &impl Transport,
    ) {
        if self.peers.is_empty() {
            return;
        }
        for (peer, message) in self.sent.iter_mut().enumerate() {
            message.clear();
            write(peer, message);
        }
        transport.exchange_unsized(&self.peers, &self.sent, &mut self.received);
        self.received.iter().enumerate().for_each(|(peer, message)| read(peer, message));
    }

    /// Tells clones what changed of their owners within a step: own ones, and those of the peers that are told and tell.
    pub(crate) fn forward_to_clones<State: Forwarded>(
        &mut self,
        state: &mut State,
        transport: &impl Transport,
    ) {
        for &(index, first) in &self.own_clones {
            for (&i, clone) in self.links[index].sent.iter().zip(first..) {
                self.update.clear();
                if state.write(i as usize, &mut self.update) {
                    state.read(clone, &self.update);
                }
            }
        }
        // The messages of those that take part are the first ones, in their order.
        let Self { told, told_ranks, peers, links, sent, received, updates, .. } = self;
        told.clear();
        told.extend((0..peers.len()).filter(|&k| state.is_told(k)));
        if told.is_empty() {
            return;
        }
        told_ranks.clear();
        told_ranks.extend(told.iter().map(|&k| peers[k]));
        let count = told.len();
        for (message, &rank) in sent.iter_mut().zip(&*told_ranks) {
            message.clear();
            let cloned = links.iter().filter(|l| l.rank == rank).flat_map(|l| &l.sent);
            for (slot, &i) in cloned.enumerate() {
                message.push(slot as f64);
                if !state.write(i as usize, message) {
                    message.pop();
                }
            }
        }
        transport.exchange_unsized(told_ranks, &sent[..count], &mut received[..count]);
        for (message, &k) in received.iter().zip(&*told) {
            let first = updates.filled[k].start;
            for record in message.chunks_exact(1 + State::NUMBERS) {
                state.read(first + record[0] as usize, &record[1..]);
            }
        }
    }
}

/// What clones are told of their owners within a step.
pub(crate) trait Forwarded {
    /// Numbers about a particle.
    const NUMBERS: usize;
    /// Whether a peer, by its number, takes part; both sides know.
    fn is_told(&self, peer: usize) -> bool;
    /// Appends the numbers of an owned particle, or returns false if there is nothing to tell.
    fn write(&self, i: usize, message: &mut Vec<f64>) -> bool;
    /// Takes the numbers for a clone.
    fn read(&mut self, clone: usize, numbers: &[f64]);
}
