//! Two boxes: a corner on a face, or an edge on an edge, from what touched before.
//!
//! With the points x = M p + t of B in the frame of A:
//!
//! - The faces that look at each other are those whose normals are nearest the way v from A to B. The corner of the other
//!   box farthest against the normal of one is the answer if its foot lies on the face.
//! - Edges along axis i of A and j of B have the common normal n = e_i × M e_j, turned from A to B, which says which of
//!   the four edges of a box looks at the other box. With w from the middle of one to that of the other,
//!
//! ```text
//! v = n (n·w)/n²,   s_A = ±(w × M e_j)·n/n²,   s_B = ±(w × e_i)·n/n²
//! ```
//!
//! are the way between the edges and the places of its ends from their middles, with − if n was turned: the answer if both
//! are on the edges and no plane speaks against it.
//!
//! What touched before is looked at first. Boxes that rock change between all these from step to step: next are the two
//! faces, then all pairs of edges about them. There are no branches, so that many pairs are answered at once in the lanes of
//! the processor.

mod lanes;
mod start;

use super::faces_and_edges::PARALLEL;
use super::nearest::nearest;
use super::query::{Bounds, Query};
use super::{MEETING, Separation, Simplex, TOLERANCE};
use crate::{Mat3, Vec3};
pub use lanes::BoxQueries;
pub use start::BoxStart;
use start::axes_of;

/// Pairs of edges that look in different ways about two faces.
const PAIRS_OF_EDGES: usize = 4;

/// Distance of two boxes of half edges (m) that touched, if corner on face or edge on edge.
#[inline(always)]
pub(super) fn pair(halves: [Vec3; 2], query: &Query, simplex: &mut Simplex) -> Option<Separation> {
    if simplex.len == 0 {
        return None;
    }
    let pair = Pair { halves, matrix: query.placement.matrix, translation: query.placement.translation };
    let touched = match BoxStart::of(&halves, simplex) {
        Some(BoxStart::CornerOnFace(points)) => {
            let v = pair.between(&points);
            pair.corner_on_face(&v).or_else(|| pair.elsewhere(&v))
        }
        Some(BoxStart::EdgeOnEdge(corners)) => {
            let edges = axes_of(&corners).map(unit_vector);
            pair.edge_on_edge(&edges).or_else(|| pair.elsewhere(&pair.across(&edges)))
        }
        None => pair.elsewhere(&pair.way_of(simplex)?),
    };
    let answer = touched.answer()?;
    touched.start(&halves).put_in(&halves, simplex);
    let Touched { distance, normal, .. } = touched;
    Some(if distance > query.cutoff { Separation::Beyond { axis: normal } } else { answer })
}

/// Two boxes in the frame of the first.
struct Pair {
    /// Half edges (m).
    halves: [Vec3; 2],
    /// Rotation times scale of B.
    matrix: Mat3,
    /// Centre of B (m).
    translation: Vec3,
}

/// Points of two boxes that are nearest each other.
struct Touched {
    /// Distance (m); not a number if they are not known to be nearest.
    distance: f64,
    /// Unit vector from A to B.
    normal: Vec3,
    /// A point of each box, in its own frame (m).
    points: [Vec3; 2],
    /// Unit vectors along the edges they are on, in the frames of their boxes; zero if a corner is on a face.
    edges: [Vec3; 2],
}

impl Touched {
    #[inline(always)]
    fn is_known(&self) -> bool {
        !self.distance.is_nan()
    }

    /// These points if they are nearest for all that is known.
    #[inline(always)]
    fn known_if(self, is_known: bool) -> Self {
        Self { distance: select(is_known, self.distance, f64::NAN), ..self }
    }

    /// These points, or others if they are not known to be nearest.
    #[inline(always)]
    fn or_else(self, others: impl FnOnce() -> Self) -> Self {
        if self.is_known() { self } else { others() }
    }

    /// One of two.
    #[inline(always)]
    fn either(is_first: bool, first: &Self, second: &Self) -> Self {
        let vector = |first: &Vec3, second: &Vec3| first.zip_map(second, |p, q| select(is_first, p, q));
        Self {
            distance: select(is_first, first.distance, second.distance),
            normal: vector(&first.normal, &second.normal),
            points: [0, 1].map(|side| vector(&first.points[side], &second.points[side])),
            edges: [0, 1].map(|side| vector(&first.edges[side], &second.edges[side])),
        }
    }

    #[inline(always)]
    fn answer(&self) -> Option<Separation> {
        let &Self { distance, normal, points: [point_a, _], .. } = self;
        let point_b = point_a + normal * distance;
        self.is_known().then_some(Separation::Apart { distance, normal, point_a, point_b })
    }

    /// The start of the next query of boxes of half edges (m).
    #[inline(always)]
    fn start(&self, halves: &[Vec3; 2]) -> BoxStart {
        match self.edges.map(|edge| bit_of(&edge)) {
            [0, _] => BoxStart::CornerOnFace(self.points),
            axes => BoxStart::of_edges(halves, axes, &self.points),
        }
    }
}

impl Pair {
    /// From A to B between points in the frames of their boxes (m).
    #[inline(always)]
    fn between(&self, [on_a, on_b]: &[Vec3; 2]) -> Vec3 {
        self.matrix * on_b + self.translation - on_a
    }

    /// Across edges along unit vectors, from A to B, of any length.
    #[inline(always)]
    fn across(&self, [e_a, e_b]: &[Vec3; 2]) -> Vec3 {
        let across = e_a.cross(&(self.matrix * e_b));
        across * 1.0_f64.copysign(across.dot(&self.translation))
    }

    /// From A to B between the nearest points of a simplex (m).
    #[cold]
    fn way_of(&self, simplex: &Simplex) -> Option<Vec3> {
        let w = std::array::from_fn(|k| self.between(&[simplex.a[k], simplex.b[k]]));
        nearest(simplex.len as usize, &w).map(|found| found.point)
    }

    /// What touches of the faces that look at each other along the way v from A to B, and of the edges about them.
    #[cold]
    #[inline(never)]
    fn elsewhere(&self, v: &Vec3) -> Touched {
        (0..PAIRS_OF_EDGES).fold(self.corner_on_face(v), |touched, number| {
            touched.or_else(|| self.edge_on_edge(&self.edges_about(v, number)))
        })
    }

    /// Unit vectors along the edges of one of four pairs about the faces that look at each other along the way v from A to B.
    #[inline(always)]
    fn edges_about(&self, v: &Vec3, number: usize) -> [Vec3; 2] {
        let next = |axis: &Vec3| Vec3::new(axis.z, axis.x, axis.y);
        let [of_a, of_b] = [facing(v), facing(&-self.matrix.tr_mul(v))].map(|face| next(&face.abs()));
        [
            if number < 2 { of_a } else { next(&of_a) },
            if number.is_multiple_of(2) { of_b } else { next(&of_b) },
        ]
    }

    /// The nearest points if a corner is on one of the faces that look at each other along the way v from A to B.
    ///
    /// Which box has the face is not known: the one whose face looks more directly at the other comes first.
    #[inline(always)]
    fn corner_on_face(&self, v: &Vec3) -> Touched {
        let back = -self.matrix.tr_mul(v);
        let (of_a, of_b) = (facing(v), facing(&back));
        let (direct_a, direct_b) = (of_a.dot(v), of_b.dot(&back));
        let is_a_first = direct_a * direct_a * self.matrix.column(0).norm_squared() >= direct_b * direct_b;
        let lowest = MEETING * self.size();
        let (first, second) = (self.over_first(&of_a, lowest), self.over_second(&of_b, lowest));
        let is_first = (is_a_first & first.is_known()) | !second.is_known();
        Touched::either(is_first, &first, &second)
    }

    /// A corner of B farther than `lowest` (m) over the face of A with an outward normal.
    #[inline(always)]
    fn over_first(&self, normal: &Vec3, lowest: f64) -> Touched {
        let [of_a, of_b] = &self.halves;
        let corner = farthest(of_b, &-self.matrix.tr_mul(normal));
        let point = self.matrix * corner + self.translation;
        let distance = normal.dot(&point) - of_a.dot(&normal.abs());
        let nearest = Touched {
            distance,
            normal: *normal,
            points: [point - normal * distance, corner],
            edges: [Vec3::zeros(); 2],
        };
        nearest.known_if((distance > lowest) & is_over_face(of_a, normal, &point))
    }

    /// A corner of A farther than `lowest` (m) over the face of B with an outward normal.
    #[inline(always)]
    fn over_second(&self, normal: &Vec3, lowest: f64) -> Touched {
        let [of_a, of_b] = &self.halves;
        let outwards = self.matrix * normal;
        let squared = outwards.norm_squared();
        let (scale, inverse) = (squared.sqrt(), 1.0 / squared);
        let corner = farthest(of_a, &-outwards);
        let point = self.matrix.tr_mul(&(corner - self.translation)) * inverse;
        let height = normal.dot(&point) - of_b.dot(&normal.abs());
        let distance = height * scale;
        let nearest = Touched {
            distance,
            normal: outwards * (-scale * inverse),
            points: [corner, point - normal * height],
            edges: [Vec3::zeros(); 2],
        };
        nearest.known_if((distance > lowest) & is_over_face(of_b, normal, &point))
    }

    /// The nearest points if an edge along the axis `e_a` of A is on one along the axis `e_b` of B.
    #[inline(always)]
    fn edge_on_edge(&self, [e_a, e_b]: &[Vec3; 2]) -> Touched {
        let ([of_a, of_b], t) = (&self.halves, &self.translation);
        let along = self.matrix * e_b;
        let across = e_a.cross(&along);
        let sign = 1.0_f64.copysign(across.dot(t));
        let towards_b = across * sign;
        let middle_a = middle(of_a, e_a, &towards_b);
        let middle_b = middle(of_b, e_b, &-self.matrix.tr_mul(&towards_b));
        let w = self.matrix * middle_b + t - middle_a;
        let squared = across.norm_squared();
        let (root, inverse) = (squared.sqrt(), 1.0 / squared);
        let height = towards_b.dot(&w);
        let [on_a, on_b] = [&along, e_a].map(|edge| w.cross(edge).dot(&across) * inverse);
        let is_on_edges = (on_a.abs() <= of_a.dot(e_a)) & (on_b.abs() <= of_b.dot(e_b));
        let v = towards_b * (height * inverse);
        let bounds = Bounds {
            squared: v.norm_squared(),
            height: v.dot(t) - of_a.dot(&v.abs()) - of_b.dot(&self.matrix.tr_mul(&v).abs()),
        };
        let size = self.size();
        let is_apart = (height > MEETING * size * root) & bounds.are_closed(TOLERANCE * size);
        let is_parallel = squared <= PARALLEL * along.norm_squared();
        let nearest = Touched {
            distance: height / root,
            normal: towards_b * (1.0 / root),
            points: [middle_a + e_a * on_a, middle_b + e_b * on_b],
            edges: [*e_a, *e_b],
        };
        nearest.known_if(is_on_edges & is_apart & !is_parallel)
    }

    /// A length like the largest coordinate (m).
    #[inline(always)]
    fn size(&self) -> f64 {
        let [of_a, of_b] = &self.halves;
        of_a.sum() + of_b.sum() * self.matrix.column(0).abs().sum() + self.translation.abs().sum()
    }
}

/// Outward unit normal of the face of a box that looks along a direction.
#[inline(always)]
fn facing(direction: &Vec3) -> Vec3 {
    let [x, y, z] = direction.abs().into();
    let is_x = (x >= y) & (x >= z);
    let is_y = !is_x & (y >= z);
    let side = |holds: bool, along: f64| select(holds, 1.0_f64.copysign(along), 0.0);
    Vec3::new(side(is_x, direction.x), side(is_y, direction.y), side(!is_x & !is_y, direction.z))
}

/// Corner of a box of half edges that is farthest along a direction (m).
#[inline(always)]
fn farthest(half: &Vec3, direction: &Vec3) -> Vec3 {
    half.zip_map(direction, f64::copysign)
}

/// Middle of the edge along an axis of a box of half edges that is farthest along a direction across it (m).
#[inline(always)]
fn middle(half: &Vec3, axis: &Vec3, direction: &Vec3) -> Vec3 {
    farthest(half, direction).zip_map(axis, |x, on_axis| select(on_axis == 0.0, x, 0.0))
}

/// Whether a point before the face of a box has its foot on it.
#[inline(always)]
fn is_over_face(half: &Vec3, normal: &Vec3, point: &Vec3) -> bool {
    let is_between = |axis: usize| (point[axis].abs() <= half[axis]) | (normal[axis] != 0.0);
    is_between(0) & is_between(1) & is_between(2)
}

/// The unit vector along an axis that is given as a bit.
#[inline(always)]
fn unit_vector(axis: u16) -> Vec3 {
    Vec3::from_fn(|k, _| select(axis == 1 << k, 1.0, 0.0))
}

/// The axis of a unit vector, as a bit; none of zero.
#[inline(always)]
fn bit_of(axis: &Vec3) -> u16 {
    let bit = |k: usize| u16::from(axis[k] != 0.0) << k;
    bit(0) | bit(1) | bit(2)
}

#[inline(always)]
fn select(holds: bool, x: f64, other: f64) -> f64 {
    if holds { x } else { other }
}
