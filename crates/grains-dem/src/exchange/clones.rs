//! Clones of particles near a border: their creation and their updates.

use super::link::Link;
use super::messages::Exchange;
use super::updates::{Origin, record_length};
use crate::films::{BodyFilm, FILM_UPDATE_LENGTH};
use crate::particles::{Body, CLONE_LENGTH, Particles, read_clone, write_clone};
use grains_domain::{Direction, Transport};
use grains_geometry::Rotation;

impl Exchange {
    /// Creates the clones of this rank after particles were sorted by cell.
    ///
    /// `ranges` (m) are how far from each owned particle's centre another's may be that it acts on before the next sorting.
    pub(crate) fn create_clones(
        &mut self,
        particles: &mut Particles,
        ranges: &[f64],
        transport: &impl Transport,
    ) {
        self.choose_sent(particles, ranges);
        self.write_clones(particles);
        transport.exchange_unsized(&self.peers, &self.sent, &mut self.received);
        let of_others =
            self.received.iter().map(|message| message.len() / self.clone_length(particles)).sum::<usize>();
        let own = self.links.iter().filter(|l| l.rank == self.own_rank).map(|l| l.sent.len()).sum::<usize>();
        particles.make_room(own + of_others);
        self.push_own_clones(particles);
        self.read_clones(particles);
        self.updates.prepare(&self.links, record_length(particles), transport);
    }

    /// Number of f64 that create a clone.
    fn clone_length(&self, particles: &Particles) -> usize {
        let of_film = if particles.is_wet() { FILM_UPDATE_LENGTH } else { 0 };
        CLONE_LENGTH + of_film + usize::from(particles.is_warm()) + usize::from(self.updates.gathers())
    }

    /// Writes the clones that other ranks get into their messages.
    fn write_clones(&mut self, particles: &Particles) {
        let identity = Rotation::identity();
        let gathers = self.updates.gathers();
        let buffer = &self.updates.buffer;
        self.sent.iter_mut().for_each(Vec::clear);
        for link in self.links.iter().filter(|l| l.rank != self.own_rank) {
            let Ok(peer) = self.peers.binary_search(&link.rank) else { continue };
            for &i in &link.sent {
                let i = i as usize;
                let orientation = particles.orientations.get(i).unwrap_or(&identity);
                let message = &mut self.sent[peer];
                write_clone(particles.ids[i], &particles.bodies[i], orientation, &link.image, message);
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
    fn push_own_clones(&mut self, particles: &mut Particles) {
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
                if let Some(clone) = particles.films.len().checked_sub(1) {
                    particles.films[clone] = particles.films[i];
                }
                if let Some(clone) = particles.temperatures.len().checked_sub(1) {
                    particles.temperatures[clone] = particles.temperatures[i];
                }
            }
        }
    }

    /// Appends the clones received from other ranks.
    fn read_clones(&mut self, particles: &mut Particles) {
        let length = self.clone_length(particles);
        for (k, message) in self.received.iter().enumerate() {
            let first = particles.len();
            self.updates.origins[k].clear();
            for record in message.chunks_exact(length) {
                let (id, body, orientation) = read_clone(record);
                particles.push_clone(id, body, orientation);
                let mut rest = &record[CLONE_LENGTH..];
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
            self.updates.filled[k] = first..particles.len();
        }
    }

    /// Lists the owned particles of each direction: those nearer to the border than what can act across it.
    fn choose_sent(&mut self, particles: &Particles, ranges: &[f64]) {
        let (lower, upper) = (self.decomposition.lower(), self.decomposition.upper());
        self.links.iter_mut().for_each(|l| l.sent.clear());
        self.updates.buffer.clear();
        for (i, (body, &range)) in particles.bodies[..particles.owned].iter().zip(ranges).enumerate() {
            let low = std::array::from_fn(|a| body.position[a] - lower[a] < range);
            let high = std::array::from_fn(|a| upper[a] - body.position[a] < range);
            if low == [false; 3] && high == [false; 3] {
                continue;
            }
            let is_near = |link: &Link| match link.image.sliding {
                Some((flow, _)) => {
                    // Where its image lies along the flow decides, not where it lies itself.
                    let x = body.position[flow] + link.image.shift[flow];
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
    pub(crate) fn start_update(&mut self, particles: &mut Particles, transport: &impl Transport) {
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
            self.updates.start(&self.links, particles, transport);
        }
    }

    /// Brings the clones of other ranks' particles up to date, if that was begun.
    pub(crate) fn finish_update(&mut self, particles: &mut Particles, transport: &impl Transport) {
        self.updates.finish(&self.links, particles, transport);
    }

    /// Tells clones what changed of their owners within a step.
    ///
    /// `write` appends `numbers` numbers about an owned particle, or returns false if there is nothing to
    /// tell; `read` takes them for a clone of it.
    pub(crate) fn forward_to_clones<State>(
        &mut self,
        state: &mut State,
        numbers: usize,
        write: impl Fn(&State, usize, &mut Vec<f64>) -> bool,
        read: impl Fn(&mut State, usize, &[f64]),
        transport: &impl Transport,
    ) {
        for &(index, first) in &self.own_clones {
            for (&i, clone) in self.links[index].sent.iter().zip(first..) {
                self.update.clear();
                if write(state, i as usize, &mut self.update) {
                    read(state, clone, &self.update);
                }
            }
        }
        if self.peers.is_empty() {
            return;
        }
        for (&peer, message) in self.peers.iter().zip(&mut self.sent) {
            message.clear();
            let sent = self.links.iter().filter(|l| l.rank == peer).flat_map(|l| &l.sent);
            for (slot, &i) in sent.enumerate() {
                message.push(slot as f64);
                if !write(state, i as usize, message) {
                    message.pop();
                }
            }
        }
        transport.exchange_unsized(&self.peers, &self.sent, &mut self.received);
        for (message, filled) in self.received.iter().zip(&self.updates.filled) {
            for record in message.chunks_exact(1 + numbers) {
                read(state, filled.start + record[0] as usize, &record[1..]);
            }
        }
    }
}
