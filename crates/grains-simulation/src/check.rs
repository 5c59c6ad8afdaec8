//! What a case is and what it will cost, found before it runs: the values that `grains-mpi check` prints.

mod heat;
mod particles;
mod sizes;

pub use crate::bonds::BondReport;
pub use crate::cost::Cost;
pub use crate::fluid::FluidStepLimit;
pub use crate::fluid::check::{
    CouplingReport, FluidReport, FluidStep, LubricationRange, ParticlesInFluid, PressureDrop, ResolvedReport,
    SettlingMotion, TooCoarse, WallsReport,
};
pub use crate::law_report::LawReport;
pub use crate::liquid::FilmReport;
pub use crate::timestep::{Encounter, Partner, Resolution, TimeStepChoice, TimeStepReason};
pub use grains_case::Basis;
pub use grains_contact::{ImpulseScheme, Sharing};
pub use grains_coupling::{Passing, effectiveness};
pub use grains_dem::{CollisionModel, FaceContact};
pub use grains_geometry::{DecompositionReport, MassReport, MassSource};
pub use heat::HeatReport;
pub use particles::{CompositeReport, MeshReport, MotionTableReport, ParticleReport, ShapeReport};
pub use sizes::SizeReport;

pub(crate) use particles::{max_overlap, seconds_per_step};

use crate::fluid;
use crate::insertion::Insertions;
use crate::plausibility;
use crate::system::{self, System};
use crate::wall_triangles::{WallTriangles, triangles_of};
use crate::{Case, RunError, agreed};
use grains_comm::Job;
use grains_dem::{Catalogue, DemSetup, Failure};
use grains_domain::{Decomposition, SerialTransport, Transport};

/// A case on a number of ranks.
#[derive(Clone, Debug)]
pub struct Report {
    /// Ranks.
    pub ranks: usize,
    /// Subdomains along each axis.
    pub subdomains: [usize; 3],
    /// Extents of a subdomain (m).
    pub subdomain: [f64; 3],
    /// The particles, if any are inserted.
    pub particles: Option<ParticleReport>,
    /// Temperatures of particles, if they have one.
    pub heat: Option<HeatReport>,
    /// The fluid, if there is one.
    pub fluid: Option<FluidReport>,
    /// Memory and disk.
    pub cost: Cost,
    /// Values that are seldom meant, with file, line, key, consequence and remedy.
    pub warnings: Vec<String>,
}

/// Examines a case for a number of ranks, and inserts in a trial what is inserted at the beginning; this process does so alone.
///
/// # Errors
/// Whatever would stop the run before its first step.
pub fn report(case: &Case, ranks: usize) -> Result<Report, RunError> {
    examine(case, ranks, &SerialTransport)
}

/// The same by all ranks of a job, each of which holds its share of the particles; collective.
///
/// # Errors
/// As for [`report`]; also a domain that cannot be divided among the ranks of the job.
pub fn report_by(case: &Case, ranks: usize, job: &Job) -> Result<Report, RunError> {
    examine(case, ranks, job.transport())
}

fn examine(case: &Case, ranks: usize, transport: &impl Transport) -> Result<Report, RunError> {
    let catalogue = all(transport, system::catalogue(case))?;
    let insertions = Insertions::read(case, &catalogue, transport)?;
    let system = all(transport, system::build(case, ranks, catalogue.clone(), insertions.kinds()))?;
    let warnings = plausibility::warnings(case, &system, &insertions);
    let System { setup, step } = system;
    let decomposition = all(transport, decomposition(case, &setup, ranks))?;
    let ranks = setup.ranks.iter().product();
    let (placed, walls) = trial(case, catalogue, insertions.clone(), transport)?;
    let cost = Cost::of(case, &setup.catalogue, &insertions, (&walls, placed[1]), ranks, transport);
    all(transport, fluid::verify(case, (&setup, insertions.kinds()), &decomposition))?;
    let fluid = all(transport, fluid::check::report(case, &setup.catalogue, &insertions, transport))?;
    let heat = HeatReport::of(case, &setup, insertions.kinds());
    let particles = match case.inserts.is_empty() {
        true => None,
        false => {
            let of = ParticleReport::of(case, (&setup, &insertions), step, (placed, ranks), transport);
            Some(all(transport, of)?)
        }
    };
    let (lower, upper) = (decomposition.lower(), decomposition.upper());
    Ok(Report {
        ranks,
        subdomains: decomposition.ranks,
        subdomain: [0, 1, 2].map(|a| upper[a] - lower[a]),
        particles,
        heat,
        fluid,
        cost,
        warnings,
    })
}

/// The outcome for all ranks.
fn all<T>(transport: &impl Transport, outcome: Result<T, String>) -> Result<T, RunError> {
    agreed(transport, outcome.map_err(RunError::case))
}

/// The first of the subdomains that the ranks get.
fn decomposition(case: &Case, setup: &DemSetup, ranks: usize) -> Result<Decomposition, String> {
    if setup.ranks.iter().product::<usize>() != ranks && case.domain.ranks.is_none() {
        return Err(format!("no decomposition for {ranks} ranks"));
    }
    let range = setup.interaction_range();
    let mut decomposition = Decomposition::new(setup.global.clone(), setup.ranks, 0, range)
        .map_err(|e| case.about("domain", e.to_string()))?;
    if let Some(nodes) = fluid::shared_nodes(case)? {
        decomposition.share_cells(&nodes);
    }
    Ok(decomposition)
}

/// Inserts what a run would insert at its first step; returns how many, how many bonds they have, and the walls as they are then;
/// collective.
fn trial(
    case: &Case,
    catalogue: Catalogue,
    mut insertions: Insertions,
    transport: &impl Transport,
) -> Result<([u64; 2], WallTriangles), RunError> {
    // Those that examine the case are seldom as many as will run it.
    let mut undivided = case.clone();
    undivided.domain.ranks = None;
    let system = all(transport, system::build(&undivided, transport.size(), catalogue, insertions.kinds()))?;
    let mut dem = all(transport, system::dem(case, system.setup, transport.rank()))?;
    dem.prescribe(insertions.prescribed_motions(case));
    insertions.insert_due(case, &mut dem, transport).map_err(RunError::case)?;
    dem.refresh(transport).map_err(|failure| match failure {
        Failure::Here { error, .. } => RunError::case(error.to_string()),
        Failure::Elsewhere => RunError::case(""),
    })?;
    all(transport, insertions.starting_overlap(case, &dem).map_or(Ok(()), Err))?;
    let [bonds, _] = all(transport, dem.check_bonds(transport).map_err(|e| e.to_string()))?;
    let walls = triangles_of(&dem, &dem.worn_volumes(transport));
    let mut placed = [dem.particles.owned as u64];
    transport.sum_counts(&mut placed);
    Ok(([placed[0], bonds], walls))
}
