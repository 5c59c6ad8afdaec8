//! Momentum: advection and diffusion on the staggered grid, and the implicit half of the diffusion.

mod constant;
mod explicit;
mod implicit;
mod outlet;
mod scheme;
mod system;
mod transposed;
mod variable;

pub(crate) use explicit::{Explicit, RowPlace, StressWeights};
pub(crate) use implicit::{Implicit, imposed_increments};
pub(crate) use outlet::{FaceTerms, OutletTerms, advance_outlets};
pub use scheme::{Advection, Diffusion};
pub(crate) use system::MomentumDiagonal;
