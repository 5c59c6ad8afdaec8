//! Works off the contacts of a step in rounds, in the same order on any ranks.
//!
//! A contact between a particle and a clone is due in a round if its key was the lowest of both when the round began, as their owners
//! then said: both ranks see that alike, and work it out alike. Between contacts of its own particles and walls a rank waits for nobody:
//! it goes on with them until what is left waits for a contact with a clone. Two ranks exchange as long as there are contacts between
//! them, which both know; nobody else takes part.

use super::contacts::{Counterpart, HardContact, collect};
use super::key::Key;
use super::model::HardModel;
use super::solver::{ContactSolver, Outcome};
use crate::catalogue::Catalogue;
use crate::contacts::PassStatistics;
use crate::error::{StepError, vector};
use crate::exchange::{Exchange, Forwarded};
use crate::particles::Particles;
use crate::verlet::VerletLists;
use crate::walls::WallScene;
use grains_domain::Transport;
use grains_geometry::Vec3;

/// The collisions of the present step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Collisions {
    contacts: Vec<HardContact>,
    /// Contacts still to be worked off in this sweep.
    pending: Vec<u32>,
    /// How many of them are with clones from each peer.
    shared: Vec<u32>,
    /// The keys of these together, bit by bit.
    keys: Vec<u64>,
    /// Lowest key among the pending contacts of each particle, clones included.
    lowest: Vec<Key>,
    /// Relocation of each particle (m), on the position quanta, clones included.
    relocations: Vec<Vec3>,
    /// Whether the clones of an owned particle are out of date.
    has_changed: Vec<bool>,
}

/// What the collisions of a step came to on this rank.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    /// Impulses, each counted on one rank.
    pub(crate) collisions: u64,
    /// Those of bodies at rest on each other.
    pub(crate) resting: u64,
    /// Rounds, each with an exchange with those ranks that share contacts still to be worked off.
    pub(crate) rounds: u64,
}

/// What the ranks agree on: the highest wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// There are no contacts.
    Idle,
    /// There are.
    Working,
    /// Some contact was not found, or by one of two ranks only.
    Failed,
}

impl Collisions {
    /// Finds all contacts at the present positions.
    pub(crate) fn find(
        &mut self,
        particles: &Particles,
        neighbours: &mut VerletLists,
        scene: &WallScene,
        catalogue: &Catalogue,
        statistics: &mut PassStatistics,
    ) {
        collect(&mut self.contacts, particles, neighbours, scene, catalogue, statistics);
    }

    /// Gives the contacts that were found their impulses, unless `statistics` says that some were not.
    pub(crate) fn resolve(
        &mut self,
        solver: &mut ContactSolver,
        model: &HardModel,
        exchange: &mut Exchange,
        statistics: &mut PassStatistics,
        transport: &impl Transport,
    ) -> Counts {
        let (all, owned) = (solver.particles.len(), solver.particles.owned);
        self.relocations.clear();
        self.relocations.resize(all, Vec3::zeros());
        self.has_changed.clear();
        self.has_changed.resize(owned, false);
        let mut counts = Counts::default();
        if let Some(unmet) = self.unmet(owned, exchange, transport) {
            let error = || unmet_by_other_rank(&self.contacts[unmet], solver.particles);
            statistics.error.get_or_insert_with(error);
        }
        let level = match (&statistics.error, self.contacts.is_empty()) {
            (Some(_), _) => Level::Failed,
            (None, false) => Level::Working,
            (None, true) => Level::Idle,
        };
        // A contact that one rank missed must not be waited for.
        if transport.highest(level as u8) != Level::Working as u8 {
            return counts;
        }
        for _ in 0..model.sweeps {
            let before = counts.collisions;
            self.begin_sweep(all, owned, exchange);
            while !self.pending.is_empty() {
                let mut state = SolverState { particles: solver.particles, collisions: self };
                exchange.forward_to_clones(&mut state, transport);
                self.has_changed.fill(false);
                self.round(solver, model, exchange, &mut counts);
                counts.rounds += 1;
            }
            if model.sweeps > 1 && !transport.any(counts.collisions > before) {
                break;
            }
        }
        counts
    }

    /// The first contact with a clone of another rank that does not have the same contacts with clones of this one; collective.
    fn unmet(&mut self, owned: usize, exchange: &mut Exchange, transport: &impl Transport) -> Option<usize> {
        let Self { contacts, shared, keys, .. } = self;
        shared.clear();
        shared.resize(exchange.peers().len(), 0);
        keys.clear();
        keys.resize(exchange.peers().len(), 0);
        for contact in &*contacts {
            if let Some(peer) = contact.peer(owned, exchange) {
                shared[peer] += 1;
                keys[peer] ^= contact.key.bits();
            }
        }
        let own = |peer: usize| [f64::from(shared[peer]), keys[peer] as f64];
        let mut differing = None;
        let mut compare = |peer: usize, other: &[f64]| {
            if own(peer)[..] != *other {
                differing = Some(peer);
            }
        };
        exchange.tell_peers(|peer, message| message.extend(own(peer)), &mut compare, transport);
        let differing = differing?;
        contacts.iter().position(|contact| contact.peer(owned, exchange) == Some(differing))
    }

    /// Applies the relocations (m) of this step, which then are done.
    pub(crate) fn relocate(&mut self, particles: &mut Particles) {
        for (i, relocation) in self.relocations.iter().enumerate().take(particles.owned) {
            particles.bodies[i].position += relocation;
            if let Some(path_length) = particles.path_length.get_mut(i) {
                *path_length += relocation.norm();
            }
        }
        self.relocations.clear();
    }

    fn begin_sweep(&mut self, all: usize, owned: usize, exchange: &Exchange) {
        self.pending.clear();
        self.pending.extend(0..self.contacts.len() as u32);
        self.shared.clear();
        self.shared.resize(exchange.peers().len(), 0);
        for peer in self.contacts.iter().filter_map(|contact| contact.peer(owned, exchange)) {
            self.shared[peer] += 1;
        }
        self.lowest.clear();
        self.lowest.resize(all, Key::NONE);
        self.find_lowest(owned);
        for (has_changed, lowest) in self.has_changed.iter_mut().zip(&self.lowest) {
            *has_changed |= *lowest < Key::NONE;
        }
    }

    /// Brings the lowest keys of owned particles up to date; those of clones come from their owners.
    fn find_lowest(&mut self, owned: usize) {
        for (lowest, _) in
            self.lowest.iter_mut().zip(&self.has_changed).filter(|(_, has_changed)| **has_changed)
        {
            *lowest = Key::NONE;
        }
        for &k in &self.pending {
            let contact = &self.contacts[k as usize];
            for i in contact.particles().filter(|&i| i < owned) {
                self.lowest[i] = self.lowest[i].min(contact.key);
            }
        }
    }

    /// Works off the contacts that are due, and then all between own particles and walls that wait for no clone.
    fn round(
        &mut self,
        solver: &mut ContactSolver,
        model: &HardModel,
        exchange: &Exchange,
        counts: &mut Counts,
    ) {
        let owned = solver.particles.owned;
        let mut with_clones = true;
        loop {
            let before = self.pending.len();
            self.pass(with_clones, solver, model, exchange, counts);
            self.find_lowest(owned);
            if self.pending.len() == before && !with_clones {
                return;
            }
            with_clones = false;
        }
    }

    /// Works off the contacts whose key is the lowest of both their bodies; no two of them share a body.
    fn pass(
        &mut self,
        with_clones: bool,
        solver: &mut ContactSolver,
        model: &HardModel,
        exchange: &Exchange,
        counts: &mut Counts,
    ) {
        let Self { contacts, pending, shared, lowest, relocations, has_changed, .. } = self;
        let owned = has_changed.len();
        pending.retain(|&k| {
            let contact = &contacts[k as usize];
            let waits = !with_clones && contact.clone(owned).is_some();
            if waits || contact.particles().any(|i| lowest[i] != contact.key) {
                return true;
            }
            let outcome = solver.collide(contact, model);
            solver.relocate(contact, relocations);
            for i in contact.particles() {
                has_changed.get_mut(i).into_iter().for_each(|update| *update = true);
            }
            if let Some(peer) = contact.peer(owned, exchange) {
                shared[peer] -= 1;
            }
            // The rank that owns the first body counts.
            if (contact.a as usize) < owned {
                counts.collisions += u64::from(outcome != Outcome::Separating);
                counts.resting += u64::from(outcome == Outcome::Rest);
            }
            false
        });
    }
}

impl HardContact {
    /// The particles among the two bodies.
    fn particles(&self) -> impl Iterator<Item = usize> + use<> {
        let counterpart = match self.counterpart {
            Counterpart::Particle(b, _) => Some(b as usize),
            Counterpart::Wall { .. } => None,
        };
        std::iter::once(self.a as usize).chain(counterpart)
    }

    /// The clone among them, of this rank or another.
    fn clone(&self, owned: usize) -> Option<usize> {
        self.particles().find(|&i| i >= owned)
    }

    /// The peer whose particle that is a clone of.
    fn peer(&self, owned: usize, exchange: &Exchange) -> Option<usize> {
        exchange.peer_of_clone(self.clone(owned)?)
    }
}

/// What is forwarded to clones of their owners.
struct SolverState<'a> {
    particles: &'a mut Particles,
    collisions: &'a mut Collisions,
}

impl Forwarded for SolverState<'_> {
    /// Velocity, angular velocity, relocation, lowest key.
    const NUMBERS: usize = 11;

    /// As long as contacts with its clones are pending.
    fn is_told(&self, peer: usize) -> bool {
        self.collisions.shared[peer] > 0
    }

    /// Appends how an owned particle fared, if that has changed.
    fn write(&self, i: usize, message: &mut Vec<f64>) -> bool {
        if !self.collisions.has_changed[i] {
            return false;
        }
        let body = &self.particles.bodies[i];
        for v in [body.velocity, body.angular_velocity, self.collisions.relocations[i]] {
            message.extend_from_slice(&[v.x, v.y, v.z]);
        }
        message.extend(self.collisions.lowest[i].numbers());
        true
    }

    /// Takes what [`SolverState::write`] wrote for a clone.
    fn read(&mut self, clone: usize, numbers: &[f64]) {
        let vector = |k: usize| Vec3::new(numbers[k], numbers[k + 1], numbers[k + 2]);
        let body = &mut self.particles.bodies[clone];
        (body.velocity, body.angular_velocity) = (vector(0), vector(3));
        self.collisions.relocations[clone] = vector(6);
        self.collisions.lowest[clone] = Key::from_numbers([numbers[9], numbers[10]]);
    }
}

#[cold]
fn unmet_by_other_rank(contact: &HardContact, particles: &Particles) -> StepError {
    let a = contact.a as usize;
    let other = match contact.counterpart {
        Counterpart::Particle(b, _) => format!("particle {}", particles.ids[b as usize]),
        Counterpart::Wall { wall, .. } => format!("wall {wall}"),
    };
    StepError::Unmatched { id: particles.ids[a], other, place: vector(&particles.bodies[a].position) }
}
