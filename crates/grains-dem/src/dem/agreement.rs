//! What ranks agree on without waiting for each other: errors, stops, and how far particles may act.
//!
//! Every [`EVERY`] steps a rank begins a reduction over all ranks, and reads the one before. So all ranks learn of an error or a stop
//! at the same step, and none waits unless it is that far ahead. A rank that has met an error keeps its particles where they are until
//! then; before anything is written all ranks agree on the step.

use super::report::Failure;
use super::state::Dem;
use crate::clock::Phase;
use crate::particles::Load;
use grains_domain::{SIZE_CLASSES, Transport};
use grains_geometry::Vec3;

/// Steps between two reductions.
const EVERY: u64 = 4;

/// What a rank has to say after a step: the highest level wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Fine,
    /// Lists are to be rebuilt by all ranks, where they do so together.
    Stale,
    Interrupted,
    Failed,
}

/// Numbers in a reduction: the level, minus the step of an error, and what the particles of each class of sizes need.
const NUMBERS: usize = 2 + SIZE_CLASSES;

/// What the ranks have agreed on.
#[derive(Clone, Debug, Default)]
pub(super) struct Agreement {
    /// How far (m) from its centre a particle may act before lists are rebuilt, by class of sizes; the same on all ranks.
    pub(super) ranges: [f64; SIZE_CLASSES],
    /// What the particles of this rank need (m).
    pub(super) needs: [f64; SIZE_CLASSES],
    /// Lower bounds (m) of the ranges when all ranks rebuild next.
    pub(super) wanted: [f64; SIZE_CLASSES],
    /// Whether a reduction has not been read.
    is_unread: bool,
    /// Whether this rank was asked to stop since.
    is_asked: bool,
}

impl Agreement {
    /// Takes ranges that fit the needs of all ranks, up to the `largest` (m), when all rebuild their lists; collective.
    pub(super) fn agree_on_ranges(&mut self, largest: f64, transport: &impl Transport) {
        self.ranges = self.needs;
        transport.max(&mut self.ranges);
        for (range, wanted) in self.ranges.iter_mut().zip(std::mem::take(&mut self.wanted)) {
            *range = range.max(wanted).min(largest);
        }
    }
}

impl Dem {
    /// Says how the step went on this rank, and learns how an earlier one went on all.
    pub(super) fn agree(&mut self, is_stale: bool, transport: &impl Transport) -> Result<(), Failure> {
        self.note_failure();
        if !self.are_apart {
            let level = if is_stale { self.level().max(Level::Stale) } else { self.level() };
            let level = transport.highest(level as u8);
            self.clock.charge(Phase::Agreement);
            self.stale |= level >= Level::Stale as u8;
            self.interrupt = level >= Level::Interrupted as u8;
            return if level >= Level::Failed as u8 { Err(self.failure(self.step)) } else { Ok(()) };
        }
        self.agreement.is_asked |= std::mem::take(&mut self.interrupt);
        if !self.step.is_multiple_of(EVERY) {
            return Ok(());
        }
        let numbers = self.numbers();
        let outcome = self.read_agreement(transport);
        transport.begin_max(&numbers);
        self.agreement.is_unread = true;
        self.agreement.is_asked = false;
        self.clock.charge(Phase::Agreement);
        outcome
    }

    /// Agrees with all ranks on the present step: on errors, a stop, and whether contact loads just added are sound; collective.
    ///
    /// # Errors
    /// A state that can no longer be trusted, on some rank.
    pub fn settle(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.note_failure();
        self.read_agreement(transport)?;
        self.agreement.is_asked |= std::mem::take(&mut self.interrupt);
        let mut numbers = self.numbers();
        self.agreement.is_asked = false;
        transport.max(&mut numbers);
        self.take_agreement(&numbers)
    }

    fn level(&self) -> Level {
        if self.error.is_some() {
            Level::Failed
        } else if self.interrupt || self.agreement.is_asked {
            Level::Interrupted
        } else {
            Level::Fine
        }
    }

    fn numbers(&self) -> [f64; NUMBERS] {
        let mut numbers = [f64::from(self.level() as u8); NUMBERS];
        numbers[1] = self.failed_at.map_or(f64::NEG_INFINITY, |step| -(step as f64));
        numbers[2..].copy_from_slice(&self.agreement.needs);
        numbers
    }

    /// Reads the reduction begun before, if any.
    fn read_agreement(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        if !std::mem::take(&mut self.agreement.is_unread) {
            return Ok(());
        }
        let mut numbers = [0.0; NUMBERS];
        transport.end_max(&mut numbers);
        self.take_agreement(&numbers)
    }

    fn take_agreement(&mut self, numbers: &[f64; NUMBERS]) -> Result<(), Failure> {
        self.interrupt |= numbers[0] >= f64::from(Level::Interrupted as u8);
        if self.are_apart {
            self.widen_ranges(&numbers[2..]);
        }
        match numbers[1].is_finite() {
            true => Err(self.failure(-numbers[1] as u64)),
            false => Ok(()),
        }
    }

    /// Lets particles act farther, if those of some rank need it: all ranks rebuild their lists then.
    fn widen_ranges(&mut self, needs: &[f64]) {
        let largest = self.largest_range();
        let Agreement { ranges, wanted, .. } = &mut self.agreement;
        for ((range, wanted), need) in ranges.iter().zip(wanted).zip(needs) {
            if need.min(largest) > *range {
                // More than is needed, so that a bed that begins to flow does not come back at once.
                *wanted = 1.1 * need;
                self.stale = true;
            }
        }
    }

    /// The largest range (m) for which no particle acts across a whole subdomain.
    pub(super) fn largest_range(&self) -> f64 {
        0.5 * self.decomposition.smallest_width()
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
        for (body, reference) in
            self.particles.bodies[..owned].iter_mut().zip(&self.neighbours.references.places)
        {
            (body.velocity, body.angular_velocity) = (Vec3::zeros(), Vec3::zeros());
            body.position = reference.position;
        }
    }

    /// What this rank has to say of an error that the first rank to do so met at a step.
    fn failure(&mut self, step: u64) -> Failure {
        match self.error.take().filter(|_| self.failed_at == Some(step)) {
            Some(error) => Failure::Here { error, step },
            None => Failure::Elsewhere,
        }
    }
}
