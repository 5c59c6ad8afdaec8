//! What `check` finds of the fluid: cells, memory, steps, and how particles settle and fluidise in it.

mod kinds;
mod resolved;

use super::enclosure::PlacedWalls;
use super::imposed::fastest;
use super::max_dt::{FluidStepLimit, max_dt};
use super::setup::{self, narrowest};
use super::walls::FluidWalls;
pub use super::walls::WallsReport;
use crate::cost;
use crate::insertion::Insertions;
use crate::timestep;
use grains_case::{Case, Coupling, Fluid, FluidField, PressureMethod, TimeStep};
use grains_dem::{Catalogue, Kind};
use grains_domain::Transport;
pub use kinds::{ParticlesInFluid, SettlingMotion};
use kinds::{SETTLED, kinds};
pub use resolved::{LubricationRange, ResolvedReport, TooCoarse};

/// Bytes per cell of the halos and the grid, and per cell of the grid alone, as processes were seen to take them: of the
/// fields of one phase and a direct solution of the pressure, of what particles add, means over time, PETSc's matrices
/// and vectors, conjugate gradients, resolved bodies, viscosities that vary, rates of strain,
/// walls in a flow averaged over particles, and what scalars share.
const BYTES: [[f64; 2]; 10] = [
    [129.0, 47.0],
    [240.0, 285.0],
    [24.0, 0.0],
    [0.0, 360.0],
    [0.0, 78.0],
    [36.0, 9.0],
    [28.0, 0.0],
    [42.0, 0.0],
    [477.0, 0.0],
    [168.0, 0.0],
];

/// Bytes per cell of the halos and the grid of each scalar.
const BYTES_OF_SCALAR: f64 = 16.0;

/// Bytes of each scalar about resolved particles: per cell, and per square of a cell's width on their surfaces.
const BYTES_AT_SURFACES: [f64; 2] = [26.0, 800.0];

/// Bytes per cell and step that a search for a steady flow combines, and what it does without: the terms of the last step, and the
/// room for files, which are written when the steps are freed.
const BYTES_OF_STEADY: [f64; 2] = [34.0, 48.0];

/// The fluid of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidReport {
    /// Cells along each axis.
    pub cells: [u64; 3],
    /// Widths of the narrowest and the widest cells along each axis (m).
    pub widths: [[f64; 2]; 3],
    /// Memory on one rank, halos included (bytes).
    pub memory: f64,
    /// Its time step.
    pub step: FluidStep,
    /// Particles smaller than the cells, if there are any.
    pub coupling: Option<CouplingReport>,
    /// Particles that the grid resolves, if there are any.
    pub resolved: Option<ResolvedReport>,
    /// What walls make of the cells, if some bound the fluid.
    pub walls: Option<WallsReport>,
    /// Rate of shear of the flow (1/s), and the dynamic viscosity there (Pa s), of a fluid whose viscosity depends on it.
    pub sheared: Option<[f64; 2]>,
    /// Minimum time of its steps on one core (s); none where particles smaller than its cells decide.
    pub min_seconds: Option<f64>,
}

/// The time step of a fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FluidStep {
    /// That of the case, of a fluid alone.
    Given {
        /// Step (s).
        step: f64,
        /// CFL number at the velocity imposed (-).
        cfl: f64,
        /// Largest speed imposed (m/s).
        speed: f64,
    },
    /// As many particle steps, or ticks, as its limits allow.
    Limited {
        /// Longest step (s).
        max: f64,
        /// What limits it.
        limit: FluidStepLimit,
        /// Longest step between the particles of a settled bed, where the same flow is faster (s).
        max_in_bed: Option<f64>,
    },
}

impl FluidStep {
    /// Longest step that particles allow as well (s).
    fn longest(&self) -> f64 {
        match *self {
            Self::Given { step, .. } => step,
            Self::Limited { max, max_in_bed, .. } => max_in_bed.unwrap_or(max),
        }
    }
}

/// Particles smaller than the cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplingReport {
    /// Void fraction of a settled bed, at which it is judged (-).
    pub void_fraction: f64,
    /// The smallest and the largest particles of each kind.
    pub kinds: Vec<ParticlesInFluid>,
    /// The pressure drop that carries all particles, where gravity lies along an axis.
    pub pressure_drop: Option<PressureDrop>,
    /// Step of the fluid (s).
    pub step: f64,
    /// Particle steps in it, if the case gives them, and their share of the longest step (-).
    pub particle_steps: Option<(u64, f64)>,
    /// Shortest relaxation time of the particles (s).
    pub shortest_relaxation: f64,
}

/// The pressure drop that carries all particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureDrop {
    /// Pressure drop (Pa).
    pub pressure: f64,
    /// Weight of all particles less their buoyancy (N).
    pub weight: f64,
    /// Largest cross-section that the walls of the fluid leave open of the domain (m²).
    pub section: f64,
}

/// The fluid of a case and the particles to be inserted; none without a fluid; collective.
///
/// # Errors
/// Shapes without a surface, or a time step that cannot be used.
pub fn report(
    case: &Case,
    catalogue: &Catalogue,
    insertions: &Insertions,
    transport: &impl Transport,
) -> Result<Option<FluidReport>, String> {
    let Some(fluid) = &case.fluid else { return Ok(None) };
    let has_particles = !case.inserts.is_empty();
    let resolved = fluid.resolved.as_ref().filter(|_| has_particles);
    let coupling = fluid.coupling.as_ref().filter(|_| has_particles && resolved.is_none());
    let step = match (case.time.dt, resolved.is_none() && coupling.is_none()) {
        (TimeStep::Seconds(step), true) => {
            let fastest = fastest(case, fluid);
            FluidStep::Given { step, cfl: fastest.rate * step, speed: fastest.speed }
        }
        _ => limited_step(case, fluid, coupling.map_or(1.0, |_| SETTLED)),
    };
    let coupling =
        coupling.map(|given| coupled(case, catalogue, (fluid, given), insertions, &step, transport));
    Ok(Some(FluidReport {
        cells: fluid.cells,
        widths: [0, 1, 2].map(|a| fluid.cell_widths(&case.domain, a)),
        memory: bytes_in_memory(case, 1) + bytes_at_surfaces(case, catalogue, insertions, transport),
        step,
        coupling: coupling.transpose()?,
        resolved: resolved.map(|given| resolved::report(case, catalogue, fluid, given, insertions.kinds())),
        walls: FluidWalls::new(case)?.report(&setup::grid(case, fluid)?),
        sheared: fluid
            .rheology
            .map(|_| [setup::shear_rate(case, fluid), setup::viscosity_of_flow(case, fluid)]),
        min_seconds: min_seconds(case),
    }))
}

/// Particles smaller than the cells of a fluid, with its step.
fn coupled(
    case: &Case,
    catalogue: &Catalogue,
    (fluid, coupling): (&Fluid, &Coupling),
    insertions: &Insertions,
    step: &FluidStep,
    transport: &impl Transport,
) -> Result<CouplingReport, String> {
    let kinds = kinds(case, catalogue, fluid, coupling.drag, insertions.kinds())?;
    let longest = step.longest();
    let (step, particle_steps) = match coupling.particle_steps {
        Some(count) => {
            let dt = timestep::choose(case, catalogue, insertions.kinds())?.dt * count as f64;
            (dt.min(longest), Some((count, dt / longest)))
        }
        None => (longest, None),
    };
    Ok(CouplingReport {
        void_fraction: SETTLED,
        pressure_drop: pressure_drop(case, catalogue, fluid, insertions, transport)?,
        step,
        particle_steps,
        shortest_relaxation: kinds.iter().map(|k| k.shortest_relaxation()).fold(f64::INFINITY, f64::min),
        kinds,
    })
}

/// Minimum time (s) of the steps of the fluid on one core; none where particles smaller than its cells decide.
pub fn min_seconds(case: &Case) -> Option<f64> {
    /// Seconds per cell and step of a fluid alone, and of one with a fifth of it resolved bodies.
    const COST: [f64; 2] = [1.0e-7, 2.0e-7];
    /// What more of a fluid whose viscosity varies, by eddies and by a rheology.
    const COST_OF_VISCOSITY: [f64; 2] = [1.5e-7, 2.5e-7];
    let fluid = case.fluid.as_ref().filter(|fluid| fluid.coupling.is_none())?;
    let resolved = case.resolved();
    let by_speed = match resolved.filter(|_| !case.holds_particles()) {
        Some(_) => fluid.cfl * narrowest(case, fluid) / case.time.impact_speed,
        None => fluid.largest_cfl() / fastest(case, fluid).rate,
    };
    let step = match case.time.dt {
        TimeStep::Seconds(dt) if resolved.is_none() || case.holds_particles() => dt,
        _ => max_dt(case, fluid).step.min(by_speed),
    };
    let cells = fluid.cells.iter().product::<u64>() as f64;
    let varies = [fluid.turbulence.is_some(), fluid.rheology.is_some()];
    let of_viscosity: f64 =
        COST_OF_VISCOSITY.iter().zip(varies).filter(|(_, varies)| *varies).map(|(cost, _)| cost).sum();
    Some(case.time.end / step * cells * (COST[usize::from(resolved.is_some())] + of_viscosity))
}

/// Bytes of the snapshots of the fluid, of their means, and of its state in the checkpoints that are kept; uncompressed.
pub fn bytes_on_disk(case: &Case) -> f64 {
    /// Numbers per cell of a checkpoint: velocities and explicit terms on faces, pressure, correction.
    const STATE: f64 = 8.0;
    /// Those of a mixture: void fraction now and at the beginning of the next step, and its rate.
    const MIXTURE: f64 = 3.0;
    /// Those of resolved bodies: their force, and the velocities that continue the flow inside, on the faces.
    const BODIES: f64 = 6.0;
    let Some(fluid) = &case.fluid else { return 0.0 };
    let cells = fluid.cells.iter().product::<u64>() as f64;
    let has_particles = (fluid.coupling.is_some() || fluid.resolved.is_some()) && !case.inserts.is_empty();
    let [is_mixture, is_resolved] =
        [fluid.coupling.is_some(), fluid.resolved.is_some()].map(|is| f64::from(u8::from(is)));
    let of_scalars = (2.0 + is_resolved) * fluid.scalar.len() as f64;
    let state = STATE + MIXTURE * is_mixture + BODIES * is_resolved + of_scalars;
    let varies = fluid.rheology.is_some() || fluid.turbulence.is_some();
    let components = |field: &FluidField| match (field, has_particles) {
        (FluidField::Velocity, _) | (FluidField::SolidVelocity, true) => 3.0,
        (FluidField::Pressure, _) | (FluidField::VoidFraction, true) => 1.0,
        (FluidField::SolidVelocity | FluidField::VoidFraction, false) => 0.0,
        (FluidField::Viscosity, _) => f64::from(u8::from(varies)),
        (FluidField::Scalars, _) => fluid.scalar.len() as f64,
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

/// Memory of the fluid on all ranks (bytes), each with the halo of its share of the cells.
pub fn bytes_in_memory(case: &Case, ranks: usize) -> f64 {
    let Some(fluid) = &case.fluid else { return 0.0 };
    let halo = 2.0 * super::plain_halo(fluid) as f64;
    // Shares are taken for cubes, whose halo is the smallest.
    let cut = libm::cbrt(ranks as f64);
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
        fluid.rheology.is_some() || fluid.turbulence.is_some(),
        fluid.rheology.is_some(),
        fluid.resolved.is_none() && case.walls.iter().any(|wall| wall.fluid.is_some()),
        !fluid.scalar.is_empty(),
    ];
    let of_scalars = stored * BYTES_OF_SCALAR * fluid.scalar.len() as f64;
    let bytes = BYTES.iter().zip(taken).filter(|(_, taken)| *taken);
    let [of_step, without] = BYTES_OF_STEADY;
    let of_steady = fluid.steady.map_or(0.0, |steady| of_step * steady.history as f64 - without);
    let of_steady = cells * of_steady.max(0.0);
    bytes.map(|([of_stored, of_cell], _)| stored * of_stored + cells * of_cell).sum::<f64>()
        + of_steady
        + of_scalars
}

/// What scalars take about particles that the grid resolves (bytes): on their surfaces and in them; collective.
pub fn bytes_at_surfaces(
    case: &Case,
    catalogue: &Catalogue,
    insertions: &Insertions,
    transport: &impl Transport,
) -> f64 {
    let Some(fluid) = case.fluid.as_ref().filter(|fluid| fluid.resolved.is_some()) else { return 0.0 };
    if fluid.scalar.is_empty() {
        return 0.0;
    }
    let cells = fluid.cells.iter().map(|&n| n as f64).product::<f64>();
    let extents = case.domain.extents();
    let cell = extents.iter().product::<f64>() / cells;
    let area = |kind: Kind, scale: f64| catalogue.shape(kind).area() * scale * scale;
    let squares = insertions.sum(case, catalogue, area, transport) / libm::pow(cell, 2.0 / 3.0);
    let [of_cell, of_square] = BYTES_AT_SURFACES;
    fluid.scalar.len() as f64 * (of_cell * cells + of_square * squares)
}

/// The longest step of the fluid; between particles at a void fraction the same flow is faster.
fn limited_step(case: &Case, fluid: &Fluid, void_fraction: f64) -> FluidStep {
    let (longest, fastest) = (max_dt(case, fluid), fastest(case, fluid));
    let at_inlet = fluid.largest_cfl() / fastest.rate;
    let between = void_fraction * at_inlet;
    let by_flow = FluidStepLimit::Imposed { speed: fastest.speed };
    let (max, limit) =
        if at_inlet > longest.step { (longest.step, longest.limit) } else { (at_inlet, by_flow) };
    let is_faster = void_fraction < 1.0 && between <= longest.step && at_inlet.is_finite();
    FluidStep::Limited { max, limit, max_in_bed: is_faster.then_some(between) }
}

/// The pressure drop that carries all particles, where gravity lies along an axis.
fn pressure_drop(
    case: &Case,
    catalogue: &Catalogue,
    fluid: &Fluid,
    insertions: &Insertions,
    transport: &impl Transport,
) -> Result<Option<PressureDrop>, String> {
    let axes: Vec<usize> = (0..3).filter(|a| case.gravity[*a] != 0.0).collect();
    let &[axis] = &axes[..] else { return Ok(None) };
    // The mass of particles of the difference in density is what the fluid does not carry by itself.
    let mut buoyant = catalogue.clone();
    buoyant.densities.iter_mut().for_each(|density| *density -= fluid.density);
    let weight = insertions.mass(case, &buoyant, transport) * case.gravity[axis].abs();
    let grid = setup::grid(case, fluid)?;
    let section = PlacedWalls::at_beginning(&FluidWalls::new(case)?, &grid).open_section(axis, &grid);
    Ok(Some(PressureDrop { pressure: weight / section, weight, section }))
}

#[cfg(test)]
mod tests;
