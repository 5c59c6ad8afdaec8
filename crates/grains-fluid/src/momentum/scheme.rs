//! The schemes of the advective and viscous terms.
//!
//! Central advection takes the mean of both sides: it keeps kinetic energy, and needs a cell Péclet number that resolves the
//! flow. Van Leer's takes the upstream value with half the harmonic slope: second order where smooth, no new extrema. Implicit
//! diffusion is Crank–Nicolson factored by directions (Douglas–Gunn in increments); explicit diffusion is forward Euler within
//! Adams–Bashforth, and its step obeys ν Δt Σ 1/Δx² ≤ 1/4.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Scheme of the advective terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Advection {
    /// Central differences, second order.
    #[default]
    Central,
    /// Bounded by the limiter of van Leer, for cells that do not resolve the flow.
    VanLeer,
}

/// Treatment of the viscous terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Diffusion {
    /// Crank–Nicolson: no limit of the time step.
    #[default]
    Implicit,
    /// Adams–Bashforth.
    Explicit,
}
