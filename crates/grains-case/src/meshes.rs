//! The meshes of the files that a case names.

use crate::sections::shape::ShapeKind;
use crate::sections::wall::WallKind;
use grains_geometry::{
    ConvexParts, DecompositionOptions, MeshFileError, ShapeError, TriMesh, WallMesh, parse_mesh, read_mesh,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Meshes that one rank has read for all, the convex parts that it has cut them into, and the walls that one rank of each node has made of
/// them; others are read and made when they are asked for.
#[derive(Clone, Debug, Default)]
pub struct Meshes {
    files: BTreeMap<PathBuf, Arc<TriMesh>>,
    parts: BTreeMap<Decomposition, Arc<ConvexParts>>,
    walls: Vec<(WallKind, Arc<WallMesh>)>,
}

/// A mesh that is to be cut into convex parts.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Decomposition {
    /// Its file.
    pub path: PathBuf,
    /// Largest number of parts (-).
    pub max_parts: u32,
    /// Voxels along the longest edge (-).
    pub resolution: u32,
}

impl Decomposition {
    fn options(&self) -> DecompositionOptions {
        let Self { max_parts, resolution, .. } = *self;
        DecompositionOptions { max_parts, resolution, ..DecompositionOptions::default() }
    }
}

impl Meshes {
    /// The mesh of a file, welded, in the unit of the file.
    ///
    /// # Errors
    /// A file that cannot be read or holds no mesh.
    pub fn mesh(&self, path: &Path) -> Result<Arc<TriMesh>, MeshFileError> {
        match self.files.get(path) {
            Some(mesh) => Ok(Arc::clone(mesh)),
            None => Ok(Arc::new(read_mesh(path)?.mesh)),
        }
    }

    /// The convex parts of a mesh.
    ///
    /// # Errors
    /// A file that cannot be read or holds no solid.
    pub fn parts(&self, decomposition: &Decomposition) -> Result<Arc<ConvexParts>, ShapeError> {
        match self.parts.get(decomposition) {
            Some(parts) => Ok(Arc::clone(parts)),
            None => {
                let mesh = self.mesh(&decomposition.path)?;
                Ok(Arc::new(ConvexParts::of(&mesh, &decomposition.options())?))
            }
        }
    }

    /// Keeps the mesh that these bytes of a file hold; of others nothing is kept.
    pub fn keep_mesh(&mut self, path: &Path, bytes: &[u8]) {
        if let Ok(read) = parse_mesh(path, bytes) {
            self.files.insert(path.to_path_buf(), Arc::new(read.mesh));
        }
    }

    /// The mesh of a wall, if it is kept.
    pub fn wall(&self, kind: &WallKind) -> Option<Arc<WallMesh>> {
        self.walls.iter().find(|(other, _)| other == kind).map(|(_, mesh)| Arc::clone(mesh))
    }

    /// Keeps the mesh of a wall.
    pub fn keep_wall(&mut self, kind: WallKind, mesh: WallMesh) {
        self.walls.push((kind, Arc::new(mesh)));
    }

    /// Keeps the convex parts of a mesh.
    pub fn keep_parts(&mut self, decomposition: Decomposition, parts: ConvexParts) {
        self.parts.insert(decomposition, Arc::new(parts));
    }
}

impl ShapeKind {
    /// The mesh that the shape is cut from, if it is.
    pub fn decomposition(&self) -> Option<Decomposition> {
        match self {
            &Self::Mesh { ref path, max_parts, resolution, .. } => {
                Some(Decomposition { path: path.clone(), max_parts, resolution })
            }
            _ => None,
        }
    }
}
