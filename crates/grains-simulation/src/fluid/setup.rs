//! From the `[fluid]` of a case to a flow and its coupling.

use super::imposed::fastest_at;
use crate::insertion::KindRange;
use grains_case::{
    BoundaryKind, Case, Drive as CaseDrive, Expression, Face, FlowProfile, Fluid as CaseFluid, Formula,
    FormulaError, PressureMethod, Resolved as CaseResolved,
};
use grains_comm::MpiTransport;
use grains_coupling::{Coupling, Fluid};
use grains_dem::Catalogue;
use grains_domain::{Decomposition, Transport};
use grains_fluid::{
    Advection, Axis, Boundaries, BoxFace, CellPartition, Condition, ConjugateGradients, Drive, FanCurve,
    FastSolver, Flow, FlowRate, FlowSetup, Grid, Patch, PressureSolver, Profile, Side, ViscosityLaw,
};
use grains_geometry::Vec3;
use grains_petsc::{Options, PetscSolver, Preconditioning, Settings};
use std::cell::Cell;
use std::sync::Arc;

/// The grid of the fluid.
///
/// # Errors
/// Cells that cannot be.
pub fn grid(case: &Case, fluid: &CaseFluid) -> Result<Grid, String> {
    let domain = &case.domain;
    let axes = std::array::from_fn(|a| {
        let (lower, upper, cells) = (domain.lower[a], domain.upper[a], fluid.cells[a] as usize);
        match fluid.refinement[a] {
            strength if strength > 0.0 => Axis::clustered(lower, upper, cells, strength),
            _ => Axis::uniform(lower, upper, cells, domain.periodic[a]),
        }
    });
    Grid::new(axes).map_err(|e| case.about("fluid.cells", e.to_string()))
}

/// Widths of the cells along an axis (m).
pub fn cell_widths(grid: &Grid, axis: usize) -> impl Iterator<Item = f64> + '_ {
    grid.axis(axis).nodes().windows(2).map(|w| w[1] - w[0])
}

/// Axes along which there is flow.
pub fn active_axes(fluid: &CaseFluid) -> impl Iterator<Item = usize> + '_ {
    (0..3).filter(|&a| fluid.cells[a] > 1)
}

/// Width of the narrowest cells along the axes of the flow (m).
pub fn narrowest(case: &Case, fluid: &CaseFluid) -> f64 {
    active_axes(fluid).map(|a| fluid.cell_widths(&case.domain, a)[0]).fold(f64::INFINITY, f64::min)
}

/// Step (s) in which momentum diffuses as far as the case allows, over the narrowest cells: at the largest viscosity where longer
/// steps would make forces alternate, else at that of the flow.
pub fn diffusion_step(case: &Case, fluid: &CaseFluid, resolved: &CaseResolved) -> f64 {
    let viscosity = match resolved.largest_diffusion_number(&case.inserts).is_finite() {
        true => fluid.viscosity_at_rest(),
        false => viscosity_of_flow(case, fluid),
    };
    resolved.diffusion_number * narrowest(case, fluid).powi(2) * fluid.density / viscosity
}

/// Rate of shear (1/s) that a case brings about at walls: by the speed that it imposes, over half the smallest extent of the domain
/// or, past what the grid resolves, four cells; or by its drive over that half extent.
pub fn shear_rate(case: &Case, fluid: &CaseFluid) -> f64 {
    /// Radius of the smallest bodies that are resolved (cells).
    const RADIUS: f64 = 4.0;
    let extents = case.domain.extents();
    let half = 0.5 * active_axes(fluid).map(|a| extents[a]).fold(f64::INFINITY, f64::min);
    let length = if fluid.resolved.is_some() { RADIUS * narrowest(case, fluid) } else { half };
    let by_drive = match (&fluid.drive, &fluid.rheology) {
        (Some(CaseDrive::PressureGradient { gradient }), Some(rheology)) => {
            let largest = gradient.iter().fold(0.0_f64, |max, g| max.max(g.abs()));
            rheology.rate_under(largest * half)
        }
        _ => 0.0,
    };
    by_drive.max(fastest_at(case, fluid, &[0.0]).speed / length)
}

/// Dynamic viscosity (Pa s) at the rate of shear of the flow, by which steps are judged; that at a rate of 1/s without yield stress
/// where nothing is known of the flow.
pub fn viscosity_of_flow(case: &Case, fluid: &CaseFluid) -> f64 {
    match (&fluid.rheology, shear_rate(case, fluid)) {
        (Some(rheology), rate) if rate > 0.0 => rheology.viscosity(rate),
        _ => fluid.viscosity,
    }
}

/// Everything that defines the flow; `halo` in cells.
///
/// # Errors
/// What the solver refuses, with the key.
pub fn flow_setup(
    case: &Case,
    fluid: &CaseFluid,
    decomposition: &Decomposition,
    halo: usize,
) -> Result<FlowSetup, String> {
    let grid = grid(case, fluid)?;
    let about = |e: grains_fluid::SetupError| case.about("fluid", e.to_string());
    let partition = CellPartition::new(&grid, decomposition).map_err(about)?;
    let is_mixture = fluid.coupling.is_some() && !case.inserts.is_empty();
    let usual_advection = if is_mixture { Advection::VanLeer } else { Advection::Central };
    let setup = FlowSetup {
        boundaries: boundaries(case, fluid, &grid)?,
        partition,
        grid,
        halo,
        density: fluid.density,
        viscosity: fluid.viscosity,
        viscosity_law: viscosity_law(fluid),
        advection: fluid.advection.unwrap_or(usual_advection),
        diffusion: fluid.diffusion,
        drive: drive(fluid),
        mixture: fluid.coupling.as_ref().filter(|_| is_mixture).map(|c| c.model),
    };
    setup.check().map_err(about)?;
    Ok(setup)
}

fn viscosity_law(fluid: &CaseFluid) -> Option<ViscosityLaw> {
    let rheology = fluid.rheology.map(ViscosityLaw::Rheology);
    rheology.or(fluid.turbulence.map(ViscosityLaw::Turbulence))
}

fn drive(fluid: &CaseFluid) -> [Drive; 3] {
    std::array::from_fn(|a| match &fluid.drive {
        Some(CaseDrive::PressureGradient { gradient }) if gradient[a] != 0.0 => {
            Drive::PressureGradient(gradient[a])
        }
        Some(CaseDrive::MeanVelocity { velocity, axes }) if axes[a] => Drive::MeanVelocity(velocity[a]),
        Some(CaseDrive::MeanFlux { velocity, axes }) if axes[a] => Drive::MeanFlux(velocity[a]),
        _ => Drive::None,
    })
}

fn boundaries(case: &Case, fluid: &CaseFluid, grid: &Grid) -> Result<Boundaries, String> {
    let mut boundaries = Boundaries::default();
    for face in BoxFace::all().filter(|face| !grid.is_active(face.axis)) {
        boundaries.faces[face.index()] = Condition::Symmetry;
    }
    for case_face in Face::ALL {
        let side = if case_face.is_upper() { Side::High } else { Side::Low };
        let face = BoxFace { axis: case_face.axis(), side };
        let on_face = fluid.on_face(case_face);
        for k in on_face.whole.into_iter().chain(on_face.patches) {
            let given = &fluid.boundary[k];
            let about = |e: String| case.about(&format!("fluid.boundary[{k}]"), e);
            let condition = condition(&given.kind, fluid.density).map_err(about)?;
            match given.part.outline() {
                Some(outline) => boundaries.patches.push(Patch { face, outline, condition }),
                None => boundaries.faces[face.index()] = condition,
            }
        }
    }
    Ok(boundaries)
}

/// Which of the conditions of [`boundaries`] a `[[fluid.boundary]]` is, as [`Boundaries`] counts them; none for one that others hide.
pub fn condition_number(fluid: &CaseFluid, boundary: usize) -> Option<usize> {
    let mut patches = 6;
    for (k, face) in Face::ALL.into_iter().enumerate() {
        let on_face = fluid.on_face(face);
        if on_face.whole == Some(boundary) {
            return Some(k);
        }
        if let Some(place) = on_face.patches.iter().position(|&p| p == boundary) {
            return Some(patches + place);
        }
        patches += on_face.patches.len();
    }
    None
}

fn condition(kind: &BoundaryKind, density: f64) -> Result<Condition, String> {
    Ok(match kind {
        BoundaryKind::Wall { velocity } => Condition::Wall { velocity: *velocity },
        BoundaryKind::Inlet { velocity } => {
            Condition::Inlet { profile: inlet(velocity).map_err(|e| e.to_string())? }
        }
        BoundaryKind::FlowInlet { profile, .. } => {
            let (flow, factor) = kind.flow(density).ok_or("states no flow")?;
            let formula = flow.compile().map_err(|e| e.to_string())?;
            let is_unsteady = formula.is_unsteady();
            let at = move |time| factor * formula.at([0.0; 3], time);
            let rate =
                if is_unsteady { FlowRate::Function(Arc::new(at)) } else { FlowRate::Constant(at(0.0)) };
            let is_parabolic = *profile == FlowProfile::Parabolic;
            Condition::Inlet { profile: Profile::FlowRate { rate, is_parabolic } }
        }
        BoundaryKind::PressureInlet { pressure, fan } => {
            let fan = fan.clone().map(FanCurve::new).transpose()?;
            Condition::PressureInlet { pressure: *pressure, fan }
        }
        BoundaryKind::ParabolicInlet { mean } => {
            Condition::Inlet { profile: Profile::Parabolic { mean: *mean } }
        }
        BoundaryKind::Outlet { pressure } => Condition::Outlet { pressure: *pressure },
        BoundaryKind::Symmetry => Condition::Symmetry,
    })
}

fn inlet(velocity: &[Expression; 3]) -> Result<Profile, FormulaError> {
    if let [Expression::Number(x), Expression::Number(y), Expression::Number(z)] = velocity {
        return Ok(Profile::Uniform([*x, *y, *z]));
    }
    let [x, y, z] = compiled(velocity)?;
    if [&x, &y, &z].iter().all(|formula| !formula.is_unsteady()) {
        return Ok(Profile::SteadyFunction(Arc::new(move |at| {
            [&x, &y, &z].map(|formula| formula.at(at, 0.0))
        })));
    }
    Ok(Profile::Function(Arc::new(move |at, time| [x.at(at, time), y.at(at, time), z.at(at, time)])))
}

fn compiled([x, y, z]: &[Expression; 3]) -> Result<[Formula; 3], FormulaError> {
    Ok([x.compile()?, y.compile()?, z.compile()?])
}

/// The solver of the pressure that the case asks for; collective.
///
/// # Errors
/// Options that PETSc refuses.
pub fn pressure_solver(
    fluid: &CaseFluid,
    petsc: &[String],
    setup: &FlowSetup,
    transport: &MpiTransport,
) -> Result<Box<dyn PressureSolver>, String> {
    let (given, problem) = (&fluid.pressure, setup.pressure_problem());
    let iterations = given.iterations as usize;
    match given.method {
        PressureMethod::Auto => Ok(setup.suitable_solver_to(given.tolerance, iterations, transport)),
        PressureMethod::Fast => Ok(Box::new(FastSolver::new(&problem, transport))),
        PressureMethod::ConjugateGradients => {
            Ok(Box::new(ConjugateGradients::new(&problem, given.tolerance, iterations, transport)))
        }
        PressureMethod::Petsc => {
            let options = Options::parse(&given.options).map_err(|e| e.to_string())?;
            let options = options.with_command_line(petsc.iter().cloned());
            let settings =
                Settings { tolerance: given.tolerance, max_iterations: iterations, ..Settings::default() };
            let communicator = transport.communicator();
            let solver =
                PetscSolver::new(&problem, communicator, &options, &settings, Preconditioning::Multigrid);
            Ok(Box::new(solver.map_err(|e| e.to_string())?))
        }
    }
}

/// How particles and fluid act on each other.
///
/// # Errors
/// A kernel that does not fit, or a shape that cannot be measured.
pub fn coupling(case: &Case, fluid: &CaseFluid, catalogue: &Catalogue) -> Result<Option<Coupling>, String> {
    let Some(given) = &fluid.coupling else { return Ok(None) };
    let medium = Fluid { density: fluid.density, viscosity: fluid.viscosity };
    let mut coupling =
        Coupling::new(given.kernel, given.drag, given.model, medium, Vec3::from(case.gravity), catalogue)
            .map_err(|e| case.about("fluid.coupling", e.to_string()))?;
    coupling.min_void_fraction = given.min_void_fraction;
    Ok(Some(coupling))
}

/// Largest diameter (m) of a sphere of the volume of any particle of some kinds.
pub fn largest_diameter(coupling: &Coupling, kinds: &[KindRange]) -> f64 {
    let diameter = |k: &KindRange| coupling.profile(k.kind.shape).equivalent_diameter * k.largest;
    kinds.iter().map(diameter).fold(0.0, f64::max)
}

/// Sets the fields at the start; collective.
///
/// # Errors
/// Formulas that mean nothing.
pub fn initialise(
    case: &Case,
    flow: &mut Flow,
    fluid: &CaseFluid,
    transport: &MpiTransport,
) -> Result<(), String> {
    let about = |e: FormulaError| case.about("fluid.initial", e.to_string());
    let [x, y, z] = compiled(&fluid.initial.velocity).map_err(about)?;
    let pressure = fluid.initial.pressure.compile().map_err(about)?;
    // Beyond the domain and on its boundaries other values are put in their place.
    let domain = &case.domain;
    let is_inside = |at: [f64; 3]| {
        (0..3).all(|a| {
            domain.lower[a] < at[a]
                && (at[a] < domain.upper[a] || domain.periodic[a] && at[a] == domain.upper[a])
        })
    };
    let odd = Cell::new(None);
    let value = |quantity: usize, formula: &Formula, at: [f64; 3]| {
        let value = formula.at(at, 0.0);
        if !value.is_finite() && odd.get().is_none() && is_inside(at) {
            odd.set(Some((quantity, value, at)));
        }
        value
    };
    let velocity = |at| [value(0, &x, at), value(1, &y, at), value(2, &z, at)];
    flow.initialise(velocity, |at| value(3, &pressure, at), transport);
    let Some(first) = transport.first_rank_with(odd.get().is_some()) else { return Ok(()) };
    let Some((quantity, value, at)) = odd.get().filter(|_| first == transport.rank()) else {
        return Err(String::new());
    };
    let key = match quantity {
        3 => "fluid.initial.pressure".into(),
        component => format!("fluid.initial.velocity[{component}]"),
    };
    Err(case.about(
        &key,
        format!("the formula is {value} at {at:?} m; it must have a value in all of the domain"),
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// What does not mention the time is steady.
    #[test]
    fn inlets_are_unsteady_whose_formulas_depend_on_time() {
        let of = |x: &str| {
            inlet(&[Expression::Formula(x.into()), Expression::Number(0.5), Expression::Number(0.0)])
        };
        for steady in ["6*y*(0.41 - y)", "tan(z)", "2"] {
            let Profile::SteadyFunction(f) = of(steady).unwrap() else { panic!("{steady} is steady") };
            let expected = Formula::parse(steady).unwrap().at([0.1, 0.2, 0.3], 7.0);
            assert_eq!(f([0.1, 0.2, 0.3]), [expected, 0.5, 0.0]);
        }
        assert!(matches!(of("y*t").unwrap(), Profile::Function(_)));
    }
}
