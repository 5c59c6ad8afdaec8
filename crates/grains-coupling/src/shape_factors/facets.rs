//! Areas of a convex body from its faces.

use grains_geometry::{TriMesh, Vec3};
use std::f64::consts::FRAC_1_PI;

/// Faces whose unit normals differ by less are parallel.
const PARALLEL: f64 = 1e-9;

/// Vector areas of the faces of a convex body, parallel ones, also of opposite sides, summed up.
#[derive(Clone, Debug, Default)]
pub(super) struct Facets {
    /// Components of A n (m²).
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    /// A² (m⁴).
    squares: Vec<f64>,
}

impl Facets {
    /// The faces of a closed convex surface.
    pub(super) fn of_mesh(mesh: &TriMesh) -> Self {
        let triangles = (0..mesh.triangles.len()).map(|t| vector_area(&mesh.corners(t)));
        let mut facets: Vec<Vec3> = Vec::new();
        for area in triangles.filter(|a| a.norm_squared() > 0.0) {
            let normal = area.normalize();
            let same = |f: &Vec3| normal.cross(&f.normalize()).norm() < PARALLEL;
            match facets.iter_mut().find(|f| same(f)) {
                Some(facet) => *facet += if facet.dot(&area) < 0.0 { -area } else { area },
                None => facets.push(area),
            }
        }
        Self::from_areas(&facets)
    }

    /// All triangles of a surface, whether parallel or not.
    pub(super) fn of_triangles(mesh: &TriMesh) -> Self {
        let areas: Vec<Vec3> = (0..mesh.triangles.len()).map(|t| vector_area(&mesh.corners(t))).collect();
        Self::from_areas(&areas)
    }

    fn from_areas(areas: &[Vec3]) -> Self {
        Self {
            x: areas.iter().map(|a| a.x).collect(),
            y: areas.iter().map(|a| a.y).collect(),
            z: areas.iter().map(|a| a.z).collect(),
            squares: areas.iter().map(|a| a.norm_squared()).collect(),
        }
    }

    /// Number of directions of faces.
    pub(super) fn len(&self) -> usize {
        self.x.len()
    }

    /// Σ A (m²).
    pub(super) fn surface(&self) -> f64 {
        self.squares.iter().map(|s| s.sqrt()).sum()
    }

    /// Projected and longitudinal area (m²) along the unit direction `d`.
    pub(super) fn areas(&self, d: &Vec3) -> [f64; 2] {
        let (mut projected, mut longitudinal) = (0.0, 0.0);
        let components = self.x.iter().zip(&self.y).zip(&self.z);
        for (((x, y), z), square) in components.zip(&self.squares) {
            let along = x * d.x + y * d.y + z * d.z;
            projected += along.abs();
            longitudinal += (square - along * along).max(0.0).sqrt();
        }
        [0.5 * projected, FRAC_1_PI * longitudinal]
    }

    /// Projected area (m²) alone.
    pub(super) fn projected_area(&self, d: &Vec3) -> f64 {
        let components = self.x.iter().zip(&self.y).zip(&self.z);
        0.5 * components.map(|((x, y), z)| (x * d.x + y * d.y + z * d.z).abs()).sum::<f64>()
    }
}

/// Area of a triangle times its normal (m²).
pub(super) fn vector_area([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)) * 0.5
}
