//! What `check` says of a case, as far as a run knows it without a trial: to be compared with what comes of it.

use crate::check::{max_overlap, seconds_per_step};
use crate::cost::Cost;
use crate::fluid;
use crate::insertion::Insertions;
use crate::timestep::TimeStepChoice;
use crate::wall_triangles::WallTriangles;
use grains_case::Case;
use grains_dem::Dem;
use grains_domain::Transport;

/// What a whole case is expected to take.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Time step of the particles (s).
    pub time_step: f64,
    /// What decided the step that would be recommended.
    pub time_step_reason: String,
    /// Steps of the particles to the end (-).
    pub steps: f64,
    /// Largest overlap at `time.impact_speed` over the radius (-), of soft contacts.
    pub max_overlap: Option<f64>,
    /// Memory and disk.
    pub cost: Cost,
    /// Wall-clock time (s) on the ranks of the run; of a fluid at least that of its longest steps.
    pub seconds: Option<f64>,
}

impl Prediction {
    /// That of a system before its first step, without bonds; collective.
    pub(crate) fn of(
        case: &Case,
        (dem, insertions): (&Dem, &Insertions),
        step: &TimeStepChoice,
        walls: &WallTriangles,
        transport: &impl Transport,
    ) -> Self {
        let ranks = transport.size();
        let catalogue = &dem.setup.catalogue;
        let steps = case.time.end / step.dt;
        let moves = !case.inserts.is_empty() && !case.holds_particles();
        let of_particles =
            moves.then(|| steps * insertions.total() as f64 * seconds_per_step(case, catalogue));
        let of_fluid = fluid::check::min_seconds(case);
        let seconds = of_particles.into_iter().chain(of_fluid).reduce(|a, b| a + b);
        Self {
            time_step: step.dt,
            time_step_reason: step.reason.to_string(),
            steps,
            max_overlap: (moves && !case.collisions.is_hard()).then(|| max_overlap(step)),
            cost: Cost::of(case, catalogue, insertions, (walls, 0), ranks, transport),
            seconds: seconds.map(|seconds| seconds / ranks as f64),
        }
    }

    /// With the bonds that there are after the first step.
    pub(crate) fn with_bonds(&self, bonds: u64) -> Self {
        Self { cost: self.cost.with_bonds(bonds), ..self.clone() }
    }
}
