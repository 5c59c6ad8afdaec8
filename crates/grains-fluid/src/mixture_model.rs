//! Models A and B of a mixture: two ways to share the pressure gradient between fluid and particles (errata R16-38).
//!
//! With p the pressure without its hydrostatic part, F_d = β (u − v) the drag of the law, and V the particle's volume:
//!
//! | | model A | model B |
//! |---|---|---|
//! | particle | F_d − V ∇p − ρ V g | F_d/ε − ρ V g |
//! | fluid, per volume | −ε ∇p − n F_d | −∇p − n F_d/ε |
//!
//! and gravity m g on the particle in both. In a homogeneous bed at steady state they are the same: the fluid of model A has
//! −∇p = n F_d/ε, hence the force on the particle F_d + V n F_d/ε = F_d (1 + (1−ε)/ε) = F_d/ε. Where ε or the flow varies they
//! differ: model A gives a particle the pressure gradient at its own place, model B the mean one that its own drag would need.
//! The thesis (5.11, 5.12) is model B. The force of the viscous stress, V ∇·τ in a strict model A, is left out in both: it is
//! of the order of V/(cell size)² μ |u|, far below the drag.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Who carries the pressure gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MixtureModel {
    /// Both phases.
    #[default]
    A,
    /// The fluid alone; drag is divided by the void fraction.
    B,
}

impl MixtureModel {
    /// Factor on the drag of a law: 1 in model A, 1/ε in model B (-).
    pub fn drag_factor(self, void_fraction: f64) -> f64 {
        match self {
            Self::A => 1.0,
            Self::B => 1.0 / void_fraction,
        }
    }
    /// Factor on −∇p in the momentum equation of the fluid: ε in model A, 1 in model B (-).
    pub fn fluid_pressure_factor(self, void_fraction: f64) -> f64 {
        match self {
            Self::A => void_fraction,
            Self::B => 1.0,
        }
    }
}
