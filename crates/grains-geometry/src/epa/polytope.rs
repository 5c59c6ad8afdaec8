//! The growing polytope: a closed surface of triangles around points of the set B − A.

use super::{Difference, Vertex};
use crate::Vec3;
use crate::convex::surface_points::on_circle;

/// Thickness of a set, relative to its size, below which it has no volume.
const FLAT: f64 = 1e-12;
/// Thickness of a needle, relative to its length, below which its faces come near [`SLIVER`].
const THIN: f64 = 1e-6;
/// Height of a point above a face, relative to the size of the set, that is rounding.
const ROUNDING: f64 = 1e-15;
/// Height of a face, relative to the size of the set, below which it is a sliver without a normal. To
/// pass it over is safe: its neighbours are as near the origin but for the square of this.
const SLIVER: f64 = 1e-8;
/// Retreat of the nearest face, relative to the size of the set, that is more than rounding.
const TURNED: f64 = 1e-9;

/// A triangle of the surface, counter-clockwise seen from outside.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub corners: [usize; 3],
    /// The faces across the edges from corner i to corner i + 1.
    neighbours: [usize; 3],
    /// Outward unit normal; zero for a sliver.
    pub normal: Vec3,
    /// Signed distance of its plane from the origin (m); infinite for a sliver, which is never nearest.
    pub distance: f64,
    /// False once the face is under the surface.
    exposed: bool,
}

impl Face {
    /// Slivers hide nothing: they go with the faces next to them.
    fn visible_from(&self, point: &Vec3, margin: f64) -> bool {
        self.distance == f64::INFINITY || self.normal.dot(point) - self.distance > margin
    }
}

/// Edge of the hole where a vertex is added, and the face outside it.
struct Rim {
    from: usize,
    to: usize,
    outside: usize,
}

/// Vertices and faces.
pub(super) struct Polytope {
    pub vertices: Vec<Vertex>,
    pub faces: Vec<Face>,
    /// Size of the set (m).
    size: f64,
    /// Centre of the first four points.
    inside: Vec3,
    /// Distance of the face last found nearest, once the origin is inside (m).
    reached: f64,
}

impl Polytope {
    /// The tetrahedron of four points, of any orientation.
    pub fn new([p, q, r, s]: [Vertex; 4], size: f64) -> Self {
        let outside = (q.w - p.w).cross(&(r.w - p.w)).dot(&(s.w - p.w)) > 0.0;
        let (q, r) = if outside { (r, q) } else { (q, r) };
        let inside = (p.w + q.w + r.w + s.w) / 4.0;
        let vertices = vec![p, q, r, s];
        let mut polytope = Self { vertices, faces: Vec::new(), size, inside, reached: f64::NEG_INFINITY };
        let faces =
            [([0, 1, 2], [1, 2, 3]), ([0, 3, 1], [3, 2, 0]), ([1, 3, 2], [1, 3, 0]), ([2, 3, 0], [2, 1, 0])];
        for (corners, neighbours) in faces {
            polytope.faces.push(polytope.face(corners, neighbours));
        }
        polytope
    }

    /// Number of the first of the exposed faces of smallest distance.
    pub fn nearest_face(&self) -> Option<usize> {
        let mut best = None;
        let mut min = f64::INFINITY;
        for (number, face) in self.faces.iter().enumerate() {
            if face.exposed && face.distance < min {
                (best, min) = (Some(number), face.distance);
            }
        }
        best
    }

    /// The faces of the surface that have a normal.
    pub fn exposed_faces(&self) -> impl Iterator<Item = &Face> {
        self.faces.iter().filter(|face| face.exposed && face.distance.is_finite())
    }

    /// Replaces the faces that `vertex` is above, from `seen` on, by a fan around it.
    ///
    /// False if rounding has spoilt the surface: the hole not bounded by one ring, or a face turned.
    pub fn expand(&mut self, vertex: Vertex, seen: usize) -> bool {
        if self.faces[seen].distance > 0.0 {
            self.reached = self.faces[seen].distance;
        }
        let apex = self.vertices.len();
        self.vertices.push(vertex);
        let ring = self.dig(&vertex.w, seen);
        let first = self.faces.len();
        for rim in &ring {
            let next = ring.iter().position(|other| other.from == rim.to);
            let last = ring.iter().position(|other| other.to == rim.from);
            let (Some(next), Some(last)) = (next, last) else { return false };
            let number = self.faces.len();
            let face = self.face([rim.from, rim.to, apex], [rim.outside, first + next, first + last]);
            if !self.sound(&face) {
                return false;
            }
            self.faces.push(face);
            let outside = &mut self.faces[rim.outside];
            for i in 0..3 {
                if outside.corners[i] == rim.to && outside.corners[(i + 1) % 3] == rim.from {
                    outside.neighbours[i] = number;
                }
            }
        }
        !ring.is_empty()
    }

    /// Takes away the faces visible from `point` that are connected to `seen`; returns the rim.
    fn dig(&mut self, point: &Vec3, seen: usize) -> Vec<Rim> {
        let margin = ROUNDING * self.size;
        let mut ring = Vec::new();
        let mut hole = vec![seen];
        self.faces[seen].exposed = false;
        while let Some(number) = hole.pop() {
            let Face { corners, neighbours, .. } = self.faces[number];
            for (i, outside) in neighbours.into_iter().enumerate() {
                let face = &mut self.faces[outside];
                if face.exposed && face.visible_from(point, margin) {
                    face.exposed = false;
                    hole.push(outside);
                } else if face.exposed {
                    ring.push(Rim { from: corners[i], to: corners[(i + 1) % 3], outside });
                }
            }
        }
        ring
    }

    fn face(&self, corners: [usize; 3], neighbours: [usize; 3]) -> Face {
        let [p, q, r] = corners.map(|i| self.vertices[i].w);
        let normal = (q - p).cross(&(r - p));
        let longest = (q - p).norm().max((r - p).norm()).max((r - q).norm());
        let (normal, distance) = match normal.try_normalize(SLIVER * self.size * longest) {
            Some(normal) => (normal, normal.dot(&p)),
            None => (Vec3::zeros(), f64::INFINITY),
        };
        Face { corners, neighbours, normal, distance, exposed: true }
    }

    /// The centre stays inside, and from an origin inside the nearest face only recedes: a normal that
    /// says otherwise has been turned by rounding.
    fn sound(&self, face: &Face) -> bool {
        face.normal.dot(&self.inside) <= face.distance && face.distance > self.reached - TURNED * self.size
    }
}

/// What the set offers for a first polytope.
pub(super) enum Start {
    /// Four points well apart.
    Solid([Vertex; 4]),
    /// The set is a needle, of which all faces would be slivers.
    Thin,
    /// The set lies in a plane of this unit normal.
    Flat(Vec3),
}

/// Grows point, line, plane and solid, each by the support points farthest from what there is.
pub(super) fn start(set: &Difference) -> Start {
    let thin = FLAT * set.size;
    let both = |direction: &Vec3| [set.support(direction), set.support(&-direction)];
    let (p, q) = longest(set);
    if length(&(p, q)) <= thin {
        let normal = set.placement.translation.try_normalize(0.0).unwrap_or_else(Vec3::z);
        return Start::Flat(normal);
    }
    let [line, aside, above] = frame(&(p, q));
    let off_line = |v: &Vertex| (v.w - p.w).cross(&line).norm();
    let r = farthest([both(&aside), both(&above)].concat(), off_line);
    if off_line(&r) <= thin {
        return Start::Flat(aside);
    }
    let normal = line.cross(&(r.w - p.w)).normalize();
    let off_plane = |v: &Vertex| (v.w - p.w).dot(&normal).abs();
    let s = farthest(both(&normal).to_vec(), off_plane);
    if off_plane(&s) <= thin {
        Start::Flat(normal)
    } else if off_line(&r) <= THIN * set.size {
        Start::Thin
    } else {
        Start::Solid([p, q, r, s])
    }
}

/// Directions across the longest extent of the set: the normals of a needle.
pub(super) fn across(set: &Difference, number: usize) -> impl Iterator<Item = Vec3> {
    let [_, aside, above] = frame(&longest(set));
    (0..number).map(move |k| {
        let on_circle = on_circle(k as f64 / number as f64);
        aside * on_circle.x + above * on_circle.y
    })
}

/// The farthest of the pairs of opposite support points along the axes.
fn longest(set: &Difference) -> (Vertex, Vertex) {
    let along = |axis: usize| (set.support(&Vec3::ith(axis, 1.0)), set.support(&-Vec3::ith(axis, 1.0)));
    let [x, y, z] = [0, 1, 2].map(along);
    [y, z].into_iter().fold(x, |best, pair| if length(&pair) > length(&best) { pair } else { best })
}

/// Unit vectors along a pair of points and across it.
fn frame((p, q): &(Vertex, Vertex)) -> [Vec3; 3] {
    let line = (q.w - p.w).normalize();
    let aside = line.cross(&Vec3::ith(line.iamin(), 1.0)).normalize();
    [line, aside, line.cross(&aside)]
}

fn length((p, q): &(Vertex, Vertex)) -> f64 {
    (q.w - p.w).norm()
}

/// The first of the vertices of largest measure; there is at least one.
fn farthest(vertices: Vec<Vertex>, measure: impl Fn(&Vertex) -> f64) -> Vertex {
    vertices.iter().fold(vertices[0], |best, v| if measure(v) > measure(&best) { *v } else { best })
}
