//! Why shapes cannot be made and queries fail.

use crate::{HullError, MeshFileError, SolidError};
use std::fmt::Debug;
use std::ops::RangeInclusive;
use thiserror::Error;

/// Why a shape cannot be made.
#[derive(Debug, Error)]
pub enum ShapeError {
    /// A dimension out of its range.
    #[error("{quantity} is {value}, but must be {allowed}: {remedy}")]
    OutOfRange {
        /// What the value is.
        quantity: &'static str,
        /// The value given.
        value: f64,
        /// Range of allowed values.
        allowed: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Vertices without a usable convex hull.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// An unreadable mesh file.
    #[error(transparent)]
    File(#[from] MeshFileError),
    /// A mesh that bounds no solid.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// Mass properties that no solid has, NaN among them.
    #[error(
        "volume {volume:e} m3 and principal moments of inertia {x:e}, {y:e}, {z:e} m5 are those of no solid: correct the vertices or the parts"
    )]
    Mass {
        /// Volume (m^3).
        volume: f64,
        /// Smallest principal moment of inertia for unit density (m^5).
        x: f64,
        /// The next (m^5).
        y: f64,
        /// Largest (m^5).
        z: f64,
    },
    /// A union whose mass properties cannot be resolved.
    #[error(
        "volume and inertia of the union are uncertain by {error:.1e} with {lines} chords per edge, but must be known to 2e-3: give thicker parts, or parts that only touch"
    )]
    Unresolved {
        /// Estimated relative error (-).
        error: f64,
        /// Chords along either edge of the finest grid (-).
        lines: u32,
    },
    /// A composite of nothing.
    #[error("a composite needs at least one part, but none is given: add parts")]
    NoComponents,
    /// A component that is a composite itself.
    #[error("{component} is a composite itself, but only convex bodies can be glued: list its parts instead")]
    NotConvex {
        /// The component.
        component: String,
    },
    /// Components that form more than one body.
    #[error(
        "the parts do not form one body: {apart} lie apart, for the gap between {inside} and {outside} is {gap:.4e} m: move them together until they touch"
    )]
    Apart {
        /// The components that form a body of their own.
        apart: String,
        /// The one of them nearest to the others.
        inside: String,
        /// The other one nearest to it.
        outside: String,
        /// Gap between the two (m).
        gap: f64,
    },
    /// Lobes whose neighbours do not meet.
    #[error(
        "the {count} lobes do not meet: their centres lie {offset:.4e} m from the axis, which leaves a lobe radius of {lobe_radius:.4e} m within the circumscribed radius {radius:.4e} m, but neighbouring centres are {spacing:.4e} m apart: take an offset below {largest:.4e} m, or an area_fraction of {lowest:.4} to 1"
    )]
    OpenLobes {
        /// Number of lobes.
        count: u32,
        /// Distance of the lobes' centres from the axis (m).
        offset: f64,
        /// Radius of a lobe (m).
        lobe_radius: f64,
        /// Radius of the circumscribed circle (m).
        radius: f64,
        /// Distance of neighbouring centres (m).
        spacing: f64,
        /// Offset at which neighbours just meet (m).
        largest: f64,
        /// Area fraction at which neighbours just meet (-).
        lowest: f64,
    },
    /// Lobes that cannot fill the circle as wanted.
    #[error(
        "area_fraction = {fraction} of {count} lobes must be at least {lowest:.4}, where neighbouring lobes just meet, and below 1: take one of this range"
    )]
    AreaFraction {
        /// Number of lobes.
        count: u32,
        /// Area fraction wanted (-).
        fraction: f64,
        /// Area fraction at which neighbours just meet (-).
        lowest: f64,
    },
    /// A mesh that the convex decomposition cannot cut.
    #[error(
        "the mesh of {triangles} triangles cannot be cut into convex parts at a resolution of {resolution} voxels: raise `resolution`, repair the mesh, or take its convex hull"
    )]
    Decomposition {
        /// Triangles.
        triangles: usize,
        /// Voxels along the longest edge.
        resolution: u32,
    },
    /// Two components whose distance cannot be found.
    #[error(transparent)]
    Distance(#[from] GjkError),
}

/// A query that found no answer it could vouch for.
#[derive(Debug, Error)]
#[error(
    "{query} of two cores did not converge: bounds differ by {gap:e} m after {iterations} iterations; \
     {pair}; check the shapes for zero extent and the placement for NaN"
)]
pub struct GjkError {
    /// What was asked: "distance" or "penetration".
    pub query: &'static str,
    /// Upper less lower bound of the distance when the query gave up (m).
    pub gap: f64,
    /// Iterations done.
    pub iterations: usize,
    /// The two cores and the placement of the second in the frame of the first.
    pub pair: Box<str>,
}

impl GjkError {
    /// The error of a query about cores A and B that left a gap (m) after so many iterations.
    pub(crate) fn new(
        query: &'static str,
        (gap, iterations): (f64, usize),
        (a, b, placement): (&impl Debug, &impl Debug, &impl Debug),
    ) -> Self {
        let pair = format!("A = {a:?}, B = {b:?}, {placement:?}").into();
        Self { query, gap, iterations, pair }
    }
}

/// Refuses lengths that are not positive and finite.
pub(crate) fn check_length(quantity: &'static str, value: f64) -> Result<(), ShapeError> {
    // Beyond this range volumes and inertias (m^5) would leave the range of f64.
    const RANGE: RangeInclusive<f64> = 1e-50..=1e50;
    if RANGE.contains(&value) {
        return Ok(());
    }
    let remedy = "give a length in metres";
    Err(ShapeError::OutOfRange { quantity, value, allowed: "positive and finite", remedy })
}

/// Crust thickness for a part whose inscribed radius is given (m).
pub(crate) fn crust_thickness(crust_fraction: f64, inscribed_radius: f64) -> Result<f64, ShapeError> {
    if crust_fraction > 0.0 && crust_fraction <= 0.5 {
        return Ok(crust_fraction * inscribed_radius);
    }
    Err(ShapeError::OutOfRange {
        quantity: "crust_fraction (crust / inscribed radius)",
        value: crust_fraction,
        allowed: "in (0, 0.5]",
        remedy: "try 0.02: thicker than the largest overlap, thin enough to keep edges sharp",
    })
}
