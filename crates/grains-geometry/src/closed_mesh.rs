//! Signed distance from a closed triangle mesh.

use crate::gjk::nearest::on_triangle;
use crate::mesh::ordered;
use crate::solid::{SolidError, solid_mass};
use crate::turn::angle_between;
use crate::{Aabb, Bvh, SignedDistance, TriMesh, Vec3};
use std::collections::BTreeMap;

/// A closed mesh of outward triangles and the normals that tell its inside from its outside.
#[derive(Clone, Debug)]
pub struct ClosedMesh {
    mesh: TriMesh,
    bvh: Bvh,
    /// Unit normals of the triangles.
    faces: Vec<Vec3>,
    /// Sums of the normals at the edges of each triangle, edge k opposite corner k.
    edges: Vec<[Vec3; 3]>,
    /// Sums of the normals at the vertices, each weighted with the angle of its triangle there.
    vertices: Vec<Vec3>,
    /// Distance (m) that counts as rounding.
    rounding: f64,
}

/// What rounding may make of a distance, over the diagonal of the mesh, and of weights of corners (-).
const ROUNDING: f64 = 1e-12;

impl ClosedMesh {
    /// The mesh with its normals.
    ///
    /// # Errors
    /// A mesh with holes, inconsistent, inside out, flat or overlapping itself.
    pub fn new(mesh: TriMesh) -> Result<Self, SolidError> {
        solid_mass(&mesh)?;
        let corners = |t: usize| mesh.corners(t);
        let count = mesh.triangles.len();
        let normal = |t: usize| {
            let [a, b, c] = corners(t);
            (b - a).cross(&(c - a)).normalize()
        };
        let faces: Vec<Vec3> = (0..count).map(normal).collect();
        let mut at_edges: BTreeMap<(u32, u32), Vec3> = BTreeMap::new();
        let mut vertices = vec![Vec3::zeros(); mesh.vertices.len()];
        for (t, ids) in mesh.triangles.iter().enumerate() {
            let points = corners(t);
            for k in 0..3 {
                let [next, last] = [(k + 1) % 3, (k + 2) % 3];
                *at_edges.entry(ordered(ids[next], ids[last])).or_insert_with(Vec3::zeros) += faces[t];
                let angle = angle_between(&(points[next] - points[k]), &(points[last] - points[k]));
                vertices[ids[k] as usize] += faces[t] * angle;
            }
        }
        let edge = |ids: &[u32; 3], k: usize| at_edges[&ordered(ids[(k + 1) % 3], ids[(k + 2) % 3])];
        let edges = mesh.triangles.iter().map(|ids| [0, 1, 2].map(|k| edge(ids, k))).collect();
        let boxes: Vec<Aabb> = (0..count).map(|t| Aabb::around(&corners(t))).collect();
        Ok(Self { bvh: Bvh::new(&boxes), faces, edges, vertices, rounding: ROUNDING * mesh.diagonal(), mesh })
    }

    /// The mesh.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// Signed distance of a point (m): its sign is that of the angle with the normal of the nearest face, edge or vertex, which
    /// of edges and vertices is a sum over their faces (Bærentzen & Aanæs 2005).
    pub fn signed_distance(&self, point: &Vec3) -> SignedDistance {
        let nearest = |t: u32| {
            let [a, b, c] = self.mesh.corners(t as usize).map(|corner| corner - point);
            on_triangle(&a, &b, &c)
        };
        let squared = |t: u32| nearest(t).point.norm_squared();
        let Some((triangle, _)) = self.bvh.nearest(point, squared) else {
            return SignedDistance { distance: f64::INFINITY, outward: Vec3::zeros() };
        };
        let found = nearest(triangle);
        let normal = self.normal_of(triangle as usize, &found.weights);
        let distance = found.point.norm();
        match found.point.dot(&normal) <= 0.0 {
            // On the surface the way to it is rounding.
            is_outside if distance <= self.rounding => SignedDistance {
                distance: if is_outside { distance } else { -distance },
                outward: normal.normalize(),
            },
            true => SignedDistance { distance, outward: -found.point / distance },
            false => SignedDistance { distance: -distance, outward: found.point / distance },
        }
    }

    /// Normal, of any length, of what carries a point with these weights of a triangle's corners.
    fn normal_of(&self, triangle: usize, weights: &[f64; 4]) -> Vec3 {
        let carries = [0, 1, 2].map(|k| weights[k] > ROUNDING);
        match carries {
            [true, true, true] => self.faces[triangle],
            [false, true, true] => self.edges[triangle][0],
            [true, false, true] => self.edges[triangle][1],
            [true, true, false] => self.edges[triangle][2],
            _ => {
                let k = carries.iter().position(|c| *c).unwrap_or(0);
                self.vertices[self.mesh.triangles[triangle][k] as usize]
            }
        }
    }
}
