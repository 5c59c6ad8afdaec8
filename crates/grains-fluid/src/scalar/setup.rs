//! What defines a scalar.

use crate::{BoxFace, Outline};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

/// A value over a part of the boundary.
#[derive(Clone)]
pub enum ScalarValue {
    /// The same everywhere.
    Uniform(f64),
    /// A function of position (m) and time (s).
    Function(Arc<dyn Fn([f64; 3], f64) -> f64 + Send + Sync>),
}

impl ScalarValue {
    /// The value at a position (m) and time (s).
    pub fn at(&self, place: [f64; 3], time: f64) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::Function(f) => f(place, time),
        }
    }
}

impl Debug for ScalarValue {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Uniform(value) => write!(f, "Uniform({value})"),
            Self::Function(_) => write!(f, "Function"),
        }
    }
}

/// What holds on a part of the boundary. Where fluid comes in it carries the value, and nothing diffuses against it; where it leaves
/// it carries its own.
#[derive(Clone, Debug, Default)]
pub enum ScalarCondition {
    /// No flux; fluid that comes in carries the value of the cell behind.
    #[default]
    Insulated,
    /// A value.
    Value(ScalarValue),
    /// A flux into the fluid (unit m/s).
    Flux(ScalarValue),
    /// A flux h (φ∞ − φ) into the fluid.
    Transfer {
        /// Transfer coefficient h (m/s).
        coefficient: f64,
        /// Value φ∞ of what is behind.
        ambient: ScalarValue,
    },
}

/// Conditions of all faces of the box; those of periodic axes are not read.
#[derive(Clone, Debug, Default)]
pub struct ScalarBoundaries {
    /// One condition per face, in the order of [`BoxFace::all`].
    pub faces: [ScalarCondition; 6],
    /// Exceptions, later ones before earlier ones, in the cells whose middle they cover.
    pub patches: Vec<(BoxFace, Outline, ScalarCondition)>,
}

/// A reaction inside a solid, which takes k cⁿ of the concentration c there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidReaction {
    /// Rate k (1/s for n = 1, else unit^(1−n)/s).
    pub rate: f64,
    /// Order n ≥ 0 (-).
    pub order: f64,
}

/// A solid that a scalar diffuses in; φ continues what it is outside: the concentration inside is K φ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior {
    /// K (-): partition coefficient, or heat capacity of the volume over that of the fluid.
    pub capacity: f64,
    /// Diffusivity of what is inside (m²/s); that of temperature is k/(ρ c).
    pub diffusivity: f64,
    /// What reacts.
    pub reaction: Option<SolidReaction>,
}

/// What holds at the surface of a solid, or in it.
#[derive(Clone, Debug)]
pub enum SolidCondition {
    /// A value on the surface.
    Value(ScalarValue),
    /// On the surface the value that the solid has, [`super::Scalar::of_solids`].
    OfSolid,
    /// A flux into the fluid (unit m/s).
    Flux(ScalarValue),
    /// A flux h (φ∞ − φ) into the fluid, φ on the surface.
    Transfer {
        /// Transfer coefficient h (m/s).
        coefficient: f64,
        /// Value φ∞ of what is behind.
        ambient: ScalarValue,
    },
    /// It diffuses inside.
    Interior(Interior),
}

impl Default for SolidCondition {
    fn default() -> Self {
        Self::Flux(ScalarValue::Uniform(0.0))
    }
}

/// Conditions of all solids; insulated where none is given.
#[derive(Clone, Debug, Default)]
pub struct SolidConditions {
    /// That of bodies.
    pub bodies: SolidCondition,
    /// Those of walls, by their numbers.
    pub walls: Vec<SolidCondition>,
    /// Value of all fluid and of the surfaces of bodies in which the scalar diffuses, if it is given: there is no film.
    pub no_film: Option<f64>,
}

impl SolidCondition {
    /// Whether nothing passes.
    pub fn is_insulated(&self) -> bool {
        match self {
            Self::Flux(ScalarValue::Uniform(flux)) => *flux == 0.0,
            Self::Transfer { coefficient, .. } => *coefficient == 0.0,
            _ => false,
        }
    }
}

impl SolidConditions {
    /// That of solid `number`, of which the first `bodies` are bodies.
    pub(super) fn of(&self, number: usize, bodies: usize) -> &SolidCondition {
        const INSULATED: &SolidCondition = &SolidCondition::Flux(ScalarValue::Uniform(0.0));
        match number.checked_sub(bodies) {
            None => &self.bodies,
            Some(wall) => self.walls.get(wall).unwrap_or(INSULATED),
        }
    }

    /// Whether shares of cells in solids count.
    pub(super) fn need_shares(&self, is_body: bool) -> bool {
        let counts = |condition: &SolidCondition| {
            !matches!(condition, SolidCondition::Value(_) | SolidCondition::OfSolid)
        };
        if is_body { counts(&self.bodies) } else { self.walls.iter().any(counts) }
    }
}

/// How a scalar moves the fluid: a force ρ β (φ₀ − φ) g.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Buoyancy {
    /// Expansion coefficient β (1/unit).
    pub expansion: f64,
    /// Value φ₀ at which the density is ρ.
    pub reference: f64,
    /// Acceleration of gravity g (m/s²).
    pub gravity: [f64; 3],
}

/// Scheme of the advection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "ScalarScheme")]
pub enum Scheme {
    /// Central where no new extremum arises.
    #[default]
    Bounded,
    /// Central.
    Central,
}

/// A scalar.
#[derive(Clone, Debug)]
pub struct ScalarSetup {
    /// Its name.
    pub name: String,
    /// Diffusivity D (m²/s).
    pub diffusivity: f64,
    /// Scheme of the advection.
    pub scheme: Scheme,
    /// Conditions on the faces of the box.
    pub boundaries: ScalarBoundaries,
    /// Conditions on solids in the fluid.
    pub solids: SolidConditions,
    /// How it moves the fluid, if it does.
    pub buoyancy: Option<Buoyancy>,
}
