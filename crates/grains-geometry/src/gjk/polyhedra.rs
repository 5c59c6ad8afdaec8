//! Two polyhedra: a corner on a face, or an edge on an edge, from what touched before.
//!
//! With the points x = M p + t of B in the frame of A:
//!
//! - The face of the body on which the foot of the corner was, of normal n and offset h, is that which looks most along the way
//!   between the two. The corner of the other body farthest against n is the answer if its foot p − n (n·p − h) lies behind
//!   all other faces.
//! - Edges with the ends a₀, a₁ and b₀, b₁ and the directions u and w have the common normal n = u × w. With s from a₀ to b₀,
//!
//! ```text
//! v = n (n·s)/n²,   s_A = (s × w)·n/n²,   s_B = (s × u)·n/n²
//! ```
//!
//! are the way between them and the places of its ends: the answer if both are on the edges and no plane speaks against it.
//!
//! There are no branches but loops over corners and faces, so that pairs of the same two bodies are answered together in the
//! lanes of the processor.

mod lanes;
mod start;

use super::faces_and_edges::PARALLEL;
use super::query::Query;
use super::{MEETING, STALLED_TOLERANCE, Separation, Simplex, TOLERANCE};
use crate::convex::Support as _;
use crate::lanes::{Matrix, Number, Vector};
use crate::{Placement, Polyhedron, Vec3};
pub use lanes::PolyhedronQueries;
pub use start::PolyhedronStart;

/// Depth below the planes of all other faces from which on a foot counts as on a face, not on its edge or at a corner (relative to the size).
const MARGIN: f64 = 1e-8;

/// Distance of two polyhedra that touched corner on face or edge on edge, if they still do.
#[inline(always)]
pub(super) fn pair(hulls: [&Polyhedron; 2], query: &Query, simplex: &mut Simplex) -> Option<Separation> {
    let features = Features::of(&hulls, simplex)?;
    let pair = Pair::<f64>::of(query.placement);
    let touched = match &features {
        Features::OnFirst(points) => pair.over_first(hulls, &pair.between(points)),
        Features::OnSecond(points) => pair.over_second(hulls, &pair.between(points)),
        Features::Edges(ends) => pair.edge_on_edge(hulls, ends),
    };
    let answer = touched.answer()?;
    features.leave(hulls, &touched, simplex);
    Some(if touched.distance > query.cutoff { Separation::Beyond { axis: touched.normal() } } else { answer })
}

/// What touched of two polyhedra, in the frames of the bodies (m).
enum Features {
    /// A point of a face of the first and a corner of the second.
    OnFirst([Vector<f64>; 2]),
    /// A corner of the first and a point of a face of the second.
    OnSecond([Vector<f64>; 2]),
    /// Ends of an edge of each.
    Edges([[Vector<f64>; 2]; 2]),
}

impl Features {
    /// Those of a simplex, if it is of one of these.
    #[inline(always)]
    fn of(hulls: &[&Polyhedron; 2], simplex: &Simplex) -> Option<Self> {
        let sides = [&simplex.a, &simplex.b];
        match simplex.len {
            1 => {
                let points = sides.map(|points| Vector::of(&points[0]));
                let is_corner = hulls[0].vertices().contains(&simplex.a[0]);
                Some(if is_corner { Self::OnSecond(points) } else { Self::OnFirst(points) })
            }
            3 => {
                let [a, b] = sides.map(|points| start::ends([points[0], points[1], points[2]]));
                Some(Self::Edges([a?, b?].map(|[first, last]| [Vector::of(&first), Vector::of(&last)])))
            }
            _ => None,
        }
    }

    /// Leaves what touches as the start of the next query.
    #[inline(always)]
    fn leave(&self, hulls: [&Polyhedron; 2], touched: &Touched<f64>, simplex: &mut Simplex) {
        let (foot, corner) =
            (touched.foot.get(), |side: usize| hulls[side].vertices()[touched.place as usize]);
        match self {
            Self::OnFirst(_) => (simplex.len, simplex.a[0], simplex.b[0]) = (1, foot, corner(1)),
            Self::OnSecond(_) => (simplex.len, simplex.a[0], simplex.b[0]) = (1, corner(0), foot),
            Self::Edges(ends) => {
                let ends = ends.each_ref().map(|ends| ends.each_ref().map(Vector::<f64>::get));
                let [a, b] = start::triangle(ends, touched.place > 0.5);
                simplex.len = 3;
                for k in 0..3 {
                    (simplex.a[k], simplex.b[k]) = (a[k], b[k]);
                }
            }
        }
    }
}

/// How the second of two polyhedra lies in the frame of the first.
#[derive(Clone, Copy, Debug)]
struct Pair<T> {
    /// Rotation times scale of B.
    matrix: Matrix<T>,
    /// Centre of B (m).
    translation: Vector<T>,
}

/// Points of two polyhedra that are nearest each other.
#[derive(Clone, Copy, Debug)]
struct Touched<T> {
    /// Distance (m); not a number if they are not known to be nearest.
    distance: T,
    /// Unit vector from A to B.
    normal: Vector<T>,
    /// The point of A (m).
    point_a: Vector<T>,
    /// Foot of the corner over a face, in the frame of the body with the face (m); of edges any.
    foot: Vector<T>,
    /// Number of that corner; of edges, whether the point of A is farther along its edge than that of B: 1 or 0.
    place: T,
}

/// The face of a polyhedron that looks most along a direction.
struct Plane<T> {
    number: T,
    /// Outward unit normal.
    normal: Vector<T>,
    /// Distance from the origin of the body (m).
    offset: T,
}

/// A corner of a polyhedron.
struct Corner<T> {
    number: T,
    /// Where it is, in the frame of the body (m).
    point: Vector<T>,
}

impl Pair<f64> {
    fn of(placement: &Placement) -> Self {
        Self { matrix: Matrix::of(&placement.matrix), translation: Vector::of(&placement.translation) }
    }
}

impl<T: Number> Pair<T> {
    /// From A to B between points in the frames of their bodies (m).
    #[inline(always)]
    fn between(&self, [on_a, on_b]: &[Vector<T>; 2]) -> Vector<T> {
        self.in_frame_of_a(on_b).minus(on_a)
    }

    #[inline(always)]
    fn in_frame_of_a(&self, point: &Vector<T>) -> Vector<T> {
        self.matrix.times(point).plus(&self.translation)
    }

    /// A corner of B over the face of A that looks along the way v from A to B.
    #[inline(always)]
    fn over_first(&self, [a, b]: [&Polyhedron; 2], v: &Vector<T>) -> Touched<T> {
        let face = facing(a, v);
        let corner = farthest(b, &self.matrix.transposed_times(&face.normal).times(T::of(-1.0)));
        let point = self.in_frame_of_a(&corner.point);
        let distance = face.normal.dot(&point) - face.offset;
        let foot = point.minus(&face.normal.times(distance));
        Touched {
            distance: self.known(distance, height_over_others(a, &face, &foot), [a, b]),
            normal: face.normal,
            point_a: foot,
            foot,
            place: corner.number,
        }
    }

    /// A corner of A over the face of B that looks against the way v from A to B.
    #[inline(always)]
    fn over_second(&self, [a, b]: [&Polyhedron; 2], v: &Vector<T>) -> Touched<T> {
        let face = facing(b, &self.matrix.transposed_times(v).times(T::of(-1.0)));
        let outwards = self.matrix.times(&face.normal);
        let squared = outwards.squared();
        let (scale, inverse) = (squared.sqrt(), T::of(1.0) / squared);
        let corner = farthest(a, &outwards.times(T::of(-1.0)));
        let point = self.matrix.transposed_times(&corner.point.minus(&self.translation)).times(inverse);
        let height = face.normal.dot(&point) - face.offset;
        let foot = point.minus(&face.normal.times(height));
        Touched {
            distance: self.known(height * scale, height_over_others(b, &face, &foot), [a, b]),
            normal: outwards.times(-scale * inverse),
            point_a: corner.point,
            foot,
            place: corner.number,
        }
    }

    /// A distance (m) if it is not too small and the foot is below the other faces, its largest height over them being `above` (m); else
    /// not a number.
    #[inline(always)]
    fn known(&self, distance: T, above: T, hulls: [&Polyhedron; 2]) -> T {
        let (none, size) = (T::of(f64::NAN), self.size(hulls));
        let on_face = (T::of(-MARGIN) * size).if_above(above, distance, none);
        distance.if_above(T::of(MEETING) * size, on_face, none)
    }

    /// The nearest points if an edge of A and one of B are nearest where they cross.
    #[inline(always)]
    fn edge_on_edge(&self, [a, b]: [&Polyhedron; 2], ends: &[[Vector<T>; 2]; 2]) -> Touched<T> {
        let ([a0, a1], [b0, b1]) = (&ends[0], &ends[1]);
        let (start, u, w) = (self.between(&[*a0, *b0]), a1.minus(a0), self.matrix.times(&b1.minus(b0)));
        let across = u.cross(&w);
        let squared = across.squared();
        let inverse = T::of(1.0) / squared;
        let way = across.times(across.dot(&start) * inverse);
        let [on_a, on_b] = [&w, &u].map(|edge| start.cross(edge).dot(&across) * inverse);
        let gap = way.squared();
        let distance = gap.sqrt();
        let back = self.matrix.transposed_times(&way).times(T::of(-1.0));
        let height = way.dot(&self.translation) - height(a, &way) - height(b, &back);
        // As `Bounds::are_closed`.
        let slack = gap - height;
        let size = self.size([a, b]);
        let tolerance = slack.if_above(T::of(0.0), T::of(TOLERANCE), T::of(STALLED_TOLERANCE)) * size;
        let none = T::of(f64::NAN);
        let closed = (tolerance * tolerance * gap).if_above(slack * slack, distance, none);
        let apart = distance.if_above(T::of(MEETING) * size, closed, none);
        let crossing = squared.if_above(T::of(PARALLEL) * u.squared() * w.squared(), apart, none);
        let on_edge = |known: T, place: T| {
            let from_start = T::of(0.0).if_above(place, none, known);
            place.if_above(T::of(1.0), none, from_start)
        };
        let is_farther_on_a = on_b.if_above(on_a, T::of(0.0), T::of(1.0));
        Touched {
            distance: on_edge(on_edge(crossing, on_a), on_b),
            normal: way.times(T::of(1.0) / distance),
            point_a: a0.plus(&u.times(on_a)),
            foot: *b0,
            place: is_farther_on_a,
        }
    }

    /// A length like the largest coordinate (m).
    #[inline(always)]
    fn size(&self, [a, b]: [&Polyhedron; 2]) -> T {
        let scale = self.matrix.0[0].sum_of_sizes();
        T::of(a.extent()) + T::of(b.extent()) * scale + self.translation.sum_of_sizes()
    }
}

impl Touched<f64> {
    fn normal(&self) -> Vec3 {
        self.normal.get()
    }

    /// The answer, if the points are known to be nearest.
    #[inline(always)]
    fn answer(&self) -> Option<Separation> {
        let (distance, normal, point_a) = (self.distance, self.normal(), self.point_a.get());
        let point_b = point_a + normal * distance;
        (!distance.is_nan()).then_some(Separation::Apart { distance, normal, point_a, point_b })
    }
}

/// The face of a polyhedron that looks most along a direction.
#[inline(always)]
fn facing<T: Number>(hull: &Polyhedron, direction: &Vector<T>) -> Plane<T> {
    let (zero, mut best) = (T::of(0.0), T::of(f64::NEG_INFINITY));
    let mut plane = Plane { number: zero, normal: Vector([zero; 3]), offset: zero };
    for (number, face) in hull.faces().iter().enumerate() {
        let normal = Vector::of(&face.normal);
        let along = normal.dot(direction);
        let is_better = (along, best);
        plane = Plane {
            number: along.if_above(best, T::of(number as f64), plane.number),
            normal: Vector::if_above(is_better, &normal, &plane.normal),
            offset: along.if_above(best, T::of(face.offset), plane.offset),
        };
        best = along.if_above(best, along, best);
    }
    plane
}

/// The corner of a polyhedron farthest along a direction.
#[inline(always)]
fn farthest<T: Number>(hull: &Polyhedron, direction: &Vector<T>) -> Corner<T> {
    let (zero, mut best) = (T::of(0.0), T::of(f64::NEG_INFINITY));
    let mut corner = Corner { number: zero, point: Vector([zero; 3]) };
    for (number, vertex) in hull.vertices().iter().enumerate() {
        let point = Vector::of(vertex);
        let along = point.dot(direction);
        corner = Corner {
            number: along.if_above(best, T::of(number as f64), corner.number),
            point: Vector::if_above((along, best), &point, &corner.point),
        };
        best = along.if_above(best, along, best);
    }
    corner
}

/// Largest d·x of a corner of a polyhedron.
#[inline(always)]
fn height<T: Number>(hull: &Polyhedron, direction: &Vector<T>) -> T {
    let mut best = T::of(f64::NEG_INFINITY);
    for vertex in hull.vertices() {
        let along = Vector::of(vertex).dot(direction);
        best = along.if_above(best, along, best);
    }
    best
}

/// Largest height of a point over the faces of a polyhedron but one (m).
#[inline(always)]
fn height_over_others<T: Number>(hull: &Polyhedron, one: &Plane<T>, point: &Vector<T>) -> T {
    let lowest = T::of(f64::NEG_INFINITY);
    let mut highest = lowest;
    for (number, face) in hull.faces().iter().enumerate() {
        let height = Vector::of(&face.normal).dot(point) - T::of(face.offset);
        let height = one.number.if_equal(T::of(number as f64), lowest, height);
        highest = height.if_above(highest, height, highest);
    }
    highest
}
