//! Mass properties of a union of convex polyhedra, exact: each is cut along the faces of those before it, and what
//! lies outside of all of them is summed.

use super::MassProperties;
use crate::{ConvexHull, TriMesh, Vec3};

/// Points closer than this to a plane lie on it (relative to the size of the union).
const ON_PLANE: f64 = 1e-13;
/// Pieces of less volume than this are rounding (relative to the cube of the size of the union).
const SLIVER: f64 = 1e-16;
/// Pieces beyond which the union is too involved to be cut.
const MAX_PIECES: usize = 20_000;

/// A convex polyhedron as the polygons of its surface, counter-clockwise seen from outside (m).
#[derive(Clone)]
struct Piece(Vec<Vec<Vec3>>);

/// Of the union of polyhedra, whose size is about `size` (m); `None` if it falls into too many pieces.
pub(super) fn union(hulls: &[ConvexHull], size: f64) -> Option<MassProperties> {
    let mut solids = Vec::new();
    for (k, hull) in hulls.iter().enumerate() {
        let mut pieces = vec![Piece::of(hull)];
        for other in &hulls[..k] {
            pieces = pieces.into_iter().flat_map(|piece| piece.outside(other, size)).collect();
            if pieces.len() + solids.len() > MAX_PIECES {
                return None;
            }
        }
        let massive = |mass: &MassProperties| mass.volume > SLIVER * size.powi(3);
        solids.extend(pieces.iter().map(Piece::mass).filter(massive));
    }
    Some(MassProperties::sum(&solids))
}

impl Piece {
    fn of(hull: &ConvexHull) -> Self {
        let corner = |k: &u32| hull.vertices[*k as usize];
        Self(hull.faces.iter().map(|face| face.vertices.iter().map(corner).collect()).collect())
    }

    /// The parts of the piece outside a polyhedron: beyond its first face, behind that and beyond the second, ...
    fn outside(self, hull: &ConvexHull, size: f64) -> Vec<Self> {
        let tolerance = ON_PLANE * size;
        let mut inside = self.clone();
        let mut beyond = Vec::new();
        for face in &hull.faces {
            let (below, above) = inside.cut(&face.normal, face.offset, tolerance);
            beyond.extend(above);
            match below {
                Some(rest) => inside = rest,
                // The two do not meet: the piece stays whole.
                None => return vec![self],
            }
        }
        beyond
    }

    /// The parts of the piece below and above the plane normal·x = offset.
    fn cut(&self, normal: &Vec3, offset: f64, tolerance: f64) -> (Option<Self>, Option<Self>) {
        let height = |x: &Vec3| normal.dot(x) - offset;
        let mut corners = self.0.iter().flatten();
        if corners.clone().all(|x| height(x) <= tolerance) {
            return (Some(self.clone()), None);
        }
        if corners.all(|x| height(x) >= -tolerance) {
            return (None, Some(self.clone()));
        }
        let (mut below, mut above, mut rim) = (Vec::new(), Vec::new(), Vec::new());
        for polygon in &self.0 {
            let [low, high] = cut_polygon(polygon, height, tolerance, &mut rim);
            below.extend((low.len() > 2).then_some(low));
            above.extend((high.len() > 2).then_some(high));
        }
        let lid = around(&rim, normal);
        above.push(lid.iter().rev().copied().collect());
        below.push(lid);
        (Some(Self(below)), Some(Self(above)))
    }

    fn mass(&self) -> MassProperties {
        let mut mesh = TriMesh::default();
        for polygon in &self.0 {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend(polygon);
            mesh.triangles.extend((1..polygon.len() as u32 - 1).map(|k| [first, first + k, first + k + 1]));
        }
        MassProperties::of_closed_mesh(&mesh)
    }
}

/// The parts of a convex polygon below and above a plane; its points on the plane are added to `rim`.
fn cut_polygon(
    polygon: &[Vec3],
    height: impl Fn(&Vec3) -> f64,
    tolerance: f64,
    rim: &mut Vec<Vec3>,
) -> [Vec<Vec3>; 2] {
    let (mut low, mut high) = (Vec::new(), Vec::new());
    for (k, x) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let (here, there) = (height(x), height(next));
        if here <= tolerance {
            low.push(*x);
        }
        if here >= -tolerance {
            high.push(*x);
        }
        if here.abs() <= tolerance {
            rim.push(*x);
        } else if there.abs() > tolerance && (here < 0.0) != (there < 0.0) {
            let crossing = x + (next - x) * (here / (here - there));
            low.push(crossing);
            high.push(crossing);
            rim.push(crossing);
        }
    }
    [low, high]
}

/// The points of a plane convex rim in order, counter-clockwise about the normal.
fn around(rim: &[Vec3], normal: &Vec3) -> Vec<Vec3> {
    let middle = rim.iter().sum::<Vec3>() / rim.len().max(1) as f64;
    let across = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
    let angle = |x: &Vec3| libm::atan2(normal.cross(&across).dot(&(x - middle)), across.dot(&(x - middle)));
    let mut ordered: Vec<Vec3> = rim.to_vec();
    ordered.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    ordered
}
