//! `analyse void-fraction`: the share of the space between the particles, by counting cells.

use super::picture::{Curve, Picture};
use super::pixels::{Counted, Grid, Rings, count};
use super::region::{Crop, Region, RegionOptions, across};
use super::report::{Report, Table, seconds};
use super::snapshots::{Snapshot, StoredRun};
use super::{Common, axis_name};
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::Shape;
use grains_simulation::RunError;
use std::str::FromStr;

/// Options of `analyse void-fraction`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
    /// Edge of a cell (m).
    #[cfg_attr(feature = "clap", arg(long, value_name = "M", conflicts_with = "cells"))]
    pub cell: Option<f64>,
    /// Number of cells of the box about the region.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1e8))]
    pub cells: f64,
    /// Also the profile about a line along the axis, through these two coordinates (m); `axis` for the middle.
    #[cfg_attr(feature = "clap", arg(long, value_name = "CX,CY|axis", allow_hyphen_values = true))]
    pub radial: Option<Center>,
    /// Number of bins of the profiles.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=100_000)))]
    pub bins: u64,
    /// Count again with cells of twice the edge, and estimate the error from the difference.
    #[cfg_attr(feature = "clap", arg(long))]
    pub refine: bool,
}

/// Where radial profiles begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Center {
    /// In the middle of the region.
    Middle,
    /// At two coordinates across the axis (m).
    At([f64; 2]),
}

impl FromStr for Center {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "axis" {
            return Ok(Self::Middle);
        }
        let numbers: Vec<f64> = text.split(',').filter_map(|word| word.trim().parse().ok()).collect();
        let wrong = format!("`{text}` is neither two coordinates with a comma between nor `axis`");
        numbers[..].try_into().map(Self::At).map_err(|_| wrong)
    }
}

impl Center {
    /// The two coordinates across the axis of a region (m).
    pub fn of(self, region: &Region) -> [f64; 2] {
        match self {
            Self::Middle => region.middle(),
            Self::At(center) => center,
        }
    }
}

/// Outer radii (m) of rings of equal width that reach the farthest point of a region.
pub fn rings(region: &Region, center: [f64; 2], bins: usize) -> Rings {
    let farthest = match region.cylinder {
        Some((middle, radius)) => radius + (middle[0] - center[0]).hypot(middle[1] - center[1]),
        None => {
            let reach = across(region.axis).into_iter().zip(center);
            let reach = reach.map(|(a, c)| (region.upper[a] - c).abs().max((region.lower[a] - c).abs()));
            reach.fold(0.0, f64::hypot)
        }
    };
    // The last a little wider, so that rounding leaves no cell out.
    let edge = |k: usize| farthest * k as f64 / bins as f64 * if k == bins { 1.0 + 1e-9 } else { 1.0 };
    Rings { center, edges: (1..=bins).map(edge).collect() }
}

/// Void fraction of counted cells `[all, solid]`; NaN without cells.
fn void([all, solid]: [u64; 2]) -> f64 {
    (all - solid) as f64 / all as f64
}

fn total(parts: &[[u64; 2]]) -> [u64; 2] {
    parts.iter().fold([0, 0], |sum, part| [sum[0] + part[0], sum[1] + part[1]])
}

/// Void fraction of a state.
#[derive(Clone, Debug)]
pub struct Found {
    /// Region.
    pub region: Region,
    /// Mean void fraction (-).
    pub mean: f64,
    /// Change of the mean from cells of twice the edge (-); NaN if not asked for.
    pub error: f64,
    /// Edge of a cell (m) and number of cells of the region.
    pub cells: (f64, u64),
    /// Middle (m) and void fraction (-) of layers along the axis.
    pub axial: Vec<[f64; 2]>,
    /// Middle (m) and void fraction (-) of rings.
    pub radial: Vec<[f64; 2]>,
}

/// Void fraction of a state in the region of the options.
///
/// # Errors
/// A region or cells that make no sense.
pub fn measure(
    case: &Case,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    options: &Options,
    transport: &impl Transport,
) -> Result<Found, RunError> {
    let region = Region::of_bed(case, shapes, snapshot, (&options.region, Crop::TENTH), transport)?;
    let volume = (region.upper - region.lower).product();
    let edge = options.cell.unwrap_or_else(|| (volume / options.cells).cbrt());
    if !(edge > 0.0 && options.cells >= 1.0 && volume / edge.powi(3) < 1e15) {
        return Err(RunError::case(format!(
            "--cell, --cells: cells of {edge:.3e} m in a region of {volume:.3e} m3 make no sense; give --cells between 1e6 and 1e10"
        )));
    }
    let rings = options.radial.map(|c| self::rings(&region, c.of(&region), options.bins as usize));
    let counted_with = |edge: f64, rings: Option<&Rings>| {
        let grid = Grid::new(&region, edge);
        (grid, count(&region, &grid, rings, (snapshot, shapes), &case.domain, transport))
    };
    let (grid, counted) = counted_with(edge, rings.as_ref());
    let mean = void(total(&counted.layers));
    let error = match options.refine {
        true => (void(total(&counted_with(2.0 * edge, None).1.layers)) - mean).abs(),
        false => f64::NAN,
    };
    let Counted { layers, rings: of_rings } = counted;
    let cells = (grid.edge(), total(&layers)[0]);
    let bins = (options.bins as usize).min(layers.len());
    let thickness = region.height() / layers.len() as f64;
    let axial = (0..bins).map(|b| {
        let range = b * layers.len() / bins..(b + 1) * layers.len() / bins;
        let middle = region.lower[region.axis] + 0.5 * thickness * (range.start + range.end) as f64;
        [middle, void(total(&layers[range]))]
    });
    let edges = rings.map_or(Vec::new(), |r| r.edges);
    let radial = of_rings.iter().enumerate().filter(|(_, ring)| ring[0] > 0).map(|(k, &ring)| {
        let inner = if k > 0 { edges[k - 1] } else { 0.0 };
        [0.5 * (inner + edges[k]), void(ring)]
    });
    Ok(Found { region, mean, error, cells, axial: axial.collect(), radial: radial.collect() })
}

/// Void fraction of the chosen states.
///
/// # Errors
/// Options that do not fit, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let mut mean = Table::new(
        "void-fraction",
        "Mean void fraction of the region between two coordinates along the axis, and its change from cells of twice the edge.",
        &[("time", "s"), ("void_fraction", "-"), ("error", "-"), ("from", "m"), ("to", "m"), ("cells", "-")],
    );
    let mut axial = Table::new(
        "void-fraction-axial",
        "Void fraction of layers along the axis, at their middles.",
        &[("time", "s"), ("position", "m"), ("void_fraction", "-")],
    );
    let mut radial = Table::new(
        "void-fraction-radial",
        "Void fraction of rings, at the middle of their radii.",
        &[("time", "s"), ("radius", "m"), ("void_fraction", "-")],
    );
    let mut report = Report::default();
    let (mut along, mut about) = (Vec::new(), Vec::new());
    for &state in states {
        let snapshot = run.read(transport, state, &[], "void-fraction")?;
        let shapes = &run.catalogue.shapes;
        let found = measure(&run.case, (&snapshot, shapes), options, transport)?;
        let (axis, time) = (found.region.axis, snapshot.time);
        let ends = [found.region.lower[axis], found.region.upper[axis]];
        mean.push(vec![time, found.mean, found.error, ends[0], ends[1], found.cells.1 as f64]);
        found.axial.iter().for_each(|p| axial.push(vec![time, p[0], p[1]]));
        found.radial.iter().for_each(|p| radial.push(vec![time, p[0], p[1]]));
        let error = if options.refine { format!(" ± {:.1e}", found.error) } else { String::new() };
        report.lines.push(format!(
            "t = {}: void fraction {:.5}{error}, solid fraction {:.5}; {:.3e} cells of {:.3e} m; {}",
            seconds(time),
            found.mean,
            1.0 - found.mean,
            found.cells.1 as f64,
            found.cells.0,
            found.region
        ));
        along.push(Curve::line(seconds(time), found.axial));
        about.push(Curve::line(seconds(time), found.radial));
    }
    let axis = axis_name(&run.case, options.region.axis);
    let label = format!("{axis} (m)");
    let title = format!("Void fraction along {axis}");
    report.pictures.push(Picture::few("void-fraction-axial", title, [&label, "void fraction (-)"], along));
    report.tables.extend([mean, axial]);
    if options.radial.is_some() {
        let axes = ["distance from the axis (m)", "void fraction (-)"];
        report.pictures.push(Picture::few(
            "void-fraction-radial",
            "Void fraction about the axis",
            axes,
            about,
        ));
        report.tables.push(radial);
    }
    Ok(report)
}

#[cfg(test)]
#[path = "void_fraction_tests.rs"]
mod tests;
