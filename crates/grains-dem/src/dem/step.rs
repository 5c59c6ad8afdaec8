//! One step: contact loads, motion, and the agreement of the ranks.

use super::report::Failure;
use super::state::Dem;
use crate::clock::Phase;
use crate::contacts::{Tally, add_sphere_forces};
use crate::error::{StepError, vector};
use crate::hard::{CollisionModel, HardModel, Site};
use crate::integrate;
use crate::lubrication;
use crate::non_spherical;
use crate::particles::Load;
use crate::tunnelling;
use crate::verlet::Inner;
use crate::walls::{self, WallLoad};
use grains_domain::Transport;

/// What the ranks agree on after a step: the highest level wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Fine,
    Stale,
    Interrupted,
    Failed,
}

/// Whom contacts are with.
#[derive(Clone, Copy)]
enum With {
    Owned,
    Clones,
}

impl Dem {
    /// One leap-frog step: refreshes lists or clones, adds the contact loads, kicks and drifts.
    pub fn step(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.start_refresh(transport)?;
        self.add_forces(transport);
        self.advance(transport)
    }

    /// Makes clones and lists fit the positions.
    pub fn refresh(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.start_refresh(transport)?;
        self.clock.start();
        self.finish_update(transport);
        Ok(())
    }

    /// Waits for the clones of other ranks' particles, if they were sent for.
    fn finish_update(&mut self, transport: &impl Transport) {
        self.exchange.finish_update(&mut self.particles, transport);
        self.clock.charge(Phase::Clones);
    }

    /// The same, but clones of other ranks' particles may be up to date only after [`Dem::add_forces`].
    pub fn start_refresh(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        if self.setup.collisions == CollisionModel::Held {
            return Ok(());
        }
        self.clock.start();
        self.finish_update(transport);
        if self.stale {
            self.rebuild(transport)?;
            self.clock.charge(Phase::Lists);
        } else {
            self.exchange.start_update(&mut self.particles, transport);
            self.clock.charge(Phase::Clones);
        }
        Ok(())
    }

    /// Adds the loads of all contacts at the present positions; hard contacts change velocities instead.
    pub fn add_forces(&mut self, transport: &impl Transport) {
        if self.setup.collisions == CollisionModel::Held {
            return;
        }
        self.clock.start();
        if let CollisionModel::Hard(model) = self.setup.collisions {
            self.finish_update(transport);
            return self.collide(&model, transport);
        }
        let mut tally = Tally::new(self.setup.overlap_limit);
        self.add_pair_forces(With::Owned, &mut tally);
        self.clock.charge(Phase::Contacts);
        self.add_wall_forces(&mut tally);
        self.clock.charge(Phase::Walls);
        self.finish_update(transport);
        self.add_pair_forces(With::Clones, &mut tally);
        self.clock.charge(Phase::Contacts);
        self.add_films(&mut tally);
        self.clock.charge(Phase::Walls);
        self.note(tally);
        if self.particles.is_carrying() {
            self.check_contact_forces();
        }
    }

    /// Looks for a sum of contact forces that is not exact, before other forces join it.
    fn check_contact_forces(&mut self) {
        let largest = self.lattice.largest_force;
        let is_beyond = |load: &Load| load.force.amax() > largest;
        if let Some(i) = self.particles.loads.iter().position(is_beyond) {
            let force = self.particles.loads[i].force.norm();
            self.overloaded(i, force);
        }
    }

    /// Looks for what particles that went far in this step may have passed through.
    fn check_passing(&mut self, fast: &[usize]) {
        let scene = self.setup.wall_scene(&self.states, self.time());
        let (catalogue, step) = (&self.setup.catalogue, self.step + 1);
        let found = tunnelling::check(&self.particles, &self.neighbours, fast, &scene, catalogue, step);
        self.error = self.error.take().or(found);
    }

    fn overloaded(&mut self, i: usize, force: f64) {
        let (id, place) = (self.particles.ids[i], vector(&self.particles.bodies[i].position));
        self.error = self.error.take().or(Some(StepError::Load { id, place, force }));
    }

    /// Adds the loads of the contacts of owned particles with each other, or with clones.
    fn add_pair_forces(&mut self, with: With, tally: &mut Tally) {
        let Self { particles, neighbours, setup, lattice, .. } = self;
        let (catalogue, dt) = (&setup.catalogue, setup.rates.dt);
        let Inner { spheres, bodies } = neighbours.inner;
        let (spheres, bodies) = match with {
            With::Owned => (&mut neighbours.spheres[..spheres], 0..bodies),
            With::Clones => (&mut neighbours.spheres[spheres..], bodies..neighbours.bodies.pairs.len()),
        };
        add_sphere_forces(particles, spheres, &catalogue.contacts, lattice, dt, tally);
        non_spherical::add_forces(particles, (&mut neighbours.bodies, bodies), catalogue, lattice, dt, tally);
    }

    fn add_films(&mut self, tally: &mut Tally) {
        let time = self.time();
        let Self { particles, neighbours, setup, lattice, states, wall_loads, .. } = self;
        let Some(film) = &setup.lubrication else { return };
        lubrication::add_between_spheres(particles, &neighbours.spheres, film, lattice, setup.rates.dt);
        let scene = setup.wall_scene(states, time);
        let (walls, catalogue) = (&neighbours.walls, &setup.catalogue);
        let found = lubrication::add_at_walls(particles, walls, &scene, catalogue, film, lattice, wall_loads);
        tally.error = tally.error.take().or(found.err());
    }

    fn note(&mut self, tally: Tally) {
        self.report.largest_overlap = tally.largest_overlap();
        self.report.worst_overlap = self.report.worst_overlap.max(self.report.largest_overlap);
        self.report.cores_met += tally.cores_met;
        self.error = self.error.take().or(tally.error);
    }

    /// Gives all contacts at the present positions their impulses.
    ///
    /// The loads of particles and walls are what was exchanged over the time step; nothing moves by them.
    fn collide(&mut self, model: &HardModel, transport: &impl Transport) {
        self.wall_loads.fill(WallLoad::default());
        let mut tally = Tally::new(self.setup.overlap_limit);
        let time = self.time();
        let Self { particles, neighbours, setup, states, wall_loads, collisions, exchange, .. } = self;
        let (scene, catalogue) = (setup.wall_scene(states, time), &setup.catalogue);
        collisions.find(particles, neighbours, &scene, catalogue, &mut tally);
        let (positions, dt) = (&setup.global.lattice, setup.rates.dt);
        let mut site = Site { particles, catalogue, wall_loads, positions, dt };
        let counts = collisions.resolve(&mut site, model, exchange, &mut tally, transport);
        self.report.collisions += counts.collisions;
        self.report.resting_collisions += counts.resting;
        self.report.rounds += counts.rounds;
        self.note(tally);
        self.clock.charge(Phase::Contacts);
    }

    fn add_wall_forces(&mut self, tally: &mut Tally) {
        self.wall_loads.fill(WallLoad::default());
        let time = self.time();
        let Self { particles, neighbours, setup, lattice, states, wall_loads, .. } = self;
        let scene = setup.wall_scene(states, time);
        walls::add_forces(
            particles,
            &mut neighbours.walls,
            &scene,
            &setup.catalogue,
            lattice,
            wall_loads,
            tally,
        );
    }

    /// Kicks and drifts, moves the walls, and agrees with the other ranks on errors and stale lists.
    pub fn advance(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.clock.start();
        let dt = self.setup.rates.dt;
        let courses = self.courses([self.step, self.step + 1].map(|step| self.origin.time_of(step, dt)));
        let Self { particles, neighbours, setup, lattice, collisions, .. } = self;
        if setup.collisions != CollisionModel::Soft {
            collisions.relocate(particles);
            particles.loads.fill(Load::default());
        }
        // What a fluid adds is no contact force: those were looked at before.
        let largest_force = if particles.is_carrying() { f64::INFINITY } else { lattice.largest_force };
        let outcome = integrate::advance(
            particles,
            neighbours,
            &setup.catalogue,
            (&setup.global, &courses),
            &setup.rates,
            largest_force,
        );
        if let Some((i, force)) = outcome.overloaded {
            self.overloaded(i, force);
        }
        if !outcome.fast.is_empty() && self.setup.collisions != CollisionModel::Held {
            self.check_passing(&outcome.fast);
        }
        self.step += 1;
        self.steps_since_build += 1;
        self.place_walls();
        self.clock.charge(Phase::Motion);
        let own = if self.error.is_some() {
            Level::Failed
        } else if self.interrupt {
            Level::Interrupted
        } else if outcome.is_stale || self.steps_since_build >= self.wall_steps {
            Level::Stale
        } else {
            Level::Fine
        };
        let level = transport.highest(own as u8);
        self.clock.charge(Phase::Agreement);
        self.stale |= level >= Level::Stale as u8;
        self.interrupt = level >= Level::Interrupted as u8;
        self.agreed(level >= Level::Failed as u8)
    }

    /// Whether the contact loads just added are sound on all ranks, as [`Dem::advance`] would say.
    pub fn check(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        let failed = transport.highest(u8::from(self.error.is_some())) > 0;
        self.agreed(failed)
    }

    fn agreed(&mut self, failed: bool) -> Result<(), Failure> {
        match (failed, self.error.take()) {
            (false, _) => Ok(()),
            (true, Some(error)) => Err(Failure::Here(error)),
            (true, None) => Err(Failure::Elsewhere),
        }
    }
}
