//! Incompressible flow on a staggered Cartesian grid.

mod boundary;
mod clock;
mod error;
mod field;
mod flow;
mod grid;
mod halo;
mod limits;
mod measure;
mod metrics;
mod mixture;
mod momentum;
mod ownership;
mod pressure;
mod projection;
mod reduced;
mod step;

pub use boundary::{Boundaries, BoxFace, Condition, Patch, Profile, Side, VelocityFunction};
pub use clock::{Clock, Phase};
pub use error::{SetupError, SolveError, StepError};
pub use field::{Centre, FaceX, FaceY, FaceZ, Faces, Field, Layout, Location};
pub use flow::{Drive, Flow, FlowSetup, FlowState, StepReport};
pub use grid::{Axis, Grid};
pub use halo::Halo;
pub use limits::FlowLimits;
pub use mixture::{Mixture, MixtureModel};
pub use momentum::{Advection, Diffusion};
pub use ownership::Ownership;
pub use pressure::{
    ConjugateGradients, FastSolver, PressureOperator, PressureProblem, PressureSolver, SolveReport,
};
