//! Works off the contacts of a step in rounds, in the same order on any ranks.
//!
//! A contact between a particle and a clone is due in a round if its key was the lowest of both when the round began, as their owners
//! then said: both ranks see that alike, and work it out alike. Contacts of own particles with each other and with walls wait for nobody
//! else: gone through in the order of their keys, each is due unless an earlier one of its bodies is left pending. Two ranks exchange
//! as long as there are contacts between them, which both know; nobody else takes part.

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
    /// Contacts still to be worked off in this sweep, in the order of their keys.
    pending: Vec<u32>,
    /// How many of them are with clones from each peer.
    shared: Vec<u32>,
    /// Scratch: what the keys of contacts with clones come to.
    keys: Vec<u64>,
    /// Lowest key among the contacts of each particle that were pending when the round began, clones included.
    lowest: Vec<Key>,
    /// The same of owned particles as the round leaves it.
    left: Vec<Key>,
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
            let error = || not_met_from_both_sides(&self.contacts[unmet], solver.particles);
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

    /// The first contact with a clone that is not met from the other side: by the rank of its owner, or, if that is this one, by the
    /// owner and a clone. Whoever waits for it would do so for ever; collective.
    fn unmet(&mut self, owned: usize, exchange: &mut Exchange, transport: &impl Transport) -> Option<usize> {
        let Self { contacts, shared, keys, .. } = self;
        let peers = exchange.peers().len();
        shared.clear();
        shared.resize(peers, 0);
        // All bits of the keys shared with each peer, and of those with own clones: each of these is there twice.
        keys.clear();
        keys.resize(peers + 1, 0);
        let side = |contact: &HardContact, exchange: &Exchange| {
            contact.clone(owned).map(|clone| exchange.peer_of_clone(clone).unwrap_or(peers))
        };
        for contact in &*contacts {
            if let Some(side) = side(contact, exchange) {
                shared.get_mut(side).into_iter().for_each(|count| *count += 1);
                keys[side] ^= contact.key.bits();
            }
        }
        let own = |peer: usize| [f64::from(shared[peer]), keys[peer] as f64];
        let mut differing = (keys[peers] != 0).then_some(peers);
        let mut compare = |peer: usize, other: &[f64]| {
            if own(peer)[..] != *other {
                differing = Some(peer);
            }
        };
        exchange.tell_peers(|peer, message| message.extend(own(peer)), &mut compare, transport);
        let differing = differing?;
        contacts.iter().position(|contact| side(contact, exchange) == Some(differing))
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
        let Self { contacts, pending, shared, lowest, has_changed, .. } = self;
        pending.clear();
        pending.extend(0..contacts.len() as u32);
        pending.sort_unstable_by_key(|&k| contacts[k as usize].key);
        shared.clear();
        shared.resize(exchange.peers().len(), 0);
        for peer in contacts.iter().filter_map(|contact| contact.peer(owned, exchange)) {
            shared[peer] += 1;
        }
        lowest.clear();
        lowest.resize(all, Key::NONE);
        for contact in &*contacts {
            for i in contact.particles().filter(|&i| i < owned) {
                lowest[i] = lowest[i].min(contact.key);
                has_changed[i] = true;
            }
        }
    }

    /// Works off the contacts that are due, in the order of their keys.
    fn round(
        &mut self,
        solver: &mut ContactSolver,
        model: &HardModel,
        exchange: &Exchange,
        counts: &mut Counts,
    ) {
        let Self { contacts, pending, shared, lowest, left, relocations, has_changed, .. } = self;
        let owned = has_changed.len();
        left.clear();
        left.resize(owned, Key::NONE);
        pending.retain(|&k| {
            let contact = &contacts[k as usize];
            let is_due = match contact.clone(owned) {
                Some(_) => contact.particles().all(|i| lowest[i] == contact.key),
                None => contact.particles().all(|i| left[i] == Key::NONE),
            };
            if !is_due {
                for i in contact.particles().filter(|&i| i < owned) {
                    left[i] = left[i].min(contact.key);
                }
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
        lowest[..owned].copy_from_slice(left);
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
fn not_met_from_both_sides(contact: &HardContact, particles: &Particles) -> StepError {
    let a = contact.a as usize;
    let other = match contact.counterpart {
        Counterpart::Particle(b, _) => format!("particle {}", particles.ids[b as usize]),
        Counterpart::Wall { wall, .. } => format!("wall {wall}"),
    };
    StepError::Unmatched { id: particles.ids[a], other, place: vector(&particles.bodies[a].position) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at what it does not expect")]
mod tests {
    use super::*;
    use crate::exchange::ExchangeStrategy;
    use grains_domain::{Decomposition, GlobalBox, SerialTransport};

    /// A contact of two bodies of a rank.
    fn contact(a: u32, b: u32, ids: [u64; 2]) -> HardContact {
        HardContact {
            key: Key::of_pair(ids, [0, 0]),
            a,
            counterpart: Counterpart::Particle(b, Vec3::zeros()),
            normal: Vec3::x(),
            overlap: 1e-6,
            arm: Vec3::zeros(),
            restitution: 1.0,
            friction: 0.0,
        }
    }

    #[test]
    fn a_contact_across_a_period_that_one_side_misses_is_not_waited_for() {
        let global = GlobalBox::new([0.0; 3], [1.0; 3], [true; 3]);
        let decomposition = Decomposition::new(global, [1; 3], 0, 0.1).unwrap();
        let mut exchange = Exchange::new(&decomposition, [false; 6], ExchangeStrategy::default(), false);
        // Eight particles, and a clone of each.
        let owned = 8;
        for missing in 0..12 {
            let mut collisions = Collisions::default();
            for a in 0..6 {
                let (b, ids) = (a + 1, [u64::from(a), u64::from(a) + 1]);
                collisions.contacts.push(contact(a, owned + b, ids));
                collisions.contacts.push(contact(owned + a, b, ids));
                // Within the box it is there once.
                collisions.contacts.push(contact(a, a + 2, [u64::from(a), u64::from(a) + 2]));
            }
            let found = collisions.unmet(owned as usize, &mut exchange, &SerialTransport);
            assert_eq!(found, None);
            collisions.contacts.remove(missing / 2 * 3 + missing % 2);
            let found = collisions.unmet(owned as usize, &mut exchange, &SerialTransport);
            assert!(
                found.is_some_and(|k| collisions.contacts[k].clone(owned as usize).is_some()),
                "{missing}"
            );
        }
    }
}
