//! How a shape was made, for those who check a case.

use crate::{MassProperties, Shape};

/// Where volume, centre of mass and inertia come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MassSource {
    /// A closed form.
    #[default]
    ClosedForm,
    /// Integrals over a closed surface of triangles.
    ClosedMesh,
    /// The sum over parts that do not overlap.
    Parts,
    /// The pixel rule ([`MassProperties::of_pixels`]).
    Pixels {
        /// Cells per direction (-).
        cells: u32,
    },
}

/// How a shape was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeReport {
    /// Where the mass properties come from.
    pub mass: MassSource,
    /// How a mesh was cut into convex parts, if it was.
    pub decomposition: Option<DecompositionReport>,
}

/// How a mesh was cut into convex parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DecompositionReport {
    /// Triangles of the mesh (-).
    pub triangles: usize,
    /// Area of the mesh (m²).
    pub area: f64,
    /// Convex pieces the decomposition found (-).
    pub pieces: usize,
    /// Unions of two pieces made to keep to the largest number of parts (-).
    pub merged: usize,
    /// Pieces dropped because they are flat or tiny (-).
    pub dropped: usize,
    /// Volume of the union of the parts less that of the mesh, over that of the mesh (-), by the pixel rule.
    pub volume_error: f64,
    /// Whether the parts were found on disk, where an earlier decomposition had left them.
    pub cached: bool,
}

/// The pixel rule beside the mass properties a shape keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassReport {
    /// Where the mass properties of the shape come from.
    pub source: MassSource,
    /// Cells per direction of the pixel rule (-).
    pub cells: u32,
    /// Volume by the pixel rule less that of the shape, over that of the shape (-).
    pub volume_difference: f64,
    /// Largest such difference of a principal moment of inertia (-).
    pub inertia_difference: f64,
}

impl Shape {
    /// Compares the mass properties with those of the pixel rule on the parts.
    pub fn mass_report(&self, cells: u32) -> MassReport {
        let pixels = MassProperties::of_pixels(&self.parts, cells);
        let relative = |a: usize| pixels.inertia[(a, a)] / self.inertia[a] - 1.0;
        let worst = (0..3).map(relative).fold(0.0, |w: f64, r| if r.abs() > w.abs() { r } else { w });
        MassReport {
            source: self.report.mass,
            cells,
            volume_difference: pixels.volume / self.volume - 1.0,
            inertia_difference: worst,
        }
    }
}
