//! What ranks agree on without waiting for each other: errors, stops, and how far particles may act.
//!
//! At the end of each step a rank begins a reduction over all ranks, and reads it [`DELAY`] steps later. So all ranks learn of an
//! error or a stop at the same step, and none waits unless it is that far ahead. A rank that has met an error keeps its particles
//! where they are until then; nobody writes anything before all reductions begun have been read.

use super::report::Failure;
use super::state::Dem;
use crate::clock::Phase;
use crate::particles::Load;
use grains_domain::{SIZE_CLASSES, Transport};
use grains_geometry::Vec3;
use std::collections::VecDeque;

/// Steps after which a reduction is read.
const DELAY: usize = 2;

/// What a rank has to say after a step: the highest level wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub(super) enum Level {
    Fine,
    /// Lists are to be rebuilt by all ranks, where they do so together.
    Stale,
    Interrupted,
    Failed,
}

/// Numbers in a reduction: the level, and what the particles of each class of sizes need.
const NUMBERS: usize = 1 + SIZE_CLASSES;

/// What the ranks have agreed on.
#[derive(Clone, Debug, Default)]
pub(super) struct Agreement {
    /// How far (m) from its centre a particle may act before lists are rebuilt, by class of sizes; the same on all ranks.
    pub(super) ranges: [f64; SIZE_CLASSES],
    /// What the particles of this rank need (m).
    pub(super) needs: [f64; SIZE_CLASSES],
    /// Steps whose reductions have not been read.
    unread: VecDeque<u64>,
}

impl Dem {
    /// Says how the step went on this rank, and learns how an earlier one went on all.
    pub(super) fn agree(&mut self, is_stale: bool, transport: &impl Transport) -> Result<(), Failure> {
        self.note_failure();
        let own = if self.error.is_some() {
            Level::Failed
        } else if self.interrupt {
            Level::Interrupted
        } else if is_stale && !self.are_apart {
            Level::Stale
        } else {
            Level::Fine
        };
        if !self.are_apart {
            let level = transport.highest(own as u8);
            self.clock.charge(Phase::Agreement);
            self.stale |= level >= Level::Stale as u8;
            self.interrupt = level >= Level::Interrupted as u8;
            return self.agreed(level >= Level::Failed as u8, self.step);
        }
        self.interrupt = false;
        let mut numbers = [0.0; NUMBERS];
        numbers[0] = f64::from(own as u8);
        numbers[1..].copy_from_slice(&self.agreement.needs);
        transport.begin_max(&numbers);
        self.agreement.unread.push_back(self.step);
        let outcome = match self.agreement.unread.len() > DELAY {
            true => self.read_agreement(transport),
            false => Ok(()),
        };
        self.clock.charge(Phase::Agreement);
        outcome
    }

    /// Reads all reductions begun, so that what is known of this step is known on all ranks; collective.
    ///
    /// # Errors
    /// A state that can no longer be trusted, on some rank.
    pub fn settle(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        while !self.agreement.unread.is_empty() {
            self.read_agreement(transport)?;
        }
        Ok(())
    }

    /// Reads the earliest reduction.
    fn read_agreement(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        let mut numbers = [0.0; NUMBERS];
        let Some(step) = self.agreement.unread.pop_front() else { return Ok(()) };
        transport.end_max(&mut numbers);
        self.interrupt |= numbers[0] >= f64::from(Level::Interrupted as u8);
        self.widen_ranges(&numbers[1..]);
        self.agreed(numbers[0] >= f64::from(Level::Failed as u8), step)?;
        Ok(())
    }

    /// Lets particles act farther, if those of some rank need it: all ranks rebuild their lists then.
    fn widen_ranges(&mut self, needs: &[f64]) {
        let largest = self.largest_range();
        for (range, need) in self.agreement.ranges.iter_mut().zip(needs) {
            if need.min(largest) > *range {
                // More than is needed, so that a bed that begins to flow does not come back at once.
                *range = (1.1 * need).min(largest);
                self.stale = true;
            }
        }
    }

    /// The largest range (m) for which no particle acts across a whole subdomain.
    pub(super) fn largest_range(&self) -> f64 {
        0.5 * self.decomposition.smallest_width()
    }

    /// Whether the contact loads just added are sound on all ranks, as [`Dem::advance`] would say; collective.
    pub fn check(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.note_failure();
        self.settle(transport)?;
        let failed = transport.highest(u8::from(self.error.is_some())) > 0;
        self.agreed(failed, self.step)
    }

    /// Notes at which step an error was met; its rank keeps its particles where they are until all ranks know.
    pub(super) fn note_failure(&mut self) {
        if self.error.is_none() || self.failed_at.is_some() {
            return;
        }
        self.failed_at = Some(self.step);
        if !self.are_apart {
            return;
        }
        let owned = self.particles.owned;
        self.particles.loads.fill(Load::default());
        self.particles.half_velocity.fill(Vec3::zeros());
        self.particles.half_spin.fill(Vec3::zeros());
        for (body, reference) in self.particles.bodies[..owned].iter_mut().zip(&self.neighbours.references.places)
        {
            (body.velocity, body.angular_velocity) = (Vec3::zeros(), Vec3::zeros());
            body.position = reference.position;
        }
    }

    /// The outcome of a step, if some rank failed in it.
    fn agreed(&mut self, has_failed: bool, step: u64) -> Result<(), Failure> {
        if !has_failed {
            return Ok(());
        }
        match self.failed_at.filter(|&at| at <= step).and_then(|step| Some((self.error.take()?, step))) {
            Some((error, step)) => Err(Failure::Here { error, step }),
            None => Err(Failure::Elsewhere),
        }
    }
}
