//! The loads of the contacts of a step.

use super::setup::DemSetup;
use super::state::Dem;
use crate::bonds::{self, BondPass};
use crate::clock::Phase;
use crate::contacts::{ContactPass, PassStatistics, add_sphere_forces};
use crate::exchange::Exchange;
use crate::hard::{CollisionModel, ContactSolver, HardModel};
use crate::lubrication;
use crate::non_spherical;
use crate::particles::{Load, Particles};
use crate::verlet::{Inner, VerletLists};
use crate::walls::{self, WallLoad, WallScene, WallSums};
use grains_contact::Lubrication;
use grains_domain::Transport;

/// Pairs of spheres between two moments in which messages may go on: some 0.1 ms of work, in whole blocks of lanes.
const PAIRS_BETWEEN: usize = 4096;

/// Whom contacts are with.
#[derive(Clone, Copy)]
enum With {
    Owned,
    Clones,
}

impl Dem {
    /// Adds the loads of all contacts at the present positions; hard contacts change velocities instead.
    pub fn add_forces(&mut self, transport: &impl Transport) {
        if self.setup.collisions == CollisionModel::Fixed {
            return;
        }
        self.clock.start();
        if let CollisionModel::Hard(model) = self.setup.collisions {
            self.finish_update(transport);
            return self.collide(&model, transport);
        }
        let mut statistics = PassStatistics::new(self.setup.overlap_limit);
        self.touching.clear();
        self.begin_virial();
        self.add_pair_forces(With::Owned, &mut statistics, transport);
        self.add_bond_forces(With::Owned);
        self.exchange.advance_update(transport);
        self.clock.charge(Phase::Contacts);
        self.add_wall_forces(&mut statistics);
        self.clock.charge(Phase::Walls);
        self.finish_update(transport);
        self.add_pair_forces(With::Clones, &mut statistics, transport);
        self.add_bond_forces(With::Clones);
        self.clock.charge(Phase::Contacts);
        self.add_lubrication(&mut statistics);
        self.conduct(&mut statistics, transport);
        self.sum_stress();
        self.particles.settle_films();
        self.clock.charge(Phase::Walls);
        self.note(statistics);
        if self.particles.is_carrying() {
            self.check_contact_forces();
        }
    }

    /// Looks for a sum of contact forces that is not exact, before other forces join it.
    fn check_contact_forces(&mut self) {
        let largest = self.quanta.largest_force;
        let is_beyond = |load: &Load| load.force.amax() > largest;
        if let Some(i) = self.particles.loads.iter().position(is_beyond) {
            let force = self.particles.loads[i].force.norm();
            self.overloaded(i, force);
        }
    }

    /// The parts of the system that a pass over the contacts works on.
    fn contact_pass<'a>(&'a mut self, statistics: &'a mut PassStatistics) -> PassParts<'a> {
        let time = self.time();
        let Self { particles, neighbours, exchange, setup, quanta, states, wall_loads, sliding, .. } = self;
        let liquid = &mut self.liquid_ledger;
        let is_due = setup.thermal.as_ref().is_some_and(|thermal| self.step.is_multiple_of(thermal.every));
        let touching = is_due.then_some(&mut self.touching);
        let (catalogue, dt) = (&setup.catalogue, setup.parameters.dt);
        PassParts {
            particles,
            neighbours,
            exchange,
            wall_sums: WallSums { loads: wall_loads, sliding },
            scene: setup.wall_scene(states, time),
            lubrication: setup.lubrication.as_ref(),
            pass: ContactPass { catalogue, quanta: *quanta, dt, statistics, liquid, touching },
        }
    }

    /// Adds the loads of the contacts of owned particles with each other, or with clones.
    fn add_pair_forces(&mut self, with: With, statistics: &mut PassStatistics, transport: &impl Transport) {
        let PassParts { particles, neighbours, exchange, mut pass, .. } = self.contact_pass(statistics);
        let Inner { spheres, part_pairs, .. } = neighbours.inner;
        let VerletLists { spheres: pairs, sphere_laws: laws, .. } = neighbours;
        let (pairs, others) = pairs.split_at_mut(spheres);
        let kept = spheres.min(laws.len());
        let (laws, laws_of_others) = laws.split_at_mut(kept);
        let (spheres, range) = match with {
            With::Owned => ((pairs, laws), 0..part_pairs),
            With::Clones => ((others, laws_of_others), part_pairs..neighbours.part_pairs.pairs.len()),
        };
        let (pairs, laws) = spheres;
        let mut laws = laws.chunks_mut(PAIRS_BETWEEN);
        for pairs in pairs.chunks_mut(PAIRS_BETWEEN) {
            add_sphere_forces(particles, (pairs, laws.next().unwrap_or_default()), &mut pass);
            exchange.advance_update(transport);
        }
        non_spherical::add_forces(particles, (&mut neighbours.part_pairs, range), &mut pass);
    }

    /// Adds the loads of bonds of owned particles with each other, or with clones.
    fn add_bond_forces(&mut self, with: With) {
        let Self { particles, neighbours, setup, quanta, dt_before, .. } = self;
        let (bonds, others) = neighbours.bonds.bonds.split_at_mut(neighbours.bonds.inner);
        let bonds = match with {
            With::Owned => bonds,
            With::Clones => others,
        };
        let DemSetup { bonds: kinds, catalogue, parameters, .. } = &*setup;
        let (quanta, dt, dt_before) = (*quanta, parameters.dt, dt_before.unwrap_or(parameters.dt));
        let mut pass = BondPass { kinds, catalogue, quanta, dt, dt_before, broken: 0, error: None };
        bonds::add_forces(particles, bonds, &mut pass);
        self.error = self.error.take().or(pass.error);
        self.bond_ledger.broken += pass.broken;
        // Pairs whose bond broke meet as others do.
        self.has_broken |= pass.broken > 0;
    }

    fn add_wall_forces(&mut self, statistics: &mut PassStatistics) {
        self.wall_loads.fill(WallLoad::default());
        self.sliding.begin();
        let PassParts { particles, neighbours, mut wall_sums, scene, mut pass, .. } =
            self.contact_pass(statistics);
        walls::add_forces(particles, &mut neighbours.walls, &scene, &mut wall_sums, &mut pass);
    }

    /// Adds the lubrication forces of spheres with each other and with walls.
    fn add_lubrication(&mut self, statistics: &mut PassStatistics) {
        let parts = self.contact_pass(statistics);
        let PassParts { particles, neighbours, wall_sums, scene, lubrication, pass, .. } = parts;
        let Some(law) = lubrication else { return };
        lubrication::add_between_spheres(particles, &neighbours.spheres, law, &pass.quanta, pass.dt);
        lubrication::add_at_walls(particles, &neighbours.walls, &scene, law, wall_sums.loads, pass);
    }

    fn note(&mut self, statistics: PassStatistics) {
        self.report.max_overlap = statistics.max_overlap();
        self.report.worst_overlap = self.report.worst_overlap.max(self.report.max_overlap);
        self.report.deep_penetrations += statistics.deep_penetrations;
        self.error = self.error.take().or(statistics.error);
    }

    /// Gives all contacts at the present positions their impulses.
    ///
    /// The loads of particles and walls are what was exchanged over the time step; nothing moves by them.
    fn collide(&mut self, model: &HardModel, transport: &impl Transport) {
        self.collision_loads.fill(Default::default());
        let mut statistics = PassStatistics::new(self.setup.overlap_limit);
        let time = self.time();
        let Self { particles, neighbours, setup, states, collision_loads, collisions, exchange, .. } = self;
        let (scene, catalogue) = (setup.wall_scene(states, time), &setup.catalogue);
        collisions.find(particles, neighbours, &scene, catalogue, &mut statistics);
        let (positions, dt) = (&setup.global.quantum, setup.parameters.dt);
        let mut solver = ContactSolver { particles, catalogue, wall_loads: collision_loads, positions, dt };
        let counts = collisions.resolve(&mut solver, model, exchange, &mut statistics, transport);
        self.report.collisions += counts.collisions;
        self.report.resting_collisions += counts.resting;
        self.report.rounds += counts.rounds;
        self.note(statistics);
        self.clock.charge(Phase::Contacts);
    }
}

/// What a pass over the contacts works on.
struct PassParts<'a> {
    particles: &'a mut Particles,
    neighbours: &'a mut VerletLists,
    exchange: &'a mut Exchange,
    wall_sums: WallSums<'a>,
    scene: WallScene<'a>,
    lubrication: Option<&'a Lubrication>,
    pass: ContactPass<'a>,
}
