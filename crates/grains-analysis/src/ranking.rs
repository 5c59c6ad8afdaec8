//! `analyse ranking`: void fraction from the slope of the sorted heights (Rakotonirina 2016, eq. 4.7).
//!
//! The heights z of the centres, sorted, rise along a straight line: over a height dz there are dN particles
//! of volume V_p in a container of cross-section S, so eps = 1 − V_p / (S s) with s = dz/dN. The thesis
//! prints the particle's surface for S; it is the container's cross-section. For mixtures N stands for the
//! cumulative volume over the mean volume, which is the rank for equal particles.

use super::Common;
use super::fit::Fit;
use super::order::Share;
use super::picture::{Curve, Picture};
use super::region::{Crop, Region, RegionOptions};
use super::report::{Report, Table, seconds};
use super::snapshots::{Snapshot, StoredRun};
use super::sums::{exact_sum, exact_sums, running_sums};
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::Shape;
use grains_simulation::RunError;

/// Options of `analyse ranking`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
}

/// Void fraction of a state.
#[derive(Clone, Debug)]
pub struct Found {
    /// Region.
    pub region: Region,
    /// Void fraction (-).
    pub void_fraction: f64,
    /// Mean volume of a particle (m³).
    pub volume: f64,
    /// Line through the points: slope in m per particle.
    pub fit: Fit,
    /// Particles (-).
    pub particles: u64,
    /// Rank (cumulative volume over mean volume) and height (m) of one in so many, and of the last one.
    pub points: Vec<[f64; 2]>,
}

/// Void fraction of a state by ranking; none with fewer than two heights.
///
/// # Errors
/// A region that makes no sense.
pub fn measure(
    case: &Case,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    options: &RegionOptions,
    transport: &impl Transport,
) -> Result<Option<Found>, RunError> {
    let region = Region::of_bed(case, shapes, snapshot, (options, Crop::TENTH), transport)?;
    let inside = (0..snapshot.len()).filter(|&i| region.contains(&snapshot.position[i]));
    let own: Vec<[f64; 3]> = inside
        .map(|i| [snapshot.position[i][region.axis], snapshot.id[i] as f64, snapshot.volume(i, shapes)])
        .collect();
    // By height, then by identity: the same order on any number of ranks.
    let Share { rows, before, all } = Share::of(&own, transport);
    let volumes: Vec<f64> = rows.iter().map(|row| row[2]).collect();
    let volume = exact_sum(transport, volumes.iter().copied()) / all as f64;
    let below = running_sums(transport, &volumes);
    let own: Vec<[f64; 2]> =
        rows.iter().zip(&below).map(|(row, below)| [(below - 0.5 * row[2]) / volume, row[0]]).collect();
    let Some(fit) = line_through(&own, all, transport) else { return Ok(None) };
    let points = Share { rows: own, before, all }.thinned(transport);
    let void_fraction = 1.0 - volume / (region.cross_section() * fit.slope);
    Ok(Some(Found { region, void_fraction, volume, fit, particles: all, points }))
}

/// Least squares through so many points of all ranks; none for fewer than two different x.
fn line_through(own: &[[f64; 2]], all: u64, transport: &impl Transport) -> Option<Fit> {
    let means =
        exact_sums(transport, 2, |add| own.iter().flatten().enumerate().for_each(|(k, x)| add(k % 2, *x)));
    let means: Vec<f64> = means.iter().map(|sum| sum / all as f64).collect();
    // About the means, so that large offsets cost no digits; each by itself, as they differ in magnitude.
    let moment =
        |a: usize, b: usize| exact_sum(transport, own.iter().map(|p| (p[a] - means[a]) * (p[b] - means[b])));
    Fit::of_moments([means[0], means[1]], [moment(0, 0), moment(0, 1), moment(1, 1)])
}

/// Void fraction of the chosen states by ranking.
///
/// # Errors
/// Options that do not fit, too few particles, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let [mut mean, mut plot] = tables();
    let mut report = Report::default();
    for &state in states {
        let snapshot = run.read(transport, state, &[], "ranking")?;
        let shapes = &run.catalogue.shapes;
        let time = snapshot.time;
        let found = measure(&run.case, (&snapshot, shapes), &options.region, transport)?;
        let Some(Found { region, void_fraction, volume, fit, particles, points }) = found else {
            report.lines.push(format!("t = {}: fewer than two heights in the bed", seconds(time)));
            continue;
        };
        let (area, axis) = (region.cross_section(), region.axis);
        mean.push(vec![
            time,
            void_fraction,
            fit.slope,
            fit.r_squared,
            particles as f64,
            volume,
            area,
            region.lower[axis],
            region.upper[axis],
        ]);
        let line = |x: f64| fit.intercept + fit.slope * x;
        points.iter().for_each(|p| plot.push(vec![time, p[0], p[1], line(p[0])]));
        report.lines.push(format!(
            "t = {}: void fraction {void_fraction:.5} from the slope {:.5e} m of {} heights (r² = {:.6}), cross-section {area:.5e} m²",
            seconds(time),
            fit.slope,
            particles,
            fit.r_squared
        ));
        if state == states[states.len() - 1] {
            let ends = [points[0][0], points[points.len() - 1][0]];
            let curves = vec![
                Curve::dots("centres", points.iter().copied().step_by(points.len().div_ceil(2000)).collect()),
                Curve::line(format!("slope {:.4e} m", fit.slope), ends.map(|x| [x, line(x)]).to_vec()),
            ];
            let title = format!("Void fraction {void_fraction:.4} by ranking, t = {}", seconds(time));
            report.pictures.push(Picture::new("ranking", title, ["rank (-)", "height (m)"], curves));
        }
    }
    report.tables.extend([mean, plot]);
    Ok(report)
}

/// What each state gives, and its sorted heights.
fn tables() -> [Table; 2] {
    let mean = Table::new(
        "ranking",
        "Void fraction 1 - V / (S s) from the slope s of the sorted heights.",
        &[
            ("time", "s"),
            ("void_fraction", "-"),
            ("slope", "m"),
            ("r_squared", "-"),
            ("particles", "-"),
            ("mean_volume", "m3"),
            ("cross_section", "m2"),
            ("from", "m"),
            ("to", "m"),
        ],
    );
    let plot = Table::new(
        "ranking-plot",
        "Sorted heights of the centres against their rank (cumulative over mean volume), and the fitted line; of many particles only some.",
        &[("time", "s"), ("rank", "-"), ("height", "m"), ("fit", "m")],
    );
    [mean, plot]
}
