//! What `check` says of the fluid: cells, memory, steps, and how particles settle and fluidise in it.

pub mod imposed;
mod kinds;
mod resolved;

use super::longest_step::{LongestStep, longest_step};
use crate::cost;
use crate::population::Population;
use crate::timestep;
use grains_case::{Case, Coupling, Fluid, FluidField, Kernel, MixtureModel, PressureMethod, TimeStep};
use grains_dem::Catalogue;
use imposed::fastest;
use kinds::{Settling, kinds};

/// Void fraction of a settled bed, at which beds are judged.
const SETTLED: f64 = 0.4;

/// Bytes per cell of the halos and the grid, and per cell of the grid alone, as processes were seen to take them: of the
/// fields of one phase and a direct solution of the pressure, of what particles add, means over time, PETSc's matrices
/// and vectors, conjugate gradients, resolved bodies.
const BYTES: [[f64; 2]; 6] =
    [[105.0, 97.0], [240.0, 285.0], [60.0, 0.0], [0.0, 360.0], [0.0, 87.0], [60.0, 187.0]];

/// Lines of `check` on the fluid and the particles to be inserted; none without a fluid.
///
/// # Errors
/// Shapes without a surface, or a time step that cannot be used.
pub fn explain(case: &Case, catalogue: &Catalogue, population: &Population) -> Result<Vec<String>, String> {
    let Some(fluid) = &case.fluid else { return Ok(Vec::new()) };
    let mut lines = vec![cells(case, fluid), memory(case)];
    let longest = longest_step(case, fluid);
    if let Some(given) = fluid.resolved.as_ref().filter(|_| !case.inserts.is_empty()) {
        lines.extend(resolved::lines(case, catalogue, fluid, given, population.kinds()));
        lines.push(step_limit(case, fluid, &longest, 1.0).1);
        return Ok(lines);
    }
    let Some(coupling) = fluid.coupling.as_ref().filter(|_| !case.inserts.is_empty()) else {
        lines.push(match case.time.dt {
            TimeStep::Seconds(dt) => {
                format!("fluid step     {dt:.4e} s (time.dt), {}", courant(case, fluid, dt))
            }
            TimeStep::Auto => step_limit(case, fluid, &longest, 1.0).1,
        });
        return Ok(lines);
    };
    lines.push(format!("coupling       {}", describe(coupling)));
    let kinds = kinds(case, catalogue, fluid, coupling.drag, population.kinds())?;
    lines.extend(kinds.iter().flat_map(Settling::lines));
    lines.extend(pressure_drop(case, catalogue, fluid, population));
    let (limit, line) = step_limit(case, fluid, &longest, SETTLED);
    lines.push(line);
    let (step, why) = match coupling.particle_steps {
        Some(count) => {
            let dt = timestep::choose(case, catalogue, population.kinds())?.dt * count as f64;
            (dt.min(limit), format!("{count} particle steps, {:.2} of the limit", dt / limit))
        }
        None => (limit, "the longest".into()),
    };
    let shortest = kinds.iter().map(|k| k.shortest_relaxation()).fold(f64::INFINITY, f64::min);
    lines.push(format!(
        "  relaxation   fluid step {step:.3e} s ({why}) over the shortest relaxation time {shortest:.3e} s: {:.3}; \
         stable at any, exact in time below about 1",
        step / shortest
    ));
    Ok(lines)
}

/// Seconds that the steps of the fluid take at least, on one core; none where particles smaller than its cells decide.
pub fn least_seconds(case: &Case) -> Option<f64> {
    /// Seconds per cell and step of a fluid alone, and of one with a fifth of it resolved bodies.
    const COST: [f64; 2] = [1.0e-7, 2.0e-7];
    let fluid = case.fluid.as_ref().filter(|fluid| fluid.coupling.is_none())?;
    let resolved = fluid.resolved.as_ref().filter(|_| !case.inserts.is_empty());
    let widths = (0..3).filter(|&a| fluid.cells[a] > 1).map(|a| fluid.cell_widths(&case.domain, a)[0]);
    let narrowest = widths.fold(f64::INFINITY, f64::min);
    let by_speed = match resolved.filter(|_| !case.holds_particles()) {
        Some(_) => fluid.courant * narrowest / case.time.impact_speed,
        None => fluid.courant / fastest(case, fluid).rate,
    };
    let step = match case.time.dt {
        TimeStep::Seconds(dt) if resolved.is_none() || case.holds_particles() => dt,
        _ => longest_step(case, fluid).step.min(by_speed),
    };
    let cells = fluid.cells.iter().product::<u64>() as f64;
    Some(case.time.end / step * cells * COST[usize::from(resolved.is_some())])
}

/// Bytes of the snapshots of the fluid, of their means, and of its state in the checkpoints that are kept; uncompressed.
pub fn bytes_on_disk(case: &Case) -> f64 {
    /// Numbers per cell of a checkpoint: velocities and explicit terms on faces, pressure, correction, void fraction.
    const STATE: f64 = 9.0;
    /// Those of resolved bodies: their force, and the velocities that continue the flow inside, on the faces.
    const BODIES: f64 = 6.0;
    let Some(fluid) = &case.fluid else { return 0.0 };
    let cells = fluid.cells.iter().product::<u64>() as f64;
    let has_particles = (fluid.coupling.is_some() || fluid.resolved.is_some()) && !case.inserts.is_empty();
    let state = STATE + if fluid.resolved.is_some() { BODIES } else { 0.0 };
    let components = |field: &FluidField| match (field, has_particles) {
        (FluidField::Velocity, _) | (FluidField::SolidVelocity, true) => 3.0,
        (FluidField::Pressure, _) | (FluidField::VoidFraction, true) => 1.0,
        (FluidField::SolidVelocity | FluidField::VoidFraction, false) => 0.0,
    };
    let numbers: f64 = fluid.output.fields.iter().map(components).sum();
    let interval = fluid.output.interval.unwrap_or(case.output.particles);
    let share = fluid.output.mean_from.map_or(0.0, |from| (1.0 - from / case.time.end).max(0.0));
    let snapshots = cost::times(case, interval) * (1.0 + share);
    // The sums of the means are part of the state.
    let state = state + if fluid.output.mean_from.is_some() { components_of_all(has_particles) } else { 0.0 };
    let kept = cost::times(case, case.output.checkpoint).max(1.0).min(case.output.keep_checkpoints as f64);
    cells * (snapshots * numbers * cost::bytes_per_real(case) + kept * state * 8.0)
}

/// Numbers per cell of all fields.
fn components_of_all(has_particles: bool) -> f64 {
    if has_particles { 8.0 } else { 4.0 }
}

fn describe(coupling: &Coupling) -> String {
    let model = match coupling.model {
        MixtureModel::A => "model A, both phases carry the pressure gradient",
        MixtureModel::B => "model B, the fluid alone carries the pressure gradient",
    };
    let kernel = match coupling.kernel {
        Kernel::Cube => "embedded cubes".into(),
        Kernel::Smooth { half_width } => format!("a smooth kernel of half width {half_width:.3} diameters"),
    };
    format!("drag by {:?}; {model}; {kernel}", coupling.drag)
}

fn cells(case: &Case, fluid: &Fluid) -> String {
    let [nx, ny, nz] = fluid.cells;
    let edge = |a: usize| match fluid.cell_widths(&case.domain, a) {
        [narrow, wide] if wide - narrow > 1e-9 * wide => format!("{narrow:.4e} to {wide:.4e}"),
        [_, wide] => format!("{wide:.4e}"),
    };
    format!(
        "fluid          {nx} x {ny} x {nz} = {} cells of {} x {} x {} m",
        nx * ny * nz,
        edge(0),
        edge(1),
        edge(2)
    )
}

/// Memory of the fluid on all ranks (bytes), each with the halo of its share of the cells.
pub fn bytes_in_memory(case: &Case, ranks: usize) -> f64 {
    let Some(fluid) = &case.fluid else { return 0.0 };
    let halo = 2.0 * super::plain_halo(fluid) as f64;
    // Shares are taken for cubes, whose halo is the least.
    let cut = (ranks as f64).cbrt();
    let [stored, cells] =
        [cut * halo, 0.0].map(|more| fluid.cells.iter().map(|&n| n as f64 + more).product::<f64>());
    let has_particles = fluid.coupling.is_some() && !case.inserts.is_empty();
    let method = fluid.pressure.method;
    let taken = [
        true,
        has_particles,
        fluid.output.mean_from.is_some(),
        method == PressureMethod::Petsc,
        method == PressureMethod::ConjugateGradients && !has_particles,
        fluid.resolved.is_some(),
    ];
    let bytes = BYTES.iter().zip(taken).filter(|(_, taken)| *taken);
    bytes.map(|([of_stored, of_cell], _)| stored * of_stored + cells * of_cell).sum()
}

fn memory(case: &Case) -> String {
    let bytes = bytes_in_memory(case, 1);
    format!(
        "  memory       about {:.0} MB of it for the fluid, halos of one rank included",
        (bytes / 1e6).ceil()
    )
}

/// The longest step of the fluid (s), and the line about it; between particles at a void fraction the same flow is faster.
fn step_limit(case: &Case, fluid: &Fluid, longest: &LongestStep, void_fraction: f64) -> (f64, String) {
    let fastest = fastest(case, fluid);
    let at_inlet = fluid.courant / fastest.rate;
    let between = void_fraction * at_inlet;
    if between > longest.step || at_inlet.is_infinite() {
        return (longest.step, format!("fluid step     at most {:.3e} s ({})", longest.step, longest.reason));
    }
    let settled = match void_fraction < 1.0 {
        true => format!(", {between:.3e} s between particles at void fraction {void_fraction}"),
        false => String::new(),
    };
    let line = if at_inlet > longest.step {
        format!("fluid step     at most {:.3e} s ({}){settled}", longest.step, longest.reason)
    } else {
        format!(
            "fluid step     at most {at_inlet:.3e} s at the {:.4} m/s imposed (fluid.courant = {}){settled}",
            fastest.speed, fluid.courant
        )
    };
    (between, line)
}

/// What a step (s) comes to at the velocity imposed.
fn courant(case: &Case, fluid: &Fluid, dt: f64) -> String {
    let fastest = fastest(case, fluid);
    format!("Courant number {:.3} at the {:.4} m/s imposed", fastest.rate * dt, fastest.speed)
}

/// The pressure drop that carries all particles, where gravity lies along an axis.
fn pressure_drop(
    case: &Case,
    catalogue: &Catalogue,
    fluid: &Fluid,
    population: &Population,
) -> Option<String> {
    let axes: Vec<usize> = (0..3).filter(|a| case.gravity[*a] != 0.0).collect();
    let &[axis] = &axes[..] else { return None };
    // The mass of particles of the difference in density is what the fluid does not carry by itself.
    let mut buoyant = catalogue.clone();
    buoyant.densities.iter_mut().for_each(|density| *density -= fluid.density);
    let weight = population.mass(case, &buoyant) * case.gravity[axis].abs();
    let extents = case.domain.extents();
    let section: f64 = (0..3).filter(|a| *a != axis).map(|a| extents[a]).product();
    Some(format!(
        "  fluidised    pressure drop {:.4e} Pa: buoyant weight of all particles {weight:.4e} N over {section:.4e} m2",
        weight / section
    ))
}

#[cfg(test)]
mod tests;
