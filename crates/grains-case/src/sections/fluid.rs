//! `[fluid]`: an incompressible fluid, alone or among the particles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sections::domain::Face;

/// A number, or a formula in x, y, z (m) and t (s) such as "0.5 * (1 - (y/0.01)^2)".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Expression {
    /// The same everywhere and always.
    Number(f64),
    /// A formula in x, y, z and t.
    Formula(String),
}

impl Default for Expression {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

/// Scheme of the advective terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Advection {
    /// Central differences, second order.
    Central,
    /// Bounded by the limiter of van Leer, for cells that do not resolve the flow.
    VanLeer,
}

/// Treatment of the viscous terms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Diffusion {
    /// Crank–Nicolson: no limit of the time step.
    #[default]
    Implicit,
    /// Adams–Bashforth.
    Explicit,
}

/// What holds on a face of the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum BoundaryKind {
    /// No slip.
    Wall {
        /// Velocity of the wall along itself (m/s).
        #[serde(default)]
        velocity: [f64; 3],
    },
    /// Imposed velocity.
    Inlet {
        /// Velocity (m/s), each component a number or a formula in x, y, z, t.
        velocity: [Expression; 3],
    },
    /// Imposed velocity, a parabola across the inlet.
    ParabolicInlet {
        /// Mean speed into the domain (m/s).
        mean: f64,
    },
    /// Imposed pressure.
    Outlet {
        /// Pressure without its hydrostatic part (Pa).
        #[serde(default)]
        pressure: f64,
    },
    /// No flow through and no shear.
    Symmetry,
}

/// A boundary condition, of a whole face or of a rectangle of it; walls at rest elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct Boundary {
    /// The face: "-x", "+x", "-y", "+y", "-z" or "+z".
    pub face: Face,
    /// The condition.
    #[serde(flatten)]
    pub kind: BoundaryKind,
    /// Lower corner of the rectangle (m); the coordinate normal to the face is not read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<[f64; 3]>,
    /// Upper corner of the rectangle (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<[f64; 3]>,
}

/// What drives the flow along a periodic axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Drive {
    /// An imposed mean pressure gradient.
    PressureGradient {
        /// Mean dp/dx along each axis (Pa/m); negative drives towards higher coordinates.
        gradient: [f64; 3],
    },
    /// An imposed mean superficial velocity, kept by adjusting the pressure gradient.
    MeanVelocity {
        /// Mean of ε u over the domain (m/s).
        velocity: [f64; 3],
        /// Axes along which the mean is kept, per axis (x, y, z).
        axes: [bool; 3],
    },
}

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

/// How the pressure equation is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PressureMethod {
    /// Fast transforms where the coefficients are constant, else PETSc.
    #[default]
    Auto,
    /// Fast transforms alone: one phase, and no face that is an outlet in part.
    Fast,
    /// Conjugate gradients of the program itself.
    ConjugateGradients,
    /// A preconditioned Krylov method of PETSc.
    Petsc,
}

/// The solver of the pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// Method: "auto", "fast", "conjugate_gradients" or "petsc".
    #[serde(default)]
    pub method: PressureMethod,
    /// Norm of the residual over that of the right-hand side at which an iterative solver stops (-).
    #[serde(default = "small")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.1, "x-plausible" = [1e-14, 1e-3]))]
    pub tolerance: f64,
    /// Iterations after which a solve has failed (-).
    #[serde(default = "many")]
    #[schemars(extend("minimum" = 1))]
    pub iterations: u64,
    /// Options for PETSc, as on its command line: "-ksp_type bcgs".
    #[serde(default)]
    pub options: String,
}

impl Default for Pressure {
    fn default() -> Self {
        Self { method: PressureMethod::Auto, tolerance: small(), iterations: many(), options: String::new() }
    }
}

/// A drag law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Drag {
    /// Beetstra et al. (2007).
    Beetstra,
    /// Ergun (1952).
    Ergun,
    /// Wen and Yu (1966).
    WenYu,
    /// Ergun up to a void fraction of 0.8, Wen and Yu beyond.
    Gidaspow,
    /// Di Felice (1994).
    DiFelice,
    /// Schiller and Naumann (1933): a lone sphere.
    SchillerNaumann,
    /// Hölzer and Sommerfeld (2008): any shape, as it lies in the flow.
    HoelzerSommerfeld,
    /// Ganser (1993): any shape, as it lies in the flow.
    Ganser,
}

/// Who carries the pressure gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MixtureModel {
    /// Both phases.
    #[default]
    A,
    /// The fluid alone; drag is divided by the void fraction.
    B,
}

/// How a particle is spread over the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Kernel {
    /// A cube of the particle's volume, cut by the cells: for cells of three diameters and more.
    #[default]
    Cube,
    /// A smooth blob whose width does not depend on the cells.
    Smooth {
        /// Half width (diameters of the sphere of the particle's volume).
        #[serde(default = "usual_half_width")]
        #[schemars(extend("minimum" = 0.5, "maximum" = 20))]
        half_width: f64,
    },
}

/// How particles and fluid act on each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Drag law.
    pub drag: Drag,
    /// Model of the pressure gradient: "A" or "B".
    #[serde(default)]
    pub model: MixtureModel,
    /// Kernel between particles and cells.
    #[serde(default)]
    pub kernel: Kernel,
    /// Void fraction of a cell below which the run ends (-).
    #[serde(default = "least_void_fraction")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub least_void_fraction: f64,
    /// Particle steps per step of the fluid (-); as many as the Courant number allows if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1))]
    pub particle_steps: Option<u64>,
}

/// A field of the fluid's snapshots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FluidField {
    /// Velocity at the centres of the cells (m/s).
    Velocity,
    /// Pressure without its hydrostatic part (Pa).
    Pressure,
    /// Void fraction (-); only among particles.
    VoidFraction,
    /// Mean velocity of the particles (m/s); only among particles.
    SolidVelocity,
}

impl FluidField {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Velocity, Self::Pressure, Self::VoidFraction, Self::SolidVelocity];
}

/// Where the fields are written as tables, at every snapshot and as means over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ProfileKind {
    /// Points along a line, ends included.
    Line {
        /// First point (m).
        from: [f64; 3],
        /// Last point (m).
        to: [f64; 3],
        /// Number of points (-).
        #[schemars(extend("minimum" = 2))]
        points: u64,
    },
    /// All cells that a plane cuts; mean pressure and flow rate also go to the time series.
    Plane {
        /// Axis the plane is normal to: "x", "y" or "z".
        axis: Axis,
        /// Its coordinate (m).
        at: f64,
    },
}

/// An axis of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

/// A line or plane with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Profile", extend("unevaluatedProperties" = false))]
pub struct Profile {
    /// Name, which also names its files.
    pub name: String,
    /// The line or plane.
    #[serde(flatten)]
    pub kind: ProfileKind,
}

/// What is written of the fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "FluidOutput")]
pub struct FluidOutput {
    /// Time between snapshots (s), 0 for none; that of the particles if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub interval: Option<f64>,
    /// Fields of the snapshots; all by default.
    #[serde(default = "all_fields")]
    pub fields: Vec<FluidField>,
    /// Time from which means over time are taken (s); none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub mean_from: Option<f64>,
}

impl Default for FluidOutput {
    fn default() -> Self {
        Self { interval: None, fields: all_fields(), mean_from: None }
    }
}

/// An incompressible fluid that fills the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density (kg/m³).
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [0.01, 20000]))]
    pub density: f64,
    /// Dynamic viscosity (Pa s).
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1000]))]
    pub viscosity: f64,
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
    pub courant: f64,
    /// Longest step (s), where the Courant number allows more; a hundredth of the run at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub longest_step: Option<f64>,
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
    /// How particles and fluid act on each other; needed if there are particles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coupling: Option<Coupling>,
    /// Lines and planes along which fields are written as tables.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profile: Vec<Profile>,
    /// What is written of the fluid.
    #[serde(default)]
    pub output: FluidOutput,
}

fn small() -> f64 {
    1e-8
}

fn many() -> u64 {
    500
}

fn quarter() -> f64 {
    0.25
}

/// Smooths like a cell of three diameters: ½ · 3 · √(7/3).
fn usual_half_width() -> f64 {
    2.291_287_847_477_92
}

fn least_void_fraction() -> f64 {
    0.2
}

fn all_fields() -> Vec<FluidField> {
    FluidField::ALL.to_vec()
}

fn three_counts(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "integer", "minimum": 1}
    })
}

fn three_refinements(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number", "minimum": 0, "maximum": 5}
    })
}
