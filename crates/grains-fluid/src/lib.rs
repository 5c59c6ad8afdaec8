//! Incompressible flow on a staggered Cartesian grid, of one phase or among particles.
//!
//! ```text
//!  ∂ε/∂t + ∇·(ε u) = 0                                                       (thesis 5.10)
//!  ρ (∂(ε u)/∂t + ∇·(ε u u)) = −γ ∇p + ∇·(μ ε (∇u + ∇uᵀ)) + S − β u          (thesis 5.11)
//! ```
//!
//! with γ = ε for [`MixtureModel::A`] and 1 for B, sources S and drag coefficients β per volume of mixture, and
//! ε = γ = 1, S = β = 0 for a single phase.
//!
//! # Data
//!
//! A rank owns the cells whose centres lie in its subdomain ([`CellPartition`]), along every axis n of them and a halo of
//! h ≥ 2. All arrays have the extents n + 2 h, x fastest ([`Layout`]); the place in the cell is part of their type
//! ([`Field`]). Velocities lie on the *upper* face of their cell:
//!
//! ```text
//!        v(i,j)
//!      +---^---+       u(i) = u at node i + 1.  On the lower face of the box the velocity has index −1 and lives in
//!      |   p   > u(i,j)  the halo, on the upper one n − 1.  Ghosts: parabola through the wall and two cells for
//!      +-------+         velocities along it (Poiseuille flow is exact), mirror images for symmetry and outlets.
//! ```
//!
//! # Flow of one step
//!
//! ```text
//! predict     Δu of all faces from advection (Adams–Bashforth), diffusion, −∇p, sources: one row at a time, planes in
//!             cache; an outlet's faces have a momentum equation of their own, into which back-flow brings nothing
//! diffuse     (1 − a δx²)(1 − a δy²)(1 − a δz²) Δu, a = ν Δt/2: Thomas along lines, vectorised across them; lines that
//!             several ranks share exchange two numbers each, and are solved exactly
//! source      f = ∇·(ε u*) + ∂ε/∂t
//! solve       div(c grad φ) = f by a [`PressureSolver`]
//! correct     u = u* − γ ∇φ/m, p += φ − ½ μ ∇·u*, m = ρ ε/Δt + β; halos and ghosts
//! scalars     carried by the velocity that this leaves, bounded by flux correction ([`Scalars`])
//! ```
//!
//! Drag is implicit in m: stiff beds need no small step. Second order in time, but for the drag and the rate of change
//! of ε, backward differences of first order that keep the fluid's mass to rounding. Results depend on the number of
//! ranks by rounding (1e-13 after some steps) and the tolerance of an iterative solver.
//!
//! # How often fields pass through memory
//!
//! Arrays read + written per step, of one phase with Crank–Nicolson: predict 7 + 6, diffuse 6 + 6 (x and y while a plane
//! is in cache, then z), add 6 + 3, source 3 + 1, fast solve 3 + 3, correct 7 + 4: 55 × 8 bytes per cell, 15 ns at
//! 30 GB/s. Measured times are several times that: the step is bound by arithmetic. Its longest loops do as many
//! numbers at a time as the processor has lanes, with the same bits in any. With explicit diffusion it is 43.
//!
//! With particles: prepare 16 + 20 (void fraction on faces and edges, fluxes, diagonals, coefficients), multigrid set-up
//! 12 + 5, predict 32 + 6, diffuse 36 + 18, add 6 + 3, source 7 + 1, correct 11 + 4, remember ε 1 + 1: 179; and per
//! iteration of the pressure 26 + 8, a seventh more for the coarse grids. See `benches/mixture_speed.rs`.
//!
//! # Where to add things
//!
//! | to add | file | one line in |
//! |---|---|---|
//! | an advection scheme | `momentum/explicit.rs` | [`Advection`], in `momentum/scheme.rs` |
//! | a boundary condition | `boundary/` | [`Condition`] |
//! | a pressure solver | any crate (`grains-petsc` is one) | implement [`PressureSolver`] |
//!
//! References: Rakotonirina 2016 ("thesis"), ch. 5 and 7; Kim & Moin 1985 (factored diffusion); Brown, Cortez & Minion
//! 2001 (pressure update); Verstappen & Veldman 2003 (stretched grids).

mod anderson;
mod boundary;
mod cell_partition;
mod clock;
mod error;
mod fans;
mod field;
mod flow;
mod grid;
mod halo;
mod limits;
mod measure;
mod metrics;
mod mixture;
mod mixture_model;
mod momentum;
mod openings;
mod predict;
mod pressure;
mod projection;
mod regions;
mod scalar;
mod step;
mod tridiagonal;
mod viscosity;

pub use anderson::Anderson;
pub use boundary::{
    Boundaries, BoxFace, Condition, FanCurve, FlowRate, Outline, Patch, Profile, Side, SteadyVelocity,
    VelocityFunction,
};
pub use cell_partition::CellPartition;
pub use clock::{Clock, Phase};
pub use error::{SetupError, SolveError, StepError};
pub use field::{Centre, FaceX, FaceY, FaceZ, Faces, Field, Layout, Location, Real};
pub use flow::{
    Drive, Flow, FlowSetup, FlowState, HeldFaces, Immersed, March, SolidStresses, StepReport, ValuesOnFaces,
};
pub use grid::{Axis, Grid, clustered};
pub use halo::Halo;
pub use limits::FlowLimits;
pub use mixture::{Mixture, SolidFlux};
pub use mixture_model::MixtureModel;
pub use momentum::{Advection, Diffusion};
pub use openings::{Clearance, Enclosure, Openings};
pub use pressure::{
    ConjugateGradients, FastSolver, Preconditioner, PressureOperator, PressureProblem, PressureSolver,
    SolveReport,
};
pub use scalar::{
    BEYOND, Buoyancy, CutFace, Interior, NearCell, NearFace, Scalar, ScalarBoundaries, ScalarCondition,
    ScalarSetup, ScalarValue, Scalars, Scheme, SolidCells, SolidCellsBuilder, SolidCondition,
    SolidConditions, SolidReaction, SurfacePoint, share_in_front,
};
pub use viscosity::{
    BadValue, Bingham, HerschelBulkley, PowerLaw, Regularisation, Rheology, Smagorinsky, Turbulence,
    ViscosityLaw, Wale,
};
