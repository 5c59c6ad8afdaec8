//! What a simulation reports: while it runs, and at its end.

use crate::cost::peak_memory;
use crate::files::Row;
use crate::fluid::{FluidPhase, FluidProgress};
use crate::insertion::Insertions;
use grains_comm::MpiTransport;
use grains_dem::{Dem, Phase};
use grains_domain::Transport;

/// Where a simulation is, at a row of its time series.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Step of the particles.
    pub step: u64,
    /// Time (s).
    pub time: f64,
    /// The last step.
    pub end: u64,
    /// Sums and extremes over all particles.
    pub totals: Row,
    /// The fluid, if there is one.
    pub fluid: Option<FluidProgress>,
}

/// Time spent in a part of the step over the ranks (s).
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTime {
    /// Its name.
    pub name: String,
    /// Minimum.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Maximum.
    pub max: f64,
}

/// What the fluid of a simulation has done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidSummary {
    /// Steps.
    pub steps: u64,
    /// Iterations for the pressure in all steps.
    pub iterations: u64,
    /// Cells.
    pub cells: usize,
    /// Time in its steps on this rank (s).
    pub seconds: f64,
    /// Whether nothing moved but the fluid.
    pub is_alone: bool,
}

/// What a simulation has done, on all ranks.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Ranks.
    pub ranks: usize,
    /// Wall-clock time (s).
    pub seconds: f64,
    /// Steps of the particles.
    pub steps: u64,
    /// Steps of the particles times how many were inside at each.
    pub particle_steps: u64,
    /// Times by part of the step.
    pub phases: Vec<PhaseTime>,
    /// Memory at the peak (bytes): of all ranks, and of the largest.
    pub memory: [f64; 2],
    /// Particles inserted since the case began, inside now, and gone through outlets.
    pub inserted: u64,
    /// Particles inside.
    pub inside: u64,
    /// Particles that left through outlets.
    pub left: u64,
    /// Min. and max. particles of a rank.
    pub per_rank: [u64; 2],
    /// Work of the busiest rank over the mean (-).
    pub imbalance: f64,
    /// How often borders between ranks moved.
    pub moves: u64,
    /// Min. and max. of how often a rank built its neighbour lists.
    pub rebuilds: [u64; 2],
    /// Contacts whose shrunken cores met.
    pub deep_penetrations: u64,
    /// Largest overlap over the inscribed radius (-).
    pub worst_overlap: f64,
    /// Hard collisions, those of bodies at rest on each other among them, and max. rounds in which a rank worked them off.
    pub collisions: [u64; 3],
    /// Insertions that are not complete, and how many particles each lacks.
    pub missing: Vec<(String, u64)>,
    /// The fluid, if there is one.
    pub fluid: Option<FluidSummary>,
}

/// What a simulation has done is in these.
pub(crate) struct Done<'a> {
    pub dem: &'a Dem,
    pub fluid: Option<&'a FluidPhase>,
    pub insertions: &'a Insertions,
    /// Wall-clock time (s).
    pub seconds: f64,
    /// Steps of the particles.
    pub steps: u64,
    /// Particles of this rank, summed over the steps.
    pub particle_steps: u64,
}

impl Summary {
    /// Wall-clock time per particle and step (µs), if particles have moved.
    pub fn microseconds_per_particle_step(&self) -> Option<f64> {
        (self.particle_steps > 0).then(|| 1e6 * self.seconds / self.particle_steps as f64)
    }

    /// That of a simulation; collective.
    pub(crate) fn of(done: &Done, transport: &MpiTransport) -> Self {
        let (dem, report) = (done.dem, &done.dem.report);
        let own = [dem.particles.owned as u64, dem.work()];
        let mut counts = [
            own[0],
            own[1],
            dem.ledger.inserted,
            dem.ledger.left,
            report.deep_penetrations,
            report.collisions,
            report.resting_collisions,
            done.particle_steps,
        ];
        transport.sum_counts(&mut counts);
        let [inside, work, inserted, left, deep_penetrations, collisions, resting, particle_steps] = counts;
        let [particles, own_work, rebuilds, rounds] =
            [own[0], own[1], report.rebuilds, report.rounds].map(|n| n as f64);
        let mut extremes =
            [particles, -particles, report.worst_overlap, own_work, rebuilds, -rebuilds, rounds];
        transport.max(&mut extremes);
        let ranks = transport.size();
        Self {
            ranks,
            seconds: done.seconds,
            steps: done.steps,
            particle_steps,
            phases: phase_times(done, transport),
            memory: memory(transport),
            inserted,
            inside,
            left,
            per_rank: [-extremes[1] as u64, extremes[0] as u64],
            imbalance: extremes[3] * ranks as f64 / (work as f64).max(1.0),
            moves: report.moves,
            rebuilds: [-extremes[5] as u64, extremes[4] as u64],
            deep_penetrations,
            worst_overlap: extremes[2],
            collisions: [collisions, resting, extremes[6] as u64],
            missing: done.insertions.missing().map(|(name, n)| (name.to_string(), n)).collect(),
            fluid: done.fluid.map(FluidSummary::of),
        }
    }
}

impl FluidSummary {
    /// Time of the cores per cell and step of the fluid on a number of ranks (ns).
    pub fn nanoseconds_per_cell_step(&self, ranks: usize) -> f64 {
        1e9 * self.seconds * ranks as f64 / self.steps.max(1) as f64 / self.cells as f64
    }

    fn of(fluid: &FluidPhase) -> Self {
        Self {
            steps: fluid.steps,
            iterations: fluid.iterations,
            cells: fluid.flow.setup.grid.cells().iter().product(),
            seconds: fluid.seconds.flow,
            is_alone: fluid.is_alone(),
        }
    }
}

/// Times spent in the parts of a step, and in none of them; collective.
fn phase_times(done: &Done, transport: &MpiTransport) -> Vec<PhaseTime> {
    let seconds = done.dem.clock.seconds();
    let phases = Phase::ALL.iter().zip(seconds).map(|((_, name), &s)| (name.to_string(), s));
    let mut parts: Vec<(String, f64)> =
        phases.chain(done.fluid.into_iter().flat_map(FluidPhase::times)).collect();
    let known: f64 = parts.iter().map(|&(_, s)| s).sum();
    parts.push(("everything else".to_string(), (done.seconds - known).max(0.0)));
    let mut sums: Vec<f64> = parts.iter().map(|&(_, s)| s).collect();
    // The maximum of each and, as that of the negative, the minimum.
    let mut spans: Vec<f64> = sums.iter().flat_map(|&s| [s, -s]).collect();
    transport.sum(&mut sums);
    transport.max(&mut spans);
    let phases = parts.into_iter().enumerate().map(|(k, (name, _))| PhaseTime {
        name,
        min: -spans[2 * k + 1],
        mean: sums[k] / transport.size() as f64,
        max: spans[2 * k],
    });
    phases.collect()
}

/// Memory at the peak (bytes), of all ranks and of the largest; collective.
fn memory(transport: &MpiTransport) -> [f64; 2] {
    let peak = peak_memory().unwrap_or(f64::NAN);
    let (mut sum, mut largest) = ([peak], [peak]);
    transport.sum(&mut sum);
    transport.max(&mut largest);
    [sum[0], largest[0]]
}
