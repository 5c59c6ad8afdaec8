//! Migration of particles that crossed a border.

use super::messages::Exchange;
use crate::contact_history::SavedHistories;
use crate::error::{StepError, vector};
use crate::films::{BodyFilm, FILM_LENGTH};
use crate::particles::{Body, CARGO_LENGTH, Cargo, ParticleRecord, Particles};
use grains_domain::Transport;
use grains_geometry::Vec3;

/// What a migration leaves.
pub(crate) struct Migration {
    /// Indices of the particles now owned here.
    pub(crate) stays: Vec<u32>,
    /// Those that left the box through an outlet; they are there until particles are sorted.
    pub(crate) left: Vec<u32>,
    /// How many ends of bonds they had.
    pub(crate) bonds_left: u64,
    /// Those of them that carried something.
    pub(crate) carriers_left: Vec<(Body, Cargo)>,
    /// What is wrong with one of them.
    pub(crate) failure: Option<StepError>,
}

/// Faces of the box and whether particles may leave there.
pub(crate) const FACES: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];

impl Exchange {
    /// Wraps owned particles into the box, drops those that left through an outlet, sends those that
    /// crossed a border to a peer that rebuilds its lists too, and appends arrivals. Who has to go to another peer stays until that
    /// one does.
    pub(crate) fn migrate(
        &mut self,
        particles: &mut Particles,
        histories: &mut SavedHistories,
        rebuilding: &[bool],
        transport: &impl Transport,
    ) -> Migration {
        let mut stays = Vec::new();
        self.sent.iter_mut().for_each(Vec::clear);
        let (mut failure, mut left, mut bonds_left, mut carriers_left) = (None, Vec::new(), 0, Vec::new());
        for i in 0..particles.owned {
            match self.destination(particles, i) {
                Ok(Some((rank, _))) if rank == self.own_rank => stays.push(i as u32),
                Ok(Some((rank, before))) => match self.peers.binary_search(&rank) {
                    Ok(peer) if !rebuilding[peer] => {
                        particles.bodies[i].position = before;
                        stays.push(i as u32);
                    }
                    Ok(peer) => {
                        particles.record(i).write(&mut self.sent[peer]);
                        self.sent[peer].extend(particles.cargo.get(i).into_iter().flatten());
                        self.sent[peer]
                            .extend(particles.films.get(i).map(BodyFilm::numbers).into_iter().flatten());
                        self.sent[peer].extend(particles.amounts_of(i));
                        histories.write(i, &mut self.sent[peer]);
                    }
                    Err(_) => {
                        failure = failure.or(Some(far_jump(particles, i)));
                        stays.push(i as u32);
                    }
                },
                Ok(None) => {
                    left.push(i as u32);
                    bonds_left += histories.bonds.row(i).len() as u64;
                    carriers_left.extend(particles.cargo.get(i).map(|cargo| (particles.bodies[i], *cargo)));
                }
                Err(error) => {
                    failure = failure.or(Some(error));
                    stays.push(i as u32);
                }
            }
        }
        let partners: Vec<usize> = (0..self.peers.len()).filter(|&k| rebuilding[k]).collect();
        let ranks: Vec<usize> = partners.iter().map(|&k| self.peers[k]).collect();
        let sent: Vec<Vec<f64>> = partners.iter().map(|&k| std::mem::take(&mut self.sent[k])).collect();
        let mut received = vec![Vec::new(); partners.len()];
        self.updates.traffic.waits += u64::from(!ranks.is_empty());
        transport.exchange_unsized(&ranks, &sent, &mut received);
        for message in &received {
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
                if let Some(film) = particles.films.last_mut() {
                    let (mine, others) = rest.split_at(FILM_LENGTH);
                    *film = BodyFilm::from_numbers(std::array::from_fn(|k| mine[k]));
                    rest = others;
                }
                let (amounts, others) = rest.split_at(particles.species);
                particles.set_last_amounts(amounts);
                rest = histories.read(others);
            }
        }
        Migration { stays, left, bonds_left, carriers_left, failure }
    }

    /// Rank that must own particle `i`, whose position is wrapped, and where it was (m) before; none if it left through an outlet.
    fn destination(&self, particles: &mut Particles, i: usize) -> Result<Option<(usize, Vec3)>, StepError> {
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
        if let Some((images, offset)) = &self.sliding {
            images.wrap(&mut body.position, [&mut body.velocity, &mut particles.half_velocity[i]], *offset);
        }
        let (before, wrapped) = (body.position, global.wrap(body.position.into()));
        body.position = Vec3::from(wrapped);
        Ok(Some((self.decomposition.owner(wrapped), before)))
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
