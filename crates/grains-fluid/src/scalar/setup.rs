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
    /// How it moves the fluid, if it does.
    pub buoyancy: Option<Buoyancy>,
}
