//! Shapes of particles: convex parts, mass properties and surface.

use crate::{
    Core, DiscreteSurface, GjkError, HullError, Mat3, MeshFileError, Rotation, ShapeReport, SolidError,
    TriMesh, Vec3, sphere_equivalent_diameter,
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
    /// Radius of a ball that fits in the body (m), the scale of overlaps: for a convex body about its
    /// centre of mass, for a composite the largest of its parts.
    pub inscribed_radius: f64,
    /// `(R, c)` with `x_user = R x_body + c`.
    pub user_to_body: (Rotation, Vec3),
    /// Surface for output and pictures, in the body frame; a coarse tessellation of round bodies.
    pub surface: TriMesh,
    /// How the shape was made.
    pub report: ShapeReport,
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

    /// Whether a point of the body frame (m) at scale 1 lies in the box about a part, or within a distance (m) of its faces.
    pub fn is_near(&self, point: &Vec3, distance: f64) -> bool {
        self.parts.iter().any(|part| {
            let local = part.rotation.tr_mul(&(point - part.center));
            (0..3).all(|a| local[a].abs() <= part.half_extents[a] + distance)
        })
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
