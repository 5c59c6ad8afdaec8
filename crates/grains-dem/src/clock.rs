//! Where the time of a step goes.

use std::time::Instant;

/// Phases of a step, as the final table lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Rebuilding cells, clones and lists.
    Lists,
    /// Updating clones between rebuilds.
    Clones,
    /// Contacts between particles.
    Contacts,
    /// Contacts with walls.
    Walls,
    /// Motion.
    Motion,
    /// Waiting for and agreeing with other ranks.
    Agreement,
    /// Placing new particles.
    Insertion,
    /// Writing files.
    Output,
}

impl Phase {
    /// All phases with their names.
    pub const ALL: [(Phase, &'static str); 8] = [
        (Phase::Lists, "neighbour lists"),
        (Phase::Clones, "clone update"),
        (Phase::Contacts, "particle contacts"),
        (Phase::Walls, "wall contacts"),
        (Phase::Motion, "motion"),
        (Phase::Agreement, "agreement of ranks"),
        (Phase::Insertion, "insertion"),
        (Phase::Output, "output"),
    ];
}

/// Stopwatch over the phases.
#[derive(Clone, Debug)]
pub struct Clock {
    seconds: [f64; Phase::ALL.len()],
    last: Instant,
}

impl Default for Clock {
    fn default() -> Self {
        Self { seconds: [0.0; Phase::ALL.len()], last: Instant::now() }
    }
}

impl Clock {
    /// Starts measuring; time before is charged to no phase.
    pub fn start(&mut self) {
        self.last = Instant::now();
    }

    /// Charges the time since the last call to a phase.
    pub fn charge(&mut self, phase: Phase) {
        let now = Instant::now();
        self.seconds[phase as usize] += (now - self.last).as_secs_f64();
        self.last = now;
    }

    /// Seconds per phase, in the order of [`Phase::ALL`].
    pub fn seconds(&self) -> &[f64] {
        &self.seconds
    }
}
