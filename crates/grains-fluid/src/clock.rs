//! Time spent per phase of a step.

use std::time::Instant;

/// Part of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Advection, explicit diffusion, pressure gradient, sources.
    Momentum,
    /// Implicit diffusion.
    Diffusion,
    /// Divergence of the predicted velocity.
    Divergence,
    /// Pressure equation.
    Pressure,
    /// Correction of velocity and pressure.
    Correction,
    /// Halos and boundary values.
    Boundaries,
    /// Scalars.
    Scalars,
}

impl Phase {
    /// All phases.
    pub const ALL: [Phase; 7] = [
        Phase::Momentum,
        Phase::Diffusion,
        Phase::Divergence,
        Phase::Pressure,
        Phase::Correction,
        Phase::Boundaries,
        Phase::Scalars,
    ];
}

/// Seconds per phase since the beginning.
#[derive(Clone, Debug)]
pub struct Clock {
    seconds: [f64; 7],
    since: Instant,
}

impl Default for Clock {
    fn default() -> Self {
        Self { seconds: [0.0; 7], since: Instant::now() }
    }
}

impl Clock {
    /// Forgets all times.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Time of a phase (s).
    pub fn seconds(&self, phase: Phase) -> f64 {
        self.seconds[phase as usize]
    }

    pub(crate) fn start(&mut self) {
        self.since = Instant::now();
    }

    /// Books the time since the last call to a phase.
    pub(crate) fn book(&mut self, phase: Phase) {
        let now = Instant::now();
        self.seconds[phase as usize] += (now - self.since).as_secs_f64();
        self.since = now;
    }
}
