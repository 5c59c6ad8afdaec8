//! `[fluid.resolved]`: particles that the grid resolves.

use grains_resolved::{Extrapolation, Interpolation, MAX_DIFFUSION_NUMBER};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Context, Fluid};
use crate::check::Checker;
use crate::diagnostic::rounded;
use crate::sections::domain::Domain;
use crate::sections::insert::Insert;
use crate::sections::motion::ParticleMotion;
use crate::sections::time::{Time, TimeStep};

/// Largest factor by which widths of cells may differ along the axes: the fluid around particles is looked at along their normals, no
/// further than the halo reaches.
const MAX_STRETCHING: f64 = 2.0;

/// What particles do in the flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// They move with the flow and collide.
    #[default]
    Free,
    /// They stay where they are inserted.
    Fixed,
}

impl From<Motion> for ParticleMotion {
    fn from(motion: Motion) -> Self {
        match motion {
            Motion::Free => Self::Free,
            Motion::Fixed => Self::Fixed,
        }
    }
}

/// How particles and fluid get one velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Velocities inside particles are set: fast, and of second order.
    #[default]
    Direct,
    /// Multipliers at points inside and on the surface are solved for by conjugate gradients (DLM/FD).
    Multiplier,
}

/// What films of fluid between spheres, and between spheres and walls, do that the grid does not resolve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lubrication {
    /// Thickness of the thickest such film (cells).
    #[serde(default = "crate::sections::one")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 4))]
    pub range: f64,
    /// Thickness of the thinnest film, by the roughness of the surfaces, over the radius of a sphere at a wall, between two
    /// over a₁ a₂/(a₁ + a₂) (-).
    #[serde(default = "usual_gap")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub min_gap: f64,
}

fn usual_gap() -> f64 {
    1e-3
}

/// Particles whose surfaces the grid resolves: no drag law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resolved {
    /// "free" or "fixed": what particles do whose `[[insert]]` does not say.
    #[serde(default)]
    pub motion: Motion,
    /// How particles and fluid get one velocity.
    #[serde(default)]
    pub method: Method,
    /// How velocities just inside a particle follow those in the fluid; "direct" only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extrapolation: Option<Extrapolation>,
    /// How velocities are found at points of the surface; "multiplier" only.
    #[serde(default)]
    pub interpolation: Interpolation,
    /// Distance of the points on the surface (cells); "multiplier" only.
    #[serde(default = "usual_spacing")]
    #[schemars(extend("minimum" = 0.8, "maximum" = 3))]
    pub point_spacing: f64,
    /// Residual of the multipliers' solve, of the velocities to be imposed (-); "multiplier" only.
    #[serde(default = "usual_tolerance")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub tolerance: f64,
    /// Largest number of iterations of that solve (-); "multiplier" only.
    #[serde(default = "usual_iterations")]
    #[schemars(extend("minimum" = 1))]
    pub iterations: u64,
    /// Share of the particles' last force on the fluid in its momentum equation (-).
    #[serde(default = "crate::sections::one")]
    #[schemars(extend("minimum" = 0, "maximum" = 1))]
    pub explicit_forcing: f64,
    /// Films of fluid too thin for the grid, between spheres and at walls; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lubrication: Option<Lubrication>,
    /// Largest ν Δt/Δx² of a step of the fluid (-), Δx that of the narrowest cells; with cubics and multipliers at most 2, beyond
    /// which forces may alternate from step to step.
    #[serde(default = "crate::sections::one")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 100))]
    pub diffusion_number: f64,
}

impl Resolved {
    /// What walls need that bound a fluid without particles.
    pub(super) fn of_walls() -> Self {
        Self {
            motion: Motion::Fixed,
            method: Method::default(),
            extrapolation: None,
            interpolation: Interpolation::default(),
            point_spacing: usual_spacing(),
            tolerance: usual_tolerance(),
            iterations: usual_iterations(),
            explicit_forcing: 1.0,
            lubrication: None,
            diffusion_number: 1.0,
        }
    }

    /// Largest diffusion number at which forces settle.
    pub fn largest_diffusion_number(&self, inserts: &[Insert]) -> f64 {
        match (self.method, self.extrapolation(inserts)) {
            (Method::Direct, Extrapolation::Quadratic | Extrapolation::Linear | Extrapolation::Rigid) => {
                f64::INFINITY
            }
            (Method::Direct, Extrapolation::Cubic) | (Method::Multiplier, _) => MAX_DIFFUSION_NUMBER,
        }
    }

    /// What to do for forces that settle at any diffusion number.
    fn steady_remedy(&self) -> &'static str {
        match self.method {
            Method::Direct => "set fluid.resolved.extrapolation = \"quadratic\"",
            Method::Multiplier => {
                "set fluid.resolved.method = \"direct\" and fluid.resolved.extrapolation = \"quadratic\""
            }
        }
    }

    /// Whether all particles stay where they are inserted.
    pub(crate) fn holds_all(&self, inserts: &[Insert]) -> bool {
        match inserts {
            [] => self.motion == Motion::Fixed,
            _ => inserts.iter().all(Insert::is_fixed),
        }
    }

    /// The extrapolation given, or the default for the motion of the particles.
    pub fn extrapolation(&self, inserts: &[Insert]) -> Extrapolation {
        let usual = if self.holds_all(inserts) { Extrapolation::Cubic } else { Extrapolation::Quadratic };
        self.extrapolation.unwrap_or(usual)
    }
}

fn usual_spacing() -> f64 {
    2.0
}

fn usual_tolerance() -> f64 {
    1e-5
}

fn usual_iterations() -> u64 {
    500
}

/// Refuses steps of the fluid in which the forces of particles would alternate.
pub(crate) fn check_step(
    fluid: &Fluid,
    (domain, inserts): (&Domain, &[Insert]),
    time: &Time,
    checker: &mut Checker,
) {
    let Some(resolved) = &fluid.resolved else { return };
    let max = resolved.largest_diffusion_number(inserts);
    let widths = (0..3).filter(|&a| fluid.cells[a] > 1).map(|a| fluid.cell_widths(domain, a)[0]);
    let width = widths.fold(f64::INFINITY, f64::min);
    let longest = max * width * width * fluid.density / fluid.viscosity_at_rest();
    if resolved.diffusion_number > max {
        let message = format!(
            "the forces of particles alternate from step to step beyond {max}; take {max} or less, or {}",
            resolved.steady_remedy()
        );
        checker.error("fluid.resolved.diffusion_number", message);
    }
    // Past fixed particles each step is one of the fluid.
    if let TimeStep::Seconds(dt) = time.dt
        && resolved.holds_all(inserts)
        && dt > longest
    {
        let message = format!(
            "the forces of particles alternate from step to step beyond {} s, nu dt/dx2 = {max}; lower it, take \"auto\", or {}",
            rounded(longest),
            resolved.steady_remedy()
        );
        checker.error("time.dt", message);
    }
}

/// Particles need cells of one width, and collisions that are soft.
pub(super) fn check(fluid: &Fluid, context: &Context<'_>, inserts: &[Insert], checker: &mut Checker) {
    let bodies = &fluid.output.bodies;
    if fluid.resolved.is_none() {
        if !bodies.is_empty() {
            let message = "forces are known of resolved particles only; remove it, or add [fluid.resolved]";
            checker.error("fluid.output.bodies", message.into());
        }
        return;
    }
    if let Some(twice) = (1..bodies.len()).find(|&k| bodies[..k].contains(&bodies[k])) {
        checker.error("fluid.output.bodies", format!("{} is there twice; remove one", bodies[twice]));
    }
    let key = "fluid.resolved";
    if fluid.coupling.is_some() {
        let message = "particles are either resolved or coupled by a drag law; remove [fluid.resolved] or [fluid.coupling]";
        checker.error(key, message.into());
    }
    if !context.has_particles && !context.has_walls {
        checker.warn(key, "without effect: there are no particles; add [[insert]] or remove it".into());
    }
    if context.is_hard {
        checker.error("collisions.model", "resolved particles collide softly only; take \"soft\"".into());
    }
    let has_films = fluid.resolved.as_ref().is_some_and(|resolved| resolved.lubrication.is_some());
    if let Some(shape) = context.not_spheres.first().filter(|_| has_films) {
        let message = format!("films are known between spheres only; remove it, or do not insert `{shape}`");
        checker.error("fluid.resolved.lubrication", message);
    } else if has_films && fluid.resolved.as_ref().is_some_and(|resolved| resolved.holds_all(inserts)) {
        checker.warn(
            "fluid.resolved.lubrication",
            "without effect: the particles stay where they are; remove it".into(),
        );
    }
    let widths = (0..3).filter(|&a| fluid.cells[a] > 1).map(|a| fluid.cell_widths(context.domain, a)[1]);
    let [min, max] = widths.fold([f64::INFINITY, 0.0], |[min, max], w| [w.min(min), w.max(max)]);
    if max > MAX_STRETCHING * min {
        checker.error(
            "fluid.cells",
            format!(
                "cells of {} to {} m, more than {MAX_STRETCHING} times as long as wide, do not resolve particles; take \
                 about as many per metre along all axes",
                rounded(min),
                rounded(max)
            ),
        );
    }
    if fluid.refinement.iter().any(|&r| r > 0.0) {
        let message =
            "particles can be resolved on equal cells only; set it to 0, or remove [fluid.resolved]";
        checker.error("fluid.refinement", message.into());
    }
}
