//! `analyse bed`: the flow through a fixed bed along an axis (Rakotonirina 2016, 7.5; errata R16-48, R16-49, R16-51).
//!
//! ```text
//! α = (Δp/H) ε³ d_p² / ((1 − ε)² μ u),   d_p = 6 V/A      (7.20, 7.24; no inertial term removed)
//! ```
//!
//! ε and Δp/H are those of one control volume, the bed less what is cropped; its section is that of the domain, or of the box or tube
//! that bounds the fluid. By continuity the superficial velocity u is the same in all layers; layers beyond the bed, where there are,
//! give it without the error of cells that bodies cut (of ⟨ε u⟩ in a bed of spheres at ε = 0.384: +9 % on 16 cells across each,
//! +4 % on 24).

use super::layers::{FlowFile, Layer, between};
use super::picture::{Curve, Picture};
use super::region::{Axis, Crop, Region, container};
use super::report::{Report, Table, seconds};
use super::snapshots::{Snapshot, StoredRun};
use super::sums::exact_sums;
use super::{Common, resolved_fluid};
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::{Shape, Vec3};
use grains_simulation::RunError;
use std::f64::consts::PI;

/// Options of `analyse bed`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Part of the bed that counts.
    pub volume: ControlVolume,
}

/// Which part of a bed counts.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct ControlVolume {
    /// Axis of the flow; that of the mean superficial velocity if absent.
    #[cfg_attr(feature = "clap", arg(long))]
    pub axis: Option<Axis>,
    /// What to leave out at the lower and upper end of the bed along the axis: layers of the diameter of the sphere of the mean
    /// volume (2), a part (10%) or a length (0.005m), or one for either with a comma between.
    #[cfg_attr(feature = "clap", arg(long, default_value = "2,3"))]
    pub crop: Crop,
}

/// The flow through a bed.
#[derive(Clone, Debug)]
pub struct Bed {
    /// Time (s).
    pub time: f64,
    /// Axis of the flow: 0, 1 or 2.
    pub axis: usize,
    /// Ends of the control volume along it (m).
    pub ends: [f64; 2],
    /// Void fraction ε of the control volume (-).
    pub void_fraction: f64,
    /// Fall of the pressure along the flow Δp/H in the control volume (Pa/m).
    pub pressure_gradient: f64,
    /// Superficial velocity u (m/s).
    pub superficial_velocity: f64,
    /// Tortuosity T = ⟨|u|⟩/⟨u_z⟩ of the fluid in the control volume (-)   (7.32).
    pub tortuosity: f64,
    /// Diameter d_p = 6 ΣV/ΣA of the particles (m)   (7.24).
    pub diameter: f64,
    /// Sphericity Ψ = (36 π V²/A³)^(1/3) of their mean volume and area (-)   (7.25).
    pub sphericity: f64,
    /// Reynolds number ρ u d_p/μ (-).
    pub reynolds: f64,
    /// Coefficient α of Blake, Kozeny and Carman (-).
    pub alpha: f64,
    /// Sums over the layers of cells along the axis.
    pub layers: Vec<Layer>,
}

impl Bed {
    /// Reynolds number Re' = ρ u d_p/((1 − ε) μ) of Ergun's equation (-).
    pub fn ergun_reynolds(&self) -> f64 {
        self.reynolds / (1.0 - self.void_fraction)
    }
}

/// Diameter 6 ΣV/ΣA (m) and sphericity (-) of particles of every rank; `areas` are those of the shapes (m²).
fn size_and_sphericity(
    snapshot: &Snapshot,
    (shapes, areas): (&[Shape], &[f64]),
    transport: &impl Transport,
) -> [f64; 2] {
    let sums = exact_sums(transport, 3, |add| {
        for i in 0..snapshot.len() {
            add(0, 1.0);
            add(1, snapshot.volume(i, shapes));
            add(2, areas[snapshot.shape[i]] * snapshot.scale[i].powi(2));
        }
    });
    let [number, volume, area] = [sums[0], sums[1], sums[2]];
    let sphericity = (36.0 * PI * (volume / number).powi(2)).cbrt() / (area / number);
    [6.0 * volume / area, sphericity]
}

/// Mean pressure of the fluid (Pa) at a coordinate along the axis (m), on the straight line through the middles of two layers
/// with fluid; NaN with fewer.
fn pressure_at(layers: &[Layer], at: f64) -> f64 {
    let wet: Vec<&Layer> = layers.iter().filter(|layer| layer.fluid > 0.0).collect();
    let above = wet.partition_point(|layer| layer.middle() < at).clamp(1, wet.len().max(2) - 1);
    let [Some(p), Some(q)] = [above - 1, above].map(|k| wet.get(k)) else { return f64::NAN };
    let share = (at - p.middle()) / (q.middle() - p.middle());
    p.mean_pressure() + share * (q.mean_pressure() - p.mean_pressure())
}

const AT_REST: &str =
    "the fluid is at rest along the axis: give a state with flow by --time, or another --axis";

/// Superficial velocity along an axis (m/s): that of the layers beyond the ends of the bed (m), else that of the control volume.
fn superficial_velocity(layers: &[Layer], whole: &Layer, ends: [f64; 2], axis: usize) -> f64 {
    let mut free = Layer::default();
    let is_free = |layer: &&Layer| layer.ends[1] <= ends[0] || layer.ends[0] >= ends[1];
    layers.iter().filter(is_free).for_each(|layer| free += *layer);
    let of = if free.volume > 0.0 { free } else { *whole };
    of.flux[axis] / of.volume
}

/// What bounds the fluid across an axis at a time (s): the domain, or the box or tube in it.
fn vessel(case: &Case, time: f64, axis: usize) -> Region {
    let mut case = case.clone();
    case.walls.retain(|wall| wall.fluid.is_some());
    container(&case, time, axis)
}

/// The axis of a mean flux, none for a fluid at rest.
fn main_axis(flux: &Vec3) -> Option<usize> {
    (flux.amax() > 0.0).then(|| flux.iamax())
}

/// The flow of a state through a bed; `layers` gives the sums of its layers normal to an axis, `areas` are those of the
/// shapes (m²).
///
/// # Errors
/// A fluid at rest, a periodic axis, or a bed that is all cropped.
pub fn measure(
    case: &Case,
    (snapshot, shapes, areas): (&Snapshot, &[Shape], &[f64]),
    options: &ControlVolume,
    layers: impl Fn(usize) -> Result<Vec<Layer>, RunError>,
    transport: &impl Transport,
) -> Result<Bed, RunError> {
    let mut sums = layers(options.axis.map_or(2, |axis| axis as usize))?;
    let (lower, upper) = (Vec3::from(case.domain.lower), Vec3::from(case.domain.upper));
    let axis = match options.axis {
        Some(axis) => axis as usize,
        None => main_axis(&between(&sums, [lower.z, upper.z]).flux).ok_or_else(|| RunError::case(AT_REST))?,
    };
    if case.domain.periodic[axis] {
        return Err(RunError::case(format!(
            "--axis: the domain is periodic along {}, where the stored pressure lacks the gradient that drives the flow: take `analyse friction`, or another --axis",
            ["x", "y", "z"][axis]
        )));
    }
    if options.axis.is_none() && axis != 2 {
        sums = layers(axis)?;
    }
    if snapshot.total(transport) == 0 {
        return Err(RunError::case("there are no particles: give a run with a bed"));
    }
    let vessel = vessel(case, snapshot.time, axis);
    let domain = Region { lower, upper, axis, cylinder: None };
    // Layers are of the whole domain: what is beyond the vessel is no part of its section.
    sums.iter_mut().for_each(|layer| layer.volume *= vessel.cross_section() / domain.cross_section());
    let uncropped = vessel.cropped(snapshot, shapes, Crop::NOTHING, transport)?;
    let region = vessel.cropped(snapshot, shapes, options.crop, transport)?;
    let [of_bed, ends] = [uncropped, region].map(|region| [region.lower[axis], region.upper[axis]]);
    let whole = between(&sums, ends);
    let velocity = superficial_velocity(&sums, &whole, of_bed, axis);
    if velocity == 0.0 || velocity.is_nan() {
        return Err(RunError::case(AT_REST));
    }
    let [diameter, sphericity] = size_and_sphericity(snapshot, (shapes, areas), transport);
    let drop = (pressure_at(&sums, ends[0]) - pressure_at(&sums, ends[1])) * velocity.signum();
    let (void, gradient, speed) = (whole.void_fraction(), drop / region.height(), velocity.abs());
    let (density, viscosity) = case.fluid.as_ref().map_or((f64::NAN, f64::NAN), |f| (f.density, f.viscosity));
    Ok(Bed {
        time: snapshot.time,
        axis,
        ends,
        void_fraction: void,
        pressure_gradient: gradient,
        superficial_velocity: speed,
        tortuosity: whole.speed / whole.flux[axis].abs(),
        diameter,
        sphericity,
        reynolds: density * speed * diameter / viscosity,
        alpha: gradient * void.powi(3) * diameter.powi(2) / ((1.0 - void).powi(2) * viscosity * speed),
        layers: sums,
    })
}

/// The flow through the bed of a run at some of its stored states; `what` is the analysis that wants it.
///
/// # Errors
/// A run of another kind, options that do not fit, or a file that cannot be read.
pub fn of_run(
    run: &StoredRun,
    states: &[usize],
    options: &ControlVolume,
    (what, transport): (&str, &MpiTransport),
) -> Result<Vec<Bed>, RunError> {
    resolved_fluid(run, what)?;
    let file = FlowFile::open(run, what, transport)?;
    let shapes = &run.catalogue.shapes;
    let areas: Vec<f64> = shapes.iter().map(Shape::area).collect();
    let bed = |&state: &usize| {
        let mut snapshot = run.read(transport, state, &[], what)?;
        let (step, time) = file.nearest(snapshot.time);
        snapshot.time = time;
        let layers = |axis: usize| file.layers(step, axis, transport);
        measure(&run.case, (&snapshot, shapes, &areas), options, layers, transport)
            .map_err(|error| error.of(&run.path))
    };
    states.iter().map(bed).collect()
}

/// Columns of the numbers of a bed.
pub const COLUMNS: [(&str, &str); 13] = [
    ("time", "s"),
    ("void_fraction", "-"),
    ("pressure_gradient", "Pa/m"),
    ("superficial_velocity", "m/s"),
    ("diameter", "m"),
    ("sphericity", "-"),
    ("reynolds", "-"),
    ("ergun_reynolds", "-"),
    ("alpha", "-"),
    ("tortuosity", "-"),
    ("axis", "-"),
    ("from", "m"),
    ("to", "m"),
];

impl Bed {
    /// Values of [`COLUMNS`].
    pub fn row(&self) -> Vec<f64> {
        let size = [self.diameter, self.sphericity, self.reynolds, self.ergun_reynolds()];
        let flow = [self.time, self.void_fraction, self.pressure_gradient, self.superficial_velocity];
        let rest = [self.alpha, self.tortuosity, self.axis as f64, self.ends[0], self.ends[1]];
        [&flow[..], &size, &rest].concat()
    }
}

/// The flow through a bed at the chosen states.
///
/// # Errors
/// A run of another kind, options that do not fit, or a file that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    options: &Options,
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let mut table = Table::new(
        "bed",
        "Flow through the control volume between two coordinates along the axis (0, 1, 2 for x, y, z); diameter 6 V/A, Reynolds numbers rho u d/mu and that over 1 - void fraction, alpha = (dp/H) eps^3 d^2/((1 - eps)^2 mu u).",
        &COLUMNS,
    );
    let mut axial = Table::new(
        "bed-axial",
        "Layers of cells along the axis, at their middles: void fraction, mean pressure of the fluid, mean of the velocity along the axis times the void fraction.",
        &[
            ("time", "s"),
            ("position", "m"),
            ("void_fraction", "-"),
            ("pressure", "Pa"),
            ("superficial_velocity", "m/s"),
        ],
    );
    let mut report = Report::default();
    let mut curves = [const { Vec::new() }; 3];
    let mut name = "z";
    for bed in of_run(run, states, &options.volume, ("bed", transport))? {
        name = ["x", "y", "z"][bed.axis];
        report.lines.push(format!(
            "t = {}: void fraction {:.5}, dp/H = {:.5e} Pa/m, u = {:.5e} m/s, d = 6V/A = {:.5e} m, sphericity {:.4}, Re = {:.3e}: alpha = {:.2}, tortuosity {:.4}; {name} from {:.6} to {:.6} m",
            seconds(bed.time),
            bed.void_fraction,
            bed.pressure_gradient,
            bed.superficial_velocity,
            bed.diameter,
            bed.sphericity,
            bed.reynolds,
            bed.alpha,
            bed.tortuosity,
            bed.ends[0],
            bed.ends[1]
        ));
        table.push(bed.row());
        let first = axial.rows.len();
        for layer in &bed.layers {
            let flow = [layer.void_fraction(), layer.mean_pressure(), layer.flux[bed.axis] / layer.volume];
            axial.push([&[bed.time, layer.middle()], &flow[..]].concat());
        }
        for (k, curves) in curves.iter_mut().enumerate() {
            let points = axial.rows[first..].iter().map(|row| [row[1], row[2 + k]]).collect();
            curves.push(Curve::line(seconds(bed.time), points));
        }
    }
    let along = format!("{name} (m)");
    let what = [
        ("bed-void-fraction", "Void fraction", "void fraction (-)"),
        ("bed-pressure", "Pressure of the fluid", "p (Pa)"),
        ("bed-velocity", "Superficial velocity", "u (m/s)"),
    ];
    for ((file, title, unit), curves) in what.into_iter().zip(curves) {
        let title = format!("{title} along {name}");
        report.pictures.push(Picture::few(file, title, [&along, unit], curves));
    }
    report.tables.extend([table, axial]);
    Ok(report)
}

#[cfg(test)]
#[path = "bed_tests.rs"]
mod tests;
