//! Why particles and fluid cannot be coupled.

use thiserror::Error;

/// What a coupled case or state refuses.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CouplingError {
    /// A number out of its range.
    #[error("{quantity} is {value}, but must be {allowed}: {remedy}")]
    OutOfRange {
        /// What the value is.
        quantity: &'static str,
        /// The value.
        value: f64,
        /// Range of allowed values.
        allowed: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Particles that the fluid carries.
    #[error(
        "the particles ({solid} kg/m3) are not heavier than the fluid ({fluid} kg/m3), so that no upward flow fluidises them and they do not settle: check both densities"
    )]
    NotHeavier {
        /// Density of the particles (kg/m³).
        solid: f64,
        /// Density of the fluid (kg/m³).
        fluid: f64,
    },
    /// A kernel that would fill more cells than its list holds.
    #[error(
        "fluid.coupling.kernel.half_width: the kernel reaches {reach:.4e} m to either side and the smallest cell along {axis} is {cell:.4e} m, so that it covers up to {cells} cells, but at most {max} are allowed: take a narrower kernel or larger cells"
    )]
    TooManyCells {
        /// Axis name.
        axis: char,
        /// Half width of the kernel (m).
        reach: f64,
        /// Smallest cell (m).
        cell: f64,
        /// Cells covered.
        cells: usize,
        /// Largest number of cells allowed.
        max: usize,
    },
    /// A particle whose kernel leaves the cells of its rank and their halo.
    #[error(
        "the kernel of a particle at {axis} = {place:.6e} m reaches {reach:.4e} m to either side, beyond the cells of this rank and their halo, [{lower:.6e}, {upper:.6e}] m: the halo is too narrow, or the particle moved too far in one fluid step (take a shorter one)"
    )]
    OutsideHalo {
        /// Axis name.
        axis: char,
        /// Coordinate of the particle (m).
        place: f64,
        /// Half width of the kernel (m).
        reach: f64,
        /// Lower end of the halo (m).
        lower: f64,
        /// Upper end of the halo (m).
        upper: f64,
    },
    /// A coordinate that is no number, or an axis without cells.
    #[error("the nodes along {axis} must be finite and ascending, at least two of them: {reason}")]
    BadNodes {
        /// Axis name.
        axis: char,
        /// What is wrong.
        reason: String,
    },
    /// A cell with less room for the fluid than the laws allow.
    #[error(
        "the void fraction of the cell at {place} is {void_fraction:.4}, below the limit {limit}: the cells are too small for the kernel, or particles overlap; take larger cells, a wider kernel (fluid.coupling.kernel.half_width) or a lower limit (fluid.coupling.min_void_fraction)"
    )]
    Jammed {
        /// Void fraction (-).
        void_fraction: f64,
        /// Limit (-).
        limit: f64,
        /// Centre of the cell.
        place: String,
    },
    /// A shape whose surface cannot be measured.
    #[error("the surface of shape {shape} cannot be measured: {reason}; check the shape's parts")]
    Shape {
        /// Name of the shape.
        shape: String,
        /// Why.
        reason: String,
    },
}
