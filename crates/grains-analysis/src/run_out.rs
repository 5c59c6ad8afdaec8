//! `analyse run-out`: length and shape of a deposit (Rakotonirina 2016, ch. 5.4.2, eq. 5.9).
//!
//! A box of length and height d, the particles' mean diameter, that spans the width W slides along the floor
//! from the wall of the reservoir. Its solid fraction φ(X) = Σ V_i / (d W d) takes the particles whose
//! centres lie in it, X being its middle. The deposit ends at the first X, after φ was above a threshold,
//! where it is no longer. The printed scaling of H∞/H is one of H∞/L (with L the initial length), which is
//! why heights are scaled with L here.

use super::Common;
use super::picture::{Curve, Picture};
use super::region::{Region, RegionOptions, mean_diameter, vertical};
use super::report::{Report, Table, seconds};
use super::snapshots::{Snapshot, StoredRun};
use super::sums::exact_sums;
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::{Shape, Vec3};
use grains_simulation::RunError;
use std::str::FromStr;

/// Options of `analyse run-out`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    /// Direction in which the column collapses: +x, -x, +y, …; +x if absent (+y if gravity is along x).
    #[cfg_attr(feature = "clap", arg(long, allow_hyphen_values = true))]
    pub direction: Option<Direction>,
    /// Coordinate of the reservoir's wall (m), where lengths begin; that of the container if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M", allow_hyphen_values = true))]
    pub origin: Option<f64>,
    /// Coordinate of the floor along gravity (m); that of the container if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M", allow_hyphen_values = true))]
    pub floor: Option<f64>,
    /// Width of the channel (m); that of the container if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub width: Option<f64>,
    /// Length L of the column before the collapse (m), to scale with.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub length: Option<f64>,
    /// Particle diameter d (m); that of the sphere of the mean volume if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub diameter: Option<f64>,
    /// Width of the bins of the height profile (m); 2 d if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub bin: Option<f64>,
    /// Solid fraction of the deposit, which turns solid volume into height.
    #[cfg_attr(feature = "clap", arg(long, default_value_t = 0.6))]
    pub packing: f64,
}

/// An axis and a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction(usize, f64);

impl FromStr for Direction {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (sign, name) = match text.strip_prefix('-') {
            Some(name) => (-1.0, name),
            None => (1.0, text.strip_prefix('+').unwrap_or(text)),
        };
        let axis = ["x", "y", "z"].iter().position(|a| *a == name);
        axis.map(|axis| Self(axis, sign)).ok_or_else(|| format!("`{text}` is none of +x, -x, +y, -y, +z, -z"))
    }
}

/// Where the channel lies.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    /// Direction of the collapse and coordinate of the reservoir's wall (m).
    along: (Direction, f64),
    /// Direction against gravity and coordinate of the floor (m).
    up: (Direction, f64),
    /// From the reservoir's wall to the end of the domain (m).
    reach: f64,
    width: f64,
    diameter: f64,
    bin: f64,
    packing: f64,
}

impl Channel {
    /// Distance from the reservoir's wall and height over the floor (m).
    fn place(&self, point: &Vec3) -> [f64; 2] {
        [self.along, self.up].map(|(Direction(axis, sign), from)| sign * (point[axis] - from))
    }
}

/// Thresholds of φ at which the deposit ends; the first is that of the thesis.
const THRESHOLDS: [f64; 3] = [0.1, 0.05, 0.025];
/// Steps in which the box slides per d.
const STEPS: usize = 20;

/// The deposit of a state.
#[derive(Clone, Debug)]
pub struct Found {
    /// Length by each threshold (m).
    pub lengths: [f64; 3],
    /// Largest distance of a centre (m).
    pub tip: f64,
    /// Middle of the box (m) and φ (-).
    pub layer: Vec<[f64; 2]>,
    /// Middle of the bin (m), height from the solid volume (m), highest point of a particle (m).
    pub profile: Vec<[f64; 3]>,
}

impl Found {
    /// Largest height from the solid volume (m).
    pub fn height(&self) -> f64 {
        self.profile.iter().map(|p| p[1]).fold(0.0, f64::max)
    }
}

/// First X after φ exceeded the threshold where it no longer does; 0 if it never did, the last X if it stays.
fn front(layer: &[[f64; 2]], threshold: f64) -> f64 {
    let Some(begin) = layer.iter().position(|p| p[1] > threshold) else { return 0.0 };
    let end = layer[begin..].iter().find(|p| p[1] <= threshold);
    end.or(layer.last()).map_or(0.0, |p| p[0])
}

/// Length and shape of the deposit of a state.
pub fn measure(
    channel: &Channel,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    transport: &impl Transport,
) -> Found {
    let d = channel.diameter;
    let step = d / STEPS as f64;
    let steps = ((channel.reach / step).ceil() as usize).max(STEPS);
    let bins = ((channel.reach / channel.bin).ceil() as usize).max(1);
    let places: Vec<[f64; 2]> = snapshot.position.iter().map(|x| channel.place(x)).collect();
    let inside = |i: usize| places[i][0] >= 0.0 && places[i][1] >= 0.0;
    let slot = |x: f64, width: f64, slots: usize| ((x / width) as usize).min(slots - 1);
    // Both histograms at once: the layer on the floor in thin slices, then all in bins.
    let volumes = exact_sums(transport, steps + bins, |add| {
        for i in (0..places.len()).filter(|&i| inside(i)) {
            let volume = snapshot.volume(i, shapes);
            if places[i][1] < d {
                add(slot(places[i][0], step, steps), volume);
            }
            add(steps + slot(places[i][0], channel.bin, bins), volume);
        }
    });
    let (slices, columns) = volumes.split_at(steps);
    let share = |window: &[f64]| window.iter().sum::<f64>() / (d * channel.width * d);
    let layer: Vec<[f64; 2]> = slices
        .windows(STEPS)
        .enumerate()
        .map(|(k, window)| [(k as f64 + 0.5 * STEPS as f64) * step, share(window)])
        .collect();
    let mut tops = vec![0.0_f64; bins + 1];
    let Direction(axis, sign) = channel.up.0;
    for i in (0..places.len()).filter(|&i| inside(i)) {
        let reach = snapshot.reach(i, axis, shapes)[usize::from(sign > 0.0)];
        let top = &mut tops[slot(places[i][0], channel.bin, bins)];
        *top = top.max(places[i][1] + reach);
        tops[bins] = tops[bins].max(places[i][0]);
    }
    transport.max(&mut tops);
    let area = channel.width * channel.bin * channel.packing;
    let profile = (0..bins).map(|b| [(b as f64 + 0.5) * channel.bin, columns[b] / area, tops[b]]).collect();
    Found { lengths: THRESHOLDS.map(|t| front(&layer, t)), tip: tops[bins], layer, profile }
}

/// The channel of the options, the rest from the container of the case.
///
/// # Errors
/// Options that make no sense.
fn channel(
    case: &Case,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    options: &Options,
    transport: &impl Transport,
) -> Result<Channel, RunError> {
    let vertical = vertical(case);
    let default = Direction(usize::from(vertical == 0), 1.0);
    let Direction(axis, sign) = options.direction.unwrap_or(default);
    if axis == vertical {
        return Err(RunError::case("--direction: lies along gravity; give one across it"));
    }
    let container = Region::chosen(case, snapshot.time, &RegionOptions::default())?;
    let up = if case.gravity[vertical] > 0.0 { -1.0 } else { 1.0 };
    let face =
        |axis: usize, sign: f64| if sign > 0.0 { container.lower[axis] } else { container.upper[axis] };
    let origin = options.origin.unwrap_or_else(|| face(axis, sign));
    let floor = options.floor.unwrap_or_else(|| face(vertical, up));
    let other = 3 - axis - vertical;
    let width = options.width.unwrap_or(container.upper[other] - container.lower[other]);
    let mean = mean_diameter(snapshot, shapes, 0..snapshot.len(), transport);
    let diameter = options.diameter.unwrap_or(mean);
    let bin = options.bin.unwrap_or(2.0 * diameter);
    let reach = sign * (face(axis, -sign) - origin);
    let lengths = [
        ("--width", width),
        ("--diameter", diameter),
        ("--bin", bin),
        ("--packing", options.packing),
        ("--origin (distance to the far end of the domain)", reach),
        ("--length", options.length.unwrap_or(1.0)),
    ];
    if let Some((name, value)) = lengths.iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
        return Err(RunError::case(format!(
            "{name}: is {value}; it must be positive (and there must be particles)"
        )));
    }
    if reach / diameter.min(bin) > 1e7 {
        return Err(RunError::case(format!(
            "--diameter, --bin: {diameter:.3e} and {bin:.3e} m are too fine for a channel of {reach:.3e} m"
        )));
    }
    let (along, up) = ((Direction(axis, sign), origin), (Direction(vertical, up), floor));
    Ok(Channel { along, up, reach, width, diameter, bin, packing: options.packing })
}

/// The deposit of the chosen states.
///
/// # Errors
/// Options that do not fit, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let scale = options.length.unwrap_or(f64::NAN);
    let [mut fronts, mut profiles, mut layers] = tables();
    let (mut report, mut heights) = (Report::default(), Vec::new());
    for &state in states {
        let snapshot = run.read(transport, state, &[], "run-out")?;
        let particles = (&snapshot, &run.catalogue.shapes[..]);
        if snapshot.total(transport) == 0 {
            report.lines.push(format!("t = {}: no particles", seconds(snapshot.time)));
            continue;
        }
        let channel = channel(&run.case, particles, options, transport)?;
        let found = measure(&channel, particles, transport);
        let (time, height) = (snapshot.time, found.height());
        let run_outs = found.lengths.map(|length| (length - scale) / scale);
        fronts.push([&[time], &found.lengths[..], &run_outs, &[found.tip, height, height / scale]].concat());
        for &[x, h, top] in &found.profile {
            profiles.push(vec![time, x, h, top, x / scale, h / scale, top / scale]);
        }
        found.layer.iter().for_each(|p| layers.push(vec![time, p[0], p[1]]));
        let curve = found.profile.iter().map(|p| [p[0], p[1]]).collect();
        heights.push(Curve::line(seconds(time), curve));
        let scaled = match options.length {
            Some(_) => format!(", run-out (L_inf - L)/L = {:.4}, H/L = {:.4}", run_outs[0], height / scale),
            None => String::new(),
        };
        report.lines.push(format!(
            "t = {}: deposit {:.5} m long (φ ≤ 0.1; {:.5} at 0.05, {:.5} at 0.025), {height:.5} m high{scaled}; d = {:.4e} m, W = {:.5} m",
            seconds(time),
            found.lengths[0],
            found.lengths[1],
            found.lengths[2],
            channel.diameter,
            channel.width
        ));
    }
    let axes = ["distance from the reservoir's wall (m)", "height (m)"];
    report.pictures.push(Picture::few("run-out-profile", "Height of the deposit", axes, heights));
    if states.len() > 1 {
        let curve = |k: usize| Curve::line(format!("φ ≤ {}", THRESHOLDS[k]), fronts.points(0, 1 + k));
        let title = "Length of the deposit";
        report.pictures.push(Picture::new(
            "run-out",
            title,
            ["time (s)", "length (m)"],
            (0..3).map(curve).collect(),
        ));
    }
    report.tables.extend([fronts, profiles, layers]);
    Ok(report)
}

fn tables() -> [Table; 3] {
    let fronts = [
        ("time", "s"),
        ("length_0.1", "m"),
        ("length_0.05", "m"),
        ("length_0.025", "m"),
        ("run_out_0.1", "-"),
        ("run_out_0.05", "-"),
        ("run_out_0.025", "-"),
        ("tip", "m"),
        ("height", "m"),
        ("height_over_length", "-"),
    ];
    let profile = [
        ("time", "s"),
        ("x", "m"),
        ("height", "m"),
        ("top", "m"),
        ("x_over_length", "-"),
        ("height_over_length", "-"),
        ("top_over_length", "-"),
    ];
    [
        Table::new(
            "run-out",
            "Length of the deposit by three thresholds of the solid fraction on the floor (eq. 5.9), run-out (length - L)/L with the initial length L, farthest centre, largest height.",
            &fronts,
        ),
        Table::new(
            "run-out-profile",
            "Height of the deposit: solid volume per bin over width, bin and packing; and the highest point of a particle in the bin.",
            &profile,
        ),
        Table::new(
            "run-out-floor",
            "Solid fraction of the box that slides along the floor, at its middle.",
            &[("time", "s"), ("x", "m"), ("solid_fraction", "-")],
        ),
    ]
}

#[cfg(test)]
#[path = "run_out_tests.rs"]
mod tests;
