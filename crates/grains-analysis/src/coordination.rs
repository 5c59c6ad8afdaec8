//! `analyse coordination`: contacts per particle.

use super::Common;
use super::fit::mean_and_deviation;
use super::picture::{Curve, Picture, Style};
use super::region::{Region, RegionOptions};
use super::report::{Report, Table, seconds};
use super::snapshots::{Extra, Snapshot, StoredRun};
use super::sums::counts;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_simulation::RunError;

/// Options of `analyse coordination`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
    /// A particle with fewer contacts, walls included, is a rattler: 2 with friction, 4 for spheres without.
    #[cfg_attr(feature = "clap", arg(long, value_name = "CONTACTS", default_value_t = 2))]
    pub rattlers: u64,
}

/// Contacts of the particles of a region.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Particles (-).
    pub particles: u64,
    /// Particles that are rattlers (-).
    pub rattlers: u64,
    /// Touching particles, per particle (-).
    pub mean: f64,
    /// The same without rattlers (-): contacts with a rattler still count.
    pub mean_without_rattlers: f64,
    /// Touching walls, per particle (-).
    pub walls: f64,
    /// How many particles have 0, 1, 2, … touching particles.
    pub histogram: Vec<u64>,
}

/// Contacts of the particles for which `is_inside` holds.
pub fn measure(
    snapshot: &Snapshot,
    is_inside: impl Fn(usize) -> bool,
    rattler_below: u64,
    transport: &impl Transport,
) -> Found {
    let inside: Vec<usize> = (0..snapshot.len()).filter(|&i| is_inside(i)).collect();
    let contacts = |i: usize| snapshot.coordination[i];
    let mut max = [inside.iter().map(|&i| contacts(i) as f64).fold(0.0, f64::max)];
    transport.max(&mut max);
    let histogram = counts(transport, max[0] as usize + 1, inside.iter().map(|&i| contacts(i) as usize));
    let is_rattler = |i: usize| contacts(i) + snapshot.wall_contacts[i] < rattler_below;
    let mut sums = [0_u64; 5];
    for &i in &inside {
        let non_rattler = u64::from(!is_rattler(i));
        let terms = [1, 1 - non_rattler, contacts(i), non_rattler * contacts(i), snapshot.wall_contacts[i]];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    transport.sum_counts(&mut sums);
    let [particles, rattlers, all, non_rattler_contacts, walls] = sums;
    let per = |sum: u64, number: u64| sum as f64 / number as f64;
    Found {
        particles,
        rattlers,
        mean: per(all, particles),
        mean_without_rattlers: per(non_rattler_contacts, particles - rattlers),
        walls: per(walls, particles),
        histogram,
    }
}

/// Contacts of the chosen states.
///
/// # Errors
/// Options that do not fit, fields that were not stored, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let mut table = Table::new(
        "coordination",
        "Touching particles per particle, of all and without rattlers, and touching walls per particle.",
        &[
            ("time", "s"),
            ("particles", "-"),
            ("coordination", "-"),
            ("rattlers", "-"),
            ("coordination_without_rattlers", "-"),
            ("wall_contacts", "-"),
        ],
    );
    let mut histogram: Vec<u64> = Vec::new();
    for &state in states {
        let snapshot = run.read(transport, state, &[Extra::Contacts], "coordination")?;
        let region =
            Region::of_state(&run.case, (&snapshot, &run.catalogue.shapes), &options.region, transport)?;
        let is_everywhere = options.region.is_empty();
        let is_inside = |i: usize| is_everywhere || region.contains(&snapshot.position[i]);
        let found = measure(&snapshot, is_inside, options.rattlers, transport);
        let [particles, rattlers] = [found.particles, found.rattlers].map(|n| n as f64);
        let means = [found.mean, found.mean_without_rattlers, found.walls];
        table.push(vec![snapshot.time, particles, means[0], rattlers, means[1], means[2]]);
        histogram.resize(histogram.len().max(found.histogram.len()), 0);
        histogram.iter_mut().zip(found.histogram).for_each(|(sum, n)| *sum += n);
    }
    let total = histogram.iter().sum::<u64>() as f64;
    let mut shares = Table::new(
        "coordination-histogram",
        "Particles with each number of touching particles, over all the states, and their share.",
        &[("coordination", "-"), ("particles", "-"), ("share", "-")],
    );
    for (contacts, &n) in histogram.iter().enumerate() {
        shares.push(vec![contacts as f64, n as f64, n as f64 / total]);
    }
    let column = |k: usize| mean_and_deviation(table.rows.iter().map(|row| row[k]));
    let ([mean, deviation], [without_rattlers, _], [walls, _]) = (column(2), column(4), column(5));
    let rattlers = table.rows.iter().map(|row| row[3]).sum::<f64>() / total;
    let mut report = Report::default();
    report.lines.push(format!(
        "coordination {mean:.4} (± {deviation:.4} over {} states), {without_rattlers:.4} without rattlers, which are {:.2} % of the particles; {walls:.4} walls per particle",
        states.len(),
        100.0 * rattlers
    ));
    let axes = ["touching particles (-)", "share of the particles (-)"];
    let bars = Curve { label: String::new(), points: shares.points(0, 2), style: Style::Bars(0.9) };
    let title = format!("Coordination, mean {mean:.3}");
    report.pictures.push(Picture::new("coordination-histogram", title, axes, vec![bars]));
    if states.len() > 1 {
        let curves = vec![
            Curve::line("all particles", table.points(0, 2)),
            Curve::line("without rattlers", table.points(0, 4)),
        ];
        let title = format!("Coordination up to {}", seconds(run.time(states[states.len() - 1])));
        report.pictures.push(Picture::new("coordination", title, ["time (s)", "coordination (-)"], curves));
    }
    report.tables.extend([table, shares]);
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::particles;
    use grains_domain::SerialTransport;
    use grains_geometry::Vec3;

    #[test]
    fn rattlers_are_told_apart_and_walls_hold() {
        let mut snapshot = particles(vec![Vec3::zeros(); 6]);
        snapshot.coordination = vec![0, 1, 1, 4, 6, 9];
        snapshot.wall_contacts = vec![0, 0, 1, 0, 0, 5];
        let found = measure(&snapshot, |i| i < 5, 2, &SerialTransport);
        assert_eq!((found.particles, found.rattlers), (5, 2));
        assert_eq!((found.mean, found.mean_without_rattlers, found.walls), (2.4, 11.0 / 3.0, 0.2));
        assert_eq!(found.histogram, [1, 2, 0, 0, 1, 0, 1]);
        assert!(measure(&snapshot, |_| false, 2, &SerialTransport).mean.is_nan());
    }
}
