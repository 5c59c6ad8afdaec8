//! Convex polyhedra: hull of points, polygonal faces, and erosion by a crust.

mod faces;
mod half_spaces;
mod triangulated;

use crate::{TriMesh, Vec3};
use faces::join_coplanar;
use std::cmp::Ordering;
use thiserror::Error;
use triangulated::triangulated_hull;

/// Points closer than this to a plane lie on it (relative to the size of the body).
const COPLANAR: f64 = 1e-11;
/// Points closer than this to each other are one point (relative to the size of the body).
const COINCIDENT: f64 = 1e-9;
/// Bodies thinner than this are flat (relative to their size).
const FLAT: f64 = 1e-6;

/// Why points have no usable convex hull.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum HullError {
    /// Fewer than four points.
    #[error("a convex polyhedron needs at least 4 vertices, but {count} are given: add vertices")]
    TooFewPoints {
        /// Points given.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {index} is ({x}, {y}, {z}) m, but coordinates must be finite: correct the vertex")]
    NotFinite {
        /// Index of the point.
        index: usize,
        /// x (m).
        x: f64,
        /// y (m).
        y: f64,
        /// z (m).
        z: f64,
    },
    /// Two points coincide.
    #[error(
        "vertices {first} and {second} are {distance} m apart, but vertices must differ by more than 1e-9 of the body's size: remove one"
    )]
    Duplicate {
        /// Lower index.
        first: usize,
        /// Higher index.
        second: usize,
        /// Their distance (m).
        distance: f64,
    },
    /// All points lie in one plane (or on a line, or at one place).
    #[error(
        "the vertices are coplanar: thickness {thickness} m for a size of {size} m, but it must exceed 1e-6 of the size: move a vertex out of the plane"
    )]
    Coplanar {
        /// Largest distance of a point from the best plane found (m).
        thickness: f64,
        /// Largest extent along an axis (m).
        size: f64,
    },
    /// The crust leaves nothing of the body.
    #[error(
        "eroding by {depth} m leaves no core, for a face is {distance} m from the centre: choose a smaller crust"
    )]
    Eroded {
        /// Depth of erosion (m).
        depth: f64,
        /// Smallest distance of a face from the centre (m).
        distance: f64,
    },
}

/// A flat face of a convex polyhedron: normal·x = offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Vertex indices, counter-clockwise seen from outside.
    pub vertices: Vec<u32>,
    /// Outward unit normal (-).
    pub normal: Vec3,
    /// Distance of the plane from the origin along the normal (m).
    pub offset: f64,
}

/// A convex polyhedron with polygonal faces.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexHull {
    /// Corners (m).
    pub vertices: Vec<Vec3>,
    /// Faces, each plane once.
    pub faces: Vec<Face>,
}

impl ConvexHull {
    /// Convex hull of the given points (m); points inside the hull or its faces are dropped.
    ///
    /// Errors: fewer than four points, a coordinate not finite, coincident or coplanar points.
    pub fn new(points: &[Vec3]) -> Result<Self, HullError> {
        check_points(points)?;
        let (centre, size) = extent(points);
        let unit: Vec<Vec3> = points.iter().map(|p| (p - centre) / size).collect();
        let mut hull = unit_hull(&unit)
            .map_err(|thickness| HullError::Coplanar { thickness: thickness * size, size })?;
        for vertex in &mut hull.vertices {
            *vertex = *vertex * size + centre;
        }
        for face in &mut hull.faces {
            face.offset = face.offset * size + face.normal.dot(&centre);
        }
        Ok(hull)
    }

    /// Smallest distance of a face's plane from `point`, negative outside (m).
    pub fn depth_of(&self, point: &Vec3) -> f64 {
        self.faces.iter().map(|f| f.offset - f.normal.dot(point)).fold(f64::INFINITY, f64::min)
    }

    /// Surface as triangles: each face cut into a fan.
    pub fn triangles(&self) -> TriMesh {
        let fan = |f: &Face| {
            let v = f.vertices.clone();
            (1..v.len() - 1).map(move |i| [v[0], v[i], v[i + 1]])
        };
        TriMesh { vertices: self.vertices.clone(), triangles: self.faces.iter().flat_map(fan).collect() }
    }

    /// Vertices of the body eroded by `depth` (m): the intersection of its half-spaces moved inwards,
    /// `{x : n_i·x <= d_i - depth}`, found through the hull of the dual points
    /// `n_i/(d_i - depth - n_i·centre)` about `centre`, a point deeper than `depth` inside.
    ///
    /// A ball of radius `depth` swept over the result gives the body with rounded edges and faces in
    /// place; faces so small that their neighbours' planes meet below them are rounded away.
    pub fn eroded_vertices(&self, centre: &Vec3, depth: f64) -> Result<Vec<Vec3>, HullError> {
        let distance = self.depth_of(centre);
        if distance.partial_cmp(&depth) != Some(Ordering::Greater) {
            return Err(HullError::Eroded { depth, distance });
        }
        let stretch = self.half_widths(centre);
        let planes: Vec<(Vec3, f64)> = self
            .faces
            .iter()
            .map(|f| {
                // In coordinates divided by the widths, so that plates and needles are as well
                // conditioned as cubes.
                let normal = f.normal.component_mul(&stretch);
                let length = normal.norm();
                (normal / length, (f.offset - depth - f.normal.dot(centre)) / length)
            })
            .collect();
        let flat = |thickness| HullError::Coplanar { thickness, size: 1.0 };
        let vertices = half_spaces::corners(&planes).map_err(flat)?;
        Ok(vertices.iter().map(|v| v.component_mul(&stretch) + centre).collect())
    }

    /// Largest distance of a vertex from `centre` along each axis (m).
    fn half_widths(&self, centre: &Vec3) -> Vec3 {
        self.vertices.iter().fold(Vec3::zeros(), |w, v| w.sup(&(v - centre).abs()))
    }
}

/// Refuses fewer than four points, infinite coordinates and coincident points.
fn check_points(points: &[Vec3]) -> Result<(), HullError> {
    if points.len() < 4 {
        return Err(HullError::TooFewPoints { count: points.len() });
    }
    if let Some(index) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        let p = points[index];
        return Err(HullError::NotFinite { index, x: p.x, y: p.y, z: p.z });
    }
    let (_, size) = extent(points);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].x.total_cmp(&points[b].x));
    for (i, &a) in order.iter().enumerate() {
        for &b in &order[i + 1..] {
            if points[b].x - points[a].x > COINCIDENT * size {
                break;
            }
            let distance = (points[a] - points[b]).norm();
            if distance <= COINCIDENT * size {
                return Err(HullError::Duplicate { first: a.min(b), second: a.max(b), distance });
            }
        }
    }
    Ok(())
}

/// Centre of the axis-aligned box around the points and its longest edge.
fn extent(points: &[Vec3]) -> (Vec3, f64) {
    let lower = points.iter().fold(Vec3::repeat(f64::INFINITY), |a, p| a.inf(p));
    let upper = points.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    ((lower + upper) / 2.0, (upper - lower).max())
}

/// Hull of points of unit extent; for coplanar points their thickness.
fn unit_hull(points: &[Vec3]) -> Result<ConvexHull, f64> {
    let start = spread_points(points)?;
    Ok(join_coplanar(points, &triangulated_hull(points, start)))
}

/// Four points far apart: the farthest from a point, line and plane in turn; for coplanar points their
/// thickness.
fn spread_points(points: &[Vec3]) -> Result<[usize; 4], f64> {
    let farthest = |measure: &dyn Fn(&Vec3) -> f64| {
        (0..points.len()).max_by(|&i, &j| measure(&points[i]).total_cmp(&measure(&points[j]))).unwrap_or(0)
    };
    let a = points[0];
    let second = farthest(&|p| (p - a).norm());
    let axis = points[second] - a;
    let third = farthest(&|p| (p - a).cross(&axis).norm());
    let area = axis.cross(&(points[third] - a));
    if area.norm() <= FLAT * axis.norm_squared() {
        return Err(0.0);
    }
    let normal = area.normalize();
    let fourth = farthest(&|p| (p - a).dot(&normal).abs());
    let thickness = (points[fourth] - a).dot(&normal).abs();
    if thickness > FLAT { Ok([0, second, third, fourth]) } else { Err(thickness) }
}
