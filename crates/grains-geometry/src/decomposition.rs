//! Convex parts of a mesh: approximate convex decomposition (Mamou 2016, in parry), done once at set-up
//! and kept on disk.

mod cache;
mod pieces;

use crate::error::check_length;
use crate::glued::{Component, glue};
use crate::report::{DecompositionReport, MassSource};
use crate::solid::solid_mass;
use crate::{MassProperties, Shape, ShapeError, TriMesh, Vec3};
use pieces::Pieces;
pub use pieces::catches_panics;
use std::path::PathBuf;

/// How a mesh is cut into convex parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecompositionOptions {
    /// Largest number of parts, at least 1.
    pub max_parts: u32,
    /// Voxels along the longest edge of the mesh's box, 16 to 400; cuts lie between voxels.
    pub resolution: u32,
    /// Folder where decompositions are kept, if they are; failing to write there is no error.
    pub cache: Option<PathBuf>,
}

impl Default for DecompositionOptions {
    /// 16 parts at most, 64 voxels, kept in `$XDG_CACHE_HOME/grains-mpi` or `~/.cache/grains-mpi`.
    fn default() -> Self {
        Self { max_parts: 16, resolution: 64, cache: cache::folder() }
    }
}

impl DecompositionOptions {
    fn check(&self) -> Result<(), ShapeError> {
        let range = |quantity, value: u32, allowed, is_allowed: bool, remedy| {
            let error = ShapeError::OutOfRange { quantity, value: f64::from(value), allowed, remedy };
            if is_allowed { Ok(()) } else { Err(error) }
        };
        let (parts, voxels) = (self.max_parts, self.resolution);
        range("max_parts", parts, "1 to 1024", (1..=1024).contains(&parts), "16 do for most bodies")?;
        range("resolution", voxels, "16 to 400", (16..=400).contains(&voxels), "64 do for most bodies")
    }
}

impl Shape {
    /// Solid bounded by a closed mesh, its vertices multiplied by `scale` (m per unit of the mesh), as
    /// convex parts that approximate it; volume, centre of mass and inertia are those of the mesh itself.
    ///
    /// Errors: a mesh that bounds no solid or several, options, scale or crust out of range.
    pub fn of_mesh(
        mesh: &TriMesh,
        scale: f64,
        options: &DecompositionOptions,
        crust_fraction: f64,
    ) -> Result<Self, ShapeError> {
        check_length("scale", scale)?;
        Shape::of_parts(mesh, scale, &ConvexParts::of(mesh, options)?, crust_fraction)
    }

    /// The same with the convex parts of the mesh.
    ///
    /// Errors: as for [`Shape::of_mesh`].
    pub fn of_parts(
        mesh: &TriMesh,
        scale: f64,
        ConvexParts { pieces, cached }: &ConvexParts,
        crust_fraction: f64,
    ) -> Result<Self, ShapeError> {
        check_length("scale", scale)?;
        let scaled = TriMesh {
            vertices: mesh.vertices.iter().map(|v| v * scale).collect(),
            triangles: mesh.triangles.clone(),
        };
        let (mass, area) = (solid_mass(&scaled)?, scaled.area());
        let (middle, size) = middle_and_size(&scaled);
        let components = pieces.hulls.iter().map(|hull| {
            let corners: Vec<Vec3> = hull.iter().map(|v| v * size + middle).collect();
            Ok(Component::new(Shape::hull(&corners, crust_fraction)?, Vec3::zeros()))
        });
        let components = components.collect::<Result<Vec<_>, ShapeError>>()?;
        let mut shape = glue(&components, crust_fraction, Some((mass, MassSource::ClosedMesh)))?;
        shape.report.decomposition = Some(DecompositionReport {
            triangles: mesh.triangles.len(),
            area,
            pieces: pieces.found,
            merged: pieces.merged,
            dropped: pieces.dropped,
            volume_error: MassProperties::of_chords(&shape.parts).0.volume / mass.volume - 1.0,
            cached: *cached,
        });
        Ok(shape.named("mesh"))
    }
}

/// The convex parts that approximate a mesh, whatever its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexParts {
    /// Of the mesh, moved to the origin and of unit size.
    pieces: Pieces,
    /// Whether they were on disk.
    cached: bool,
}

impl ConvexParts {
    /// Those of a closed mesh, from disk if they are kept there.
    ///
    /// Errors: a mesh that bounds no solid or several, options out of range.
    pub fn of(mesh: &TriMesh, options: &DecompositionOptions) -> Result<Self, ShapeError> {
        options.check()?;
        solid_mass(mesh)?;
        // The decomposition has absolute tolerances, made for bodies of unit size.
        let (middle, size) = middle_and_size(mesh);
        let unit = TriMesh {
            vertices: mesh.vertices.iter().map(|v| (v - middle) / size).collect(),
            triangles: mesh.triangles.clone(),
        };
        let file = options.cache.as_ref().map(|folder| folder.join(cache::file_name(&unit, options)));
        if let Some(pieces) = file.as_deref().and_then(cache::load) {
            return Ok(Self { pieces, cached: true });
        }
        let pieces = Pieces::of(&unit, options).ok_or(ShapeError::Decomposition {
            triangles: unit.triangles.len(),
            resolution: options.resolution,
        })?;
        if let Some(file) = &file {
            cache::store(file, &pieces);
        }
        Ok(Self { pieces, cached: false })
    }

    /// The parts as bytes, for other processes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = cache::encode(&self.pieces);
        bytes.push(u8::from(self.cached));
        bytes
    }

    /// What [`ConvexParts::bytes`] made; `None` of others.
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let (cached, pieces) = bytes.split_last()?;
        Some(Self { pieces: cache::decode(pieces)?, cached: *cached == 1 })
    }
}

/// Middle and longest edge of the box around a mesh.
fn middle_and_size(mesh: &TriMesh) -> (Vec3, f64) {
    let (lower, upper) = mesh.extents();
    ((lower + upper) / 2.0, (upper - lower).max())
}
