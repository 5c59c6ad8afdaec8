//! Shapes of particles: convex parts, mass properties and surface.

use crate::{
    Core, DiscreteSurface, HullError, Mat3, MeshFileError, Rotation, TriMesh, Vec3,
    sphere_equivalent_diameter,
};
use std::ops::RangeInclusive;
use std::sync::Arc;
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
}

/// A convex part of a shape: a core swept by a ball of radius `crust`, at scale 1.
#[derive(Clone, Debug)]
pub struct Part {
    /// The body eroded by the crust, in the part frame.
    pub core: Core,
    /// Radius of the ball swept over the core (m).
    pub crust: f64,
    /// Origin of the part frame in the body frame (m).
    pub center: Vec3,
    /// Rotation from the part frame to the body frame.
    pub rotation: Mat3,
    /// Half edges of the box about the part, crust included, aligned with and centred on the part frame (m).
    pub half_extents: Vec3,
    /// Radius of a ball about the part's origin that holds the part (m).
    pub bounding_radius: f64,
}

/// A particle shape at scale 1, in its body frame: principal axes at the centre of mass.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Name used in messages and output.
    pub name: String,
    /// Convex parts, one unless the shape is glued.
    pub parts: Vec<Part>,
    /// Volume of the body with sharp edges (m^3).
    pub volume: f64,
    /// Principal moments of inertia for unit density (m^5).
    pub inertia: Vec3,
    /// Radius of a ball about the centre of mass that holds the body (m).
    pub bounding_radius: f64,
    /// Radius of a ball about the centre of mass that fits in the body (m).
    pub inscribed_radius: f64,
    /// `(R, c)` with `x_user = R x_body + c`.
    pub user_to_body: (Rotation, Vec3),
    /// Surface for output and pictures, in the body frame; a coarse tessellation of round bodies.
    pub surface: TriMesh,
    /// Vertices that find contacts in place of the parts, if the shape asks for it (Srinivasan 2019, 2.4).
    pub discrete: Option<Arc<DiscreteSurface>>,
}

impl Part {
    /// Whether a point of the part's frame (m) lies in the body with sharp edges, whose erosion the core is.
    pub fn contains(&self, point: &Vec3) -> bool {
        match &self.core {
            Core::Point => point.norm_squared() <= self.crust * self.crust,
            Core::Box(half) => (0..3).all(|a| point[a].abs() <= half[a] + self.crust),
            Core::Cylinder { radius, half_height } => {
                point.z.abs() <= half_height + self.crust && point.x.hypot(point.y) <= radius + self.crust
            }
            Core::Polyhedron(hull) => {
                hull.faces().iter().all(|face| face.normal.dot(point) <= face.offset + self.crust)
            }
            Core::Triangle(_) => false,
            Core::Superellipsoid(body) => body.inside_outside(point) <= 1.0,
        }
    }
}

impl Shape {
    /// Whether a point of the body frame (m) at scale 1 lies in the body.
    pub fn contains(&self, point: &Vec3) -> bool {
        self.parts.iter().any(|part| part.contains(&part.rotation.tr_mul(&(point - part.center))))
    }

    /// Whether the shape is a single sphere.
    pub fn is_sphere(&self) -> bool {
        matches!(self.parts.as_slice(), [Part { core: Core::Point, .. }])
    }

    /// Diameter of the sphere of the same volume (m).
    pub fn sphere_equivalent_diameter(&self) -> f64 {
        sphere_equivalent_diameter(self.volume)
    }

    /// The same shape under another name.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
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
