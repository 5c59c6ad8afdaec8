//! A simulation from its case: particles, walls and fluid on all ranks, its files, and what it will cost.
//!
//! ```no_run
//! use grains_simulation::{Options, RunError, Simulation, Status, load, start};
//!
//! fn main() -> Result<(), RunError> {
//!     let job = start()?;
//!     let case = load("cases/silo/quick.toml".as_ref(), &job)?;
//!     let mut silo = Simulation::new(&case, &job, Options::default())?;
//!     silo.run_to(1.5)?;
//!     let fastest = silo.particles().map(|p| p.velocity().norm()).fold(0.0, f64::max);
//!     println!("t = {} s: up to {fastest} m/s here", silo.time());
//!     while silo.step()? == Status::Running {}
//!     let summary = silo.close()?;
//!     println!("{} particles in {} s", summary.inside, summary.seconds);
//!     Ok(())
//! }
//! ```
//!
//! A rank sees its own particles, its loads on walls and its cells of the fluid ([`ParticleView`], [`WallView`], [`FluidView`]);
//! [`Simulation::sum`] and [`Simulation::max`] go over all ranks. A simulation acts at times by [`Simulation::run_to`] and
//! [`Simulation::set_wall_motion`]. [`Options::restart`] continues a checkpoint, with the same bits as if it had not been stopped.
//! [`check::report`] finds sizes, time step and cost of a case without running it; `grains-analysis` analyses a stored run.
//!
//! ```no_run
//! use grains_simulation::{Motion, Options, RunError, Simulation, Status, check, load, start};
//!
//! fn main() -> Result<(), RunError> {
//!     let job = start()?;
//!     let case = load("cases/silo/quick.toml".as_ref(), &job)?;
//!     println!("{:.0} MB", check::report(&case, job.size())?.cost.memory / 1e6);
//!     let options = Options { restart: Some("latest".into()), ..Options::default() };
//!     let mut silo = Simulation::new(&case, &job, options)?;
//!     if silo.run_to(2.0)? == Status::Running {
//!         silo.set_wall_motion("plate", Motion::Fixed)?;
//!     }
//!     let load = silo.sum(silo.walls().map(|wall| wall.load.force.z).sum());
//!     let pressure = silo.fluid().map(|fluid| fluid.flow.state.pressure.own().fold(0.0, f64::max));
//!     println!("walls carry {load} N, pressure up to {pressure:?} Pa here");
//!     silo.close()?;
//!     Ok(())
//! }
//! ```
//!
//! Messages go to [`log`], on one rank. An error on one rank is an error on all; ranks that did not meet it have no text.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bonds;
mod changes;
pub mod check;
mod convex;
mod cost;
mod duration;
mod error;
#[cfg(test)]
mod extreme_numbers;
mod files;
mod fluid;
mod heat;
mod insertion;
mod law_report;
mod laws;
mod liquid;
mod loan;
mod lock;
mod numbering;
mod plausibility;
mod prediction;
mod random;
mod restart;
mod run_directory;
mod schedule;
mod series_columns;
mod shapes;
mod simulation;
mod sizes;
mod species;
mod steering;
mod summary;
mod system;
mod timestep;
mod views;
mod wall_surfaces;
mod wall_triangles;
mod wear;

pub use duration::duration;
pub use error::{ErrorKind, RunError, agreed};
pub use files::Row;
pub use fluid::FluidProgress;
pub use grains_case::Case;
pub use grains_comm::{Job, abort};
pub use grains_dem::{Loading, Motion};
pub use loan::{FluidLoan, Loan};
pub use lock::is_written_to;
pub use prediction::Prediction;
pub use simulation::{Options, Simulation, Status};
pub use steering::Inflow;
pub use summary::{FluidSummary, PhaseTime, Progress, Summary};
pub use system::catalogue;
pub use views::{FluidView, ParticleView, WallView};

use grains_case::read_text;
use grains_comm::{ranks_of_node, share_on_node};
use grains_domain::Transport;
use grains_geometry::{ConvexParts, WallMesh};
use std::path::Path;

/// Joins MPI that others have started: the job of a communicator; as for [`start`].
///
/// # Safety
/// `communicator` is the address of an `MPI_Comm` that is valid while the job is.
#[allow(unsafe_code)]
pub unsafe fn join(communicator: usize) -> Job {
    // SAFETY: as the caller says.
    unsafe { Job::join(communicator, grains_geometry::catches_panics) }
}

/// Starts MPI, once in a process; a panic on any rank from here on ends all ranks instead of hanging them.
///
/// A program started without mpirun is a job of one rank.
///
/// # Errors
/// MPI that runs already.
pub fn start() -> Result<Job, RunError> {
    Job::start(grains_geometry::catches_panics).map_err(RunError::files)
}

/// The case of a file on every rank: rank 0 reads the text and the meshes, all ranks check them alike; collective.
///
/// # Errors
/// A file that cannot be read, or a case that is wrong: where, what and the remedy.
pub fn load(path: &Path, job: &Job) -> Result<Case, RunError> {
    let is_first = job.transport().rank() == 0;
    let text = is_first.then(|| match read_text(path) {
        Ok(text) if text.trim().is_empty() => Err(format!(
            "{}: the case file is empty; `grains-mpi new silo` writes one to begin with",
            path.display()
        )),
        Ok(text) => Ok(text),
        Err(error) => Err(format!("{}: cannot read the case file: {error}", path.display())),
    });
    let text = job.broadcast(text.unwrap_or(Ok(String::new()))).map_err(RunError::case)?;
    let base = path.parent().unwrap_or(Path::new(""));
    let case = Case::parse(&text, &path.display().to_string(), base);
    let mut case = agreed(job.transport(), case.map_err(|e| RunError::case(e.to_string())))?;
    share_meshes(&mut case, job);
    share_walls(&mut case, job);
    if is_first {
        case.warnings.iter().for_each(|w| log::warn!("{w}"));
    }
    Ok(case)
}

/// Gives all ranks the meshes that rank 0 reads and cuts into convex parts; what is wrong with one shows where it is asked for. Collective.
fn share_meshes(case: &mut Case, job: &Job) {
    let is_first = job.transport().rank() == 0;
    let of_first =
        |found: &dyn Fn() -> Vec<u8>| job.broadcast_bytes(if is_first { found() } else { Vec::new() });
    for path in case.mesh_files() {
        let bytes = of_first(&|| std::fs::read(&path).unwrap_or_default());
        case.meshes.keep_mesh(&path, &bytes);
    }
    for decomposition in case.decompositions() {
        let parts = of_first(&|| case.meshes.parts(&decomposition).map_or(Vec::new(), |parts| parts.bytes()));
        if let Some(parts) = ConvexParts::of_bytes(&parts) {
            case.meshes.keep_parts(decomposition, parts);
        }
    }
}

/// Gives the ranks of each node one copy of the meshes of walls, built by the first of them; what is wrong with one shows where it is
/// asked for. Collective.
fn share_walls(case: &mut Case, job: &Job) {
    let node = ranks_of_node(job.world());
    for wall in &case.walls {
        let of_first = || wall_surfaces::mesh_to_share(&wall.kind, &case.meshes).map(|mesh| mesh.bytes());
        let shared = share_on_node(&node, of_first);
        if let Some(mesh) = shared.and_then(|memory| WallMesh::in_memory(&memory)) {
            case.meshes.keep_wall(wall.kind.clone(), mesh);
        }
    }
}
