//! One step: lists or clones, contact loads, motion, and the agreement of the ranks.

use super::report::Failure;
use super::state::Dem;
use crate::clock::Phase;
use crate::error::{StepError, vector};
use crate::hard::CollisionModel;
use crate::integrate;
use crate::particles::Load;
use crate::tunnelling;
use grains_domain::Transport;

/// What the ranks agree on after a step: the highest level wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Fine,
    Stale,
    Interrupted,
    Failed,
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
    pub(super) fn finish_update(&mut self, transport: &impl Transport) {
        self.exchange.finish_update(&mut self.particles, transport);
        self.clock.charge(Phase::Clones);
    }

    /// The same, but clones of other ranks' particles may be up to date only after [`Dem::add_forces`].
    pub fn start_refresh(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        if self.setup.collisions == CollisionModel::Fixed {
            return Ok(());
        }
        self.clock.start();
        self.finish_update(transport);
        self.slide_images(self.stale);
        if self.stale {
            self.rebuild(transport)?;
            self.clock.charge(Phase::Lists);
        } else {
            self.exchange.start_update(&mut self.particles, transport);
            self.clock.charge(Phase::Clones);
        }
        Ok(())
    }

    /// Kicks and drifts, moves the walls, and agrees with the other ranks on errors and stale lists.
    pub fn advance(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.clock.start();
        let dt = self.setup.parameters.dt;
        let courses = self.courses([self.step, self.step + 1].map(|step| self.origin.time_of(step, dt)));
        let Self { particles, neighbours, setup, quanta, collisions, .. } = self;
        if setup.collisions != CollisionModel::Soft {
            collisions.relocate(particles);
            particles.loads.fill(Load::default());
        }
        // What a fluid adds is no contact force: those were looked at before.
        let largest_force = if particles.is_carrying() { f64::INFINITY } else { quanta.largest_force };
        let outcome = integrate::advance(
            particles,
            neighbours,
            &setup.catalogue,
            (&setup.global, &courses),
            &setup.parameters,
            largest_force,
        );
        if let Some((i, force)) = outcome.overloaded {
            self.overloaded(i, force);
        }
        if !outcome.fast.is_empty() && self.setup.collisions != CollisionModel::Fixed {
            self.check_tunnelling(&outcome.fast);
        }
        let has_crossed = self.images.is_some_and(|images| images.follow(&mut self.particles));
        self.heat_up();
        self.move_loaded_walls(transport);
        self.sliding.finish();
        self.step += 1;
        self.dt_before = None;
        self.steps_since_build += 1;
        self.place_walls();
        self.check_loaded_walls();
        self.clock.charge(Phase::Motion);
        let has_broken = std::mem::take(&mut self.has_broken);
        self.agree(outcome.is_stale || has_crossed || has_broken, transport)
    }

    /// Agrees with the other ranks on errors, an interrupt, and stale lists.
    fn agree(&mut self, is_stale: bool, transport: &impl Transport) -> Result<(), Failure> {
        let own = if self.error.is_some() {
            Level::Failed
        } else if self.interrupt {
            Level::Interrupted
        } else if is_stale
            || self.is_bond_due()
            || self.steps_since_build >= self.wall_steps
            || self.way_left < 0.0
        {
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

    /// Looks for what particles that went far in this step may have passed through.
    fn check_tunnelling(&mut self, fast: &[usize]) {
        let scene = self.setup.wall_scene(&self.states, self.time());
        let (catalogue, step) = (&self.setup.catalogue, self.step + 1);
        let found = tunnelling::check(&self.particles, &self.neighbours, fast, &scene, catalogue, step);
        self.error = self.error.take().or(found);
    }

    pub(super) fn overloaded(&mut self, i: usize, force: f64) {
        let (id, place) = (self.particles.ids[i], vector(&self.particles.bodies[i].position));
        self.error = self.error.take().or(Some(StepError::Load { id, place, force }));
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
