//! Whether a mesh bounds a solid, and its mass properties.

use crate::mesh::ordered;
use crate::{MassProperties, TriMesh};
use std::collections::BTreeMap;
use thiserror::Error;

/// Solids of less volume than this times the cube of their size are flat.
const FLAT: f64 = 1e-9;

/// Why a mesh bounds no solid.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SolidError {
    /// A surface with holes.
    #[error(
        "the mesh is not closed: {open} of {edges} edges belong to one triangle only, one of them at {place:?} m, so that it bounds no volume: close its holes in a mesh editor"
    )]
    Open {
        /// Edges of one triangle.
        open: usize,
        /// All edges.
        edges: usize,
        /// The middle of the first of them (m).
        place: [f64; 3],
    },
    /// Triangles whose sides disagree about what is outside.
    #[error(
        "{turned} of {edges} edges are run through more often in one direction than in the other: neighbouring triangles disagree about what is outside; make the normals of the mesh consistent in a mesh editor"
    )]
    Inconsistent {
        /// Edges not run through as often in either direction.
        turned: usize,
        /// All edges.
        edges: usize,
    },
    /// A surface turned inside out.
    #[error(
        "the mesh of {triangles} triangles is inside out, its volume being {volume:.4e} m3: flip its normals in a mesh editor"
    )]
    Inverted {
        /// Triangles.
        triangles: usize,
        /// Signed volume (m^3).
        volume: f64,
    },
    /// A surface that encloses nothing, or as much inside out as not.
    #[error(
        "the mesh of {triangles} triangles encloses a volume of {volume:.4e} m3 within a size of {size:.4e} m: it is flat or overlaps itself; give a solid of one outer surface"
    )]
    Flat {
        /// Triangles.
        triangles: usize,
        /// Signed volume (m^3).
        volume: f64,
        /// Diagonal of the box around the mesh (m).
        size: f64,
    },
    /// A surface whose integrals no solid has.
    #[error(
        "the mesh of {triangles} triangles overlaps itself: its moments are those of no solid; give a solid of one outer surface"
    )]
    Impossible {
        /// Triangles.
        triangles: usize,
    },
}

/// Mass properties at unit density of the solid a mesh bounds.
///
/// Errors: a mesh with holes, inconsistent, inside out, flat or overlapping itself so much that its
/// integrals are those of no solid.
pub(crate) fn solid_mass(mesh: &TriMesh) -> Result<MassProperties, SolidError> {
    check_edges(mesh)?;
    let triangles = mesh.triangles.len();
    let mass = MassProperties::of_closed_mesh(mesh);
    let (volume, size) = (mass.volume, mesh.diagonal());
    let flat = FLAT * size.powi(3);
    if volume < -flat {
        return Err(SolidError::Inverted { triangles, volume });
    }
    // Not the opposite comparison: NaN is no volume either.
    if volume.partial_cmp(&flat) != Some(std::cmp::Ordering::Greater) {
        return Err(SolidError::Flat { triangles, volume, size });
    }
    // The second moments of a solid, tr J/2 − J, are positive along every axis; and its centre of mass
    // lies within its box.
    let half_trace = mass.inertia.trace() / 2.0;
    let second = crate::Mat3::identity() * half_trace - mass.inertia;
    let (lower, upper) = mesh.extents();
    let is_inside = (0..3).all(|a| lower[a] <= mass.center[a] && mass.center[a] <= upper[a]);
    if second.cholesky().is_none() || !is_inside || volume > (upper - lower).product() * (1.0 + 1e-9) {
        return Err(SolidError::Impossible { triangles });
    }
    Ok(mass)
}

/// Refuses meshes whose edges are not run through once in each direction.
fn check_edges(mesh: &TriMesh) -> Result<(), SolidError> {
    let mut uses: BTreeMap<(u32, u32), [usize; 2]> = BTreeMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            uses.entry(ordered(a, b)).or_default()[usize::from(a > b)] += 1;
        }
    }
    let edges = uses.len();
    let mut open = uses.iter().filter(|(_, u)| u[0] + u[1] == 1);
    if let Some(((a, b), _)) = open.next() {
        let middle = (mesh.vertices[*a as usize] + mesh.vertices[*b as usize]) * 0.5;
        return Err(SolidError::Open { open: 1 + open.count(), edges, place: middle.into() });
    }
    match uses.values().filter(|u| u[0] != u[1]).count() {
        0 => Ok(()),
        turned => Err(SolidError::Inconsistent { turned, edges }),
    }
}
