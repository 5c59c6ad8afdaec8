//! `analyse radial-distribution`: how particles lie about each other.
//!
//! ```text
//! g(r) = n(r) / (N_c ρ 4/3 π ((r + Δr)³ − r³))
//! ```
//!
//! n(r) pairs of a centre and another particle are r to r + Δr apart, of the N_c centres that are farther than the largest
//! distance from where the region ends; ρ is the number of particles in the region over its volume. g is 1 where particles
//! lie at random. Regions that span a periodic axis do not end there, and pairs count in their nearest image.

use super::Common;
use super::order::Share;
use super::picture::{Curve, Picture};
use super::region::{Region, RegionOptions, across, mean_diameter};
use super::report::{Report, Table, seconds};
use super::snapshots::{Snapshot, StoredRun};
use super::sums::counts;
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::Vec3;
use grains_simulation::RunError;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Options of `analyse radial-distribution`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
    /// Largest distance (m); four mean diameters if absent, in narrow regions a quarter of the width.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub distance: Option<f64>,
    /// Shells between centres that coincide and the largest distance.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000)))]
    pub bins: u64,
}

/// Pairs in a region.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Centres far enough from where the region ends (-).
    pub centres: u64,
    /// Particles per volume of the region (1/m³).
    pub density: f64,
    /// Pairs of a centre and another particle, by shell.
    pub pairs: Vec<u64>,
}

impl Found {
    /// Middle r of each shell (m) and g(r) (-), for shells up to a distance (m).
    pub fn curve(&self, distance: f64) -> Vec<[f64; 2]> {
        let width = distance / self.pairs.len() as f64;
        let shell = |(k, &pairs): (usize, &u64)| {
            let [inner, outer] = [k, k + 1].map(|k| k as f64 * width);
            let volume = 4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3));
            [0.5 * (inner + outer), pairs as f64 / (self.centres as f64 * self.density * volume)]
        };
        self.pairs.iter().enumerate().map(shell).collect()
    }
}

/// A region, and the axes along which it goes on in the next image of the domain.
struct Space<'a> {
    region: &'a Region,
    /// Length of the domain along the axes that the region spans periodically (m).
    periods: [Option<f64>; 3],
}

impl<'a> Space<'a> {
    fn new(region: &'a Region, case: &Case) -> Self {
        let (lower, upper) = (case.domain.lower, case.domain.upper);
        let periods = std::array::from_fn(|a| {
            let (length, span) = (upper[a] - lower[a], region.upper[a] - region.lower[a]);
            let is_round = region.cylinder.is_some() && a != region.axis;
            (case.domain.periodic[a] && !is_round && span >= (1.0 - 1e-9) * length).then_some(length)
        });
        Self { region, periods }
    }

    /// Largest distance (m) at which a particle has one image only.
    fn longest(&self) -> f64 {
        self.periods.into_iter().flatten().fold(f64::INFINITY, |m, length| m.min(0.5 * length))
    }

    /// Whether everything within a distance (m) of a point lies in the region.
    fn is_centre(&self, point: &Vec3, distance: f64) -> bool {
        let Region { lower, upper, axis, cylinder } = self.region;
        let is_far = |a: usize| lower[a] + distance <= point[a] && point[a] <= upper[a] - distance;
        match cylinder {
            Some((_, radius)) => {
                let along = self.periods[*axis].is_some() || is_far(*axis);
                along && self.region.distance(point) + distance <= *radius
            }
            None => (0..3).all(|a| self.periods[a].is_some() || is_far(a)),
        }
    }

    /// From one point to the nearest image of another (m).
    fn separation(&self, from: &Vec3, to: &Vec3) -> Vec3 {
        let mut between = to - from;
        for (x, period) in between.iter_mut().zip(self.periods) {
            *x -= period.map_or(0.0, |length| length * (*x / length).round());
        }
        between
    }

    /// Volume of the region (m³).
    fn volume(&self) -> f64 {
        self.region.cross_section() * self.region.height()
    }
}

/// Points in cells as wide as a distance (m) or wider.
struct Cells {
    lower: Vec3,
    number: [usize; 3],
    width: [f64; 3],
    points: HashMap<[usize; 3], Vec<Vec3>>,
}

impl Cells {
    fn new(region: &Region, distance: f64, points: impl Iterator<Item = Vec3>) -> Self {
        let extent = region.upper - region.lower;
        let number = std::array::from_fn(|a| (extent[a] / distance).floor().clamp(1.0, 1024.0) as usize);
        let width = std::array::from_fn(|a| extent[a] / number[a] as f64);
        let mut cells = Self { lower: region.lower, number, width, points: HashMap::new() };
        points.for_each(|point| {
            let cell = cells.cell(&point);
            cells.points.entry(cell).or_default().push(point);
        });
        cells
    }

    fn cell(&self, point: &Vec3) -> [usize; 3] {
        std::array::from_fn(|a| {
            let place = ((point[a] - self.lower[a]) / self.width[a]).max(0.0) as usize;
            place.min(self.number[a] - 1)
        })
    }

    /// The cells next to that of a point and itself, each once; around axes that go on.
    fn near(&self, point: &Vec3, periods: &[Option<f64>; 3]) -> impl Iterator<Item = &Vec3> {
        let cell = self.cell(point);
        let along = |a: usize| {
            let n = self.number[a] as isize;
            let mut found: Vec<usize> = (-1..=1)
                .map(|step| cell[a] as isize + step)
                .filter_map(|i| match periods[a] {
                    Some(_) => Some(i.rem_euclid(n) as usize),
                    None => (0..n).contains(&i).then_some(i as usize),
                })
                .collect();
            found.sort_unstable();
            found.dedup();
            found
        };
        let [x, y, z] = [0, 1, 2].map(along);
        let cells = x.into_iter().flat_map(move |i| {
            let z = z.clone();
            y.clone().into_iter().flat_map(move |j| z.clone().into_iter().map(move |k| [i, j, k]))
        });
        cells.filter_map(|cell| self.points.get(&cell)).flatten()
    }
}

/// Pairs up to a distance (m) in a region of the domain of a case, in a number of shells. Each rank holds its own particles
/// of the snapshot, and the counts are those of all.
pub fn measure(
    (case, region): (&Case, &Region),
    (distance, bins): (f64, usize),
    snapshot: &Snapshot,
    transport: &impl Transport,
) -> Found {
    let space = Space::new(region, case);
    let axis = (region.upper - region.lower).imax();
    let inside = snapshot.position.iter().filter(|point| region.contains(point));
    let rows: Vec<[f64; 3]> = inside.map(|point| [0, 1, 2].map(|k| point[(axis + k) % 3])).collect();
    let Share { rows, all: number, .. } = Share::of(&rows, transport);
    let others = rows_near((&rows, distance, space.periods[axis]), transport);
    let point = |row: &[f64; 3]| Vec3::from_fn(|a, _| row[(a + 3 - axis) % 3]);
    let cells = Cells::new(region, distance, rows.iter().chain(&others).map(point));
    let points: Vec<Vec3> = rows.iter().map(point).collect();
    let centres: Vec<&Vec3> = points.iter().filter(|point| space.is_centre(point, distance)).collect();
    let shells = centres.iter().flat_map(|centre| {
        let near = cells.near(centre, &space.periods).map(|other| space.separation(centre, other).norm());
        // A centre is no neighbour of itself.
        near.filter(|&r| r > 0.0 && r < distance)
            .map(|r| ((r / distance * bins as f64) as usize).min(bins - 1))
    });
    let pairs = counts(transport, bins, shells);
    let mut count = [centres.len() as u64];
    transport.sum_counts(&mut count);
    Found { centres: count[0], density: number as f64 / space.volume(), pairs }
}

/// Rows of other ranks whose first value is within a distance (m) of those of this rank, in the nearest image; every rank has a share
/// of the rows in order.
fn rows_near(
    (rows, distance, period): (&[[f64; 3]], f64, Option<f64>),
    transport: &impl Transport,
) -> Vec<[f64; 3]> {
    // Wider by what rounding may take away.
    let reach = distance * (1.0 + 1e-9);
    let ends = match rows {
        [] => [f64::NAN; 2],
        [first, ..] => [first[0] - reach, rows[rows.len() - 1][0] + reach],
    };
    let images = period.map_or(vec![0.0], |length| vec![-length, 0.0, length]);
    let mut sent = Vec::new();
    for (rank, ends) in transport.gather(&ends).as_chunks::<2>().0.iter().enumerate() {
        if rank == transport.rank() || ends[0].is_nan() {
            continue;
        }
        let (mut message, mut next) = (Vec::new(), 0);
        for image in &images {
            let begin = rows.partition_point(|row| row[0] < ends[0] + image).max(next);
            next = rows.partition_point(|row| row[0] <= ends[1] + image).max(begin);
            message.extend(rows[begin..next].as_flattened());
        }
        if !message.is_empty() {
            sent.push((rank, message));
        }
    }
    let received = transport.exchange_sparse(sent);
    received.iter().flat_map(|(_, message)| message.as_chunks().0).copied().collect()
}

/// Largest distance (m) of the options, which must leave a centre in the region.
fn distance(options: &Options, (region, case): (&Region, &Case), diameter: f64) -> Result<f64, RunError> {
    let space = Space::new(region, case);
    let [a, b] = across(region.axis);
    let half = |a: usize| match space.periods[a] {
        Some(_) => f64::INFINITY,
        None => 0.5 * (region.upper[a] - region.lower[a]),
    };
    let max = space.longest().min(half(a)).min(half(b)).min(half(region.axis));
    let distance = options.distance.unwrap_or((4.0 * diameter).min(0.5 * max));
    if distance.is_nan() || distance <= 0.0 || distance > max {
        return Err(RunError::case(format!(
            "--distance: {distance} m must be positive and at most {max} m, half of the shortest side of the region; give a smaller one, or a larger region"
        )));
    }
    Ok(distance)
}

/// Radial distribution of the chosen states.
///
/// # Errors
/// Options that do not fit, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let mut table = Table::new(
        "radial-distribution",
        "Radial distribution function g of the centres of particles in shells of a distance r, and the pairs of a centre and another particle in each shell.",
        &[("time", "s"), ("r", "m"), ("r_over_diameter", "-"), ("g", "-"), ("pairs", "-")],
    );
    let (mut report, mut curves) = (Report::default(), Vec::new());
    let (case, shapes) = (&run.case, &run.catalogue.shapes);
    for &state in states {
        let snapshot = run.read(transport, state, &[], "radial-distribution")?;
        let region = Region::of_state(case, (&snapshot, shapes), &options.region, transport)?;
        let inside = (0..snapshot.len()).filter(|&i| region.contains(&snapshot.position[i]));
        let diameter = mean_diameter(&snapshot, shapes, inside, transport);
        let distance = distance(options, (&region, case), diameter)?;
        let found = measure((case, &region), (distance, options.bins as usize), &snapshot, transport);
        let curve = found.curve(distance);
        for ([r, g], &pairs) in curve.iter().zip(&found.pairs) {
            table.push(vec![snapshot.time, *r, r / diameter, *g, pairs as f64]);
        }
        let peak = curve.iter().fold([f64::NAN; 2], |m, &p| if m[1] >= p[1] { m } else { p });
        report.lines.push(format!(
            "t = {}: g is largest, {:.4}, at r = {:.4e} m ({:.3} mean diameters); {} centres, {:.5e} particles per m³",
            seconds(snapshot.time),
            peak[1],
            peak[0],
            peak[0] / diameter,
            found.centres,
            found.density
        ));
        curves.push(Curve::line(
            seconds(snapshot.time),
            curve.iter().map(|[r, g]| [r / diameter, *g]).collect(),
        ));
    }
    let axes = ["distance over mean diameter (-)", "g (-)"];
    report.pictures.push(Picture::few("radial-distribution", "Radial distribution", axes, curves));
    report.tables.push(table);
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{case, lattice, particles};
    use grains_domain::SerialTransport;
    use grains_testing::on_ranks;

    fn unit_box(is_periodic: bool) -> (Case, Region) {
        let case = case([0.0; 3], [1.0; 3], [is_periodic; 3], "");
        let region = Region::chosen(&case, 0.0, &RegionOptions::default()).unwrap();
        (case, region)
    }

    /// Numbers from 0 to 1, the same at every call (splitmix64).
    fn random(count: usize) -> Vec<f64> {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z ^ (z >> 31)) as f64 / u64::MAX as f64
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn points_at_random_have_no_structure_with_and_without_images() {
        let points: Vec<Vec3> = random(12_000).chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])).collect();
        for is_periodic in [false, true] {
            let (case, region) = unit_box(is_periodic);
            let found = measure((&case, &region), (0.2, 10), &particles(points.clone()), &SerialTransport);
            assert_eq!(found.centres == 4000, is_periodic);
            for ([_, g], pairs) in found.curve(0.2).into_iter().zip(&found.pairs).skip(2) {
                // Four standard deviations of a count, each pair of centres being counted twice.
                assert!((g - 1.0).abs() < 4.0 * (2.0 / *pairs as f64).sqrt(), "{g} of {pairs}");
            }
        }
    }

    #[test]
    fn neighbours_of_a_cubic_lattice_are_counted() {
        let (case, region) = unit_box(true);
        let points = lattice(Vec3::zeros(), [10, 10, 10], 0.1);
        let found = measure((&case, &region), (0.22, 220), &particles(points), &SerialTransport);
        let at = |r: f64| found.pairs[(r * 1e3 - 2.0) as usize..(r * 1e3 + 3.0) as usize].iter().sum::<u64>();
        let shells = [1.0, 2_f64.sqrt(), 3_f64.sqrt(), 2.0].map(|r| at(0.1 * r));
        assert_eq!(shells, [6000, 12_000, 8000, 6000]);
        assert_eq!(found.pairs.iter().sum::<u64>(), 32_000);
        assert!((found.density - 1e3).abs() < 1e-9);
    }

    #[test]
    fn pairs_of_cells_on_ranks_are_those_of_all_with_all() {
        let in_unit_box: Vec<Vec3> =
            random(900).chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])).collect();
        let runs = [1, 2, 3, 7].into_iter().flat_map(|ranks| {
            [(true, 0.13), (true, 0.5), (false, 0.31), (true, 0.02)]
                .map(|(is_periodic, distance)| (ranks, is_periodic, distance))
        });
        for (axis, (ranks, is_periodic, distance)) in runs.flat_map(|run| [0, 1, 2].map(|axis| (axis, run))) {
            let mut upper = [1.0; 3];
            upper[axis] = 2.0;
            let case = case([0.0; 3], upper, [is_periodic; 3], "");
            let region = Region::chosen(&case, 0.0, &RegionOptions::default()).unwrap();
            let points: Vec<Vec3> =
                in_unit_box.iter().map(|point| point.component_mul(&Vec3::from(upper))).collect();
            let found = on_ranks(ranks, |transport| {
                // Dealt out like cards; the last rank has none.
                let dealt = points.iter().skip(transport.rank()).step_by((ranks - 1).max(1)).copied();
                let own =
                    if ranks > 1 && transport.rank() == ranks - 1 { Vec::new() } else { dealt.collect() };
                measure((&case, &region), (distance, 7), &particles(own), &transport)
            });
            assert!(found.iter().all(|other| *other == found[0]));
            let found = found[0].clone();
            let space = Space::new(&region, &case);
            let mut pairs = vec![0; 7];
            for a in points.iter().filter(|point| space.is_centre(point, distance)) {
                let apart = points.iter().map(|b| space.separation(a, b).norm());
                apart
                    .filter(|&r| r > 0.0 && r < distance)
                    .for_each(|r| pairs[(r / distance * 7.0) as usize] += 1);
            }
            assert_eq!(found.pairs, pairs, "{ranks} ranks, {distance}");
            assert_eq!(found.density, 150.0);
        }
    }
}
