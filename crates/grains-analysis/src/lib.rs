//! What the stored states of a run say: tables and pictures.
//!
//! Each rank reads its share of the particles (`snapshots`) and of the cells of a resolved flow (`layers`), and the ranks
//! work together on each state; all sums are exact (`sums`), so the results have the same bits on any number of ranks.

pub mod bed;
mod coarse_grid;
pub mod coordination;
pub mod drum;
pub mod ergun;
mod fit;
pub mod flow_rate;
pub mod friction;
pub mod granular_temperature;
mod layers;
pub mod mixing;
mod order;
pub mod orientation;
mod picture;
mod pixels;
pub mod profiles;
pub mod radial_distribution;
mod ranking;
pub mod region;
mod report;
pub mod run_out;
mod series;
mod snapshots;
mod sums;
pub mod transfer;
pub mod void_fraction;

use grains_case::{Case, Fluid};
use grains_comm::Job;
use grains_domain::Transport;
use grains_simulation::{RunError, agreed};
use region::Axis;
use snapshots::StoredRun;
pub use snapshots::Times;
use std::path::PathBuf;

/// What every analysis is told.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Common {
    /// Output directory of a run, its particles.vtkhdf, or a checkpoint.
    pub run: PathBuf,
    /// Which states: first, last, all, the nearest to a time (s), or FROM:TO (s).
    #[cfg_attr(
        feature = "clap",
        arg(long, default_value = "last", value_name = "WHICH", allow_hyphen_values = true)
    )]
    pub time: Times,
    /// Folder of the results; `analysis` in the directory of the run if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "FOLDER"))]
    pub output: Option<PathBuf>,
    /// Case file to use instead of the case stored with the states.
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub case: Option<PathBuf>,
}

/// An analysis of the stored states of a run.
#[cfg_attr(feature = "clap", derive(clap::Subcommand))]
pub enum Analysis {
    /// Void fraction by counting cells: mean, axial and radial profile.
    VoidFraction(void_fraction::Options),
    /// Void fraction by the ranking plot: slope of the sorted heights.
    Ranking(ranking::Options),
    /// Profiles of density, velocity and granular temperature.
    Profiles(profiles::Options),
    /// Contacts per particle: mean and histogram.
    Coordination(coordination::Options),
    /// Order of a body axis, and its angle to gravity.
    Orientation(orientation::Options),
    /// Length and shape of the deposit of a collapsed column.
    RunOut(run_out::Options),
    /// Speed, free surface and regime of a rotating drum.
    Drum(drum::Options),
    /// Granular temperature in the cells of a coarse grid.
    GranularTemperature(granular_temperature::Options),
    /// Radial distribution function of the centres.
    RadialDistribution(radial_distribution::Options),
    /// Mixing index of Lacey and segregation in height of kinds of particles.
    Mixing(mixing::Options),
    /// Number and mass per time through flow planes, from the time series.
    FlowRate(flow_rate::Options),
    /// Friction coefficient of a periodic array of resolved particles, over time.
    Friction(friction::Options),
    /// Flow through a fixed bed of resolved particles: pressure gradient, Ergun's alpha, tortuosity, axial profiles.
    Bed(bed::Options),
    /// Coefficients of Ergun's equation from the beds of several runs.
    Ergun(ergun::Options),
    /// Nusselt numbers of resolved particles, and profiles of the temperature of the flow through them.
    Nusselt(transfer::Options),
    /// Sherwood numbers of resolved particles, and profiles of a concentration.
    Sherwood(transfer::Options),
    /// Effectiveness of resolved catalysts, and profiles of the reactant.
    Effectiveness(transfer::Options),
}

impl Analysis {
    fn common(&self) -> &Common {
        match self {
            Self::VoidFraction(options) => &options.common,
            Self::Ranking(options) => &options.common,
            Self::Profiles(options) => &options.common,
            Self::Coordination(options) => &options.common,
            Self::Orientation(options) => &options.common,
            Self::RunOut(options) => &options.common,
            Self::Drum(options) => &options.common,
            Self::GranularTemperature(options) => &options.common,
            Self::RadialDistribution(options) => &options.common,
            Self::Mixing(options) => &options.common,
            Self::FlowRate(options) => &options.common,
            Self::Friction(options) => &options.common,
            Self::Bed(options) => &options.common,
            Self::Ergun(options) => &options.common,
            Self::Nusselt(options) | Self::Sherwood(options) | Self::Effectiveness(options) => {
                &options.common
            }
        }
    }
}

/// What an analysis found, and where it is written.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Main numbers, a line for each state; the tables hold all.
    pub lines: Vec<String>,
    /// Folder of the files.
    pub folder: PathBuf,
    /// Names of the files.
    pub files: Vec<String>,
}

/// Reads the states, analyses them and writes the results; `program` is what the files say they come from. Collective.
///
/// # Errors
/// Options that do not fit the run, fields it did not store, or files that cannot be read or written.
pub fn analyse(analysis: &Analysis, program: &str, job: &Job) -> Result<Findings, RunError> {
    let (common, transport) = (analysis.common(), job.transport());
    let run = StoredRun::open(&common.run, common.case.as_deref(), job)?;
    let states = run.select(common.time)?;
    let report = match analysis {
        Analysis::VoidFraction(options) => void_fraction::analyse(&run, &states, options, transport),
        Analysis::Ranking(options) => ranking::analyse(&run, &states, options, transport),
        Analysis::Profiles(options) => profiles::analyse(&run, &states, options, transport),
        Analysis::Coordination(options) => coordination::analyse(&run, &states, options, transport),
        Analysis::Orientation(options) => orientation::analyse(&run, &states, options, transport),
        Analysis::RunOut(options) => run_out::analyse(&run, &states, options, transport),
        Analysis::Drum(options) => drum::analyse(&run, &states, options, transport),
        Analysis::GranularTemperature(options) => {
            granular_temperature::analyse(&run, &states, options, transport)
        }
        Analysis::RadialDistribution(options) => {
            radial_distribution::analyse(&run, &states, options, transport)
        }
        Analysis::Mixing(options) => mixing::analyse(&run, &states, options, transport),
        Analysis::FlowRate(options) => flow_rate::analyse(&run, options, transport),
        Analysis::Friction(options) => friction::analyse(&run, &states, options, transport),
        Analysis::Bed(options) => bed::analyse(&run, &states, options, transport),
        Analysis::Ergun(options) => ergun::analyse((&run, &states), options, job),
        Analysis::Nusselt(options) => {
            transfer::analyse(&run, &states, (transfer::Number::Nusselt, options), transport)
        }
        Analysis::Sherwood(options) => {
            transfer::analyse(&run, &states, (transfer::Number::Sherwood, options), transport)
        }
        Analysis::Effectiveness(options) => {
            transfer::analyse(&run, &states, (transfer::Number::Effectiveness, options), transport)
        }
    }?;
    let directory = run.path.parent().map_or_else(PathBuf::new, PathBuf::from);
    let folder = common.output.clone().unwrap_or_else(|| directory.join("analysis"));
    let times = match (states.first(), states.last()) {
        (Some(&first), Some(&last)) if first != last => {
            format!("{} states from {} s to {} s", states.len(), run.time(first), run.time(last))
        }
        (Some(&first), _) => format!("{} s", run.time(first)),
        _ => String::new(),
    };
    let written = match transport.rank() {
        0 => report.write(&folder, program, &run.path, &times),
        _ => Ok(()),
    };
    agreed(transport, written)?;
    let files = report.files();
    Ok(Findings { lines: report.lines, folder, files })
}

/// Name of an axis, by default that of gravity.
fn axis_name(case: &Case, axis: Option<Axis>) -> &'static str {
    ["x", "y", "z"][axis.map_or_else(|| region::vertical(case), |a| a as usize)]
}

/// The fluid of a run whose particles the grid resolves; `what` is the analysis that wants one.
///
/// # Errors
/// A run of another kind.
fn resolved_fluid<'a>(run: &'a StoredRun, what: &str) -> Result<&'a Fluid, RunError> {
    run.case.fluid.as_ref().filter(|_| run.case.holds_particles()).ok_or_else(|| {
        RunError::case(format!(
            "{}: the case has no flow past particles that stay where they are, which `analyse {what}` needs: give a run of one with `fluid.resolved` and its `motion` \"fixed\"",
            run.path.display()
        ))
    })
}

#[cfg(test)]
mod synthetic;
