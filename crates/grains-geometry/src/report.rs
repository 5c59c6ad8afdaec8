//! How a shape was made, for those who check a case.

/// Where volume, centre of mass and inertia come from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MassSource {
    /// A closed form.
    #[default]
    ClosedForm,
    /// Integrals over a closed surface of triangles.
    ClosedMesh,
    /// The sum over parts that do not overlap.
    Parts,
    /// The sum over the pieces of polyhedra cut along each other's faces.
    Clipped,
    /// Chords through the union ([`MassProperties::of_chords`](crate::MassProperties::of_chords)).
    Chords {
        /// Lines per edge of the grid (-).
        lines: u32,
        /// Relative difference from the grid of half as many (-).
        error: f64,
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
    /// Volume of the union of the parts less that of the mesh, over that of the mesh (-), by chords.
    pub volume_error: f64,
    /// Whether the parts were found on disk, where an earlier decomposition had left them.
    pub cached: bool,
}
