//! Meshes of a script: where its words put them, and their files.

use crate::error::ImportError;
use grains_geometry::mesh_file::{parse_stl, read_mesh, write_stl};
use grains_geometry::{Rotation, TriMesh, Vec3};
use nalgebra::Unit;
use std::fs;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A mesh as a file has it, scaled, turned and moved: x = s R X + t.
#[derive(Clone, Debug)]
pub struct PlacedMesh {
    /// The file.
    pub path: PathBuf,
    /// Factor s (m per unit of the file).
    pub scale: f64,
    /// Rotation R.
    pub rotation: Rotation,
    /// Translation t (m).
    pub translation: Vec3,
}

impl PlacedMesh {
    /// The mesh of a file whose unit is so many metres.
    pub fn new(path: PathBuf, unit: f64) -> Self {
        Self { path, scale: unit, rotation: Rotation::identity(), translation: Vec3::zeros() }
    }

    /// Moves it (m).
    pub fn shift(&mut self, by: [f64; 3]) {
        self.translation += Vec3::from(by);
    }

    /// Scales it about the origin.
    pub fn magnify(&mut self, factor: f64) {
        self.scale *= factor;
        self.translation *= factor;
    }

    /// Turns it about an axis through a point (m) by an angle (rad).
    pub fn turn(&mut self, point: [f64; 3], axis: [f64; 3], angle: f64) {
        let point = Vec3::from(point);
        let turn = Rotation::from_axis_angle(&Unit::new_normalize(Vec3::from(axis)), angle);
        self.rotation = turn * self.rotation;
        self.translation = point + turn * (self.translation - point);
    }

    /// The triangles (m).
    ///
    /// # Errors
    /// A file that is missing or no STL or OBJ.
    pub fn triangles(&self) -> Result<TriMesh, String> {
        // Not welded: an insertion face may be any triangles.
        let is_stl = self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("stl"));
        let mesh = match is_stl {
            true => fs::read(&self.path)
                .map_err(|e| e.to_string())
                .and_then(|bytes| parse_stl(&bytes).map_err(|e| e.to_string())),
            false => read_mesh(&self.path).map(|m| m.mesh).map_err(|e| e.to_string()),
        };
        let mesh = mesh.map_err(|e| format!("mesh {}: {e}", self.path.display()))?;
        Ok(mesh.transformed(&self.rotation, self.scale, &self.translation))
    }

    /// Writes the mesh to `to` as a case needs it, and says by which scale and translation (m) the case must place it: a mesh that is
    /// not turned is copied as it is.
    ///
    /// # Errors
    /// Files that cannot be read or written.
    pub fn write(&self, to: &Path) -> Result<(f64, [f64; 3]), ImportError> {
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder).map_err(ImportError::write(folder))?;
        }
        if self.rotation.angle() == 0.0 {
            fs::copy(&self.path, to).map_err(ImportError::write(to))?;
            return Ok((self.scale, self.translation.into()));
        }
        let mesh = self.triangles().map_err(ImportError::Case)?;
        let file = fs::File::create(to).map_err(ImportError::write(to))?;
        write_stl(&mut BufWriter::new(file), &mesh).map_err(ImportError::write(to))?;
        Ok((1.0, [0.0; 3]))
    }
}
