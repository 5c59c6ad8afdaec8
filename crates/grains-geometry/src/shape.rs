//! Shapes of particles: convex parts, mass properties and surface.

use crate::{Core, DiscreteSurface, Mat3, Rotation, ShapeReport, TriMesh, Vec3, sphere_equivalent_diameter};
use std::sync::Arc;

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
    /// Whether the origin is shifted and the axes are turned.
    pub frame: PartFrame,
    /// Half edges of the box about the part, crust included, aligned with and centred on the part frame (m).
    pub half_extents: Vec3,
    /// Radius of a ball about the part's origin that holds the part (m).
    pub bounding_radius: f64,
}

/// How the frame of a part lies in that of its body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartFrame {
    /// It is that of the body.
    OfBody,
    /// Its origin is elsewhere, its axes are those of the body.
    Shifted,
    /// Its axes are others.
    Turned,
}

impl PartFrame {
    /// The frame of an origin and a rotation in the body frame.
    pub fn of(center: &Vec3, rotation: &Mat3) -> Self {
        match (*rotation == Mat3::identity(), *center == Vec3::zeros()) {
            (true, true) => Self::OfBody,
            (true, false) => Self::Shifted,
            (false, _) => Self::Turned,
        }
    }
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
    /// The same part at another place in the body frame.
    #[must_use]
    pub fn placed(self, center: Vec3, rotation: Mat3) -> Self {
        Self { center, rotation, frame: PartFrame::of(&center, &rotation), ..self }
    }

    /// Whether a point of the part's frame (m) lies in the body with sharp edges, whose erosion the core is.
    pub fn contains(&self, point: &Vec3) -> bool {
        self.core.contains(self.crust, point)
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

    /// Radius (m) at scale 1 of the ball of the mean volume of the parts; of a sphere, its radius.
    pub fn part_radius(&self) -> f64 {
        if self.is_sphere() {
            return self.bounding_radius;
        }
        libm::cbrt(0.75 / std::f64::consts::PI * self.volume / self.parts.len() as f64)
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
