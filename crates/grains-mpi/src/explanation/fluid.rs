//! What the terminal shows of the fluid of a case.

use super::heat;
use grains_case::{
    Case, Coupling, Drive, Extrapolation, Fluid, FluidSide, Insert, Kernel, MixtureModel, Resolved,
    ResolvedMethod, Scalar, ScalarKind, Side, Wall, WallKind, inline,
};
use grains_simulation::check::{
    CouplingReport, FluidReport, FluidStep, FluidStepLimit, ParticlesInFluid, ResolvedReport, TooCoarse,
    WallsReport,
};

/// Prints what was found of the fluid.
pub fn tell(case: &Case, found: &FluidReport) {
    let Some(fluid) = &case.fluid else { return };
    cells(found);
    viscosity(case, fluid, found);
    if let (Some(found), Some(given)) = (&found.coupling, &fluid.coupling) {
        coupling(given, found);
    }
    if let Some(found) = &found.walls {
        walls(case, found);
    }
    if let (Some(found), Some(given)) = (&found.resolved, &fluid.resolved) {
        resolved(case, (fluid, given), found);
    }
    say!("fluid step     {}", step(case, fluid, found));
    fluid.scalar.iter().for_each(|scalar| of_scalar(case, fluid, scalar, found));
    if let Some(given) = &fluid.steady {
        say!(
            "steady flow    by pseudo-steps up to CFL number {}, {} of them combined; the run ends when forces, pressure \
             gradients and mean velocities change by less than {:e} of themselves, at pseudo-time {} s at the latest \
             (time.end)",
            given.cfl,
            given.history,
            given.tolerance,
            case.time.end
        );
    }
    if let Some(found) = &found.coupling {
        relaxation(found);
    }
}

fn cells(found: &FluidReport) {
    let [nx, ny, nz] = found.cells;
    let [x, y, z] = found.widths.map(|[narrow, wide]| match wide - narrow > 1e-9 * wide {
        true => format!("{narrow:.4e} to {wide:.4e}"),
        false => format!("{wide:.4e}"),
    });
    say!("fluid          {nx} x {ny} x {nz} = {} cells of {x} x {y} x {z} m", nx * ny * nz);
    let memory = (found.memory / 1e6).ceil();
    say!("  memory       about {memory:.0} MB of it for the fluid, halos of one rank included");
}

/// Ratio of the largest viscosity to that at a rate of 1/s beyond which plugs were seen to drift (-).
const STIFF: f64 = 30.0;

/// Prints what the viscosity depends on, and what a regularisation lets creep.
fn viscosity(case: &Case, fluid: &Fluid, found: &FluidReport) {
    if let Some(turbulence) = &fluid.turbulence {
        say!("  viscosity    {:.4e} Pa s and that of small eddies", fluid.viscosity);
        say!("    eddies     turbulence = {}", inline(turbulence));
    }
    let Some(rheology) = &fluid.rheology else { return };
    let (rest, reference) = (rheology.viscosity_at_rest(), rheology.reference_viscosity());
    say!("  viscosity    rheology = {}", inline(rheology));
    if let Some([rate, viscosity]) = found.sheared.filter(|[rate, _]| *rate > 0.0) {
        say!(
            "    sheared    {viscosity:.4e} Pa s at the {rate:.3e} 1/s that the case brings about; steps are judged by it"
        );
    }
    say!(
        "    at rest    at most {rest:.4e} Pa s, {:.3e} times that at 1/s without yield stress",
        rest / reference
    );
    if rest > STIFF * reference {
        say!(
            "  warning: fluid that has not yielded may drift by some per cent of the fastest where the flow varies along \
             several axes; a regularisation with at most {STIFF} times the viscosity at 1/s holds it"
        );
    }
    if rheology.yield_stress() == 0.0 {
        return;
    }
    let extents = case.domain.extents();
    let active = (0..3).filter(|&a| fluid.cells[a] > 1);
    let smallest = active.map(|a| extents[a]).fold(f64::INFINITY, f64::min);
    let creep = rheology.creep_rate();
    say!(
        "    unyielded  fluid creeps at up to {creep:.3e} 1/s where the ideal one is rigid, by {:.3e} m/s over half the \
         smallest extent",
        0.5 * creep * smallest
    );
    if let Some(Drive::PressureGradient { gradient }) = &fluid.drive {
        let largest = gradient.iter().fold(0.0_f64, |max, g| max.max(g.abs()));
        say!(
            "    yields     where stresses exceed {:.4e} Pa; between walls half the smallest extent from the middle the \
             drive makes {:.4e} Pa",
            rheology.yield_stress(),
            0.5 * largest * smallest
        );
    }
}

/// The step of the fluid and what limits it.
fn step(case: &Case, fluid: &Fluid, found: &FluidReport) -> String {
    match found.step {
        FluidStep::Given { step, cfl, speed } => {
            format!("{step:.4e} s (time.dt), CFL number {cfl:.3} at the {speed:.4} m/s imposed")
        }
        FluidStep::Limited { max, limit, max_in_bed } => {
            let in_bed = match (max_in_bed, &found.coupling) {
                (Some(step), Some(coupling)) => {
                    let void_fraction = coupling.void_fraction;
                    format!(", {step:.3e} s between particles at void fraction {void_fraction}")
                }
                _ => String::new(),
            };
            format!("at most {max:.3e} s ({}){in_bed}", reason(case, fluid, limit))
        }
    }
}

/// What limits the step of the fluid, by its key.
fn reason(case: &Case, fluid: &Fluid, limit: FluidStepLimit) -> String {
    match limit {
        FluidStepLimit::Given => "fluid.max_dt".into(),
        FluidStepLimit::Imposed { speed } => {
            let key = if fluid.steady.is_some() { "fluid.steady.cfl" } else { "fluid.cfl" };
            format!("{key} = {} at the {speed:.4} m/s imposed", fluid.largest_cfl())
        }
        FluidStepLimit::Drive => "fluid.cfl from rest by fluid.drive".into(),
        FluidStepLimit::Gravity => "fluid.cfl from rest by gravity".into(),
        FluidStepLimit::Buoyancy => "fluid.cfl from rest by the buoyancy of scalars".into(),
        FluidStepLimit::Crossing => {
            format!("particles cross a cell at time.impact_speed = {} m/s", case.time.impact_speed)
        }
        FluidStepLimit::Diffusion => {
            let number = fluid.resolved.as_ref().map_or(f64::NAN, |resolved| resolved.diffusion_number);
            format!("fluid.resolved.diffusion_number = {number}")
        }
        FluidStepLimit::Viscosity => {
            "a hundredth of H2/nu, in which viscosity stops a flow between walls".into()
        }
        FluidStepLimit::ViscosityAtWalls => {
            "a fifth of the time of diffusion over a cell, beside walls inside the flow".into()
        }
        FluidStepLimit::None => "nothing limits it".into(),
    }
}

/// Prints how a scalar diffuses and moves the fluid.
fn of_scalar(case: &Case, fluid: &Fluid, scalar: &Scalar, found: &FluidReport) {
    let diffusivity = scalar.diffusivity(fluid.density);
    let number = match scalar.kind {
        ScalarKind::Temperature { .. } => "Prandtl",
        ScalarKind::Concentration { .. } => "Schmidt",
    };
    let step = match found.step {
        FluidStep::Given { step, .. } | FluidStep::Limited { max: step, .. } => step,
    };
    let narrowest = found.widths.iter().map(|[narrow, _]| *narrow).fold(f64::INFINITY, f64::min);
    say!(
        "  scalar       {}: diffusivity {diffusivity:.4e} m2/s, {number} number {:.4e}; over the narrowest cell it diffuses in \
         {:.3e} s, {:.3e} steps, which limits none",
        scalar.name,
        fluid.viscosity / fluid.density / diffusivity,
        narrowest * narrowest / diffusivity,
        narrowest * narrowest / diffusivity / step
    );
    if let (Some(transfer), Some(found)) = (&scalar.particles, &found.coupling) {
        heat::of_transfer(case, (fluid, scalar), transfer, found);
    }
    if let (Some(transfer), Some(found)) = (&scalar.particles, &found.resolved) {
        heat::of_resolved((fluid, scalar), transfer, found, narrowest);
    }
    if let Some(buoyancy) = &scalar.buoyancy {
        let g = case.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let share = buoyancy.expansion.abs() * scalar.largest_difference(&case.domain, buoyancy.reference);
        let height = (0..3).map(|a| case.domain.extents()[a] * (case.gravity[a] / g).abs()).sum::<f64>();
        let rayleigh = 2.0 * share * g * height.powi(3) / (fluid.viscosity / fluid.density * diffusivity);
        say!(
            "    buoyancy   up to {share:.3e} of gravity; Rayleigh number {rayleigh:.3e} of twice that and the extent along gravity"
        );
        if share > NOT_SMALL {
            say!(
                "    warning: the density changes by {:.0} %, but is taken for constant everywhere but in the weight (Boussinesq)",
                100.0 * share
            );
        }
    }
}

/// Share of gravity by which buoyancy moves the fluid, from which on its density cannot be taken for constant (-).
const NOT_SMALL: f64 = 0.2;

/// Prints drag, model and kernel, the kinds of particles and the pressure drop.
fn coupling(given: &Coupling, found: &CouplingReport) {
    let model = match given.model {
        MixtureModel::A => "model A, both phases carry the pressure gradient",
        MixtureModel::B => "model B, the fluid alone carries the pressure gradient",
    };
    let kernel = match given.kernel {
        Kernel::Cube => "embedded cubes".into(),
        Kernel::Smooth { half_width } => format!("a smooth kernel of half width {half_width:.3} diameters"),
    };
    say!("coupling       drag by {:?}; {model}; {kernel}", given.drag);
    found.kinds.iter().for_each(|kind| particles(kind, found.void_fraction));
    if let Some(drop) = &found.pressure_drop {
        say!(
            "  fluidised    pressure drop {:.4e} Pa: buoyant weight of all particles {:.4e} N over {:.4e} m2",
            drop.pressure,
            drop.weight,
            drop.section
        );
    }
}

/// Prints how particles of one kind and size settle and fluidise.
fn particles(kind: &ParticlesInFluid, void_fraction: f64) {
    let [x, y, z] = kind.cells;
    say!(
        "  particles    {}: diameter {:.4e} m, cells of {x:.2} x {y:.2} x {z:.2} diameters",
        kind.name,
        kind.diameter
    );
    let motion = match &kind.motion {
        Ok(motion) => motion,
        Err(reason) => return say!("    neither settle nor fluidise: {reason}"),
    };
    let by = if motion.is_by_wen_yu { " by Wen and Yu, as Ergun's law is for beds" } else { "" };
    say!(
        "    alone      terminal velocity {:.4e} m/s{by}, relaxation time m/beta {:.3e} s",
        motion.terminal,
        motion.relaxation
    );
    say!(
        "    in a bed   minimum fluidisation at {:.4e} m/s by the law at void fraction {void_fraction}, at {:.4e} \
         m/s by the correlation of Wen and Yu; relaxation time {:.3e} s",
        motion.fluidisation,
        motion.correlation,
        motion.relaxation_in_bed
    );
}

fn relaxation(found: &CouplingReport) {
    let why = match found.particle_steps {
        Some((count, share)) => format!("{count} particle steps, {share:.2} of the limit"),
        None => "the longest".into(),
    };
    let (step, shortest) = (found.step, found.shortest_relaxation);
    say!(
        "  relaxation   fluid step {step:.3e} s ({why}) over the shortest relaxation time {shortest:.3e} s: {:.3}; \
         stable at any, exact in time below about 1",
        step / shortest
    );
}

/// Prints how well the grid resolves bodies.
fn resolved(case: &Case, (fluid, given): (&Fluid, &Resolved), found: &ResolvedReport) {
    let how = match (given.method, given.extrapolation(&case.inserts)) {
        (ResolvedMethod::Multiplier, _) => format!("multipliers {} cells apart", given.point_spacing),
        (_, Extrapolation::Cubic) => "cubics".into(),
        (_, Extrapolation::Quadratic) => "parabolas".into(),
        (_, Extrapolation::Linear) => "straight lines".into(),
        (_, Extrapolation::Rigid) => "nothing".into(),
    };
    say!("resolved       {}; velocities next to surfaces by {how}", bodies(case));
    let [smallest, largest] = found.cells_across;
    let across = match largest > 1.001 * smallest {
        true => format!("{smallest:.1} to {largest:.1}"),
        false => format!("{smallest:.1}"),
    };
    say!(
        "  cells        {across} across the {} of equal size, {:.1} across the thinnest part; about {:.0} \
         velocities imposed by the largest",
        if fluid.cells.contains(&1) { "disc" } else { "sphere" },
        found.cells_across_thinnest,
        found.imposed_velocities
    );
    if let Some([surface, inside]) = found.multipliers {
        say!("  multipliers  about {surface:.0} on the surface and {inside:.0} inside the largest");
    }
    match found.too_coarse {
        Some(TooCoarse::Part { cells, max_width }) => say!(
            "  warning: parts thinner than {cells} cells: the fluid hardly sees them; take cells of at most {max_width:.3e} m"
        ),
        Some(TooCoarse::Body { cells }) => say!(
            "  warning: fewer than {cells} cells across the smallest: drag is off by ten percent and more"
        ),
        None => {}
    }
    if let Some(lubrication) = found.lubrication {
        say!(
            "  lubrication  in gaps below {:.3e} m between spheres and at walls, down to {} of the radius",
            lubrication.range,
            lubrication.min_gap
        );
    }
    let longest = found.max_diffusion_step;
    say!(
        "  diffusion    at most {longest:.3e} s per step of the fluid (fluid.resolved.diffusion_number = {}), {:.0} \
         steps to the end",
        given.diffusion_number,
        (case.time.end / longest).ceil()
    );
}

/// Prints which walls bound the fluid, on which side it is, and what they make of the cells.
fn walls(case: &Case, found: &WallsReport) {
    let side = |wall: &Wall| match (wall.fluid, &wall.kind) {
        (Some(FluidSide::Particles), WallKind::Plane { .. }) => "before",
        (Some(FluidSide::Outside), _) => "outside",
        (Some(FluidSide::Particles), kind) if kind.side() == Some(Side::Outside) => "outside",
        _ => "inside",
    };
    let named = |(_, wall): (usize, &Wall)| format!("{} `{}`", side(wall), wall.name);
    let names: Vec<String> = case.walls_of_fluid().map(named).collect();
    say!(
        "  walls        the fluid is {}; {:.1} % of the cells are solid",
        names.join(", "),
        100.0 * found.solid
    );
    if let Some((count, place)) = found.narrow {
        say!(
            "  warning: {count} cells lie between walls less than two cells apart, one at {place:?} m: no flow is resolved there; take smaller cells, or close the gap"
        );
    }
}

/// The kinds of motion of the bodies of a case.
fn bodies(case: &Case) -> String {
    let is_driven = |insert: &Insert| insert.is_prescribed() && !insert.is_fixed();
    let kinds = [
        ("free bodies", case.inserts.iter().any(|insert| !insert.is_prescribed())),
        ("bodies that stay where they are", case.inserts.iter().any(Insert::is_fixed)),
        ("bodies of prescribed motion", case.inserts.iter().any(is_driven)),
    ];
    let names: Vec<&str> =
        kinds.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect();
    names.join(", ")
}
