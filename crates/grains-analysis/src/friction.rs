//! `analyse friction`: the friction coefficient of a periodic array of particles (Rakotonirina 2016, 7.4.2).
//!
//! ```text
//! K = (dp/L) 2 a² / (9 μ φ U)      (7.16)
//! ```
//!
//! With the force (dp/L) V/N per particle, V the volume of the domain and φ = N 4/3 π a³/V, that is F/(6π μ a U), the drag over
//! Stokes' of one sphere alone. Particles of other shapes count as spheres of their mean volume.

use super::picture::{Curve, Picture};
use super::region::Axis;
use super::report::{Report, Table, seconds};
use super::series::TimeSeries;
use super::snapshots::StoredRun;
use super::{Common, resolved_fluid};
use grains_case::Fluid;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::sphere_equivalent_diameter;
use grains_simulation::{RunError, agreed};

/// Options of `analyse friction`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    /// Axis along which the flow is driven; that of the largest mean pressure gradient if absent.
    #[cfg_attr(feature = "clap", arg(long))]
    pub axis: Option<Axis>,
}

/// A row of the time series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time (s).
    pub time: f64,
    /// Mean pressure gradient dp/L that drives the flow (Pa/m).
    pub pressure_gradient: f64,
    /// Superficial velocity U (m/s).
    pub superficial_velocity: f64,
    /// Solid fraction φ (-).
    pub solid_fraction: f64,
    /// Friction coefficient K (-); NaN without flow.
    pub friction: f64,
    /// Reynolds number 2 ρ a U/μ (-).
    pub reynolds: f64,
}

/// The friction coefficient at every row of a series, of a number of particles in a domain of a volume (m³).
///
/// # Errors
/// Columns that lack, or a flow that nothing drives.
pub fn measure(
    series: &TimeSeries,
    (fluid, axis): (&Fluid, Option<Axis>),
    (particles, volume): (u64, f64),
) -> Result<Vec<Row>, RunError> {
    let names = ["x", "y", "z"];
    let mut drives = Vec::new();
    for name in names {
        drives.push(series.column(&format!("drive_{name}"))?);
    }
    let last = |a: usize| drives[a].last().map_or(0.0, |drive| drive.abs());
    let axis = axis.map_or_else(
        || (0..3).fold(0, |best, a| if last(a) > last(best) { a } else { best }),
        |a| a as usize,
    );
    if last(axis) == 0.0 {
        return Err(RunError::case(format!(
            "nothing drives the flow along {}, without which there is no friction coefficient: give a run with `fluid.drive` along a periodic axis, or take `analyse bed`",
            names[axis]
        )));
    }
    let (times, solids) = (series.column("time")?, series.column("solid_volume")?);
    let velocities = series.column(&format!("superficial_{}", names[axis]))?;
    let row = |k: usize| {
        let (time, gradient, velocity) = (times[k], drives[axis][k], velocities[k]);
        let (phi, a) = (solids[k] / volume, 0.5 * sphere_equivalent_diameter(solids[k] / particles as f64));
        Row {
            time,
            pressure_gradient: gradient,
            superficial_velocity: velocity,
            solid_fraction: phi,
            friction: match velocity {
                0.0 => f64::NAN,
                _ => gradient * 2.0 * a * a / (9.0 * fluid.viscosity * phi * velocity),
            },
            reynolds: 2.0 * fluid.density * a * velocity.abs() / fluid.viscosity,
        }
    };
    Ok((0..times.len()).map(row).collect())
}

/// The friction coefficient over the time series of a run; the report is that of rank 0.
///
/// # Errors
/// A run of other kind, or files that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let fluid = resolved_fluid(run, "friction")?;
    let last = states.last().copied().unwrap_or_default();
    let particles = run.read(transport, last, &[], "friction")?.total(transport);
    let volume = run.case.domain.extents().iter().product();
    let rows = match transport.rank() {
        0 => TimeSeries::read(run)
            .and_then(|series| measure(&series, (fluid, options.axis), (particles, volume))),
        _ => Ok(Vec::new()),
    };
    Ok(report(&agreed(transport, rows)?))
}

fn report(rows: &[Row]) -> Report {
    let mut table = Table::new(
        "friction",
        "Friction coefficient K = (dp/L) 2 a^2/(9 mu phi U) = F/(6 pi mu a U) of the sphere of the mean volume, at the rows of the time series.",
        &[
            ("time", "s"),
            ("pressure_gradient", "Pa/m"),
            ("superficial_velocity", "m/s"),
            ("solid_fraction", "-"),
            ("friction", "-"),
            ("reynolds", "-"),
        ],
    );
    for r in rows {
        let row =
            [r.time, r.pressure_gradient, r.superficial_velocity, r.solid_fraction, r.friction, r.reynolds];
        table.push(row.to_vec());
    }
    let mut report = Report::default();
    if let [.., before, last] = rows {
        let change = last.friction / before.friction - 1.0;
        report.lines.push(format!(
            "t = {}: K = {:.5}, changed by {change:.1e} since t = {}; solid fraction {:.5}, U = {:.5e} m/s, Re = {:.3e}",
            seconds(last.time),
            last.friction,
            seconds(before.time),
            last.solid_fraction,
            last.superficial_velocity,
            last.reynolds
        ));
    } else if let [only] = rows {
        report.lines.push(format!("t = {}: K = {:.5}, the only row", seconds(only.time), only.friction));
    }
    let curve = Curve::line("", table.points(0, 4));
    report.pictures.push(Picture::new("friction", "Friction coefficient", ["t (s)", "K (-)"], vec![curve]));
    report.tables.push(table);
    report
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::tests::series;
    use crate::synthetic::case;
    use std::f64::consts::PI;

    #[test]
    fn the_coefficient_is_the_drag_over_stokes_of_one_sphere() {
        let more = "[fluid]\ndensity = 2\nviscosity = 0.5\ncells = [10, 10, 10]\nresolved = { motion = \"fixed\" }\n";
        let case = case([0.0; 3], [1.0; 3], [true; 3], more);
        let fluid = case.fluid.as_ref().unwrap();
        // Two spheres of radius 0.2; the flow goes down.
        let (a, u, drag) = (0.2_f64, -0.1, 7.0 * 6.0 * PI * 0.5 * 0.2 * -0.1);
        let solid = 2.0 * 4.0 / 3.0 * PI * a.powi(3);
        let header = "time,drive_x,drive_y,drive_z,superficial_x,superficial_y,superficial_z,solid_volume\n";
        let text = format!("{header}0,0,0,0,0,0,0,{solid}\n1,0,{},0,0,{u},0.01,{solid}\n", 2.0 * drag);
        let rows = measure(&series(&text).unwrap(), (fluid, None), (2, 1.0)).unwrap();
        assert!(rows[0].friction.is_nan());
        assert!((rows[1].friction - 7.0).abs() < 1e-9, "{:?}", rows[1]);
        assert!((rows[1].reynolds - 2.0 * 2.0 * a * 0.1 / 0.5).abs() < 1e-12);
        let other = measure(&series(&text).unwrap(), (fluid, Some(Axis::Z)), (2, 1.0));
        assert!(other.unwrap_err().message.contains("along z"));
        assert_eq!(report(&rows).lines.len(), 1);
    }
}
