//! Works off the contacts of a step in rounds, in the same order on any ranks.

use super::contacts::{Counterpart, HardContact, collect};
use super::key::Key;
use super::model::HardModel;
use super::solver::{ContactSolver, Outcome};
use crate::catalogue::Catalogue;
use crate::contacts::PassStatistics;
use crate::error::{StepError, vector};
use crate::exchange::Exchange;
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
    /// Rounds, the same on all ranks.
    pub(crate) rounds: u64,
}

/// What the ranks agree on: the highest wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// Nothing is pending.
    Done,
    /// What is pending waits for contacts of other ranks.
    Waiting,
    /// There is more to do.
    Working,
    /// Some contact was not found.
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
        let level = match (&statistics.error, self.contacts.is_empty()) {
            (Some(_), _) => Level::Failed,
            (None, false) => Level::Working,
            (None, true) => Level::Done,
        };
        // A contact that one rank missed must not be waited for.
        if transport.highest(level as u8) != Level::Working as u8 {
            return counts;
        }
        for _ in 0..model.sweeps {
            let before = counts.collisions;
            self.begin_sweep(all, owned);
            if !self.work_off(solver, model, exchange, &mut counts, transport) {
                let unmet = self.pending.first().map(|&k| &self.contacts[k as usize]);
                statistics.error = unmet.map(|contact| waits_for_ever(contact, solver.particles));
                break;
            }
            if model.sweeps > 1 && !transport.any(counts.collisions > before) {
                break;
            }
        }
        counts
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

    fn begin_sweep(&mut self, all: usize, owned: usize) {
        self.pending.clear();
        self.pending.extend(0..self.contacts.len() as u32);
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

    /// Works off every pending contact once, round by round; returns whether that came to an end.
    fn work_off(
        &mut self,
        solver: &mut ContactSolver,
        model: &HardModel,
        exchange: &mut Exchange,
        counts: &mut Counts,
        transport: &impl Transport,
    ) -> bool {
        // A rank that has worked off its last contact says `Done` while others still wait to hear of it.
        let mut waits = 0;
        while waits <= transport.size() {
            let mut state = SolverState { particles: solver.particles, collisions: self };
            exchange.forward_to_clones(
                &mut state,
                SolverState::NUMBERS,
                SolverState::write,
                SolverState::read,
                transport,
            );
            self.has_changed.fill(false);
            let before = self.pending.len();
            self.round(solver, model, counts);
            self.find_lowest(solver.particles.owned);
            counts.rounds += 1;
            let level = match self.pending.len() {
                0 => Level::Done,
                left if left < before => Level::Working,
                _ => Level::Waiting,
            };
            let highest = transport.highest(level as u8);
            if highest == Level::Done as u8 {
                return true;
            }
            waits = if highest == Level::Waiting as u8 { waits + 1 } else { 0 };
        }
        false
    }

    /// Works off the contacts whose key is the lowest of both their bodies; no two of them share a body.
    fn round(&mut self, solver: &mut ContactSolver, model: &HardModel, counts: &mut Counts) {
        let Self { contacts, pending, lowest, relocations, has_changed } = self;
        pending.retain(|&k| {
            let contact = &contacts[k as usize];
            if contact.particles().any(|i| lowest[i] != contact.key) {
                return true;
            }
            let outcome = solver.collide(contact, model);
            solver.relocate(contact, relocations);
            for i in contact.particles() {
                has_changed.get_mut(i).into_iter().for_each(|update| *update = true);
            }
            // The rank that owns the first body counts.
            if (contact.a as usize) < has_changed.len() {
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
}

/// What is forwarded to clones of their owners.
struct SolverState<'a> {
    particles: &'a mut Particles,
    collisions: &'a mut Collisions,
}

impl SolverState<'_> {
    /// Velocity, angular velocity, relocation, lowest key.
    const NUMBERS: usize = 11;

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
fn waits_for_ever(contact: &HardContact, particles: &Particles) -> StepError {
    let a = contact.a as usize;
    let other = match contact.counterpart {
        Counterpart::Particle(b, _) => format!("particle {}", particles.ids[b as usize]),
        Counterpart::Wall { wall, .. } => format!("wall {wall}"),
    };
    StepError::Unmatched { id: particles.ids[a], other, place: vector(&particles.bodies[a].position) }
}
