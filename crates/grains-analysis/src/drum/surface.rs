//! The free surface of a bed in the cross-section of a drum.
//!
//! In a frame turned so that the surface is nearly level, the bed is cut into columns that stand on the
//! drum's wall. In a column filled evenly from the wall at h_w to the surface, half of the volume lies below
//! the middle, so the surface is at 2 h_½ − h_w, with h_½ the median height: neither a packing fraction nor
//! the few grains in flight matter. The line of the median slope (Theil-Sen) through the columns of the
//! middle half of the drum gives the angle, and the frame is turned again until it no longer changes, so
//! that steep surfaces are found as well as flat ones.

use super::super::fit::median_slope;
use super::super::snapshots::Snapshot;
use super::super::sums::{counts, exact_sums};
use super::geometry::Drum;
use grains_domain::Transport;
use grains_geometry::Shape;
use std::f64::consts::FRAC_PI_2;

/// A fitted surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Angle against the horizontal (rad), positive where the surface rises forward.
    pub angle: f64,
    /// Distance of the line from the axis (m), negative below it.
    pub height: f64,
    /// Root mean square distance of the surface from the line over the radius (-).
    pub roughness: f64,
    /// Share of the particles that lie higher than two diameters above the line (-).
    pub thrown: f64,
}

/// Distance of the centre of volume from the axis over the radius below which there is no bed (-).
const NO_BED: f64 = 0.05;
/// Cells across the drum in which heights are told apart.
const HEIGHTS: usize = 400;

/// Fits the surface; `middle` is the centre of volume in the cross-section (m), `diameter` that of the
/// particles (m). None without a bed on one side of the drum.
pub fn find(
    drum: &Drum,
    middle: [f64; 2],
    diameter: f64,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    transport: &impl Transport,
) -> Option<Surface> {
    let r = drum.radius;
    // Without particles the centre is not a number.
    if middle[0].is_nan() || middle[0].hypot(middle[1]) <= NO_BED * r {
        return None;
    }
    // A level surface lies across the direction from the axis to the centre of volume.
    let mut angle = middle[0].atan2(-middle[1]);
    let mut fitted = None;
    for _ in 0..20 {
        let columns = columns(drum, angle, diameter, (snapshot, shapes), transport);
        let central: Vec<[f64; 2]> = columns.iter().copied().filter(|c| c[0].abs() <= 0.5 * r).collect();
        if central.len() < 4 {
            return None;
        }
        let fit = median_slope(&central)?;
        let residues = columns.iter().map(|c| (c[1] - fit.intercept - fit.slope * c[0]).powi(2));
        let roughness = (residues.sum::<f64>() / columns.len() as f64).sqrt() / r;
        angle += fit.slope.atan();
        let height = fit.intercept * fit.slope.atan().cos();
        fitted = Some(Surface { angle, height, roughness, thrown: 0.0 });
        if fit.slope.abs() < 1e-3 {
            break;
        }
    }
    // Particles that hang over the axis are no bed.
    let surface = fitted.filter(|s| s.angle.abs() <= FRAC_PI_2)?;
    let is_thrown =
        |i: usize| usize::from(turned(drum, surface.angle, snapshot, i)[1] > surface.height + 2.0 * diameter);
    let [all, thrown] = {
        let found = counts(transport, 2, (0..snapshot.len()).map(is_thrown));
        [found[0] + found[1], found[1]]
    };
    Some(Surface { thrown: thrown as f64 / all as f64, ..surface })
}

/// Place of a particle along and across a direction at an angle against the horizontal (m).
fn turned(drum: &Drum, angle: f64, snapshot: &Snapshot, i: usize) -> [f64; 2] {
    let ([x, y], (sin, cos)) = (drum.place(&snapshot.position[i]), angle.sin_cos());
    [x * cos + y * sin, y * cos - x * sin]
}

/// Middles of columns as wide as a particle and the surface in them (m); those without particles are left out.
fn columns(
    drum: &Drum,
    angle: f64,
    diameter: f64,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    transport: &impl Transport,
) -> Vec<[f64; 2]> {
    // Near the sides the wall is too steep for columns to tell anything.
    let (r, half_width) = (drum.radius, 0.8 * drum.radius);
    let number = ((2.0 * half_width / diameter) as usize).clamp(8, 400);
    let (width, rise) = (2.0 * half_width / number as f64, 2.0 * r / HEIGHTS as f64);
    let volumes = exact_sums(transport, number * HEIGHTS, |add| {
        for i in 0..snapshot.len() {
            let [s, h] = turned(drum, angle, snapshot, i);
            let level = (((h + r) / rise).max(0.0) as usize).min(HEIGHTS - 1);
            // Shared by the two nearest columns, lest a grain on the border between them weighs too much.
            let at = (s + half_width) / width - 0.5;
            let share = at - at.floor();
            for (column, share) in [(at.floor(), 1.0 - share), (at.floor() + 1.0, share)] {
                if (0.0..number as f64).contains(&column) {
                    add(column as usize * HEIGHTS + level, share * snapshot.volume(i, shapes));
                }
            }
        }
    });
    let surface = |(k, column): (usize, &[f64])| {
        let total: f64 = column.iter().sum();
        let middle = -half_width + (k as f64 + 0.5) * width;
        let wall = -(r * r - middle * middle).sqrt();
        let mut below = 0.0;
        let level = column.iter().position(|v| {
            below += v;
            below >= 0.5 * total
        })?;
        let part = (0.5 * total - (below - column[level])) / column[level];
        let median = -r + (level as f64 + part) * rise;
        Some([middle, 2.0 * median - wall])
    };
    let filled = volumes.chunks_exact(HEIGHTS).enumerate().filter(|(_, c)| c.iter().any(|&v| v > 0.0));
    filled.filter_map(surface).collect()
}
