//! What a step reports.

use crate::error::StepError;
use crate::particles::{Body, Cargo};

/// Why a step could not be done; the same kind of answer on every rank.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// This rank met the error.
    Here {
        /// What went wrong.
        error: StepError,
        /// The step it went wrong in.
        step: u64,
    },
    /// Another rank did.
    Elsewhere,
}

/// What the last evaluation of the contacts found on this rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Largest overlap over inscribed radius (-).
    pub max_overlap: f64,
    /// Largest of these since the start (-).
    pub worst_overlap: f64,
    /// Contacts since the start that the penetration routine had to resolve.
    pub deep_penetrations: u64,
    /// Rebuilds of the lists since the start.
    pub rebuilds: u64,
    /// Those of all ranks.
    pub common_rebuilds: u64,
    /// Rebuilds of those with clones alone, as neighbours rebuilt theirs.
    pub border_rebuilds: u64,
    /// Rebuilds of all ranks before which borders between subdomains moved.
    pub moves: u64,
    /// Work until the last rebuild, in pairs of spheres.
    pub work: u64,
    /// Hard collisions since the start, each counted on one rank.
    pub collisions: u64,
    /// Those of them whose restitution was taken as 0: the bodies rest on each other.
    pub resting_collisions: u64,
    /// Rounds since the start in which hard collisions were worked off, each with an exchange with some neighbours.
    pub rounds: u64,
}

/// From where time is counted: t = `time` + (n − `step`) Δt at step n; other than zero after the time step has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Origin {
    /// Step.
    pub step: u64,
    /// Time then (s).
    pub time: f64,
}

impl Origin {
    /// Time (s) of a step.
    pub fn time_of(&self, step: u64, dt: f64) -> f64 {
        self.time + (step - self.step) as f64 * dt
    }

    /// The step nearest to a time (s).
    pub fn step_at(&self, time: f64, dt: f64) -> u64 {
        (self.step as f64 + ((time - self.time) / dt).round()) as u64
    }
}

/// Particles in and out, summed over this rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ledger {
    /// Particles inserted since the case began.
    pub inserted: u64,
    /// Particles that left through outlets.
    pub left: u64,
}

/// Particles with cargo that came and went on this rank, until they are taken: whoever moves them between the phases has to
/// know.
#[derive(Clone, Debug, Default)]
pub struct Passages {
    /// Where they were inserted.
    pub inserted: Vec<Body>,
    /// Where they left through an outlet, with what they carried.
    pub left: Vec<(Body, Cargo)>,
}
