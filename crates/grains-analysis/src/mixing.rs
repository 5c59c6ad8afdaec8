//! `analyse mixing`: how well kinds of particles are mixed, and which of them lies on top.
//!
//! The index of Lacey (1954), J. Appl. Chem. 4, 257, compares the variance of the share of a kind between cells with those of the
//! unmixed and of the random state:
//!
//! ```text
//! M = (S₀² − S²) / (S₀² − S_R²)       S² = Σ n_c (p_c − p)² / N      S₀² = p (1 − p)      S_R² = p (1 − p) (C − 1)/(N − 1)
//! ```
//!
//! The N particles of the C cells count by number; cell c holds n_c of them and the share p_c of the kind. S_R² is the mean of S²
//! over all ways to deal out the same particles to the same places, so that M is 0 where no cell holds two kinds, and 1 on
//! average where chance deals them out.

use super::Common;
use super::coarse_grid::{CoarseGrid, edge};
use super::picture::{Curve, Picture};
use super::region::{Region, RegionOptions, mean_diameter};
use super::report::{Report, Table, seconds};
use super::snapshots::{Extra, Snapshot, StoredRun};
use super::sums::{counts, exact_sums};
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::sphere_equivalent_diameter;
use grains_simulation::RunError;

/// Options of `analyse mixing`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
    /// What makes a kind; the material if the case has particles of several, else the shape, else the size.
    #[cfg_attr(feature = "clap", arg(long))]
    pub by: Option<By>,
    /// Equivalent diameter (m) that parts small from large particles, with `--by size`; that of the mean volume if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub diameter: Option<f64>,
    /// Edge of a cell (m); three mean diameters if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub cell: Option<f64>,
    /// Particles a cell must hold to count.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(2..)))]
    pub min: u64,
}

/// What makes a kind of particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum By {
    /// Particles of one `[[material]]`.
    Material,
    /// Particles of one `[[shape]]`.
    Shape,
    /// Small and large particles.
    Size,
}

/// The mixture in a region.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    /// Particles in the cells that count (-).
    pub particles: u64,
    /// Cells that count (-).
    pub cells: u64,
    /// Standard deviation of the heights of these particles (m).
    pub deviation: f64,
    /// What became of each kind.
    pub kinds: Vec<KindOfMixture>,
}

/// One kind of a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KindOfMixture {
    /// Share p of the particles (-).
    pub share: f64,
    /// Lacey's index M (-); NaN if the kind is absent or alone.
    pub index: f64,
    /// Mean height less that of all (m).
    pub height: f64,
}

/// The mixture of a number of kinds in the cells of a grid over a region that hold at least `min` particles; `kind` is that of a
/// particle.
pub fn measure(
    (region, edge, min): (&Region, f64, u64),
    (kinds, kind): (usize, impl Fn(usize) -> usize),
    snapshot: &Snapshot,
    transport: &impl Transport,
) -> Mixture {
    let grid = CoarseGrid::new(region, edge);
    let inside = (0..snapshot.len()).filter(|&i| region.contains(&snapshot.position[i]));
    let inside: Vec<(usize, usize)> = inside.map(|i| (i, grid.cell(&snapshot.position[i]))).collect();
    // Slot of cell c and kind k: c kinds + k.
    let of_kind = counts(transport, grid.len() * kinds, inside.iter().map(|&(i, c)| c * kinds + kind(i)));
    let in_cell: Vec<u64> = of_kind.chunks_exact(kinds).map(|cell| cell.iter().sum()).collect();
    let counting: Vec<usize> = (0..grid.len()).filter(|&c| in_cell[c] >= min).collect();
    let particles: u64 = counting.iter().map(|&c| in_cell[c]).sum();
    let (n, cells) = (particles as f64, counting.len() as f64);
    let members: Vec<usize> = inside.iter().filter(|m| in_cell[m.1] >= min).map(|m| m.0).collect();
    let height = |i: usize| snapshot.position[i][region.axis];
    let sums = exact_sums(transport, kinds, |add| members.iter().for_each(|&i| add(kind(i), height(i))));
    let mean = sums.iter().sum::<f64>() / n;
    let squares = exact_sums(transport, 1, |add| {
        members.iter().for_each(|&i| add(0, (height(i) - mean).powi(2)));
    });
    let of = |k: usize| {
        let number = counting.iter().map(|&c| of_kind[c * kinds + k]).sum::<u64>() as f64;
        let p = number / n;
        let scatter = |&c: &usize| {
            let count = in_cell[c] as f64;
            count * (of_kind[c * kinds + k] as f64 / count - p).powi(2)
        };
        let variance = counting.iter().map(scatter).sum::<f64>() / n;
        let unmixed = p * (1.0 - p);
        let random = unmixed * (cells - 1.0) / (n - 1.0);
        KindOfMixture {
            share: p,
            index: (unmixed - variance) / (unmixed - random),
            height: sums[k] / number - mean,
        }
    };
    Mixture {
        particles,
        cells: counting.len() as u64,
        deviation: (squares[0] / n).sqrt(),
        kinds: (0..kinds).map(of).collect(),
    }
}

/// What the kinds are called, and what makes them.
fn kinds(run: &StoredRun, options: &Options) -> (By, Vec<String>) {
    let case = &run.case;
    let used = |is_used: &dyn Fn(usize) -> bool, number: usize| (0..number).filter(|&k| is_used(k)).count();
    let of_insert = |pick: &dyn Fn(usize, usize) -> bool| {
        case.inserts.iter().any(|insert| insert.particles.iter().any(|p| pick(p.shape, p.material)))
    };
    let materials = used(&|m| of_insert(&|_, material| material == m), case.materials.len());
    let shapes = used(&|s| of_insert(&|shape, _| shape == s), case.shapes.len());
    let by = options.by.unwrap_or(match (materials, shapes) {
        (2.., _) => By::Material,
        (_, 2..) => By::Shape,
        _ => By::Size,
    });
    let names = match by {
        By::Material => case.materials.iter().map(|m| m.name.clone()).collect(),
        By::Shape => case.shapes.iter().map(|s| s.name.clone()).collect(),
        By::Size => ["small", "large"].map(String::from).to_vec(),
    };
    (by, names)
}

/// Mixing of the chosen states.
///
/// # Errors
/// Options that do not fit, fields that were not stored, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let (by, names) = kinds(run, options);
    let mut table = Table::new(
        "mixing",
        "Of each kind its share by number, Lacey's mixing index (0 separate, 1 random), and its mean height less that of all particles; over cells that hold enough particles.",
        &[("time", "s"), ("particles", "-"), ("cells", "-"), ("height_deviation", "m")],
    );
    for name in &names {
        let of_kind = [("share", "-"), ("mixing_index", "-"), ("height", "m")];
        table.columns.extend(of_kind.map(|(what, unit)| (format!("{name}_{what}"), unit)));
    }
    let extras: &[Extra] = if by == By::Material { &[Extra::Material] } else { &[] };
    let (mut report, shapes) = (Report::default(), &run.catalogue.shapes);
    for &state in states {
        let snapshot = run.read(transport, state, extras, "mixing")?;
        let region = Region::of_state(&run.case, (&snapshot, shapes), &options.region, transport)?;
        let edge = edge(options.cell, &region, (&snapshot, shapes), transport)?;
        let parting = options
            .diameter
            .unwrap_or_else(|| mean_diameter(&snapshot, shapes, 0..snapshot.len(), transport));
        let kind = |i: usize| match by {
            By::Material => snapshot.material[i],
            By::Shape => snapshot.shape[i],
            By::Size => usize::from(sphere_equivalent_diameter(snapshot.volume(i, shapes)) >= parting),
        };
        if transport.any((0..snapshot.len()).any(|i| kind(i) >= names.len())) {
            return Err(RunError::case(format!(
                "{}: names a material the case lacks: give the case of this run",
                run.path.display()
            )));
        }
        let found = measure((&region, edge, options.min), (names.len(), kind), &snapshot, transport);
        let mut row = vec![snapshot.time, found.particles as f64, found.cells as f64, found.deviation];
        row.extend(found.kinds.iter().flat_map(|k| [k.share, k.index, k.height]));
        table.push(row);
        let there = names.iter().zip(&found.kinds).filter(|(_, k)| k.share > 0.0);
        let told: Vec<String> = there
            .map(|(name, k)| format!("{name} ({:.1} %) {:.4}, {:+.3e} m", 100.0 * k.share, k.index, k.height))
            .collect();
        report.lines.push(format!(
            "t = {}: Lacey's index and height above the mean: {} ({} particles in {} cells of {edge:.3e} m)",
            seconds(snapshot.time),
            told.join("; "),
            found.particles,
            found.cells
        ));
    }
    let curves = |offset: usize| -> Vec<Curve> {
        let curve =
            |(k, name): (usize, &String)| Curve::line(name.clone(), table.points(0, 4 + 3 * k + offset));
        names.iter().enumerate().map(curve).collect()
    };
    report.pictures = vec![
        Picture::new("mixing", "Mixing index of Lacey", ["time (s)", "M (-)"], curves(1)),
        Picture::new("mixing-height", "Height above the mean", ["time (s)", "height (m)"], curves(2)),
    ];
    report.tables.push(table);
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{lattice, particles};
    use grains_domain::SerialTransport;
    use grains_geometry::Vec3;

    /// A bed of 12 x 12 x 12 particles in cells of 3 x 3 x 3, with a kind for each.
    fn bed(kind: impl Fn(usize) -> usize) -> Mixture {
        let snapshot = particles(lattice(Vec3::zeros(), [12; 3], 1.0));
        let region = Region { lower: Vec3::zeros(), upper: Vec3::repeat(12.0), axis: 2, cylinder: None };
        measure((&region, 3.0, 5), (3, kind), &snapshot, &SerialTransport)
    }

    #[test]
    fn layers_are_unmixed_and_lie_where_they_lie() {
        // The lowest quarter of one kind; the third kind is absent.
        let found = bed(|i| usize::from(i >= 432));
        assert_eq!((found.particles, found.cells), (1728, 64));
        assert!((found.kinds[0].share - 0.25).abs() < 1e-12);
        for k in 0..2 {
            assert!(found.kinds[k].index.abs() < 1e-12, "{:?}", found.kinds[k]);
        }
        assert!((found.kinds[0].height + 4.5).abs() < 1e-12 && (found.kinds[1].height - 1.5).abs() < 1e-12);
        assert!((found.deviation - (143.0_f64 / 12.0).sqrt()).abs() < 1e-12);
        assert!(found.kinds[2].share == 0.0 && found.kinds[2].index.is_nan());
    }

    #[test]
    fn what_chance_deals_out_has_an_index_of_one_on_average() {
        let mut state = 1_u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) as usize) % below
        };
        let mut cards: Vec<usize> =
            (0..1728).map(|i| usize::from(i >= 400) + usize::from(i >= 900)).collect();
        let mut indices = vec![Vec::new(); 3];
        for _ in 0..200 {
            (1..cards.len()).rev().for_each(|i| cards.swap(i, random(i + 1)));
            let found = bed(|i| cards[i]);
            (0..3).for_each(|k| indices[k].push(found.kinds[k].index));
        }
        for kind in indices {
            let [mean, deviation] = crate::fit::mean_and_sample_deviation(&kind);
            assert!((mean - 1.0).abs() < 4.0 * deviation / (200.0_f64).sqrt(), "{mean} ± {deviation}");
            assert!(deviation < 0.02, "{deviation}");
        }
    }

    #[test]
    fn cells_of_equal_shares_are_mixed_better_than_by_chance() {
        // Alternating along x, y and z: 13 or 14 of 27 in each cell.
        let found = bed(|i| (i % 12 + i / 12 % 12 + i / 144) % 2);
        assert!(found.kinds[0].index > 1.03, "{:?}", found.kinds[0]);
    }
}
