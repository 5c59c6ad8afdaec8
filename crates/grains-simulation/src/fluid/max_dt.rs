//! The longest step of the fluid: what the flow that can come about asks for, whatever the end of the run.

use super::imposed::fastest_at;
use super::scalars;
use super::setup::{active_axes, diffusion_step, narrowest, viscosity_of_flow};
use grains_case::{BoundaryKind, Case, Drive, Fluid};

/// Share of the time H²/ν in which momentum diffuses through the domain that a step may take.
const SHARE_OF_DIFFUSION: f64 = 0.01;

/// Largest ν Δt/Δx² of flows averaged over particles that walls bound (-): beside cut cells part of the viscous stress is explicit.
const DIFFUSION_AT_WALLS: f64 = 0.2;

/// A longest step, and what limits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxStep {
    /// Step (s).
    pub step: f64,
    /// What limits it.
    pub limit: FluidStepLimit,
}

/// What limits the step of the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FluidStepLimit {
    /// The case's own longest step.
    Given,
    /// The CFL number at the velocity that boundaries, drive and initial fields impose.
    Imposed {
        /// Speed (m/s).
        speed: f64,
    },
    /// The CFL number from rest under the drive, or between imposed pressures.
    Drive,
    /// The CFL number from rest under gravity.
    Gravity,
    /// The CFL number from rest under the buoyancy of scalars.
    Buoyancy,
    /// Particles smaller than the cells cross one at `time.impact_speed`.
    Crossing,
    /// The diffusion number of resolved bodies.
    Diffusion,
    /// H²/(100 ν), of the time in which viscosity stops a flow between walls.
    Viscosity,
    /// A fifth of Δx²/ν, of averaged flows that walls inside bound.
    ViscosityAtWalls,
    /// Nothing.
    None,
}

/// The case's own longest step, or the shortest of what its flow asks for; with particles that the grid resolves also that in
/// which momentum diffuses a cell or so.
///
/// With cells Δx along an axis, CFL number C, kinematic viscosity ν (where it varies, at the rate of shear of the flow) and the smallest extent H of the domain in the flow:
///
/// * C/Σ(|u|/Δx) of the velocities u imposed at the beginning, by boundaries, drive and initial fields;
/// * √(2 C Δx/a): a drive, imposed pressures, gravity or buoyancy of acceleration a makes the flow, or particles that move, move C cells from rest;
/// * Δx/v: a particle smaller than the cells crosses one at the impact speed v;
/// * H²/(100 ν) without resolved particles;
/// * Δx²/(5 ν) of flows averaged over particles that walls inside bound, also where the case gives its own longest step.
pub fn max_dt(case: &Case, fluid: &Fluid) -> MaxStep {
    let resolved = case.resolved();
    let mut candidates = Vec::new();
    let mut add = |step: f64, limit| candidates.push(MaxStep { step, limit });
    if let Some(resolved) = &fluid.resolved {
        add(diffusion_step(case, fluid, resolved), FluidStepLimit::Diffusion);
    }
    if fluid.coupling.is_some() && case.walls_of_fluid().next().is_some() {
        let (width, viscosity) = (narrowest(case, fluid), viscosity_of_flow(case, fluid));
        let step = DIFFUSION_AT_WALLS * width * width * fluid.density / viscosity;
        add(step, FluidStepLimit::ViscosityAtWalls);
    }
    if let Some(given) = fluid.max_dt {
        add(given, FluidStepLimit::Given);
    } else {
        let imposed = fastest_at(case, fluid, &[0.0]);
        add(fluid.largest_cfl() / imposed.rate, FluidStepLimit::Imposed { speed: imposed.speed });
        if let Some(Drive::PressureGradient { gradient }) = &fluid.drive {
            add(from_rest(case, fluid, gradient.map(|g| g / fluid.density)), FluidStepLimit::Drive);
        }
        if let Some(acceleration) = by_pressure(case, fluid) {
            add(from_rest(case, fluid, acceleration), FluidStepLimit::Drive);
        }
        if !case.inserts.is_empty() && !case.holds_particles() {
            add(from_rest(case, fluid, case.gravity), FluidStepLimit::Gravity);
        }
        let share = scalars::largest_buoyancy(case, fluid);
        if share > 0.0 {
            add(from_rest(case, fluid, case.gravity.map(|g| share * g)), FluidStepLimit::Buoyancy);
        }
        if fluid.coupling.is_some() && !case.inserts.is_empty() {
            add(narrowest(case, fluid) / case.time.impact_speed, FluidStepLimit::Crossing);
        }
        if resolved.is_none() {
            let extents = case.domain.extents();
            let smallest = active_axes(fluid).map(|a| extents[a]).fold(f64::INFINITY, f64::min);
            let viscosity = viscosity_of_flow(case, fluid);
            let step = SHARE_OF_DIFFUSION * smallest * smallest * fluid.density / viscosity;
            add(step, FluidStepLimit::Viscosity);
        }
    }
    let first = MaxStep { step: f64::MAX, limit: FluidStepLimit::None };
    candidates.into_iter().fold(first, |a, b| if b.step < a.step { b } else { a })
}

/// Acceleration (m/s²) along each axis of what is at rest, by the largest difference of the pressures that are imposed, over the
/// extent of the domain; none without inlets of imposed pressure.
fn by_pressure(case: &Case, fluid: &Fluid) -> Option<[f64; 3]> {
    let of = |kind: &BoundaryKind| match kind {
        BoundaryKind::PressureInlet { pressure, fan } => {
            let rises = fan.iter().flatten().map(|point| point[1]);
            Some(pressure + rises.fold(0.0, f64::max))
        }
        BoundaryKind::Outlet { pressure } => Some(*pressure),
        _ => None,
    };
    let is_inlet = |kind: &BoundaryKind| matches!(kind, BoundaryKind::PressureInlet { .. });
    fluid.boundary.iter().find(|boundary| is_inlet(&boundary.kind))?;
    let pressures = || fluid.boundary.iter().filter_map(|boundary| of(&boundary.kind));
    let [low, high] =
        [pressures().fold(f64::INFINITY, f64::min), pressures().fold(f64::NEG_INFINITY, f64::max)];
    let inlets = fluid.boundary.iter().filter(|boundary| is_inlet(&boundary.kind));
    let axes: Vec<usize> = inlets.map(|boundary| boundary.face.axis()).collect();
    let extents = case.domain.extents();
    Some([0, 1, 2].map(|a| if axes.contains(&a) { (high - low) / (fluid.density * extents[a]) } else { 0.0 }))
}

/// Time (s) in which what is at rest moves as far as the CFL number allows, at an acceleration (m/s²).
fn from_rest(case: &Case, fluid: &Fluid, acceleration: [f64; 3]) -> f64 {
    let rate: f64 =
        active_axes(fluid).map(|a| acceleration[a].abs() / fluid.cell_widths(&case.domain, a)[0]).sum();
    (2.0 * fluid.largest_cfl() / rate).sqrt()
}

#[cfg(test)]
mod tests {
    use super::max_dt;
    use crate::timestep::of_fluid;
    use grains_case::Case;
    use std::path::Path;

    /// Air in a box between walls; `more` goes into its table.
    fn text(end: f64, more: &str, intervals: [f64; 4]) -> String {
        let [particles, series, checkpoint, fluid] = intervals;
        format!(
            "[domain]\nlower = [0, 0, 0]\nupper = [0.2, 0.1, 0.1]\nperiodic = [true, false, false]\n[time]\nend = {end}\n\
             [output]\nparticles = {particles}\nseries = {series}\ncheckpoint = {checkpoint}\n[fluid]\ndensity = 1.2\n\
             viscosity = 1.8e-5\ncells = [20, 10, 10]\n{more}\n[fluid.output]\ninterval = {fluid}\n"
        )
    }

    fn case(end: f64, more: &str, intervals: [f64; 4]) -> Case {
        Case::parse(&text(end, more, intervals), "box.toml", Path::new("")).unwrap()
    }

    const FLOWS: [&str; 5] = [
        "",
        "max_dt = 2e-4",
        "drive = { kind = \"pressure_gradient\", gradient = [-3, 0, 0] }",
        "drive = { kind = \"mean_flux\", velocity = [40, 0, 0], axes = [true, false, false] }",
        "initial = { velocity = [\"y*7\", 0, 0] }",
    ];

    /// Steps (s) by closed forms: the time of diffusion, what is given, from rest, and the CFL number twice.
    #[test]
    fn the_longest_step_follows_from_the_flow_and_not_from_the_end() {
        let wanted = [
            0.01 * 0.01 * 1.2 / 1.8e-5,
            2e-4,
            (2.0 * 0.25 * 0.01 * 1.2 / 3.0_f64).sqrt(),
            0.25 * 0.01 / 40.0,
            0.25 * 0.01 / 0.7,
        ];
        for (flow, wanted) in FLOWS.into_iter().zip(wanted) {
            for end in [1e-3, 1.0, 1e4] {
                let case = case(end, flow, [0.0; 4]);
                let found = max_dt(&case, case.fluid.as_ref().unwrap());
                assert!((found.step / wanted - 1.0).abs() < 1e-9, "{flow} {end}: {found:?}, {wanted}");
            }
        }
    }

    /// Between walls under a drive G a power-law fluid is sheared at (G H/2K)^(1/n), and has the viscosity G H/2 over that.
    #[test]
    fn a_rheology_is_judged_at_the_rate_of_shear_of_its_flow() {
        let drive = "drive = { kind = \"pressure_gradient\", gradient = [-3e-9, 0, 0] }";
        for (consistency, index) in [(1e-4, 0.5), (2e-3, 0.8), (1e-2, 1.5)] {
            let law = format!(
                "rheology = {{ kind = \"power_law\", consistency = {consistency}, index = {index}, max_viscosity = 1e9 }}"
            );
            let text = text(1.0, drive, [0.0; 4]).replace("viscosity = 1.8e-5", &law);
            let case = Case::parse(&text, "box.toml", Path::new("")).unwrap();
            let stress = 3e-9 * 0.05;
            let viscosity = stress / f64::powf(stress / consistency, 1.0 / index);
            let wanted = (0.01 * 0.01 * 1.2 / viscosity).min((2.0 * 0.25 * 0.01 * 1.2 / 3e-9_f64).sqrt());
            let found = max_dt(&case, case.fluid.as_ref().unwrap()).step;
            assert!((found / wanted - 1.0).abs() < 1e-9, "{consistency} {index}: {found}, {wanted}");
        }
    }

    /// Whatever the intervals, also if nothing is ever written: a step of the fluid has many ticks, outputs are whole numbers of
    /// them, and the tick is that of the version before where that had many already.
    #[test]
    fn a_tick_is_short_beside_the_longest_step() {
        for flow in FLOWS {
            for intervals in [[0.0; 4], [0.0, 0.5, 0.0, 0.0], [0.01, 1e-3, 2.0, 0.01]] {
                for end in [2e-3, 2.0, 2e4] {
                    let case = case(end, flow, intervals);
                    let (tick, longest) = (of_fluid(&case).dt, max_dt(&case, case.fluid.as_ref().unwrap()));
                    assert!(
                        1024.0 * tick <= longest.step,
                        "{flow} {intervals:?} {end}: {tick} of {longest:?}"
                    );
                    let shortest = intervals.into_iter().filter(|&t| t > 0.0).fold(end, f64::min);
                    let ticks = shortest / tick;
                    assert!(
                        (ticks.log2() - ticks.log2().round()).abs() < 1e-9 && ticks >= 65535.0,
                        "{ticks}"
                    );
                    assert!(ticks < 65537.0 || 2048.0 * tick > longest.step, "{ticks}");
                }
            }
        }
    }
}
