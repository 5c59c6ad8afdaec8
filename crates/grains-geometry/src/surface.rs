//! Walls given by triangle meshes: contact of a body with each triangle, no place counted twice.
//!
//! A contact is a *local minimum of the distance over the whole surface*. Where that minimum lies on an
//! edge or a vertex, the lowest-numbered triangle there owns it. The tests of edges and vertices are
//! inclusive by a rounding tolerance, so no minimum is lost; what they then report twice, and the faces
//! of a valley shallower than the smooth angle, is reduced to the nearest by comparing neighbours.

mod conform;
mod facets;
mod shared;
mod topology;

use crate::Vec3;
use crate::bvh::Bvh;
use crate::mesh::{MeshError, MeshReport, TriMesh, WELD_TOLERANCE, WeldReport};
use crate::table::Table;
use facets::Facets;
use topology::{Edge, Triangle, Vertex};

pub use facets::{Facet, OverFacet};

/// Rounding of distances from an edge, relative to the diagonal of the mesh.
const SIDE_TOLERANCE: f64 = 1e-14;
/// Rounding of positions along edges near a vertex, relative to the diagonal of the mesh.
const CORNER_TOLERANCE: f64 = 1e-11;
/// Relative difference of distances that counts as rounding.
const TIE: f64 = 1e-13;
/// Accuracy of points found by iteration, relative to the length of an edge.
const POINT_TOLERANCE: f64 = 1e-6;
/// Accuracy of unit directions found by iteration (-).
const DIRECTION_TOLERANCE: f64 = 1e-4;

/// Default angle below which neighbouring faces count as one smooth surface (rad): one degree.
pub const SMOOTH_ANGLE: f64 = std::f64::consts::PI / 180.0;

/// Closest point of a triangle to a point, a local minimum over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleContact {
    /// Point on the triangle (m).
    pub point: Vec3,
    /// Distance of the query point from it (m).
    pub distance: f64,
    /// Unit vector from `point` to the query point; the face's own normal if these coincide.
    pub normal: Vec3,
}

/// A local minimum before neighbours are compared.
struct Minimum {
    contact: TriangleContact,
    /// How far inside the triangle it lies (m), 0 on the border.
    margin: f64,
    /// Distance (m), made to prefer face to edge to vertex where they differ by rounding only: the
    /// normal of a face suffers least.
    rank: f64,
}

/// What was found while a wall was built from a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct WallReport {
    /// Vertices merged and triangles dropped.
    pub weld: WeldReport,
    /// Triangles dropped because another has the same vertices.
    pub duplicate_triangles: usize,
    /// Triangles added by splitting at vertices that lay on the edges of others.
    pub split_triangles: usize,
    /// Edges, extents and areas of the final mesh.
    pub mesh: MeshReport,
}

/// A triangle mesh prepared for contact detection.
#[derive(Clone, Debug)]
pub struct WallMesh {
    mesh: TriMesh,
    report: WallReport,
    triangles: Table<Triangle>,
    edges: Table<Edge>,
    vertices: Table<Vertex>,
    /// Inward in-plane unit normals, one per triangle at an edge, edge by edge.
    sides: Table<Vec3>,
    /// Unit edge directions away from a vertex, vertex by vertex.
    spokes: Table<Vec3>,
    /// Edges of these directions.
    spoke_edges: Table<u32>,
    /// Triangles sharing a vertex with a triangle, triangle by triangle.
    neighbours: Table<u32>,
    facets: Facets,
    bvh: Bvh,
    side_tolerance: f64,
    corner_tolerance: f64,
    smooth_sine: f64,
    smooth_cosine: f64,
}

impl WallMesh {
    /// Wall from a mesh: welded, split where vertices lie on edges of other triangles, then indexed.
    ///
    /// Two faces of a valley whose normals differ by less than `smooth_angle` (rad, see
    /// [`SMOOTH_ANGLE`]) give one contact, with the nearer. Errors: no triangle of non-zero area.
    pub fn new(mesh: &TriMesh, smooth_angle: f64) -> Result<Self, MeshError> {
        let (mut mesh, weld) = mesh.welded(WELD_TOLERANCE)?;
        let diagonal = mesh.diagonal();
        let duplicate_triangles = conform::drop_duplicates(&mut mesh);
        let split_triangles = conform::split_at_vertices(&mut mesh, WELD_TOLERANCE * diagonal);
        let parts = topology::build(&mesh);
        Ok(WallMesh {
            report: WallReport { weld, duplicate_triangles, split_triangles, mesh: mesh.report() },
            facets: Facets::of(&parts.triangles, parts.edges.len(), WELD_TOLERANCE * diagonal),
            triangles: parts.triangles.into(),
            edges: parts.edges.into(),
            vertices: parts.vertices.into(),
            sides: parts.sides.into(),
            spokes: parts.spokes.into(),
            spoke_edges: parts.spoke_edges.into(),
            neighbours: parts.neighbours.into(),
            bvh: Bvh::new(&parts.boxes),
            mesh,
            side_tolerance: SIDE_TOLERANCE * diagonal,
            corner_tolerance: CORNER_TOLERANCE * diagonal,
            smooth_sine: libm::sin(smooth_angle),
            smooth_cosine: libm::cos(smooth_angle),
        })
    }

    /// The final mesh: triangle ids refer to it.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// Geometry checks made while building.
    pub fn report(&self) -> &WallReport {
        &self.report
    }

    /// Calls `f` once with each triangle whose bounding box meets the box `lower..upper` (m), in an
    /// order fixed by the mesh.
    #[inline]
    pub fn for_each_in_box(&self, lower: &Vec3, upper: &Vec3, f: impl FnMut(u32)) {
        self.bvh.for_each_in_box(lower, upper, f);
    }

    /// Lower bound (m) on the distance of triangle `t` from `c`, by its box, its plane and its edges.
    #[inline]
    pub fn distance_bound(&self, t: u32, c: &Vec3) -> f64 {
        let triangle = &self.triangles[t as usize];
        let [p, q, r] = &triangle.corners;
        let (lower, upper) = (p.inf(q).inf(r), p.sup(q).sup(r));
        let from_box = (lower - c).sup(&(c - upper)).max();
        // The boxes of slanted triangles hold much that is far from them.
        let height = triangle.normal.dot(&(c - triangle.corners[0]));
        let outside = triangle.depths(c).into_iter().fold(0.0, f64::min);
        from_box.max((height * height + outside * outside).sqrt())
    }

    /// The facet of triangle `t`: the triangles that lie in its plane, but for the rounding that is welded, and that edges of two
    /// triangles, one on each side, join to it.
    #[inline]
    pub fn facet(&self, t: u32) -> &Facet {
        &self.facets.all[self.facets.of_triangle[t as usize] as usize]
    }

    /// Distance (m) from the rim of a facet beyond which a ball of a radius (m) over it touches it as it would touch its plane: no
    /// neighbour of the facet, even in a smooth valley, competes.
    #[inline]
    pub fn clearance(&self, radius: f64) -> f64 {
        radius * (1.0 + self.smooth_sine * self.smooth_sine).sqrt() + 2.0 * self.side_tolerance
    }

    /// Where `c` lies over triangle `t` of its facet.
    pub fn over_triangle(&self, t: u32, c: &Vec3) -> OverFacet {
        let triangle = &self.triangles[t as usize];
        let [a, b, d] = triangle.depths(c);
        let is_inside = a.min(b).min(d) >= -self.side_tolerance;
        let rims = (0..3).filter(|&k| self.facets.is_rim(t, k)).map(|k| {
            let edge = &self.edges[triangle.edges[k] as usize];
            let from_origin = c - edge.origin;
            let along = from_origin.dot(&edge.direction).clamp(0.0, edge.length);
            (from_origin - edge.direction * along).norm()
        });
        OverFacet { is_inside, from_rim: rims.fold(f64::INFINITY, f64::min) }
    }

    /// Where `c` lies over the facet of triangle `t`, by its triangles within `range` (m): the rim is looked for so far.
    pub fn over_facet(&self, t: u32, c: &Vec3, range: f64) -> OverFacet {
        let facet = self.facets.of_triangle[t as usize];
        let half = Vec3::repeat(range);
        let mut over = OverFacet::outside(range);
        self.for_each_in_box(&(c - half), &(c + half), |other| {
            if self.facets.of_triangle[other as usize] == facet {
                over = over.joined(&self.over_triangle(other, c));
            }
        });
        over
    }

    /// Triangle of the facet of triangle `t` over which a point lies (m), deepest within its edges.
    pub fn triangle_below(&self, t: u32, point: &Vec3) -> u32 {
        let facet = self.facets.of_triangle[t as usize];
        let point = point - self.facet(t).normal * self.facet(t).height(point);
        let half =
            Vec3::repeat(10.0 * WELD_TOLERANCE * (self.report.mesh.upper - self.report.mesh.lower).norm());
        let mut best = (f64::NEG_INFINITY, self.facet(t).first);
        self.for_each_in_box(&(point - half), &(point + half), |other| {
            if self.facets.of_triangle[other as usize] == facet {
                let [a, b, c] = self.triangles[other as usize].depths(&point);
                let depth = a.min(b).min(c);
                if depth > best.0 || depth == best.0 && other < best.1 {
                    best = (depth, other);
                }
            }
        });
        best.1
    }

    /// Whether plane and edges of triangle `t` allow it to meet a ball of a radius (m) around `c`.
    #[inline]
    fn may_touch(&self, t: u32, c: &Vec3, radius: f64) -> bool {
        let triangle = &self.triangles[t as usize];
        let height = triangle.normal.dot(&(c - triangle.corners[0]));
        // The ball cuts the plane in a circle: is that beyond an edge?
        let circle = radius * radius - height * height;
        let outside = triangle.depths(c).into_iter().fold(0.0, f64::min);
        circle > outside * outside
    }

    /// Contact of triangle `t` with a sphere centred at `c` (m), if `t` owns a local minimum of the
    /// distance from `c` over the surface.
    pub fn closest_on_triangle(&self, t: u32, c: &Vec3) -> Option<TriangleContact> {
        let own = self.local_minimum(t, c)?;
        if self.is_alone(&self.triangles[t as usize], own.margin, own.contact.distance) {
            return Some(own.contact);
        }
        let duplicated = self.neighbours[self.triangles[t as usize].neighbours()].iter().any(|&other| {
            self.local_minimum(other, c).is_some_and(|rival| {
                rival.contact.normal.dot(&own.contact.normal) >= self.smooth_cosine
                    && (rival.rank, other) < (own.rank, t)
            })
        });
        (!duplicated).then_some(own.contact)
    }

    /// The same for a sphere of a radius (m): `None` unless it reaches the surface.
    #[inline(always)]
    pub fn closest_within(&self, t: u32, c: &Vec3, radius: f64) -> Option<TriangleContact> {
        let triangle = &self.triangles[t as usize];
        let [a, b, d] = triangle.depths(c);
        let height = triangle.normal.dot(&(c - triangle.corners[0]));
        let distance = height.abs();
        if self.is_alone(triangle, a.min(b).min(d), distance) {
            let contact = face_contact(triangle, c, height);
            return (radius * radius - height * height > 0.0 && distance < radius).then_some(contact);
        }
        self.closest_near_border(t, c, radius)
    }

    /// Whether no neighbour of a triangle competes for a minimum `margin` within its border at a distance (m).
    ///
    /// One can only within the strip of a shallow valley along the border, and there no nearer than over a place `margin` aside
    /// that rises towards the point by the relief.
    #[inline(always)]
    fn is_alone(&self, triangle: &Triangle, margin: f64, distance: f64) -> bool {
        let rise = 2.0 * (triangle.relief + self.side_tolerance) + 10.0 * TIE * distance;
        let is_flat = margin > self.side_tolerance && margin * margin > distance * rise;
        is_flat || margin > self.side_tolerance + distance * self.smooth_sine
    }

    #[inline(never)]
    fn closest_near_border(&self, t: u32, c: &Vec3, radius: f64) -> Option<TriangleContact> {
        if !self.may_touch(t, c, radius) {
            return None;
        }
        self.closest_on_triangle(t, c).filter(|contact| contact.distance < radius)
    }

    /// Way (m) that a ball of a radius (m) around `c` may go, wherever to, before triangle `t` can have a contact with it; not
    /// positive where one step may bring it.
    ///
    /// It has none as long as plane or edges keep it out of reach, or no minimum of the distance is its own.
    pub fn free_path(&self, t: u32, c: &Vec3, radius: f64) -> f64 {
        (self.distance_bound(t, c) - radius).max(self.way_to_minimum(t, c))
    }

    /// Way (m) that a point may go before [`Self::local_minimum`] finds one: each condition is as far from being met as a
    /// coordinate along a unit vector, and of all conditions of a place one is enough.
    fn way_to_minimum(&self, t: u32, c: &Vec3) -> f64 {
        let triangle = &self.triangles[t as usize];
        let inside = triangle.depths(c);
        let to_face = -inside[0].min(inside[1]).min(inside[2]);
        let edges = (0..3).filter(|&k| triangle.owns_edge(k)).map(|k| {
            let edge = &self.edges[triangle.edges[k] as usize];
            let from_origin = c - edge.origin;
            let along = from_origin.dot(&edge.direction);
            let beyond = (-along).max(along - edge.length) - self.corner_tolerance;
            let sides = self.sides[edge.sides()].iter().map(|side| from_origin.dot(side));
            sides.chain([inside[k]]).map(|depth| depth - self.side_tolerance).fold(beyond, f64::max)
        });
        let vertices = (0..3).filter(|&k| triangle.owns_vertex(k)).map(|k| {
            let spokes = &self.spokes[self.vertices[triangle.vertices[k] as usize].spokes()];
            let along = spokes.iter().map(|spoke| (c - triangle.corners[k]).dot(spoke));
            along.fold(f64::NEG_INFINITY, f64::max) - self.corner_tolerance
        });
        edges.chain(vertices).fold(to_face, f64::min)
    }

    /// Local minimum that triangle `t` owns, before neighbours are compared.
    #[inline]
    fn local_minimum(&self, t: u32, c: &Vec3) -> Option<Minimum> {
        let triangle = &self.triangles[t as usize];
        let inside = triangle.depths(c);
        let margin = inside[0].min(inside[1]).min(inside[2]);
        if margin > 0.0 {
            let height = triangle.normal.dot(&(c - triangle.corners[0]));
            let contact = face_contact(triangle, c, height);
            return Some(Minimum { contact, margin, rank: contact.distance * (1.0 - 2.0 * TIE) });
        }
        let (point, tie) = match self.edge_minimum(triangle, &inside, c) {
            Some(point) => (point, TIE),
            None => (self.vertex_minimum(triangle, c)?, 0.0),
        };
        let distance = (c - point).norm();
        let normal = if distance > 0.0 { (c - point) / distance } else { triangle.normal };
        let contact = TriangleContact { point, distance, normal };
        Some(Minimum { contact, margin: 0.0, rank: distance * (1.0 - tie) })
    }

    /// Local minimum on an edge that the triangle owns (m).
    fn edge_minimum(&self, triangle: &Triangle, inside: &[f64; 3], c: &Vec3) -> Option<Vec3> {
        let owned = (0..3).filter(|&k| triangle.owns_edge(k) && inside[k] <= self.side_tolerance);
        owned.map(|k| &self.edges[triangle.edges[k] as usize]).find_map(|edge| {
            let from_origin = c - edge.origin;
            let along = from_origin.dot(&edge.direction);
            let within = along >= -self.corner_tolerance && along <= edge.length + self.corner_tolerance;
            let is_minimum =
                || self.sides[edge.sides()].iter().all(|side| from_origin.dot(side) <= self.side_tolerance);
            (within && is_minimum()).then(|| edge.origin + edge.direction * along.clamp(0.0, edge.length))
        })
    }

    /// Local minimum on a vertex that the triangle owns (m).
    fn vertex_minimum(&self, triangle: &Triangle, c: &Vec3) -> Option<Vec3> {
        let owned = (0..3).filter(|&k| triangle.owns_vertex(k));
        owned.map(|k| (triangle.corners[k], triangle.vertices[k])).find_map(|(position, v)| {
            let spokes = &self.spokes[self.vertices[v as usize].spokes()];
            let is_minimum = spokes.iter().all(|spoke| (c - position).dot(spoke) <= self.corner_tolerance);
            is_minimum.then_some(position)
        })
    }

    /// Whether triangle `t` owns a local minimum of the distance between the surface and a convex body,
    /// for `point`, the triangle's point closest to the body (m), and the direction `toward` from it to
    /// the body's closest point (any length).
    ///
    /// Both may carry the error of an iteration: 1e-6 of an edge's length, 1e-4 rad.
    pub fn owns_local_minimum(&self, t: u32, point: &Vec3, toward: &Vec3) -> bool {
        let triangle = &self.triangles[t as usize];
        let Some(toward) = toward.try_normalize(0.0) else { return true };
        let descends = |direction: &Vec3| direction.dot(&toward) > DIRECTION_TOLERANCE;
        for k in 0..3 {
            let vertex = &self.vertices[triangle.vertices[k] as usize];
            if (point - triangle.corners[k]).norm() <= POINT_TOLERANCE * vertex.shortest_edge {
                let spokes = &self.spokes[vertex.spokes()];
                return triangle.owns_vertex(k) && !spokes.iter().any(descends);
            }
        }
        for (k, depth) in triangle.depths(point).into_iter().enumerate() {
            let edge = &self.edges[triangle.edges[k] as usize];
            if depth <= POINT_TOLERANCE * edge.length {
                return triangle.owns_edge(k) && !self.sides[edge.sides()].iter().any(descends);
            }
        }
        true
    }

    /// Which edges and corners of triangle `t`, that it owns, bodies `toward` (any length) meet before its face: borders
    /// and ridges, no flat seams nor valleys.
    pub(crate) fn ridges(&self, t: u32, toward: &Vec3) -> [[bool; 3]; 2] {
        let triangle = &self.triangles[t as usize];
        let is_ridge = |edge: u32| self.edges[edge as usize].is_ridge(&self.sides, toward);
        let edge = |k: usize| triangle.owns_edge(k) && is_ridge(triangle.edges[k]);
        let corner = |k: usize| {
            let spokes = self.vertices[triangle.vertices[k] as usize].spokes();
            triangle.owns_vertex(k) && self.spoke_edges[spokes].iter().any(|&edge| is_ridge(edge))
        };
        [[0, 1, 2].map(edge), [0, 1, 2].map(corner)]
    }
}

/// Contact of a point `c` (m), `height` (m) over the plane of a triangle, with its face.
#[inline(always)]
fn face_contact(triangle: &Triangle, c: &Vec3, height: f64) -> TriangleContact {
    TriangleContact {
        point: c - triangle.normal * height,
        distance: height.abs(),
        normal: if height < 0.0 { -triangle.normal } else { triangle.normal },
    }
}
