//! `analyse granular-temperature`: fluctuations of the velocity in the cells of a coarse grid.

use super::Common;
use super::coarse_grid::{CoarseGrid, edge};
use super::picture::{Curve, Picture};
use super::region::{Region, RegionOptions};
use super::report::{Report, Table, seconds};
use super::snapshots::{Extra, Snapshot, StoredRun};
use super::sums::{counts, exact_sums};
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::Vec3;
use grains_simulation::RunError;

/// Options of `analyse granular-temperature`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
    /// Edge of a cell (m); three mean diameters if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub cell: Option<f64>,
    /// Particles a cell must hold to count.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u64).range(1..)))]
    pub min: u64,
}

/// A cell with particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Middle (m).
    pub middle: Vec3,
    /// Particles (-).
    pub count: u64,
    /// Mean velocity (m/s).
    pub velocity: Vec3,
    /// Granular temperature T = ⟨|v − mean|²⟩/3 (m²/s²).
    pub temperature: f64,
}

/// Granular temperature of the cells of a region that hold enough particles, x fastest.
pub fn measure(
    region: &Region,
    edge: f64,
    min: u64,
    snapshot: &Snapshot,
    transport: &impl Transport,
) -> Vec<Cell> {
    let grid = CoarseGrid::new(region, edge);
    let members: Vec<(usize, usize)> = (0..snapshot.len())
        .filter(|&i| region.contains(&snapshot.position[i]))
        .map(|i| (i, grid.cell(&snapshot.position[i])))
        .collect();
    let slots = grid.len();
    let count = counts(transport, slots, members.iter().map(|m| m.1));
    let sums = exact_sums(transport, 3 * slots, |add| {
        members.iter().for_each(|&(i, c)| (0..3).for_each(|a| add(3 * c + a, snapshot.velocity[i][a])));
    });
    let mean = |c: usize| Vec3::from_column_slice(&sums[3 * c..3 * c + 3]) / count[c] as f64;
    let spread = exact_sums(transport, slots, |add| {
        members.iter().for_each(|&(i, c)| add(c, (snapshot.velocity[i] - mean(c)).norm_squared()));
    });
    let cell = |c: usize| {
        let temperature = spread[c] / (3.0 * count[c] as f64);
        Cell { middle: grid.middle(c), count: count[c], velocity: mean(c), temperature }
    };
    (0..slots).filter(|&c| count[c] >= min).map(cell).collect()
}

/// Mean over some cells, each with the weight of its particles; NaN without cells.
fn weighted<'a>(cells: impl Iterator<Item = &'a Cell> + Clone, value: impl Fn(&Cell) -> f64) -> f64 {
    let weight = cells.clone().map(|cell| cell.count as f64).sum::<f64>();
    cells.map(|cell| cell.count as f64 * value(cell)).sum::<f64>() / weight
}

/// Mean temperature of each layer of cells along an axis, by the middle of the layer.
fn by_layer(cells: &[Cell], axis: usize) -> Vec<[f64; 2]> {
    let mut layers: Vec<f64> = cells.iter().map(|cell| cell.middle[axis]).collect();
    layers.sort_by(f64::total_cmp);
    layers.dedup();
    let mean = |&x: &f64| [x, weighted(cells.iter().filter(|c| c.middle[axis] == x), |c| c.temperature)];
    layers.iter().map(mean).collect()
}

/// Granular temperature of the chosen states.
///
/// # Errors
/// Options that do not fit, fields that were not stored, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let [mut means, mut table] = tables();
    let (mut report, mut curves, mut axis) = (Report::default(), Vec::new(), 2);
    for &state in states {
        let snapshot = run.read(transport, state, &[Extra::Velocity], "granular-temperature")?;
        let shapes = &run.catalogue.shapes;
        let region = Region::of_state(&run.case, (&snapshot, shapes), &options.region, transport)?;
        axis = region.axis;
        let edge = edge(options.cell, &region, (&snapshot, shapes), transport)?;
        let cells = measure(&region, edge, options.min, &snapshot, transport);
        let temperature = weighted(cells.iter(), |c| c.temperature);
        let flow = weighted(cells.iter(), |c| c.velocity.norm_squared() / 3.0);
        let count: u64 = cells.iter().map(|c| c.count).sum();
        means.push(vec![snapshot.time, temperature, flow, count as f64, cells.len() as f64]);
        for c in &cells {
            let (x, v) = (c.middle, c.velocity);
            table.push(vec![snapshot.time, x.x, x.y, x.z, c.count as f64, v.x, v.y, v.z, c.temperature]);
        }
        curves.push(Curve::line(seconds(snapshot.time), by_layer(&cells, axis)));
        report.lines.push(format!(
            "t = {}: granular temperature {temperature:.5e} m²/s² ({count} particles in {} cells of {edge:.3e} m), mean flow {flow:.5e} m²/s²",
            seconds(snapshot.time),
            cells.len()
        ));
    }
    let along = ["x", "y", "z"][axis];
    report.pictures.push(profile(along, curves));
    if states.len() > 1 {
        report.pictures.push(over_time(&means));
        let typical = super::fit::mean_and_deviation(means.rows.iter().map(|row| row[1]));
        report.lines = vec![format!(
            "granular temperature {:.5e} m²/s², ± {:.2e} over {} states",
            typical[0],
            typical[1],
            states.len()
        )];
    }
    report.tables.extend([means, table]);
    Ok(report)
}

const LABEL: &str = "granular temperature (m²/s²)";

/// Granular temperature along an axis, a curve for each state.
fn profile(axis: &str, curves: Vec<Curve>) -> Picture {
    let axes = [&format!("{axis} (m)"), LABEL];
    Picture::few("granular-temperature-profile", "Granular temperature", axes, curves)
}

fn over_time(means: &Table) -> Picture {
    let curve = Curve::line("", means.points(0, 1));
    Picture::new("granular-temperature", "Granular temperature", ["time (s)", LABEL], vec![curve])
}

/// Means of each state, and its cells.
fn tables() -> [Table; 2] {
    let means = Table::new(
        "granular-temperature",
        "Granular temperature <|v - mean of the cell|^2>/3, mean over cells by their particles; kinetic part of the mean flow <|mean of the cell|^2>/3; particles in cells that count.",
        &[
            ("time", "s"),
            ("granular_temperature", "m2/s2"),
            ("mean_flow", "m2/s2"),
            ("particles", "-"),
            ("cells", "-"),
        ],
    );
    let columns = [
        ("time", "s"),
        ("x", "m"),
        ("y", "m"),
        ("z", "m"),
        ("count", "-"),
        ("velocity_x", "m/s"),
        ("velocity_y", "m/s"),
        ("velocity_z", "m/s"),
        ("granular_temperature", "m2/s2"),
    ];
    let table = Table::new(
        "granular-temperature-cells",
        "Cells that hold enough particles, by their middles.",
        &columns,
    );
    [means, table]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{lattice, particles};
    use grains_domain::SerialTransport;

    #[test]
    fn a_shear_flow_has_the_temperature_of_its_fluctuations_only() {
        // Eight particles per cell; mean velocity 10 x, fluctuations of 0.3 along y and 0.4 along z.
        let mut snapshot = particles(lattice(Vec3::zeros(), [8, 4, 4], 0.25));
        for (i, v) in snapshot.velocity.iter_mut().enumerate() {
            let cell = (snapshot.position[i].x / 0.5).floor();
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            *v = Vec3::new(10.0 * cell, 0.3 * sign, -0.4 * sign);
        }
        let region =
            Region { lower: Vec3::zeros(), upper: Vec3::new(2.0, 1.0, 1.0), axis: 2, cylinder: None };
        let cells = measure(&region, 0.5, 8, &snapshot, &SerialTransport);
        assert_eq!(cells.len(), 16);
        for cell in &cells {
            assert_eq!(cell.count, 8);
            assert!((cell.temperature - 0.25 / 3.0).abs() < 1e-12, "{}", cell.temperature);
            assert!(
                (cell.velocity - Vec3::new(10.0 * (cell.middle.x / 0.5).floor(), 0.0, 0.0)).norm() < 1e-12
            );
        }
        assert!(measure(&region, 0.5, 9, &snapshot, &SerialTransport).is_empty());
        assert_eq!(by_layer(&cells, 2).len(), 2);
        assert!((weighted(cells.iter(), |c| c.temperature) - 0.25 / 3.0).abs() < 1e-12);
        assert!(weighted([].iter(), |c| c.temperature).is_nan());
    }
}
