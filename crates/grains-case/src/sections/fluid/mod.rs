//! `[fluid]`: an incompressible fluid, alone or among the particles.

mod boundary;
mod cells;
mod coupling;
mod drive;
mod formula;
mod outline;
mod output;
mod pressure;
mod resolved;
mod scalar;
mod steady;
mod transfer;
mod viscosity;
mod walls;

use grains_fluid::{Advection, Diffusion, Rheology, Turbulence};
use grains_resolved::Extrapolation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use boundary::{Boundary, BoundaryKind, FlowProfile, OnFace};
pub(crate) use cells::check_thickness;
pub use coupling::Coupling;
pub use drive::Drive;
pub use formula::{Expression, Formula, FormulaError};
pub use outline::Part;
pub use output::{FluidField, FluidOutput, Profile, ProfileKind};
pub use pressure::{Pressure, PressureMethod};
pub(crate) use resolved::check_step;
pub use resolved::{Method as ResolvedMethod, Motion as BodyMotion, Resolved};
pub use scalar::{Scalar, ScalarBoundary, ScalarBoundaryKind, ScalarBuoyancy, ScalarKind};
pub use steady::Steady;
pub use transfer::{Evaporation, Inside, ParticleTransfer, Reaction, Uptake};
pub(crate) use walls::check_walls;

use crate::check::Checker;
use crate::sections::domain::Domain;
use crate::sections::insert::Insert;

/// Fields at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// Velocity (m/s), each component a number or a formula in x, y, z.
    #[serde(default)]
    pub velocity: [Expression; 3],
    /// Pressure without its hydrostatic part (Pa).
    #[serde(default)]
    pub pressure: Expression,
}

/// An incompressible fluid that fills the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density (kg/m³).
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [0.01, 20000]))]
    pub density: f64,
    /// Dynamic viscosity (Pa s); this or `rheology` is needed.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1000]))]
    pub viscosity: f64,
    /// How the viscosity depends on the rate of shear, in place of a constant one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rheology: Option<Rheology>,
    /// What eddies smaller than the cells add to the viscosity; nothing if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Number of cells along x, y, z (-); an axis of one cell makes the flow two-dimensional.
    #[schemars(schema_with = "three_counts")]
    pub cells: [u64; 3],
    /// Refinement towards both ends of each axis (-): nodes at tanh(s ξ)/tanh(s), ξ from −1 to 1; 0 for equal cells.
    #[serde(default)]
    #[schemars(schema_with = "three_refinements")]
    pub refinement: [f64; 3],
    /// Scheme of the advective terms; "van_leer" among particles and "central" without if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advection: Option<Advection>,
    /// Treatment of the viscous terms.
    #[serde(default)]
    pub diffusion: Diffusion,
    /// Largest Courant number of a step (-).
    #[serde(default = "quarter")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub cfl: f64,
    /// Longest step (s), where the Courant number allows more; if absent what the flow asks for that can come about: by what is
    /// imposed on it, its drive, its viscosity over the domain, and gravity and impact speed of particles (see `check`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_dt: Option<f64>,
    /// Boundary conditions; later ones hold where several do.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boundary: Vec<Boundary>,
    /// What drives the flow along periodic axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Drive>,
    /// Fields at the start.
    #[serde(default)]
    pub initial: Initial,
    /// The solver of the pressure.
    #[serde(default)]
    pub pressure: Pressure,
    /// How particles smaller than the cells and the fluid act on each other; this or `resolved` is needed if there are
    /// particles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coupling: Option<Coupling>,
    /// Particles larger than the cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolved: Option<Resolved>,
    /// The steady flow past fixed particles and walls, without marching in time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady: Option<Steady>,
    /// Temperature and concentrations that the fluid carries.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scalar: Vec<Scalar>,
    /// Lines and planes along which fields are written as tables.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profile: Vec<Profile>,
    /// What is written of the fluid.
    #[serde(default)]
    pub output: FluidOutput,
}

fn quarter() -> f64 {
    0.25
}

fn three_counts(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "array", "minItems": 3, "maxItems": 3,
        "items": {"type": "integer", "minimum": 1, "maximum": 1_000_000}
    })
}

fn three_refinements(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number", "minimum": 0, "maximum": 5}
    })
}

/// What the fluid is checked against.
pub(crate) struct Context<'a> {
    pub domain: &'a Domain,
    /// Acceleration of gravity (m/s²).
    pub gravity: [f64; 3],
    pub has_particles: bool,
    /// Whether particles have temperatures.
    pub has_heat: bool,
    /// Whether walls bound the fluid, and whether one of them moves.
    pub has_walls: bool,
    pub walls_move: bool,
    /// Names of these walls, and whether each moves.
    pub fluid_walls: Vec<(String, bool)>,
    /// Whether all particles stay where they are.
    pub particles_are_fixed: bool,
    /// Names of the shapes that are inserted and no spheres.
    pub not_spheres: Vec<String>,
    /// Whether collisions are impulses.
    pub is_hard: bool,
    /// Time between snapshots of the particles (s).
    pub interval: f64,
    /// End of the run (s).
    pub end: f64,
}

impl Fluid {
    /// Largest Courant number of a step (-): of a pseudo-step, if the steady flow is looked for.
    pub fn largest_cfl(&self) -> f64 {
        self.steady.map_or(self.cfl, |steady| steady.cfl)
    }

    /// Fills in the defaults that depend on other keys and checks what the schema cannot express.
    pub(crate) fn check(mut self, context: &Context<'_>, inserts: &[Insert], checker: &mut Checker) -> Self {
        let domain = context.domain;
        let usual = if self.coupling.is_some() { Advection::VanLeer } else { Advection::Central };
        self.advection.get_or_insert(usual);
        if context.has_walls && self.coupling.is_none() {
            let resolved = self.resolved.get_or_insert_with(Resolved::of_walls);
            if context.walls_move {
                resolved.extrapolation.get_or_insert(Extrapolation::Quadratic);
            }
        }
        viscosity::check(&mut self, context, checker);
        self.output.check(context.interval, context.end, checker);
        if self.resolved.is_none() {
            coupling::check(self.coupling.as_ref(), context, checker);
        }
        resolved::check(&self, context, inserts, checker);
        steady::check(&self, context, inserts, checker);
        cells::check(&self, domain, checker);
        boundary::check(&self, domain, checker);
        pressure::check(&self, domain, checker);
        scalar::check(&self, context, checker);
        output::check_profiles(&self.profile, domain, checker);
        if let Some(drive) = &self.drive {
            drive.check(&self.cells, domain, checker);
        }
        self.initial.check(domain, checker);
        self
    }
}

impl Initial {
    fn check(&self, domain: &Domain, checker: &mut Checker) {
        let components = self.velocity.iter().enumerate();
        let keyed = components.map(|(c, component)| (format!("fluid.initial.velocity[{c}]"), component));
        for (path, expression) in keyed.chain([("fluid.initial.pressure".to_owned(), &self.pressure)]) {
            check_formula(expression, &path, domain, checker);
            if expression.compile().is_ok_and(|formula| formula.is_unsteady()) {
                checker.error(&path, "t means nothing at the start; use x, y and z, or write 0 for t".into());
            }
        }
    }
}

/// A formula must compile, and should have a value somewhere inside.
fn check_formula(expression: &Expression, path: &str, domain: &Domain, checker: &mut Checker) {
    match expression.compile() {
        Ok(formula) => {
            // Neither a middle nor an end, where a formula may well have a pole.
            let at = [0, 1, 2].map(|a| domain.lower[a] + 0.382 * domain.extents()[a]);
            let value = formula.at(at, 0.0);
            if !value.is_finite() {
                checker.warn(path, format!("is {value} at {at:?} m and t = 0 s"));
            }
        }
        Err(error) => checker.error(path, error.to_string()),
    }
}
