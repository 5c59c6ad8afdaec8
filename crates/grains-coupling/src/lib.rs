//! Particles in a fluid that does not resolve them: drag laws, kernels between particles and cells, and the exchange of
//! momentum (Rakotonirina 2016, ch. 5, section 4.3, eqs 5.10-5.18; errata R16-37 to R16-41; Srinivasan 2019, 4.1.2).
//!
//! The crate knows the particles, but of the fluid only arrays: velocities on faces, void fraction in cells
//! ([`FluidFields`]), and where their values lie ([`Grid`]).
//!
//! # One step of the fluid, from tⁿ to tⁿ + Δt
//!
//! ```text
//! deposit_volume   solid volume → cells; halo add; ε = 1 − solid/V; halo exchange of ε
//! deposit_drag     K and K v̂ − unpaid/Δt → faces; halo add
//! (fluid)          (ρ ε/Δt + B) u = … + S                with B = ΣwK/V_f, S = Σw(K v̂ − unpaid/Δt)/V_f
//! (boundary)       where a boundary of the domain bears the drag of its half cell, ∇p is what balances it
//! set_fluid_velocities u at each particle, by the same weights but without the faces on boundaries, and ∇p; what the fluid has
//!                  paid in advance becomes unpaid
//! add_drag         in each DEM step, between its forces and its advance: exact relaxation towards u
//! ```
//!
//! # Why it is stable and keeps momentum
//!
//! *Linear drag.* At tⁿ the drag is made linear in the slip by Newton's tangent: with β ∝ |u − v|^p and the slip
//! s = uⁿ − vⁿ, F = K (u − v − l), K = β (1 + p), l = p/(1 + p) s. It is exact in steady state and by Stokes, and
//! converges there for steps much longer than the relaxation time, where a lagged β would oscillate for ever.
//!
//! *Fluid first, implicitly.* The fluid sees all particles at their velocities v̂ = vⁿ + l, its own at the new time. It
//! pays each particle in advance the impulse J* = K (uⁿ⁺¹ − v̂) Δt, whatever the particle will make of it. Then the
//! particle integrates m dv/dt = F_other + K (u − l − v) exactly over each DEM step, at the fluid velocity it was given,
//! and gets the impulse J. The difference J − J* is *unpaid*: it goes to the fluid in the next step, explicitly, at
//! the particle's new place. With x = K Δt/m and y = K Δt/m_fluid the slip of free particles falls by
//! ((1 − xE) + y (1 − E))/(1 + y) per step, E = (1 − e^−x)/x, which lies between 0 and 1 for all x and y: neither
//! stiff drag on light grains nor heavy loading of a light gas can oscillate. Grains held by contacts give 1/(1 + y).
//! Steady states are exact for any Δt.
//!
//! *Ledger.* At any time: given to particles = taken from the fluid + unpaid, to rounding ([`MomentumLedger`]). What is
//! unpaid is O(Δt) and lives with the particle ([`DragLink`], its cargo: [`grains_dem::Particles::carry`]), which takes it along to other
//! ranks; a checkpoint must hold it. A particle that leaves the domain takes it out. The reaction to the pressure-gradient force of model A
//! is the factor ε of ∇p in the fluid, and part of no ledger.
//!
//! The velocity given must be the one that multiplies B in the fluid's update. A projection method has it if the pressure
//! correction too divides by ρ ε/Δt + B, which is also what makes the split scheme accurate in dense beds.
//!
//! # Many ranks
//!
//! Each rank deposits the particles it *owns*; clones deposit nothing, for their owner does. A kernel may
//! reach into the halo: after a deposit the fluid *adds* its halo to the cells of the neighbours it belongs to, the
//! reverse of the exchange that fills it. Periodic images are halo cells like any others. A
//! particle may have left its rank's box since it last migrated, so the halo must hold the kernel's reach and this
//! way ([`Kernel::halo`]); a kernel that leaves it is an error, not a loss. Nothing beyond a boundary of the domain
//! is halo: kernels are mirrored there. Sums over particles are made in the order of the rank's particles, so results
//! on other numbers of ranks differ by rounding.

mod coupling;
mod drag;
mod error;
mod exchange;
mod fluidisation;
mod kernel;
mod shape_factors;
mod transfer;

pub use coupling::{Coupling, DragFields, FluidFields, Grid, OpenShares, buoyancy, void_fractions};
pub use drag::{Coefficient, DragLaw, Flow, Fluid};
pub use error::CouplingError;
pub use exchange::{
    DragLink, MomentumLedger, add_drag, boundary_gradient, impulse_taken, relaxation, unpaid_impulse,
};
pub use fluidisation::Bed;
pub use kernel::{End, GridAxis, Kernel, Layout, MAX_CELLS, Site, SiteWeights, Stencil};
pub use shape_factors::{ShapeFactors, ShapeProfile, TableError};
pub use transfer::{Passing, TransferLaw, TransferLink, effectiveness};
