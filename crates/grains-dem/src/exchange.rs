//! What subdomains tell each other: who moves, who is cloned, and what clones must know.
//!
//! When lists are rebuilt, particles that crossed a border *migrate* with all their contacts remember; right after,
//! clones are *created* of every particle so near a border that it may act across it, with the neighbours of its
//! GEOLOC. In every step between, [`crate::updates`] brings them up to date. Hard collisions *tell clones* what each of
//! their rounds changed. All that goes to one neighbour is one message.

use crate::dem::bytes;
use crate::error::vector;
use crate::memory::Memories;
use crate::record::{CLONE_LENGTH, read_clone, write_clone};
use crate::updates::{ExchangeStrategy, Origin, Traffic, Updates, record_length};
use crate::{Body, CARGO_LENGTH, Cargo, ParticleRecord, Particles, StepError};
use grains_domain::{Decomposition, Direction, Transport};
use grains_geometry::{Rotation, Vec3};

/// A neighbour direction: who is there, and what it gets.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    direction: Direction,
    pub(crate) rank: usize,
    pub(crate) shift: Vec3,
    /// Owned particles cloned in this direction.
    pub(crate) sent: Vec<u32>,
}

/// What a migration leaves.
pub(crate) struct Migration {
    /// Indices of the particles now owned here.
    pub(crate) stays: Vec<u32>,
    /// How many left the box through an outlet.
    pub(crate) left: u64,
    /// Those of them that carried something.
    pub(crate) carriers_left: Vec<(Body, Cargo)>,
}

/// The messages of one rank.
#[derive(Debug)]
pub(crate) struct Exchange {
    decomposition: Decomposition,
    outlets: [bool; 6],
    links: Vec<Link>,
    own_rank: usize,
    /// Neighbour ranks other than the own one, ascending.
    peers: Vec<usize>,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
    /// What keeps clones of other ranks' particles up to date.
    updates: Updates,
    /// Per self link, the first clone it fills.
    own_clones: Vec<(usize, usize)>,
    /// What one clone of this rank's own particles is told.
    news: Vec<f64>,
}

/// Faces of the box and whether particles may leave there.
pub(crate) const FACES: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];

impl Exchange {
    /// Messages of a subdomain; particles may leave the box through the faces that are `outlets`.
    pub(crate) fn new(decomposition: &Decomposition, outlets: [bool; 6], strategy: ExchangeStrategy) -> Self {
        let own_rank = decomposition.rank_at(decomposition.coordinates);
        let links: Vec<Link> = Direction::all()
            .filter_map(|direction| {
                let (rank, shift) = decomposition.neighbour(direction)?;
                Some(Link { direction, rank, shift: Vec3::from(shift), sent: Vec::new() })
            })
            .collect();
        let mut peers: Vec<usize> = links.iter().map(|l| l.rank).filter(|&r| r != own_rank).collect();
        peers.sort_unstable();
        peers.dedup();
        let buffers = vec![Vec::new(); peers.len()];
        Self {
            decomposition: decomposition.clone(),
            outlets,
            links,
            own_rank,
            updates: Updates::new(&peers, strategy),
            peers,
            sent: buffers.clone(),
            received: buffers,
            own_clones: Vec::new(),
            news: Vec::new(),
        }
    }

    /// Takes over borders that moved; neighbours stay who they are.
    pub(crate) fn divide(&mut self, decomposition: &Decomposition) {
        self.decomposition.cuts.clone_from(&decomposition.cuts);
    }

    /// Wraps owned particles into the box, drops those that left through an outlet, sends those that
    /// crossed a border, and appends arrivals.
    pub(crate) fn migrate(
        &mut self,
        particles: &mut Particles,
        memories: &mut Memories,
        transport: &impl Transport,
    ) -> Result<Migration, StepError> {
        particles.drop_clones();
        let mut stays = Vec::new();
        self.sent.iter_mut().for_each(Vec::clear);
        let (mut failure, mut left, mut carriers_left) = (None, 0, Vec::new());
        for i in 0..particles.owned {
            match self.destination(particles, i) {
                Ok(Some(rank)) if rank == self.own_rank => stays.push(i as u32),
                Ok(Some(rank)) => match self.peers.binary_search(&rank) {
                    Ok(peer) => {
                        particles.record(i).write(&mut self.sent[peer]);
                        self.sent[peer].extend(particles.cargo.get(i).into_iter().flatten());
                        memories.write(i, &mut self.sent[peer]);
                    }
                    Err(_) => failure = failure.or(Some(far_jump(particles, i))),
                },
                Ok(None) => {
                    left += 1;
                    carriers_left.extend(particles.cargo.get(i).map(|cargo| (particles.bodies[i], *cargo)));
                }
                Err(error) => failure = failure.or(Some(error)),
            }
        }
        transport.exchange_unsized(&self.peers, &self.sent, &mut self.received);
        if let Some(error) = failure {
            return Err(error);
        }
        for message in &self.received {
            let mut rest = &message[..];
            while !rest.is_empty() {
                stays.push(particles.owned as u32);
                particles.push(&ParticleRecord::read(rest));
                rest = &rest[ParticleRecord::LENGTH..];
                if let Some(cargo) = particles.cargo.last_mut() {
                    let (mine, others) = rest.split_at(CARGO_LENGTH);
                    cargo.copy_from_slice(mine);
                    rest = others;
                }
                rest = memories.read(rest);
            }
        }
        Ok(Migration { stays, left, carriers_left })
    }

    /// Rank that must own particle `i`, whose position is wrapped; none if it left through an outlet.
    fn destination(&self, particles: &mut Particles, i: usize) -> Result<Option<usize>, StepError> {
        let global = &self.decomposition.global;
        let body = &mut particles.bodies[i];
        if !(body.position + body.velocity + body.angular_velocity).norm().is_finite() {
            return Err(StepError::NotANumber { id: particles.ids[i], place: vector(&body.position) });
        }
        for a in (0..3).filter(|&a| !global.periodic[a]) {
            let beyond = [body.position[a] < global.lower[a], body.position[a] >= global.upper[a]];
            for side in 0..2 {
                if beyond[side] && !self.outlets[2 * a + side] {
                    return Err(StepError::Lost {
                        id: particles.ids[i],
                        face: FACES[2 * a + side].to_string(),
                        place: vector(&body.position),
                        velocity: vector(&body.velocity),
                    });
                }
            }
            if beyond[0] || beyond[1] {
                return Ok(None);
            }
        }
        let wrapped = global.wrap(body.position.into());
        body.position = Vec3::from(wrapped);
        Ok(Some(self.decomposition.owner(wrapped)))
    }

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
        let identity = Rotation::identity();
        let gathers = self.updates.gathers();
        let length = CLONE_LENGTH + usize::from(gathers);
        let buffer = &self.updates.buffer;
        self.sent.iter_mut().for_each(Vec::clear);
        for link in self.links.iter().filter(|l| l.rank != self.own_rank) {
            let Ok(peer) = self.peers.binary_search(&link.rank) else { continue };
            for &i in &link.sent {
                let i = i as usize;
                let orientation = particles.orientations.get(i).unwrap_or(&identity);
                let message = &mut self.sent[peer];
                write_clone(particles.ids[i], &particles.bodies[i], orientation, &link.shift, message);
                if gathers {
                    // Where the receiver finds it among all buffer particles, and by which way it came.
                    let slot = buffer.binary_search(&(i as u32)).unwrap_or(0);
                    message.push((slot * Direction::COUNT + link.direction.index()) as f64);
                }
            }
        }
        transport.exchange_unsized(&self.peers, &self.sent, &mut self.received);
        self.own_clones.clear();
        let of_others = self.received.iter().map(|message| message.len() / length).sum::<usize>();
        let own = self.links.iter().filter(|l| l.rank == self.own_rank).map(|l| l.sent.len()).sum::<usize>();
        particles.make_room(own + of_others);
        for (index, link) in self.links.iter().enumerate().filter(|(_, l)| l.rank == self.own_rank) {
            self.own_clones.push((index, particles.len()));
            for &i in &link.sent {
                let i = i as usize;
                let mut body = particles.bodies[i];
                body.position += link.shift;
                let orientation = *particles.orientations.get(i).unwrap_or(&identity);
                particles.push_clone(particles.ids[i], body, orientation);
            }
        }
        for (k, message) in self.received.iter().enumerate() {
            let first = particles.len();
            self.updates.origins[k].clear();
            for record in message.chunks_exact(length) {
                let (id, body, orientation) = read_clone(record);
                particles.push_clone(id, body, orientation);
                if let Some(&code) = record.get(CLONE_LENGTH) {
                    let (slot, way) = (code as usize / Direction::COUNT, code as usize % Direction::COUNT);
                    // Its way back is one of ours, with the opposite shift.
                    let back = self.links.iter().find(|l| l.direction.opposite().index() == way);
                    let shift = back.map_or(Vec3::zeros(), |link| -link.shift);
                    self.updates.origins[k].push(Origin { slot: slot as u32, shift });
                }
            }
            self.updates.filled[k] = first..particles.len();
        }
        self.updates.prepare(&self.links, record_length(particles), transport);
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
            for link in self.links.iter_mut().filter(|l| l.direction.needs_clone(low, high)) {
                link.sent.push(i as u32);
            }
            let links = &self.links;
            if links.iter().any(|l| l.rank != self.own_rank && l.sent.last() == Some(&(i as u32))) {
                self.updates.buffer.push(i as u32);
            }
        }
    }

    /// Brings clones of own particles up to date, and sends for the news of the others.
    pub(crate) fn start_update(&mut self, particles: &mut Particles, transport: &impl Transport) {
        let turning = particles.turns();
        for &(index, first) in &self.own_clones {
            let link = &self.links[index];
            for (&i, clone) in link.sent.iter().zip(first..) {
                let (i, before) = (i as usize, particles.bodies[clone].position);
                let owner = particles.bodies[i];
                particles.bodies[clone] = crate::Body { position: owner.position + link.shift, ..owner };
                if turning {
                    particles.turn_to(clone, &before, particles.orientations[i]);
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
    pub(crate) fn tell_clones<State>(
        &mut self,
        state: &mut State,
        numbers: usize,
        write: impl Fn(&State, usize, &mut Vec<f64>) -> bool,
        read: impl Fn(&mut State, usize, &[f64]),
        transport: &impl Transport,
    ) {
        for &(index, first) in &self.own_clones {
            for (&i, clone) in self.links[index].sent.iter().zip(first..) {
                self.news.clear();
                if write(state, i as usize, &mut self.news) {
                    read(state, clone, &self.news);
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

    /// What the updates of clones cost so far.
    pub(crate) fn traffic(&self) -> Traffic {
        self.updates.traffic
    }

    /// Memory (B) of messages.
    pub(crate) fn bytes(&self) -> usize {
        let links = self.links.iter().map(|link| bytes(&link.sent)).sum::<usize>();
        links + self.sent.iter().chain(&self.received).map(bytes).sum::<usize>() + self.updates.bytes()
    }

    /// Number of neighbour ranks.
    pub(crate) fn neighbours(&self) -> usize {
        self.peers.len()
    }

    /// Number of clones of this rank's particles, its own periodic images included.
    pub(crate) fn clones_sent(&self) -> usize {
        self.links.iter().map(|l| l.sent.len()).sum()
    }
}

fn far_jump(particles: &Particles, i: usize) -> StepError {
    let body = &particles.bodies[i];
    StepError::FarJump {
        id: particles.ids[i],
        place: vector(&body.position),
        velocity: vector(&body.velocity),
    }
}
