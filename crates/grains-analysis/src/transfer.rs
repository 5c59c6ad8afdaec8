//! `analyse nusselt`, `sherwood`, `effectiveness`: what resolved particles exchange with a scalar of the flow through them.
//!
//! ```text
//! φ_m = Σ ε v u φ/Σ ε v u                      mixed by the flow, of a layer of cells normal to the axis
//! Nu, Sh = q d/(A D (φ_m − φ_s)),   d = 6 V/A  of a particle that gets q, with the value φ_s on its surface, φ_m at its centre
//! η = r/(V k (K φ_m)ⁿ)                         of a particle in which r reacts: film and diffusion inside together
//! ```

use super::layers::FlowFile;
use super::order::Share;
use super::picture::{Curve, Picture};
use super::region::Axis;
use super::report::{Report, Table, seconds};
use super::snapshots::StoredRun;
use super::sums::{exact_sum, exact_sums};
use super::{Common, resolved_fluid};
use grains_case::{Fluid, ParticleTransfer, Scalar, ScalarKind};
use grains_comm::MpiTransport;
use grains_geometry::Shape;
use grains_simulation::RunError;

/// Options of the analyses of what particles exchange.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    /// Axis of the flow.
    #[cfg_attr(feature = "clap", arg(long, default_value = "z"))]
    pub axis: Axis,
    /// Name of the scalar; the first that fits if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub scalar: Option<String>,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// Nusselt number of a temperature.
    Nusselt,
    /// Sherwood number of a concentration.
    Sherwood,
    /// Effectiveness of a catalyst.
    Effectiveness,
}

impl Number {
    /// Name of the analysis.
    fn name(self) -> &'static str {
        match self {
            Self::Nusselt => "nusselt",
            Self::Sherwood => "sherwood",
            Self::Effectiveness => "effectiveness",
        }
    }

    /// Whether a scalar tells of it.
    fn fits(self, scalar: &Scalar) -> bool {
        let is_temperature = matches!(scalar.kind, ScalarKind::Temperature { .. });
        let Some(particles) = &scalar.particles else { return false };
        match self {
            Self::Nusselt => is_temperature && (particles.value.is_some() || particles.uniform),
            Self::Sherwood => !is_temperature && particles.value.is_some(),
            Self::Effectiveness => particles.inside.is_some() && particles.reaction.is_some(),
        }
    }

    /// What a case must state for it.
    fn wants(self) -> &'static str {
        match self {
            Self::Nusselt => "a temperature with particles = { value = ... } or { uniform = true }",
            Self::Sherwood => "a concentration with particles = { value = ... }",
            Self::Effectiveness => "a concentration with particles = { inside = ..., reaction = ... }",
        }
    }
}

/// The scalar that is asked for.
fn chosen<'a>(
    run: &StoredRun,
    fluid: &'a Fluid,
    number: Number,
    options: &Options,
) -> Result<(&'a Scalar, &'a ParticleTransfer), RunError> {
    let is_asked = |scalar: &&Scalar| options.scalar.as_ref().is_none_or(|name| *name == scalar.name);
    let found = fluid.scalar.iter().filter(is_asked).find(|scalar| number.fits(scalar));
    found.and_then(|scalar| Some((scalar, scalar.particles.as_ref()?))).ok_or_else(|| {
        let named = options.scalar.as_ref().map_or(String::new(), |name| format!(" with the name {name:?}"));
        RunError::case(format!(
            "{}: the case has no scalar{named} that `analyse {}` needs: {}",
            run.path.display(),
            number.name(),
            number.wants()
        ))
    })
}

/// A layer of cells: middle (m), φ mixed by the flow, and mean φ of the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mixed {
    middle: f64,
    cup: f64,
    mean: f64,
}

/// The layers normal to an axis, and the same mean over rings about the middle of the box: radius (m), mean.
fn mixed(
    file: &FlowFile,
    (step, scalar, axis): (usize, &str, usize),
    transport: &MpiTransport,
) -> Result<(Vec<Mixed>, Vec<[f64; 2]>), RunError> {
    let nodes = file.nodes();
    let count = nodes[axis].len() - 1;
    let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
    let ends = [b, c].map(|a| [nodes[a][0], nodes[a][nodes[a].len() - 1]]);
    let middle = ends.map(|[low, high]| 0.5 * (low + high));
    let largest = ends.map(|[low, high]| 0.5 * (high - low)).into_iter().fold(f64::INFINITY, f64::min);
    let rings = ((nodes[b].len() - 1).min(nodes[c].len() - 1) / 2).max(1);
    // Per layer Σ ε v u φ, Σ ε v u, Σ ε v φ, Σ ε v; then per ring the last two.
    let mut parts: Vec<(usize, [f64; 4])> = Vec::new();
    let mut of_rings: Vec<(usize, [f64; 2])> = Vec::new();
    file.cells(step, &["velocity", "void_fraction", scalar], transport, |index, at, volume, values| {
        let (u, fluid, value) = (values[0][axis], values[1][0] * volume, values[2][0]);
        let ring = ((at[b] - middle[0]).hypot(at[c] - middle[1]) / largest * rings as f64) as usize;
        let flux = fluid * u;
        match parts.last_mut() {
            Some((slot, sums)) if *slot == index[axis] => {
                for (sum, x) in sums.iter_mut().zip([flux * value, flux, fluid * value, fluid]) {
                    *sum += x;
                }
            }
            _ => parts.push((index[axis], [flux * value, flux, fluid * value, fluid])),
        }
        if ring < rings {
            of_rings.push((ring, [fluid * value, fluid]));
        }
    })?;
    let sums = exact_sums(transport, 4 * count, |add| {
        parts.iter().for_each(|(slot, sums)| (0..4).for_each(|s| add(4 * slot + s, sums[s])));
    });
    let ringed = exact_sums(transport, 2 * rings, |add| {
        of_rings.iter().for_each(|(ring, sums)| (0..2).for_each(|s| add(2 * ring + s, sums[s])));
    });
    let layers = sums.chunks_exact(4).zip(nodes[axis].windows(2)).map(|(sums, ends)| Mixed {
        middle: 0.5 * (ends[0] + ends[1]),
        cup: sums[0] / sums[1],
        mean: sums[2] / sums[3],
    });
    let radius = |ring: usize| (ring as f64 + 0.5) * largest / rings as f64;
    let rings = ringed.chunks_exact(2).enumerate().map(|(ring, sums)| [radius(ring), sums[0] / sums[1]]);
    Ok((layers.collect(), rings.collect()))
}

/// The mixed value at a coordinate (m), between the middles of layers.
fn at(layers: &[Mixed], coordinate: f64) -> f64 {
    let above = layers.partition_point(|layer| layer.middle < coordinate).clamp(1, layers.len().max(2) - 1);
    let [Some(p), Some(q)] = [above - 1, above].map(|k| layers.get(k)) else { return f64::NAN };
    let share = ((coordinate - p.middle) / (q.middle - p.middle)).clamp(0.0, 1.0);
    p.cup + share * (q.cup - p.cup)
}

/// Nusselt or Sherwood numbers, or effectiveness, of all particles at the chosen states, and the profiles of the scalar.
///
/// # Errors
/// A run without what is needed, or files that cannot be read.
pub fn analyse(
    run: &StoredRun,
    states: &[usize],
    (number, options): (Number, &Options),
    transport: &MpiTransport,
) -> Result<Report, RunError> {
    let what = number.name();
    let fluid = resolved_fluid(run, what)?;
    let (scalar, particles) = chosen(run, fluid, number, options)?;
    let file = FlowFile::open(run, what, transport)?;
    let axis = options.axis as usize;
    let axis_name = ["x", "y", "z"][axis];
    let shapes = &run.catalogue.shapes;
    let areas: Vec<f64> = shapes.iter().map(Shape::area).collect();
    let mut beds = Table::new(
        what,
        "Means over all particles with the standard error of the mean and the spread; scalar mixed by the flow at both ends of the domain.",
        &[
            ("time", "s"),
            ("particles", "-"),
            ("mean", "-"),
            ("error", "-"),
            ("spread", "-"),
            ("sum", "SI"),
            ("first", "SI"),
            ("last", "SI"),
        ],
    );
    let mut each = Table::new(
        &format!("{what}-particles"),
        "Particles, of many one in so many: coordinate along the axis, what they get or what reacts in them, the scalar mixed by the flow there, the number.",
        &[("time", "s"), ("id", "-"), ("position", "m"), ("rate", "SI"), ("mixed", "SI"), ("number", "-")],
    );
    let mut axial = Table::new(
        &format!("{what}-axial"),
        "Layers of cells along the axis: the scalar mixed by the flow, and its mean in the fluid.",
        &[("time", "s"), ("position", "m"), ("mixed", "SI"), ("mean", "SI")],
    );
    let mut radial = Table::new(
        &format!("{what}-radial"),
        "Rings about the axis through the middle of the domain: mean of the scalar in the fluid.",
        &[("time", "s"), ("radius", "m"), ("mean", "SI")],
    );
    let mut report = Report::default();
    let (mut of_layers, mut of_particles) = (Vec::new(), Vec::new());
    for &state in states {
        let snapshot = run.read(transport, state, &[], what)?;
        let (step, time) = file.nearest(snapshot.time);
        let (layers, rings) = mixed(&file, (step, &scalar.name, axis), transport)?;
        let rate = match number {
            Number::Effectiveness => format!("{}_reaction", scalar.name),
            _ => format!("{}_flow", scalar.name),
        };
        let rates = run.real(state, &rate, what)?;
        let on_surfaces = match particles.uniform {
            true => run.real(state, "temperature", what)?,
            false => Vec::new(),
        };
        let given = particles.value.as_ref().and_then(|value| value.compile().ok());
        let conducts = scalar.diffusivity(fluid.density) * scalar.capacity(fluid.density);
        let mut own: Vec<[f64; 5]> = Vec::new();
        for i in 0..snapshot.len() {
            let place = snapshot.position[i];
            let volume = snapshot.volume(i, shapes);
            let area = areas[snapshot.shape[i]] * snapshot.scale[i].powi(2);
            let mixed = at(&layers, place[axis]);
            let found = match (number, &particles.reaction, &particles.inside) {
                (Number::Effectiveness, Some(reaction), Some(inside)) => {
                    let inside = inside.partition.unwrap_or(1.0) * mixed;
                    rates[i] / (volume * reaction.rate * inside.powf(reaction.order))
                }
                _ => {
                    let surface =
                        given.as_ref().map_or_else(|| on_surfaces[i], |value| value.at(place.into(), time));
                    rates[i] * (6.0 * volume / area) / (area * conducts * (mixed - surface))
                }
            };
            own.push([snapshot.id[i] as f64, place[axis], rates[i], mixed, found]);
        }
        let share = Share::of(&own, transport);
        let count = share.all as f64;
        let sum = |f: &dyn Fn(&[f64; 5]) -> f64| exact_sum(transport, own.iter().map(f));
        let mean = sum(&|row| row[4]) / count;
        let spread = (sum(&|row| (row[4] - mean).powi(2)) / (count - 1.0).max(1.0)).sqrt();
        let error = spread / count.sqrt();
        let total = sum(&|row| row[2]);
        let ends = [layers.first(), layers.last()].map(|layer| layer.map_or(f64::NAN, |layer| layer.cup));
        report.lines.push(format!(
            "t = {}: {what} of {} {:.5} +- {:.2e} (spread {:.3}) over {} particles, {rate} {total:.5e} in all; mixed by the flow {:.6} to {:.6}",
            seconds(time), scalar.name, mean, error, spread, share.all, ends[0], ends[1]
        ));
        beds.push(vec![time, count, mean, error, spread, total, ends[0], ends[1]]);
        of_layers
            .push(Curve::line(seconds(time), layers.iter().map(|layer| [layer.middle, layer.cup]).collect()));
        let rows = share.thinned(transport);
        of_particles.push(Curve::line(seconds(time), {
            let mut points: Vec<[f64; 2]> = rows.iter().map(|row| [row[1], row[4]]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            points
        }));
        rows.iter().for_each(|[id, place, rate, mixed, found]| {
            each.push(vec![time, *id, *place, *rate, *mixed, *found])
        });
        layers.iter().for_each(|layer| axial.push(vec![time, layer.middle, layer.cup, layer.mean]));
        rings.iter().for_each(|[radius, mean]| radial.push(vec![time, *radius, *mean]));
    }
    let along = format!("{axis_name} (m)");
    let unit = scalar.units()[0];
    report.pictures.push(Picture::few(
        &format!("{what}-mixed"),
        format!("{} mixed by the flow", scalar.name),
        [&along, &format!("{} ({unit})", scalar.name)],
        of_layers,
    ));
    report.pictures.push(Picture::few(
        &format!("{what}-of-particles"),
        format!("{what} of each particle"),
        [&along, &format!("{what} (-)")],
        of_particles,
    ));
    report.tables.extend([beds, each, axial, radial]);
    Ok(report)
}
