//! Momentum: advection and diffusion on the staggered grid, and the implicit half of the diffusion.

mod constant;
mod explicit;
mod implicit;
mod outlet;
mod system;
mod variable;

pub(crate) use explicit::{Explicit, Porosity, RowPlace};
pub(crate) use implicit::{Implicit, imposed_increments};
pub(crate) use outlet::{FaceTerms, OutletTerms, advance_outlets};
pub(crate) use system::Capacity;

/// Scheme of the advected velocity on the faces of the control volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Advection {
    /// Mean of both sides: second order, keeps kinetic energy; needs a cell Péclet number that resolves the flow.
    #[default]
    Central,
    /// Upstream value with half the harmonic slope (van Leer): second order where smooth, no new extrema.
    VanLeer,
}

/// Treatment of the viscous term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Diffusion {
    /// Crank–Nicolson, factored by directions (Douglas–Gunn in increments): second order in time, no limit.
    #[default]
    CrankNicolson,
    /// Forward Euler within Adams–Bashforth: cheaper, the step obeys ν Δt Σ 1/Δx² ≤ 1/4.
    Explicit,
}
