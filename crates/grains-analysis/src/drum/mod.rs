//! `analyse drum`: speed, free surface and regime of a rotating drum (Rakotonirina 2016, ch. 3.4.2).

mod geometry;
mod regime;
mod surface;

use super::Common;
use super::fit::mean_and_deviation;
use super::picture::{Curve, Picture};
use super::region::mean_diameter;
use super::report::{Report, Table, seconds};
use super::snapshots::{Extra, Snapshot, StoredRun};
use super::sums::exact_sums;
use geometry::{Drum, DrumOptions};
use grains_comm::MpiTransport;
use grains_dem::Catalogue;
use grains_domain::Transport;
use grains_simulation::RunError;
use regime::{Signs, regime};
use std::f64::consts::TAU;
use surface::Surface;

/// Options of `analyse drum`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// The drum.
    pub drum: DrumOptions,
}

/// A particle moves with the drum if its velocity differs from that of the drum by less than this part of the
/// speed of the rim.
const WITH_THE_DRUM: f64 = 0.05;

/// What a state shows.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Mean speed of the particles over that of the rim (-).
    pub speed: f64,
    /// Share of the particles that move with the drum (-).
    pub order: f64,
    /// Free surface of the bed, if there is one.
    pub surface: Option<Surface>,
    /// Translational and rotational kinetic energy (J).
    pub energies: [f64; 2],
    /// Distance of the centre of volume from the axis over the radius (-).
    pub offset: f64,
    /// Mean diameter of the particles over the radius (-).
    pub grain: f64,
}

/// What a state shows; it must hold materials, velocities and angular velocities.
pub fn measure(
    drum: &Drum,
    (snapshot, catalogue): (&Snapshot, &Catalogue),
    transport: &impl Transport,
) -> Found {
    let shapes = &catalogue.shapes;
    let rim = drum.rate.abs() * drum.radius;
    let is_carried = |i: usize| {
        let carried = drum.velocity_at(&snapshot.position[i]);
        (snapshot.velocity[i] - carried).norm() < WITH_THE_DRUM * rim
    };
    let mut numbers =
        [snapshot.len(), (0..snapshot.len()).filter(|&i| is_carried(i)).count()].map(|n| n as u64);
    transport.sum_counts(&mut numbers);
    let own = 0..snapshot.len();
    let speeds =
        exact_sums(transport, 1, |add| own.clone().for_each(|i| add(0, snapshot.velocity[i].norm())));
    let energies = exact_sums(transport, 2, |add| {
        for i in own.clone() {
            let (shape, scale) = (&shapes[snapshot.shape[i]], snapshot.scale[i]);
            let density = catalogue.densities[snapshot.material[i]];
            let spin = snapshot.orientation[i].inverse() * snapshot.angular_velocity[i];
            let turning = shape.inertia.dot(&spin.component_mul(&spin)) * scale.powi(5);
            add(0, 0.5 * density * shape.volume * scale.powi(3) * snapshot.velocity[i].norm_squared());
            add(1, 0.5 * density * turning);
        }
    });
    let middles = exact_sums(transport, 3, |add| {
        for i in own.clone() {
            let (place, volume) = (drum.place(&snapshot.position[i]), snapshot.volume(i, shapes));
            [place[0] * volume, place[1] * volume, volume]
                .into_iter()
                .enumerate()
                .for_each(|(k, x)| add(k, x));
        }
    });
    let middle = [middles[0] / middles[2], middles[1] / middles[2]];
    let diameter = mean_diameter(snapshot, shapes, own, transport);
    Found {
        speed: speeds[0] / numbers[0] as f64 / rim,
        order: numbers[1] as f64 / numbers[0] as f64,
        surface: surface::find(drum, middle, diameter, (snapshot, shapes), transport),
        energies: [energies[0], energies[1]],
        offset: middle[0].hypot(middle[1]) / drum.radius,
        grain: diameter / drum.radius,
    }
}

/// The drum in the chosen states, and its regime over all of them.
///
/// # Errors
/// No drum to be found in the case, fields that were not stored, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let drum = Drum::chosen(&run.case, &options.drum)?;
    let (mut table, mut grain) = (table(), 0.0);
    for &state in states {
        let wanted = [Extra::Material, Extra::Velocity, Extra::AngularVelocity];
        let snapshot = run.read(transport, state, &wanted, "drum")?;
        let found = measure(&drum, (&snapshot, &run.catalogue), transport);
        let [moving, turning] = found.energies;
        grain = f64::max(grain, found.grain);
        let of_surface = match found.surface {
            Some(s) => [s.angle.to_degrees(), s.roughness, s.thrown],
            None => [f64::NAN; 3],
        };
        let turned = drum.turned(snapshot.time);
        let row = [&[snapshot.time, turned, found.speed, found.order], &of_surface[..]].concat();
        table.push([&row[..], &[found.offset, moving, turning, moving / turning]].concat());
    }
    let mut report = Report { lines: summary(&drum, &table, grain), ..Report::default() };
    if states.len() > 1 {
        let picture = |name: &str, title: &str, label: &str, column: usize| {
            let curve = Curve::line("", table.points(1, column));
            Picture::new(name, title, ["angle turned (rad)", label], vec![curve])
        };
        report.pictures = vec![
            picture("drum-speed", "Mean speed", "mean speed / rim speed (-)", 2),
            picture("drum-order", "Particles that move with the drum", "share of the particles (-)", 3),
            picture("drum-angle", "Angle of the free surface", "angle (degrees)", 4),
        ];
    } else {
        report.pictures = vec![cross_section(run, states[0], &drum, &table, transport)?];
    }
    report.tables.push(table);
    Ok(report)
}

fn table() -> Table {
    let what = "Mean speed over rim speed, share of the particles that move with the drum, angle of the free surface against the horizontal (positive where it rises the way the drum's lowest point moves), rms distance of the surface from the fitted line over the radius, share of the particles above the surface, distance of the centre of volume from the axis over the radius, kinetic energies and their ratio.";
    let columns = [
        ("time", "s"),
        ("turned", "rad"),
        ("speed", "-"),
        ("order", "-"),
        ("angle", "deg"),
        ("roughness", "-"),
        ("thrown", "-"),
        ("offset", "-"),
        ("kinetic_translation", "J"),
        ("kinetic_rotation", "J"),
        ("kinetic_ratio", "-"),
    ];
    Table::new("drum", what, &columns)
}

/// The main numbers, means over the states.
fn summary(drum: &Drum, table: &Table, grain: f64) -> Vec<String> {
    let column = |k: usize| mean_and_deviation(table.rows.iter().map(|row| row[k]));
    let (speed, angle) = (column(2), column(4));
    let mean = |k: usize| column(k)[0];
    let energy = |k: usize| table.rows.iter().map(|row| row[k]).sum::<f64>();
    let froude = drum.froude();
    let signs = Signs {
        froude,
        speed: speed[0],
        order: mean(3),
        roughness: mean(5),
        grain,
        thrown: mean(6),
        angle_deviation: if table.rows.len() >= Signs::ENOUGH { Some(angle[1]) } else { None },
    };
    let regime = regime(&signs);
    vec![
        format!(
            "drum of radius {:.5} m at {:.2} rpm, Fr = {froude:.5}: {} ({})",
            drum.radius,
            drum.rate.abs() * 60.0 / TAU,
            regime.name(),
            regime.reason(&signs)
        ),
        format!(
            "mean speed {:.4} ± {:.4} of the rim, {:.2} % move with the drum, surface at {:.2} ± {:.2} degrees, kinetic energy ratio {:.3}; {} states",
            speed[0],
            speed[1],
            100.0 * signs.order,
            angle[0],
            angle[1],
            energy(8) / energy(9),
            table.rows.len()
        ),
    ]
}

/// Centres in the cross-section with the fitted surface.
fn cross_section(
    run: &StoredRun,
    state: usize,
    drum: &Drum,
    table: &Table,
    transport: &MpiTransport,
) -> Result<Picture, RunError> {
    const MAX: usize = 3000;
    let wanted = [Extra::Material, Extra::Velocity, Extra::AngularVelocity];
    let snapshot = run.read(transport, state, &wanted, "drum")?;
    // Every stride-th of all, counted over the ranks.
    let (mut first, mut total) = ([snapshot.len() as u64], [snapshot.len() as u64]);
    transport.counts_before(&mut first);
    transport.sum_counts(&mut total);
    let stride = (total[0] as usize).div_ceil(MAX).max(1);
    let skipped = (first[0] as usize).next_multiple_of(stride) - first[0] as usize;
    let own = snapshot.position.iter().skip(skipped).step_by(stride);
    let all = transport.gather(&own.flat_map(|x| drum.place(x)).collect::<Vec<f64>>());
    let centres = all.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
    let rim =
        (0..=180).map(|k| f64::from(k) / 180.0 * TAU).map(|a| [drum.radius * a.cos(), drum.radius * a.sin()]);
    let mut curves = vec![Curve::line("drum", rim.collect()), Curve::dots("centres", centres)];
    let angle = table.rows[0][4];
    let found = measure(drum, (&snapshot, &run.catalogue), transport);
    if let Some(Surface { angle, height, .. }) = found.surface {
        let (sin, cos) = angle.sin_cos();
        let half = (drum.radius * drum.radius - height * height).max(0.0).sqrt();
        let end = |s: f64| [s * cos - height * sin, s * sin + height * cos];
        curves.push(Curve::line("surface", vec![end(-half), end(half)]));
    }
    let title = format!("Free surface at {angle:.1} degrees, t = {}", seconds(snapshot.time));
    let picture = Picture::new("drum", title, ["the way the lowest point moves (m)", "up (m)"], curves);
    Ok(Picture { is_true_to_scale: true, ..picture })
}

#[cfg(test)]
mod tests;
