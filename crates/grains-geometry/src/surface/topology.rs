//! Edges, vertices and neighbours of a wall mesh, in flat arrays.

use crate::Vec3;
use crate::bvh::Aabb;
use crate::mesh::{TriMesh, ordered};
use bytemuck::{Pod, Zeroable};
use std::collections::BTreeMap;
use std::ops::Range;

/// What a query needs of a triangle.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Triangle {
    pub corners: [Vec3; 3],
    pub normal: Vec3,
    /// Inward in-plane unit normal of edge k, from corner k to corner k + 1.
    pub inward: [Vec3; 3],
    /// How far (m) the triangles that share a vertex with it rise over its plane, to either side.
    pub relief: f64,
    pub edges: [u32; 3],
    pub vertices: [u32; 3],
    first_neighbour: u32,
    end_neighbour: u32,
    /// Bits 0 to 2 of the edges that it owns, 3 to 5 of the vertices.
    owned: u64,
}

impl Triangle {
    /// Distance of a point from each edge, in the plane and positive inside (m).
    #[inline]
    pub fn depths(&self, c: &Vec3) -> [f64; 3] {
        let depth = |k: usize| self.inward[k].dot(&(c - self.corners[k]));
        [depth(0), depth(1), depth(2)]
    }

    /// Whether it owns edge `k`.
    #[inline]
    pub fn owns_edge(&self, k: usize) -> bool {
        self.owned >> k & 1 == 1
    }

    /// Whether it owns vertex `k`.
    #[inline]
    pub fn owns_vertex(&self, k: usize) -> bool {
        self.owned >> (3 + k) & 1 == 1
    }

    /// Where its neighbours stand.
    #[inline]
    pub fn neighbours(&self) -> Range<usize> {
        self.first_neighbour as usize..self.end_neighbour as usize
    }
}

/// An edge, seen the same way by all its triangles.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Edge {
    pub origin: Vec3,
    pub direction: Vec3,
    pub length: f64,
    first_side: u32,
    end_side: u32,
}

impl Edge {
    /// Where the inward normals of its triangles stand.
    #[inline]
    pub fn sides(&self) -> Range<usize> {
        self.first_side as usize..self.end_side as usize
    }
}

/// A vertex of the mesh.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Vertex {
    pub shortest_edge: f64,
    first_spoke: u32,
    end_spoke: u32,
}

/// Sine of the angle between faces below which their seam is flat.
const FLAT: f64 = 1e-4;

impl Edge {
    /// Whether bodies, in a direction from it, meet it before its faces: not where these are flat or a valley.
    pub fn is_ridge(&self, sides: &[Vec3], toward: &Vec3) -> bool {
        let sides = &sides[self.sides()];
        let bend: Vec3 = sides.iter().sum();
        sides.len() == 1 || (bend.norm_squared() > FLAT * FLAT && bend.dot(toward) < 0.0)
    }
}

impl Vertex {
    /// Where its spokes stand.
    #[inline]
    pub fn spokes(&self) -> Range<usize> {
        self.first_spoke as usize..self.end_spoke as usize
    }
}

/// The arrays of a wall mesh.
pub(super) struct Parts {
    pub triangles: Vec<Triangle>,
    pub edges: Vec<Edge>,
    pub vertices: Vec<Vertex>,
    pub sides: Vec<Vec3>,
    pub spokes: Vec<Vec3>,
    pub spoke_edges: Vec<u32>,
    pub neighbours: Vec<u32>,
    pub boxes: Vec<Aabb>,
}

/// Indexes a welded mesh.
pub(super) fn build(mesh: &TriMesh) -> Parts {
    let users = triangles_at_edges(mesh);
    let fans = triangles_at_vertices(mesh);
    let mut triangles: Vec<Triangle> = (0..mesh.triangles.len()).map(|t| triangle(mesh, t, &fans)).collect();
    let mut sides = Vec::new();
    let mut edges = Vec::with_capacity(users.len());
    for (&(a, b), uses) in &users {
        let (origin, end) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
        let first_side = sides.len() as u32;
        for (order, &(t, k)) in uses.iter().enumerate() {
            let triangle = &mut triangles[t as usize];
            triangle.edges[k] = edges.len() as u32;
            triangle.owned |= u64::from(order == 0) << k;
            sides.push(triangle.inward[k]);
        }
        let length = (end - origin).norm();
        let direction = (end - origin) / length;
        edges.push(Edge { origin, direction, length, first_side, end_side: sides.len() as u32 });
    }
    let (vertices, spokes, spoke_edges) = vertices_and_spokes(mesh.vertices.len(), &edges, users.keys());
    let neighbours = list_neighbours(mesh, &fans, &mut triangles);
    let boxes = triangles.iter().map(|t| Aabb::around(&t.corners)).collect();
    Parts { triangles, edges, vertices, sides, spokes, spoke_edges, neighbours, boxes }
}

/// For each edge, its triangles in ascending order, with the edge's place in them.
fn triangles_at_edges(mesh: &TriMesh) -> BTreeMap<(u32, u32), Vec<(u32, usize)>> {
    let mut users: BTreeMap<(u32, u32), Vec<(u32, usize)>> = BTreeMap::new();
    for (t, v) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            users.entry(ordered(v[k], v[(k + 1) % 3])).or_default().push((t as u32, k));
        }
    }
    users
}

/// For each vertex, its triangles in ascending order.
fn triangles_at_vertices(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let mut fans = vec![Vec::new(); mesh.vertices.len()];
    for (t, vertices) in mesh.triangles.iter().enumerate() {
        vertices.iter().for_each(|&v| fans[v as usize].push(t as u32));
    }
    fans
}

/// Geometry of one triangle and the vertices it owns; edges and neighbours follow.
fn triangle(mesh: &TriMesh, t: usize, fans: &[Vec<u32>]) -> Triangle {
    let corners = mesh.corners(t);
    let edge = |k: usize| corners[(k + 1) % 3] - corners[k];
    let normal = unit_normal([edge(0), edge(1), edge(2)]);
    let vertices = mesh.triangles[t];
    let owns = |k: usize| fans[vertices[k] as usize].first() == Some(&(t as u32));
    Triangle {
        corners,
        normal,
        inward: [0, 1, 2].map(|k| normal.cross(&edge(k)).normalize()),
        edges: [0; 3],
        vertices,
        owned: (0..3).map(|k| u64::from(owns(k)) << (3 + k)).sum(),
        relief: 0.0,
        first_neighbour: 0,
        end_neighbour: 0,
    }
}

/// Unit normal of a triangle, exact along the longest edge even of slivers.
fn unit_normal(edges: [Vec3; 3]) -> Vec3 {
    let longest = (0..3).max_by(|&a, &b| edges[a].norm().total_cmp(&edges[b].norm())).unwrap_or(0);
    let along = edges[longest].normalize();
    let normal = edges[(longest + 1) % 3].cross(&edges[(longest + 2) % 3]).normalize();
    // A sliver's cross product is wrong by rounding / height in any direction. Tilt across the sliver
    // moves no point by more than rounding; tilt along it would, and is removed.
    (normal - along * along.dot(&normal)).normalize()
}

/// The edges around each vertex: their directions, and their numbers.
fn vertices_and_spokes<'a>(
    count: usize,
    edges: &[Edge],
    ends: impl Iterator<Item = &'a (u32, u32)>,
) -> (Vec<Vertex>, Vec<Vec3>, Vec<u32>) {
    let mut around: Vec<Vec<(Vec3, f64, u32)>> = vec![Vec::new(); count];
    for (k, (edge, &(a, b))) in edges.iter().zip(ends).enumerate() {
        around[a as usize].push((edge.direction, edge.length, k as u32));
        around[b as usize].push((-edge.direction, edge.length, k as u32));
    }
    let spoke_edges = around.iter().flatten().map(|spoke| spoke.2).collect();
    let mut spokes = Vec::with_capacity(2 * edges.len());
    let vertices = around.iter().map(|edges| {
        let first_spoke = spokes.len() as u32;
        spokes.extend(edges.iter().map(|(direction, ..)| *direction));
        let shortest_edge = edges.iter().map(|e| e.1).fold(f64::INFINITY, f64::min);
        Vertex { shortest_edge, first_spoke, end_spoke: spokes.len() as u32 }
    });
    (vertices.collect(), spokes, spoke_edges)
}

/// Lists the triangles that share a vertex with each triangle.
fn list_neighbours(mesh: &TriMesh, fans: &[Vec<u32>], triangles: &mut [Triangle]) -> Vec<u32> {
    let mut neighbours = Vec::new();
    for (t, triangle) in triangles.iter_mut().enumerate() {
        let mut around: Vec<u32> =
            mesh.triangles[t].iter().flat_map(|&v| fans[v as usize].iter().copied()).collect();
        around.sort_unstable();
        around.dedup();
        let height = |corner: &Vec3| triangle.normal.dot(&(corner - triangle.corners[0])).abs();
        let rises =
            around.iter().flat_map(|&other| mesh.corners(other as usize)).map(|corner| height(&corner));
        triangle.relief = rises.fold(0.0, f64::max);
        triangle.first_neighbour = neighbours.len() as u32;
        neighbours.extend(around.into_iter().filter(|&other| other != t as u32));
        triangle.end_neighbour = neighbours.len() as u32;
    }
    neighbours
}
