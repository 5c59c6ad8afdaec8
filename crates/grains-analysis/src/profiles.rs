//! `analyse profiles`: density, velocity and granular temperature along the axis and about it.

use super::Common;
use super::picture::{Curve, Picture};
use super::region::{Region, RegionOptions, vertical};
use super::report::{Report, Table, seconds};
use super::snapshots::{Extra, Snapshot, StoredRun};
use super::sums::{counts, exact_sums};
use super::void_fraction::{Center, rings};
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::{Shape, Vec3};
use grains_simulation::RunError;
use std::f64::consts::PI;

/// Options of `analyse profiles`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Where particles count.
    pub region: RegionOptions,
    /// Centre of the radial profile across the axis (m); `axis` for the middle of the region.
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "CX,CY|axis", allow_hyphen_values = true, default_value = "axis")
    )]
    pub radial: Center,
    /// Number of bins of either profile.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000)))]
    pub bins: u64,
}

/// Which part of the volume of a particle lies in a bin.
#[derive(Clone, Debug)]
pub enum Bins {
    /// Layers of equal thickness along the axis; a particle counts as the sphere of its volume.
    Layers(usize),
    /// Rings about a centre, by outer radius (m); a particle lies where its centre does.
    Rings([f64; 2], Vec<f64>),
}

/// A bin of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Middle of the bin (m).
    pub position: f64,
    /// Centres in it (-).
    pub count: u64,
    /// Centres per volume (1/m³).
    pub number_density: f64,
    /// Solid volume per volume (-).
    pub solid_fraction: f64,
    /// Mean velocity (m/s); NaN without particles.
    pub velocity: Vec3,
    /// Granular temperature, the mean of |v − mean|²/3 (m²/s²); NaN without particles.
    pub temperature: f64,
}

/// Volume of the part of a sphere of radius `r` that lies below height `h` over its centre.
fn below(h: f64, r: f64) -> f64 {
    let h = h.clamp(-r, r);
    PI * (h + r).powi(2) * (2.0 * r - h) / 3.0
}

/// Profile of a region.
pub fn measure(
    region: &Region,
    bins: &Bins,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    transport: &impl Transport,
) -> Vec<Bin> {
    let (axis, lower) = (region.axis, region.lower[region.axis]);
    let (number, step) = match bins {
        Bins::Layers(n) => (*n, region.height() / *n as f64),
        Bins::Rings(_, edges) => (edges.len(), f64::NAN),
    };
    let bin = |i: usize| match bins {
        Bins::Layers(n) => (((snapshot.position[i][axis] - lower) / step) as usize).min(n - 1),
        Bins::Rings(center, edges) => {
            let [a, b] = super::region::across(axis);
            let distance = (snapshot.position[i][a] - center[0]).hypot(snapshot.position[i][b] - center[1]);
            edges.partition_point(|&edge| edge < distance).min(edges.len() - 1)
        }
    };
    let members: Vec<(usize, usize)> = (0..snapshot.len())
        .filter(|&i| region.contains(&snapshot.position[i]))
        .map(|i| (i, bin(i)))
        .collect();
    let count = counts(transport, number, members.iter().map(|m| m.1));
    let mut volumes = exact_sums(transport, number, |add| match bins {
        Bins::Rings(..) => members.iter().for_each(|&(i, b)| add(b, snapshot.volume(i, shapes))),
        Bins::Layers(n) => layer_volumes(region, *n, (snapshot, shapes), add),
    });
    let moments = exact_sums(transport, 3 * number, |add| {
        members.iter().for_each(|&(i, b)| (0..3).for_each(|c| add(3 * b + c, snapshot.velocity[i][c])));
    });
    let mean = |b: usize| Vec3::from_column_slice(&moments[3 * b..3 * b + 3]) / count[b] as f64;
    let spreads = exact_sums(transport, number, |add| {
        members.iter().for_each(|&(i, b)| add(b, (snapshot.velocity[i] - mean(b)).norm_squared()));
    });
    let spaces = spaces(region, bins);
    (0..number)
        .map(|b| {
            let position = match bins {
                Bins::Layers(_) => lower + (b as f64 + 0.5) * step,
                Bins::Rings(_, edges) => 0.5 * (edges[b] + if b > 0 { edges[b - 1] } else { 0.0 }),
            };
            volumes[b] /= spaces[b];
            Bin {
                position,
                count: count[b],
                number_density: count[b] as f64 / spaces[b],
                solid_fraction: volumes[b],
                velocity: mean(b),
                temperature: spreads[b] / (3.0 * count[b] as f64),
            }
        })
        .collect()
}

/// Hands to `add` the volume each particle has in each layer.
fn layer_volumes(
    region: &Region,
    layers: usize,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    add: &mut dyn FnMut(usize, f64),
) {
    let (axis, lower) = (region.axis, region.lower[region.axis]);
    let step = region.height() / layers as f64;
    for i in 0..snapshot.len() {
        // A particle beyond an end of the region may reach into it.
        let mut seen = snapshot.position[i];
        seen[axis] = lower + 0.5 * region.height();
        if !region.contains(&seen) {
            continue;
        }
        let radius = 0.5 * grains_geometry::sphere_equivalent_diameter(snapshot.volume(i, shapes));
        let x = snapshot.position[i][axis] - lower;
        let first = ((x - radius) / step).floor().max(0.0) as usize;
        let end = ((x + radius) / step).ceil().clamp(0.0, layers as f64) as usize;
        for b in first..end {
            let edges = [b, b + 1].map(|k| below(k as f64 * step - x, radius));
            add(b, edges[1] - edges[0]);
        }
    }
}

/// Volume of each bin (m³); of rings cut by the sides of a box by counting points on circles.
fn spaces(region: &Region, bins: &Bins) -> Vec<f64> {
    match bins {
        Bins::Layers(n) => vec![region.cross_section() * region.height() / *n as f64; *n],
        Bins::Rings(center, edges) => {
            let area = |k: usize, edge: f64| {
                let inner = if k > 0 { edges[k - 1] } else { 0.0 };
                PI * (edge * edge - inner * inner) * share_inside(region, *center, inner, edge)
            };
            edges.iter().enumerate().map(|(k, &edge)| area(k, edge) * region.height()).collect()
        }
    }
}

/// Share of a ring that lies in the region, from 64 circles of 720 points.
fn share_inside(region: &Region, center: [f64; 2], inner: f64, outer: f64) -> f64 {
    const CIRCLES: usize = 64;
    const POINTS: usize = 720;
    let [a, b] = super::region::across(region.axis);
    let mut point = Vec3::zeros();
    point[region.axis] = 0.5 * (region.lower[region.axis] + region.upper[region.axis]);
    let mut inside = 0;
    for circle in 0..CIRCLES {
        // Circles between rings of equal area.
        let part = (circle as f64 + 0.5) / CIRCLES as f64;
        let radius = (inner * inner + part * (outer * outer - inner * inner)).sqrt();
        for k in 0..POINTS {
            let angle = 2.0 * PI * (k as f64 + 0.5) / POINTS as f64;
            point[a] = center[0] + radius * angle.cos();
            point[b] = center[1] + radius * angle.sin();
            inside += usize::from(region.contains(&point));
        }
    }
    inside as f64 / (CIRCLES * POINTS) as f64
}

const COLUMNS: [(&str, &str); 9] = [
    ("time", "s"),
    ("position", "m"),
    ("count", "-"),
    ("number_density", "1/m3"),
    ("solid_fraction", "-"),
    ("velocity_x", "m/s"),
    ("velocity_y", "m/s"),
    ("velocity_z", "m/s"),
    ("granular_temperature", "m2/s2"),
];

/// Profiles of the chosen states.
///
/// # Errors
/// Options that do not fit, fields that were not stored, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let axial =
        "Layers along the axis, at their middles; solid fraction from spheres of the particles' volumes.";
    let radial = "Rings about the axis, at the middles of their radii; solid fraction by centres (for the exact one: analyse void-fraction --radial).";
    let mut tables =
        [Table::new("profiles-axial", axial, &COLUMNS), Table::new("profiles-radial", radial, &COLUMNS)];
    let (mut report, mut curves) = (Report::default(), [vec![], vec![], vec![], vec![]]);
    let bins = options.bins as usize;
    for &state in states {
        let snapshot = run.read(transport, state, &[Extra::Velocity], "profiles")?;
        let particles = (&snapshot, &run.catalogue.shapes[..]);
        let region = Region::of_state(&run.case, (&snapshot, particles.1), &options.region, transport)?;
        let rings = rings(&region, options.radial.of(&region), bins);
        let kinds = [Bins::Layers(bins), Bins::Rings(rings.center, rings.edges)];
        for (k, kind) in kinds.iter().enumerate() {
            let profile = measure(&region, kind, particles, transport);
            for bin in &profile {
                let (v, t) = (bin.velocity, bin.temperature);
                let density = [bin.count as f64, bin.number_density, bin.solid_fraction];
                tables[k].push([&[snapshot.time, bin.position], &density[..], &[v.x, v.y, v.z, t]].concat());
            }
            let label = seconds(snapshot.time);
            let points =
                |value: &dyn Fn(&Bin) -> f64| profile.iter().map(|b| [b.position, value(b)]).collect();
            curves[2 * k].push(Curve::line(&label, points(&|b| b.solid_fraction)));
            curves[2 * k + 1].push(Curve::line(&label, points(&|b| b.velocity[region.axis])));
            if k == 0 {
                let highest = profile.iter().map(|b| b.solid_fraction).fold(0.0, f64::max);
                let inside: u64 = profile.iter().map(|b| b.count).sum();
                report.lines.push(format!(
                    "t = {label}: {inside} particles in the {region}; highest solid fraction of a layer {highest:.4}"
                ));
            }
        }
    }
    let axis = options.region.axis.map_or_else(|| vertical(&run.case), |a| a as usize);
    let along = format!("{} (m)", ["x", "y", "z"][axis]);
    let velocity = format!("mean velocity along {} (m/s)", ["x", "y", "z"][axis]);
    let about = "distance from the axis (m)";
    let [layers, layer_speeds, rings, ring_speeds] = curves;
    report.pictures = vec![
        Picture::few("profiles-axial", "Solid fraction", [&along, "solid fraction (-)"], layers),
        Picture::few("profiles-axial-velocity", "Mean velocity", [&along, &velocity], layer_speeds),
        Picture::few("profiles-radial", "Solid fraction", [about, "solid fraction (-)"], rings),
        Picture::few("profiles-radial-velocity", "Mean velocity", [about, &velocity], ring_speeds),
    ];
    report.tables = tables.into();
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{ball, particles};
    use grains_domain::SerialTransport;

    fn region() -> Region {
        Region { lower: Vec3::zeros(), upper: Vec3::new(2.0, 2.0, 4.0), axis: 2, cylinder: None }
    }

    #[test]
    fn a_ball_between_layers_is_shared_and_its_volume_kept() {
        let snapshot = particles(vec![Vec3::new(1.0, 1.0, 2.0), Vec3::new(1.0, 1.0, 0.25)]);
        let shapes = ball(0.5);
        let profile = measure(&region(), &Bins::Layers(8), (&snapshot, &shapes), &SerialTransport);
        let volume = |k: usize| profile[k].solid_fraction * 2.0;
        let half = 0.5 * shapes[0].volume;
        assert!((volume(3) - half).abs() < 1e-12 && (volume(4) - half).abs() < 1e-12);
        // The second reaches through the lower face: a cap of height 1/4 is missing.
        let cap = PI * 0.25_f64.powi(2) * (1.5 - 0.25) / 3.0;
        assert!((volume(0) + volume(1) - (shapes[0].volume - cap)).abs() < 1e-12);
        assert_eq!(profile.iter().map(|b| b.count).collect::<Vec<_>>(), [1, 0, 0, 0, 1, 0, 0, 0]);
        assert!((profile[4].number_density - 0.5).abs() < 1e-12 && profile[1].temperature.is_nan());
    }

    #[test]
    fn a_ring_of_particles_shows_in_its_bin_only() {
        let place = |k: usize| {
            let (sin, cos) = (0.1 + k as f64).sin_cos();
            Vec3::new(1.0 + 0.55 * cos, 1.0 + 0.55 * sin, 0.03 * k as f64)
        };
        let mut snapshot = particles((0..100).map(place).collect());
        // Half of them move up at 3, half at 1: mean 2, spread 1 in one direction.
        for (k, v) in snapshot.velocity.iter_mut().enumerate() {
            v.z = if k % 2 == 0 { 3.0 } else { 1.0 };
        }
        let bins = Bins::Rings([1.0, 1.0], vec![0.25, 0.5, 0.75, 1.0, 1.5]);
        let profile = measure(&region(), &bins, (&snapshot, &ball(0.01)), &SerialTransport);
        assert_eq!(profile.iter().map(|b| b.count).collect::<Vec<_>>(), [0, 0, 100, 0, 0]);
        let space = PI * (0.75 * 0.75 - 0.25) * 4.0;
        assert!((profile[2].number_density * space / 100.0 - 1.0).abs() < 1e-9);
        assert!((profile[2].velocity - Vec3::new(0.0, 0.0, 2.0)).norm() < 1e-12);
        assert!((profile[2].temperature - 1.0 / 3.0).abs() < 1e-12);
        // The last ring lies in the corners only.
        let corners = spaces(&region(), &bins)[4];
        assert!((corners / (4.0 * (4.0 - PI)) - 1.0).abs() < 0.02, "{corners}");
    }
}
