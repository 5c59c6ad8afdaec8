//! Convex polyhedra.

use super::feature::{Feature, SIDES};
use super::line::{WHOLE_LINE, below, closed_after};
use super::surface_points::{SurfaceElement, on_triangles};
use super::{Convex, FacePlane, Support, bounds_of, offer, radius_of};
use crate::hull::{ConvexHull, Face};
use crate::mesh::leaders;
use crate::{Mat3, Vec3};

/// Corners closer than this are one (relative to the size of a polyhedron).
const COINCIDENT: f64 = 4e-9;

/// Vertices of a convex polyhedron, also laid out for a vectorised support scan.
#[derive(Clone, Debug)]
pub struct Polyhedron {
    vertices: Vec<Vec3>,
    /// x, y, z of four vertices at a time; the last group is filled up with the first vertex.
    lanes: Vec<[[f64; LANES]; 3]>,
    /// Largest distance of a vertex from the origin (m).
    radius: f64,
    faces: Vec<Face>,
}

const LANES: usize = 4;

impl Polyhedron {
    pub(crate) fn new(vertices: Vec<Vec3>, faces: Vec<Face>) -> Self {
        assert!(!vertices.is_empty(), "a polyhedron needs at least one vertex");
        let lanes = vertices
            .chunks(LANES)
            .map(|group| {
                std::array::from_fn(|axis| {
                    std::array::from_fn(|lane| group.get(lane).unwrap_or(&vertices[0])[axis])
                })
            })
            .collect();
        let radius = radius_of(&vertices);
        Self { vertices, lanes, radius, faces }
    }

    /// The flat faces, as loops of vertex numbers; none if the vertices span no volume.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The vertices, in the order given (m).
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Corners of the body with sharp edges of which this is the core under a crust (m).
    pub(crate) fn sharp_corners(&self, crust: f64) -> Vec<Vec3> {
        let vertices = self.vertices.clone();
        let centre = vertices.iter().sum::<Vec3>() / vertices.len() as f64;
        let hull = ConvexHull { vertices, faces: self.faces.clone() };
        let corners = hull.eroded_vertices(&centre, -crust).unwrap_or_default();
        let size = corners.iter().map(|v| (v - centre).amax()).fold(0.0, f64::max);
        let leader = leaders(&corners, COINCIDENT * size);
        let kept = corners.iter().zip(&leader).enumerate().filter(|(k, (_, leader))| *k as u32 == **leader);
        kept.map(|(_, (corner, _))| *corner).collect()
    }
}

impl Support for Polyhedron {
    const CURVED: bool = false;
    const FACED: bool = true;

    #[inline]
    fn facing(&self, direction: &Vec3) -> Option<FacePlane> {
        let mut best = (0, f64::NEG_INFINITY);
        for (number, face) in self.faces.iter().enumerate() {
            let along = face.normal.dot(direction);
            if along > best.1 {
                best = (number, along);
            }
        }
        let Face { normal, offset, .. } = self.faces.get(best.0)?;
        Some(FacePlane { number: best.0, normal: *normal, offset: *offset })
    }

    #[inline]
    fn is_below(&self, face: &FacePlane, point: &Vec3) -> bool {
        let corners = &self.faces[face.number].vertices;
        let mut last = corners.last().copied().unwrap_or(0);
        corners.iter().all(|&next| {
            let (from, to) = (self.vertices[last as usize], self.vertices[next as usize]);
            last = next;
            (to - from).cross(&(point - from)).dot(&face.normal) >= 0.0
        })
    }

    #[inline]
    fn corners(&self, face: &FacePlane, to: &mut [Vec3]) -> Option<usize> {
        let corners = &self.faces[face.number].vertices;
        let to = to.get_mut(..corners.len())?;
        to.iter_mut().zip(corners).for_each(|(to, &k)| *to = self.vertices[k as usize]);
        Some(corners.len())
    }

    #[inline]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let mut best = [f64::NEG_INFINITY; LANES];
        let mut group = [0; LANES];
        for (number, points) in self.lanes.iter().enumerate() {
            let heights = heights(points, direction);
            for lane in 0..LANES {
                let higher = heights[lane] > best[lane];
                best[lane] = if higher { heights[lane] } else { best[lane] };
                group[lane] = if higher { number } else { group[lane] };
            }
        }
        let pick = |i: usize, j: usize| if best[j] > best[i] { j } else { i };
        let (low, high) = (pick(0, 1), pick(2, 3));
        let lane = pick(low, high);
        let [x, y, z] = &self.lanes[group[lane]];
        Vec3::new(x[lane], y[lane], z[lane])
    }

    /// Four running maxima side by side: no branch in the scan.
    #[inline]
    fn height(&self, direction: &Vec3) -> f64 {
        let mut best = [f64::NEG_INFINITY; LANES];
        for points in &self.lanes {
            let heights = heights(points, direction);
            for lane in 0..LANES {
                best[lane] = larger(heights[lane], best[lane]);
            }
        }
        larger(larger(best[0], best[1]), larger(best[2], best[3]))
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.radius
    }

    #[inline(always)]
    fn polyhedron(&self) -> Option<&Polyhedron> {
        (!self.faces.is_empty()).then_some(self)
    }
}

impl Convex for Polyhedron {
    fn bounds(&self) -> (Vec3, Vec3) {
        bounds_of(&self.vertices)
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64 {
        self.vertices.iter().map(|v| (rotation * v + center).norm()).fold(0.0, f64::max) + crust
    }

    fn for_each_vertex(&self, visit: impl FnMut(Vec3)) {
        self.vertices.iter().copied().for_each(visit);
    }

    #[inline]
    fn vertex(&self, number: usize) -> Vec3 {
        self.vertices[number]
    }

    #[inline]
    fn number_of(&self, point: &Vec3) -> Option<u16> {
        self.vertices.iter().position(|vertex| vertex == point).map(|k| k as u16)
    }

    fn offset_from(&self, _point: &Vec3) -> Option<Vec3> {
        None
    }

    fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        let faces = self.faces.iter().map(|face| (face, face.normal.dot(direction)));
        let (face, _) = faces.reduce(|best, next| if next.1 > best.1 { next } else { best })?;
        // Of a face with many corners every second or third will do.
        let every = face.vertices.len().div_ceil(SIDES);
        let corners = face.vertices.iter().step_by(every).map(|&v| self.vertices[v as usize]);
        found.set(corners, Some(face.normal));
        found.is_whole = every == 1;
        Some(())
    }

    #[inline]
    fn contains(&self, crust: f64, point: &Vec3) -> bool {
        self.faces.iter().all(|face| face.normal.dot(point) <= face.offset + crust)
    }

    fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let turned = self.sharp_corners(crust).into_iter().map(|p| rotation * p);
        turned.fold(start, |(lower, upper), p| (lower.inf(&p), upper.sup(&p)))
    }

    fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        self.faces.iter().try_fold(WHOLE_LINE, |chord, face| {
            below(chord, face.normal.dot(along), face.offset + crust - face.normal.dot(start))
        })
    }

    fn exit(&self, crust: f64, point: &Vec3, direction: &Vec3) -> f64 {
        self.faces
            .iter()
            .map(|f| closed_after(f.offset + crust - f.normal.dot(point), f.normal.dot(direction)))
            .fold(f64::INFINITY, f64::min)
    }

    fn surface_normals(
        &self,
        crust: f64,
        point: &Vec3,
        across: Option<&Vec3>,
        mut visit: impl FnMut(f64, Vec3),
    ) {
        for face in &self.faces {
            offer(across, face.offset + crust - face.normal.dot(point), face.normal, &mut visit);
        }
    }

    fn surface_elements(&self, crust: f64, number: usize, visit: impl FnMut(SurfaceElement)) {
        if let Ok(hull) = ConvexHull::new(&self.sharp_corners(crust)) {
            on_triangles(&hull.triangles(), number, visit);
        }
    }

    fn has_exact_area(&self) -> bool {
        false
    }
}

/// d·x of four points.
#[inline(always)]
fn heights([x, y, z]: &[[f64; LANES]; 3], direction: &Vec3) -> [f64; LANES] {
    std::array::from_fn(|lane| x[lane] * direction.x + y[lane] * direction.y + z[lane] * direction.z)
}

/// The larger of two numbers, one machine instruction where `f64::max` must mind NaN.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
