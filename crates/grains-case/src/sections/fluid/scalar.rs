//! `[[fluid.scalar]]`: temperature and concentrations that the fluid carries.

use super::outline::{Part, Wants};
use super::transfer::{self, ParticleTransfer};
use super::{BoundaryKind, Context, Expression, Fluid, ResolvedMethod, check_formula};
use crate::check::Checker;
use crate::sections::domain::{Domain, Face};
use grains_fluid::Scheme;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a scalar is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ScalarKind {
    /// A temperature (K); fluxes are those of heat (W/m²).
    Temperature {
        /// Thermal conductivity of the fluid (W/(m K)).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-3, 500]))]
        conductivity: f64,
        /// Specific heat capacity of the fluid (J/(kg K)).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [100, 20000]))]
        heat_capacity: f64,
    },
    /// A concentration (mol/m³, kg/m³ or whatever else is counted); fluxes are those of what is counted (mol/(m² s)).
    Concentration {
        /// Diffusivity in the fluid (m²/s).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-13, 1]))]
        diffusivity: f64,
    },
}

/// A force ρ β (φ₀ − φ) g on the fluid (Boussinesq).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScalarBuoyancy {
    /// Expansion coefficient β (1/K, m³/mol); negative of what makes the fluid heavier.
    pub expansion: f64,
    /// Value φ₀ (K, mol/m³) at which the density is `fluid.density`.
    pub reference: f64,
}

/// What holds on a face or on a part of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ScalarBoundaryKind {
    /// No flux.
    Insulated,
    /// A value; where fluid comes in, that which it carries.
    Value {
        /// The value (K, mol/m³), a number or a formula in x, y, z, t.
        value: Expression,
    },
    /// A flux into the fluid.
    Flux {
        /// The flux (W/m², mol/(m² s)), a number or a formula in x, y, z, t.
        flux: Expression,
    },
    /// A flux h (φ∞ − φ) into the fluid, φ its value at the face.
    Transfer {
        /// Transfer coefficient h (W/(m² K), m/s).
        #[schemars(extend("minimum" = 0))]
        coefficient: f64,
        /// Value φ∞ (K, mol/m³) beyond the face, a number or a formula in x, y, z, t.
        ambient: Expression,
    },
}

/// A boundary condition of a scalar, on a face of the domain or on a wall in the fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct ScalarBoundary {
    /// The face: "-x", "+x", "-y", "+y", "-z" or "+z".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<Face>,
    /// Instead of a face: the name of a wall that bounds the fluid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall: Option<String>,
    /// The condition.
    #[serde(flatten)]
    pub kind: ScalarBoundaryKind,
    /// Where on the face it holds, if not on the whole: in the cells whose middle it covers.
    #[serde(flatten)]
    pub part: Part,
}

/// A temperature or concentration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "FluidScalar", extend("unevaluatedProperties" = false))]
pub struct Scalar {
    /// Name, which its fields and columns have.
    pub name: String,
    /// What it is.
    #[serde(flatten)]
    pub kind: ScalarKind,
    /// Value at the start (K, mol/m³), a number or a formula in x, y, z.
    pub initial: Expression,
    /// Scheme of the advection: "bounded" by what is around, or "central".
    #[serde(default)]
    pub advection: Scheme,
    /// How it moves the fluid; not at all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub buoyancy: Option<ScalarBuoyancy>,
    /// What particles exchange with it; nothing if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub particles: Option<ParticleTransfer>,
    /// Boundary conditions; later ones hold where several do, and no flux where none does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boundary: Vec<ScalarBoundary>,
}

impl Scalar {
    /// Diffusivity (m²/s) in a fluid of a density (kg/m³).
    pub fn diffusivity(&self, density: f64) -> f64 {
        match self.kind {
            ScalarKind::Temperature { conductivity, .. } => conductivity / self.capacity(density),
            ScalarKind::Concentration { diffusivity } => diffusivity,
        }
    }

    /// What a volume of fluid holds per unit of the value: its heat capacity ρ c (J/(m³ K)), or 1.
    pub fn capacity(&self, density: f64) -> f64 {
        match self.kind {
            ScalarKind::Temperature { heat_capacity, .. } => density * heat_capacity,
            ScalarKind::Concentration { .. } => 1.0,
        }
    }

    /// Units of the value and of its content.
    pub fn units(&self) -> [&'static str; 2] {
        match self.kind {
            ScalarKind::Temperature { .. } => ["K", "J"],
            ScalarKind::Concentration { .. } => ["1/m3", "-"],
        }
    }

    /// Largest |φ − φ₀| of the values that are given, to a reference φ₀; formulas count with their values at the corners of the domain.
    pub fn largest_difference(&self, domain: &Domain, reference: f64) -> f64 {
        let of_value = |(_, expression): (String, &Expression)| {
            let Ok(formula) = expression.compile() else { return 0.0 };
            let at_corners = domain.corners().into_iter().map(|corner| formula.at(corner, 0.0));
            at_corners.filter(|x| x.is_finite()).map(|x| (x - reference).abs()).fold(0.0, f64::max)
        };
        self.values().map(of_value).fold(0.0, f64::max)
    }

    /// Values that a condition or the start states, with their keys.
    fn values(&self) -> impl Iterator<Item = (String, &Expression)> {
        let of_boundary = self.boundary.iter().enumerate().filter_map(|(i, boundary)| match &boundary.kind {
            ScalarBoundaryKind::Value { value } => Some((format!("boundary[{i}].value"), value)),
            ScalarBoundaryKind::Transfer { ambient, .. } => Some((format!("boundary[{i}].ambient"), ambient)),
            _ => None,
        });
        std::iter::once(("initial".to_string(), &self.initial)).chain(of_boundary)
    }
}

/// Names that the fields of a fluid have already.
const TAKEN: [&str; 5] = ["velocity", "pressure", "void_fraction", "solid_velocity", "viscosity"];

/// Checks all scalars.
pub(super) fn check(fluid: &Fluid, context: &Context<'_>, checker: &mut Checker) {
    if fluid.scalar.is_empty() {
        return;
    }
    checker.names("fluid.scalar", fluid.scalar.iter().map(|scalar| scalar.name.clone()).collect());
    for (k, scalar) in fluid.scalar.iter().enumerate() {
        check_scalar(scalar, &format!("fluid.scalar[{k}]"), (fluid, context), checker);
    }
    let mut refuse = |key: &str, message: &str| checker.error(key, message.into());
    if fluid.resolved.as_ref().is_some_and(|resolved| resolved.method == ResolvedMethod::Multiplier) {
        refuse(
            "fluid.resolved.method",
            "scalars know direct forcing only; take \"direct\", or remove [[fluid.scalar]]",
        );
    }
    if fluid.steady.is_some() && fluid.scalar.iter().any(|scalar| scalar.buoyancy.is_some()) {
        let message =
            "a steady flow is found before the scalars, which move it; remove it, or their buoyancy";
        refuse("fluid.steady", message);
    }
}

fn check_scalar(
    scalar: &Scalar,
    path: &str,
    (fluid, context): (&Fluid, &Context<'_>),
    checker: &mut Checker,
) {
    let domain = context.domain;
    if TAKEN.contains(&scalar.name.as_str()) {
        let message = "a field of the fluid has this name; take another, such as \"temperature\"";
        checker.error(&format!("{path}.name"), message.into());
    }
    for (key, value) in scalar.values() {
        let key = format!("{path}.{key}");
        check_formula(value, &key, domain, checker);
        if let (Expression::Number(value), ScalarKind::Temperature { .. }) = (value, &scalar.kind)
            && *value < 0.0
        {
            let message = "below absolute zero; temperatures are in kelvin, 273.15 K above those in °C";
            checker.error(&key, message.into());
        }
    }
    if scalar.initial.compile().is_ok_and(|formula| formula.is_unsteady()) {
        let message = "t means nothing at the start; use x, y and z, or write 0 for t";
        checker.error(&format!("{path}.initial"), message.into());
    }
    if scalar.buoyancy.is_some() && context.gravity == [0.0; 3] {
        let message = "without effect: there is no gravity; state `gravity`";
        checker.warn(&format!("{path}.buoyancy"), message.into());
    }
    if let Some(transfer) = &scalar.particles {
        let of = (matches!(scalar.kind, ScalarKind::Temperature { .. }), fluid, context);
        transfer::check(transfer, &format!("{path}.particles"), of, checker);
    }
    for (i, boundary) in scalar.boundary.iter().enumerate() {
        check_boundary(boundary, &format!("{path}.boundary[{i}]"), (fluid, context), checker);
    }
    check_inlets(scalar, path, fluid, checker);
}

fn check_boundary(
    boundary: &ScalarBoundary,
    path: &str,
    (fluid, context): (&Fluid, &Context<'_>),
    checker: &mut Checker,
) {
    let domain = context.domain;
    if let ScalarBoundaryKind::Flux { flux } = &boundary.kind {
        check_formula(flux, &format!("{path}.flux"), domain, checker);
    }
    let face = match (boundary.face, &boundary.wall) {
        (Some(face), None) => face,
        (None, Some(wall)) => return check_wall(boundary, wall, path, context, checker),
        (Some(_), Some(_)) => {
            return checker.error(&format!("{path}.wall"), "excludes face; state one of the two".into());
        }
        (None, None) => {
            let message =
                "missing: where the condition holds; state face, or wall with the name of one in the fluid";
            return checker.error(&format!("{path}.face"), message.into());
        }
    };
    let (axis, name) = (face.axis(), ["x", "y", "z"][face.axis()]);
    if domain.periodic[axis] {
        let message =
            format!("no boundary there: {name} is periodic; remove the condition or domain.periodic[{axis}]");
        return checker.error(&format!("{path}.face"), message);
    }
    if fluid.cells[axis] == 1 {
        let message = format!("nothing passes along {name}, which has one cell; remove the condition");
        return checker.error(&format!("{path}.face"), message);
    }
    let wants = Wants { parabola: false, cells: true };
    boundary.part.check(face, wants, path, fluid, domain, checker);
}

/// A condition on a wall in the fluid.
fn check_wall(
    boundary: &ScalarBoundary,
    wall: &str,
    path: &str,
    context: &Context<'_>,
    checker: &mut Checker,
) {
    let Some((_, moves)) = context.fluid_walls.iter().find(|(name, _)| name == wall) else {
        let names: Vec<String> = context.fluid_walls.iter().map(|(name, _)| format!("{name:?}")).collect();
        let known = if names.is_empty() {
            "there are none".into()
        } else {
            format!("there are {}", names.join(", "))
        };
        let message = format!("no wall that bounds the fluid has this name; {known}");
        return checker.error(&format!("{path}.wall"), message);
    };
    let needs_shares =
        matches!(boundary.kind, ScalarBoundaryKind::Flux { .. } | ScalarBoundaryKind::Transfer { .. });
    if *moves && needs_shares {
        let message = "only for walls that stay where they are; take kind = \"value\" or \"insulated\"";
        checker.error(&format!("{path}.kind"), message.into());
    }
    if boundary.part.outline().is_some() {
        let message = "a condition on a wall holds on all of it; remove what tells a part of a face";
        checker.error(path, message.into());
    }
}

/// What fluid brings in must be stated.
fn check_inlets(scalar: &Scalar, path: &str, fluid: &Fluid, checker: &mut Checker) {
    let enters =
        |kind: &BoundaryKind| kind.imposes_flow() || matches!(kind, BoundaryKind::PressureInlet { .. });
    for (i, inlet) in fluid.boundary.iter().enumerate().filter(|(_, boundary)| enters(&boundary.kind)) {
        let is_value = |kind: &ScalarBoundaryKind| matches!(kind, ScalarBoundaryKind::Value { .. });
        if !scalar
            .boundary
            .iter()
            .any(|boundary| boundary.face == Some(inlet.face) && is_value(&boundary.kind))
        {
            let message = format!(
                "fluid comes in by fluid.boundary[{i}], and what it carries is not stated; add \
                 [[fluid.scalar.boundary]] with face = \"{}\", kind = \"value\" and a value",
                inlet.face.name()
            );
            return checker.error(&format!("{path}.boundary"), message);
        }
    }
}
