//! One step: lists or clones, contact loads, and motion.

use super::report::Failure;
use super::state::Dem;
use crate::clock::Phase;
use crate::error::{StepError, vector};
use crate::hard::CollisionModel;
use crate::integrate;
use crate::particles::Load;
use crate::tunnelling;
use grains_domain::Transport;

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

    /// Waits for the clones of other ranks' particles, if they were sent for, and takes new ones of neighbours that rebuild their lists.
    pub fn finish_update(&mut self, transport: &impl Transport) {
        let was_sent_for = self.exchange.finish_update(&mut self.particles, transport);
        self.clock.charge(Phase::Clones);
        if !was_sent_for || !self.are_apart {
            return;
        }
        if self.exchange.notices().iter().any(|notice| notice.rebuilds) {
            self.rebuild_border(transport);
            self.clock.charge(Phase::Lists);
        }
        self.consider_notices();
    }

    /// The same, but clones of other ranks' particles may be up to date only after [`Dem::add_forces`].
    pub fn start_refresh(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        if self.setup.collisions == CollisionModel::Fixed {
            return Ok(());
        }
        self.clock.start();
        self.finish_update(transport);
        self.stale |= self.are_apart && self.is_bond_due();
        // Borders that went as far as they may go on in the next step.
        let have_borders_moved = (self.stale || self.are_apart) && self.balance(transport);
        self.stale |= have_borders_moved;
        self.slide_images(self.stale);
        if self.stale {
            self.rebuild_all(transport)?;
            self.stale = have_borders_moved;
            self.clock.charge(Phase::Lists);
        } else if self.rebuilds_now() {
            self.rebuild_own(transport)?;
            self.clock.charge(Phase::Lists);
        } else {
            let Self { exchange, particles, times, .. } = self;
            exchange.start_update(particles, |peer| times.notice(false, peer), transport);
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
        let is_stale = outcome.is_stale
            || has_crossed
            || std::mem::take(&mut self.has_broken)
            || self.steps_since_build >= self.wall_steps
            || self.way_left < 0.0;
        if self.are_apart {
            self.times.is_due |= is_stale;
            self.look_ahead();
            self.clock.charge(Phase::Motion);
        }
        self.agree(is_stale || self.is_bond_due(), transport)
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
}
