//! Triangle meshes: welding, triangulation of polygons, and geometry checks.

use crate::{Rotation, Vec3};
use std::collections::{BTreeMap, HashMap};
use thiserror::Error;

/// Default welding tolerance, relative to the diagonal of the mesh: just above the rounding of the
/// 32-bit coordinates of a binary STL file.
pub const WELD_TOLERANCE: f64 = 1e-7;

/// Why vertices and faces form no mesh.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// A face names a vertex that does not exist.
    #[error(
        "face {face} names vertex {vertex}, but there are {count} vertices, counted from 0: correct the face"
    )]
    NoSuchVertex {
        /// Index of the face.
        face: usize,
        /// Vertex it names.
        vertex: usize,
        /// Vertices given.
        count: usize,
    },
    /// A face with fewer than three vertices.
    #[error("face {face} has {count} vertices, but a face needs at least 3: correct or remove it")]
    TooFewCorners {
        /// Index of the face.
        face: usize,
        /// Vertices it names.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite: correct it")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// No triangle of non-zero area.
    #[error(
        "the mesh has no triangle of non-zero area ({degenerate} degenerate ones dropped): check its vertices and units"
    )]
    Empty {
        /// Triangles dropped.
        degenerate: usize,
    },
}

/// Triangles over shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Positions (m).
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// What welding changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WeldReport {
    /// Vertices merged into others.
    pub merged_vertices: usize,
    /// Triangles dropped because a height of theirs is below the tolerance.
    pub degenerate_triangles: usize,
}

/// Quality of a mesh as a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshReport {
    /// Edges of one triangle only (a closed surface has none).
    pub open_edges: usize,
    /// Edges of three or more triangles.
    pub non_manifold_edges: usize,
    /// Lower corner of the axis-aligned box around the mesh (m).
    pub lower: Vec3,
    /// Upper corner of that box (m).
    pub upper: Vec3,
    /// Triangle of the smallest area.
    pub smallest_triangle: usize,
    /// Its area (m^2).
    pub smallest_area: f64,
    /// Sum of all areas (m^2).
    pub area: f64,
}

impl TriMesh {
    /// Mesh from vertices (m) and polygons of vertex indices, cut into triangles.
    ///
    /// Errors: a polygon with fewer than three vertices or naming a vertex that does not exist.
    pub fn from_polygons(vertices: Vec<Vec3>, polygons: &[Vec<usize>]) -> Result<Self, MeshError> {
        let count = vertices.len();
        if let Some(vertex) = vertices.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
            return Err(MeshError::NotFinite { vertex });
        }
        let mut triangles = Vec::new();
        for (face, polygon) in polygons.iter().enumerate() {
            if polygon.len() < 3 {
                return Err(MeshError::TooFewCorners { face, count: polygon.len() });
            }
            if let Some(&vertex) = polygon.iter().find(|&&v| v >= count) {
                return Err(MeshError::NoSuchVertex { face, vertex, count });
            }
            triangles.extend(cut_ears(&vertices, polygon));
        }
        Ok(TriMesh { vertices, triangles })
    }

    /// Corners of a triangle (m).
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// Lower and upper corner of the axis-aligned box around the vertices (m).
    pub fn extents(&self) -> (Vec3, Vec3) {
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        self.vertices.iter().fold(start, |(lower, upper), v| (lower.inf(v), upper.sup(v)))
    }

    /// Diagonal of the box around the vertices (m).
    pub fn diagonal(&self) -> f64 {
        let (lower, upper) = self.extents();
        if self.vertices.is_empty() { 0.0 } else { (upper - lower).norm() }
    }

    /// Area of the triangles (m²).
    pub fn area(&self) -> f64 {
        let twice = |[a, b, c]: [Vec3; 3]| (b - a).cross(&(c - a)).norm();
        (0..self.triangles.len()).map(|t| 0.5 * twice(self.corners(t))).sum()
    }

    /// Copy with every vertex x replaced by `scale * (rotation x) + translation`.
    pub fn transformed(&self, rotation: &Rotation, scale: f64, translation: &Vec3) -> Self {
        let vertices = self.vertices.iter().map(|v| rotation * v * scale + translation).collect();
        TriMesh { vertices, triangles: self.triangles.clone() }
    }

    /// Merges vertices closer than `tolerance` times the diagonal, then drops triangles with a height
    /// below that distance and vertices no triangle uses.
    ///
    /// Tolerances below 1e-12 act as 1e-12. The first of coincident vertices stays in place. Errors: a coordinate not finite, no triangle left.
    pub fn welded(&self, tolerance: f64) -> Result<(Self, WeldReport), MeshError> {
        if let Some(vertex) = self.vertices.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
            return Err(MeshError::NotFinite { vertex });
        }
        let distance = tolerance.max(1e-12) * self.diagonal();
        let leader = leaders(&self.vertices, distance);
        let merged_vertices = leader.iter().enumerate().filter(|(i, l)| *i as u32 != **l).count();
        let kept: Vec<[u32; 3]> = self
            .triangles
            .iter()
            .map(|t| t.map(|v| leader[v as usize]))
            .filter(|t| smallest_height(&t.map(|v| self.vertices[v as usize])) > distance)
            .collect();
        let degenerate_triangles = self.triangles.len() - kept.len();
        if kept.is_empty() {
            return Err(MeshError::Empty { degenerate: degenerate_triangles });
        }
        Ok((compacted(&self.vertices, &kept), WeldReport { merged_vertices, degenerate_triangles }))
    }

    /// Counts open and non-manifold edges and measures extents and areas.
    pub fn report(&self) -> MeshReport {
        let mut uses: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        for t in &self.triangles {
            for k in 0..3 {
                *uses.entry(ordered(t[k], t[(k + 1) % 3])).or_default() += 1;
            }
        }
        let (lower, upper) = self.extents();
        let areas: Vec<f64> = (0..self.triangles.len()).map(|t| area(&self.corners(t))).collect();
        let smallest_triangle = (0..areas.len()).min_by(|&a, &b| areas[a].total_cmp(&areas[b])).unwrap_or(0);
        MeshReport {
            open_edges: uses.values().filter(|&&n| n == 1).count(),
            non_manifold_edges: uses.values().filter(|&&n| n > 2).count(),
            lower,
            upper,
            smallest_triangle,
            smallest_area: areas.get(smallest_triangle).copied().unwrap_or(0.0),
            area: areas.iter().sum(),
        }
    }
}

/// The two indices in ascending order.
pub(crate) fn ordered(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// Area of a triangle (m^2).
fn area(p: &[Vec3; 3]) -> f64 {
    (p[1] - p[0]).cross(&(p[2] - p[0])).norm() / 2.0
}

/// Height of a triangle over its longest edge (m); 0 if two corners coincide.
pub(crate) fn smallest_height(p: &[Vec3; 3]) -> f64 {
    let longest = (0..3).map(|k| (p[(k + 1) % 3] - p[k]).norm()).fold(0.0, f64::max);
    if longest > 0.0 { 2.0 * area(p) / longest } else { 0.0 }
}

/// For each vertex, the first vertex within `distance` that leads itself.
pub(crate) fn leaders(vertices: &[Vec3], distance: f64) -> Vec<u32> {
    let cell = 2.0 * distance.max(f64::MIN_POSITIVE);
    let key = |v: &Vec3| [0, 1, 2].map(|k| (v[k] / cell).floor() as i64);
    // Only ever looked up by key, so its random order cannot show in the result.
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut leader: Vec<u32> = Vec::with_capacity(vertices.len());
    for (i, v) in vertices.iter().enumerate() {
        let (low, high) = (key(&v.add_scalar(-distance)), key(&v.add_scalar(distance)));
        let mut found = i as u32;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    for &j in grid.get(&[x, y, z]).into_iter().flatten() {
                        if j < found && (vertices[j as usize] - v).norm() <= distance {
                            found = j;
                        }
                    }
                }
            }
        }
        if found == i as u32 {
            grid.entry(key(v)).or_default().push(found);
        }
        leader.push(found);
    }
    leader
}

/// The triangles over only the vertices they use, in the order of the vertices.
fn compacted(vertices: &[Vec3], triangles: &[[u32; 3]]) -> TriMesh {
    let mut used = vec![false; vertices.len()];
    triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut renumbered = vec![0; vertices.len()];
    let mut kept = Vec::new();
    for (i, v) in vertices.iter().enumerate().filter(|(i, _)| used[*i]) {
        renumbered[i] = kept.len() as u32;
        kept.push(*v);
    }
    let triangles = triangles.iter().map(|t| t.map(|v| renumbered[v as usize])).collect();
    TriMesh { vertices: kept, triangles }
}

/// Cuts a simple polygon, convex or not, into triangles of the same sense by removing ears.
fn cut_ears(vertices: &[Vec3], polygon: &[usize]) -> Vec<[u32; 3]> {
    let at = |i: usize| vertices[i];
    let mean = polygon.iter().map(|&i| at(i)).sum::<Vec3>() / polygon.len() as f64;
    let n = polygon.len();
    let normal: Vec3 =
        (0..n).map(|k| (at(polygon[k]) - mean).cross(&(at(polygon[(k + 1) % n]) - mean))).sum();
    let mut rest = polygon.to_vec();
    let mut triangles = Vec::with_capacity(n - 2);
    while rest.len() > 3 {
        let m = rest.len();
        let corner = |k: usize| [rest[(k + m - 1) % m], rest[k], rest[(k + 1) % m]];
        let is_ear = |&k: &usize| {
            let ear = corner(k);
            turn(&ear.map(at), &normal) > 0.0
                && !rest.iter().any(|v| !ear.contains(v) && within(&ear.map(at), &at(*v), &normal))
        };
        // A polygon that crosses itself may have no ear: any corner then does as well as another.
        let k = (1..=m).map(|k| k % m).find(is_ear).unwrap_or(1);
        triangles.push(corner(k).map(|v| v as u32));
        rest.remove(k);
    }
    triangles.push([rest[0] as u32, rest[1] as u32, rest[2] as u32]);
    triangles
}

/// Twice the signed area of a triangle seen along `-normal`, times the normal's length.
fn turn(p: &[Vec3; 3], normal: &Vec3) -> f64 {
    (p[1] - p[0]).cross(&(p[2] - p[1])).dot(normal)
}

/// Whether a point lies in a triangle, its border included, seen along the normal.
fn within(p: &[Vec3; 3], x: &Vec3, normal: &Vec3) -> bool {
    (0..3).all(|k| turn(&[p[k], p[(k + 1) % 3], *x], normal) >= 0.0)
}
