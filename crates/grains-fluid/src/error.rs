//! What can go wrong when a flow is set up, stepped or its pressure solved.

use thiserror::Error;

/// A fluid case that cannot be set up.
#[derive(Debug, Error, PartialEq, Clone)]
pub enum SetupError {
    /// The nodes of an axis do not ascend, or are fewer than two.
    #[error(
        "fluid grid along {axis}: node {index} = {value:.6e} m: nodes must be finite and ascend, at least two"
    )]
    Nodes {
        /// Axis name.
        axis: char,
        /// First node at fault.
        index: usize,
        /// Its coordinate (m).
        value: f64,
    },
    /// The grid does not cover the box of the decomposition.
    #[error(
        "fluid grid along {axis} spans {grid:?} m, the domain {domain:?} m: the fluid fills the domain, use the same corners and periodic axes"
    )]
    OtherBox {
        /// Axis name.
        axis: char,
        /// Ends of the grid (m).
        grid: [f64; 2],
        /// Ends of the box (m).
        domain: [f64; 2],
    },
    /// A subdomain has fewer cells than its halo is wide.
    #[error(
        "rank column {column} along {axis} owns {cells} fluid cells, fewer than the halo of {halo}: use smaller cells or fewer ranks along {axis}"
    )]
    TooFewCells {
        /// Axis name.
        axis: char,
        /// Place of the subdomain along the axis.
        column: usize,
        /// Cells it owns.
        cells: usize,
        /// Width of the halo (cells).
        halo: usize,
    },
    /// A halo too narrow for the stencils.
    #[error("halo = {halo} cells: the difference stencils need at least 2")]
    NarrowHalo {
        /// Width asked for (cells).
        halo: usize,
    },
    /// A 2-D axis whose two faces are not symmetry planes.
    #[error(
        "the fluid grid has one cell along {axis}: this axis must be periodic or a symmetry plane on both faces"
    )]
    OneCell {
        /// Axis name.
        axis: char,
    },
    /// A wall that would move into or out of the fluid.
    #[error(
        "wall {face}: normal velocity {speed:.4e} m/s: a boundary wall moves only along itself; use an inlet for flow through it"
    )]
    WallMovesOut {
        /// Face name.
        face: String,
        /// Velocity along the axis (m/s).
        speed: f64,
    },
    /// A patch on a face of a periodic axis, or one that covers no cell.
    #[error("patch on {face}: {reason}")]
    Patch {
        /// Face name.
        face: String,
        /// What is wrong and the remedy.
        reason: String,
    },
    /// A property that is not physical.
    #[error("{key} = {value:e}: must be {range}")]
    Value {
        /// Key of the property.
        key: &'static str,
        /// Value given.
        value: f64,
        /// Allowed range.
        range: &'static str,
    },
    /// Explicit viscous terms of a viscosity that varies.
    #[error(
        "fluid.diffusion = \"explicit\": a viscosity that varies is treated implicitly only; take \"implicit\""
    )]
    ExplicitVariable,
    /// More fluid enters than leaves.
    #[error(
        "an inlet faces a closed box: {net:.4e} m³/s enter and no pressure outlet lets them out; declare an outlet or balance the inlets"
    )]
    ClosedBox {
        /// Net volume rate into the box (m³/s).
        net: f64,
    },
    /// More fluid enters a region between walls than leaves it.
    #[error(
        "walls shut an inlet off from all outlets: {net:.4e} m³/s enter the region about {at:?} m and nothing lets them out; open a way between walls or bodies, at least a cell wide, or give this region an outlet"
    )]
    ClosedRegion {
        /// Net volume rate into the region (m³/s).
        net: f64,
        /// Centre of a cell in it (m).
        at: [f64; 3],
    },
    /// Walls leave nothing open of an inlet with a stated flow.
    #[error(
        "the flow of an inlet on {face} has nothing to go through: walls inside the flow cover all of it; move the inlet to where they leave the face open"
    )]
    CoveredInlet {
        /// Face name.
        face: String,
    },
    /// A drive along an axis on which it means nothing.
    #[error("flow rate or mean pressure gradient along {axis}: only a periodic axis can be driven so")]
    DriveNotPeriodic {
        /// Axis name.
        axis: char,
    },
    /// The pressure solver refused its coefficients.
    #[error(transparent)]
    Pressure(#[from] SolveError),
}

/// A pressure equation that was not solved.
#[derive(Debug, Error, PartialEq, Clone)]
pub enum SolveError {
    /// The iteration ended above the tolerance.
    #[error(
        "pressure: relative residual {residual:.3e} after {iterations} iterations, above {tolerance:.1e}: {reason}"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Residual over the norm of the right-hand side.
        residual: f64,
        /// Tolerance asked for.
        tolerance: f64,
        /// Likely cause and remedy.
        reason: String,
    },
    /// Without an imposed pressure, sources and sinks must balance.
    #[error(
        "pressure: the right-hand side sums to {sum:.3e} m³/s (terms {scale:.3e}), but no boundary imposes a pressure: more fluid enters than leaves; declare an outlet"
    )]
    Incompatible {
        /// Sum over all cells (m³/s).
        sum: f64,
        /// Sum of absolute values (m³/s).
        scale: f64,
    },
    /// Coefficients the solver cannot treat.
    #[error("pressure: {reason}")]
    Coefficients {
        /// What is wrong and the remedy.
        reason: String,
    },
    /// A solver library failed.
    #[error("pressure: {0}")]
    Library(String),
}

/// A step that failed.
#[derive(Debug, Error, PartialEq, Clone)]
pub enum StepError {
    /// The pressure equation was not solved.
    #[error("fluid step {step}: {source}")]
    Pressure {
        /// Number of the step.
        step: u64,
        /// What the solver said.
        source: SolveError,
    },
    /// Walls have shut off what must flow.
    #[error("fluid step {step}: {source}")]
    ShutOff {
        /// Number of the step.
        step: u64,
        /// What is shut off.
        source: SetupError,
    },
    /// A velocity that is no number.
    #[error(
        "fluid step {step}: the velocity is no longer finite (CFL {cfl:.2} at the last check): the time step {dt:.3e} s is too large; lower fluid.cfl or fluid.max_dt"
    )]
    NotFinite {
        /// Number of the step.
        step: u64,
        /// Time step (s).
        dt: f64,
        /// Courant number of the step.
        cfl: f64,
    },
    /// Void fraction outside (0, 1].
    #[error(
        "fluid step {step}: void fraction {value:.4} in cell {cell:?}: must be in (0, 1]; widen the kernel or the cells"
    )]
    VoidFraction {
        /// Number of the step.
        step: u64,
        /// Offending value.
        value: f64,
        /// Global cell.
        cell: [usize; 3],
    },
    /// Scalars that a step carries out of cells far too often.
    #[error(
        "fluid step {step}: it carries the scalars {parts:.0} times out of a cell, which holds next to no fluid: lower fluid.cfl, or take wider cells"
    )]
    Scalars {
        /// Number of the step.
        step: u64,
        /// How often.
        parts: f64,
    },
    /// A step that is not positive.
    #[error("fluid step {step}: dt = {dt:e} s: must be positive and finite")]
    TimeStep {
        /// Number of the step.
        step: u64,
        /// Value given (s).
        dt: f64,
    },
}
