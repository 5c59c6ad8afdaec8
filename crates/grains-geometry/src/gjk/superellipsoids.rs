//! Two superellipsoids without edges (ε ≤ 1), from the points that were nearest before.
//!
//! Newton's method and the proof of its answer are those of [`smooth`](super::smooth), without branches, so that pairs of the same two
//! bodies are answered together in the lanes of the processor. Points that lie farther off the surfaces, and pairs that need
//! more steps, are left to it.

mod lanes;

use super::query::Query;
use super::smooth::LEAST_CURVATURE;
use super::{MEETING, Separation, Simplex, TOLERANCE};
use crate::Superellipsoid;
use crate::lanes::{Matrix, Number, Vector};
use crate::superellipsoid::{RoundBody, Surface};
pub use lanes::SuperellipsoidQueries;

/// Newton steps before a pair is left to the general method.
const MAX_STEPS: usize = 6;

/// Distance of two superellipsoids less their insets, from the nearest points of their surfaces in the last step.
#[inline(always)]
pub(super) fn pair(
    a: &Superellipsoid,
    b: &Superellipsoid,
    query: &Query,
    simplex: &mut Simplex,
) -> Option<Separation> {
    if simplex.len != 1 {
        return None;
    }
    let bodies = [a.round()?, b.round()?];
    let pair = Pair::new(
        &bodies,
        Matrix::<f64>::of(&query.placement.matrix),
        Vector::of(&query.placement.translation),
    );
    let mut near = [Vector::of(&simplex.a[0]), Vector::of(&simplex.b[0])];
    for _ in 0..MAX_STEPS {
        let facing = pair.facing(&near);
        let distance = facing.distance();
        if !distance.is_nan() {
            let (normal, point_a) = (facing.at[0].normal.get(), facing.nearest_of_a().get());
            (simplex.a[0], simplex.b[0]) = (facing.at[0].point.get(), facing.at[1].point.get());
            return Some(if distance > query.cutoff {
                Separation::Beyond { axis: normal }
            } else {
                Separation::Apart { distance, normal, point_a, point_b: point_a + normal * distance }
            });
        }
        near = facing.step();
    }
    None
}

/// Two superellipsoids in the frame of the first.
struct Pair<'a, T> {
    bodies: &'a [RoundBody; 2],
    /// Rotation times scale of B.
    matrix: Matrix<T>,
    /// Centre of B (m).
    translation: Vector<T>,
    /// Scale of B and its inverse (-).
    scale: T,
    inverse_scale: T,
    /// A length like the largest coordinate (m).
    size: T,
}

/// The surfaces of both at points that may be nearest each other.
struct Facing<'a, T> {
    pair: &'a Pair<'a, T>,
    at: [Surface<T>; 2],
    /// Outward normal of B in the frame of A.
    normal_b: Vector<T>,
    /// From the point of A to that of B (m).
    w: Vector<T>,
    /// Distance of the surfaces along the normal of A (m).
    gap: T,
}

impl<'a, T: Number> Pair<'a, T> {
    #[inline(always)]
    fn new(bodies: &'a [RoundBody; 2], matrix: Matrix<T>, translation: Vector<T>) -> Self {
        let scale = matrix.0[0].norm();
        let [of_a, of_b] = bodies.each_ref().map(|body| T::of(body.size()));
        let size = of_a + of_b * scale + translation.sum_of_sizes();
        Self { bodies, matrix, translation, scale, inverse_scale: T::of(1.0) / scale, size }
    }

    /// The surfaces at points near them, in the frames of the bodies (m).
    #[inline(always)]
    fn facing(&'a self, near: &[Vector<T>; 2]) -> Facing<'a, T> {
        let [a, b] = self.bodies;
        let at = [a.surface(&near[0]), b.surface(&near[1])];
        let normal_b = self.matrix.times(&at[1].normal.times(self.inverse_scale));
        let w = self.matrix.times(&at[1].point).plus(&self.translation).minus(&at[0].point);
        Facing { pair: self, at, normal_b, w, gap: w.dot(&at[0].normal) }
    }

    /// A vector of the frame of A in that of B, in the length of A.
    #[inline(always)]
    fn in_b(&self, v: &Vector<T>) -> Vector<T> {
        self.matrix.transposed_times(v).times(self.inverse_scale)
    }
}

impl<T: Number> Facing<'_, T> {
    /// Distance of the cores (m) if the points are nearest each other; else not a number.
    #[inline(always)]
    fn distance(&self) -> T {
        let Self { pair, at, .. } = self;
        let [inset_a, inset_b] = [T::of(pair.bodies[0].inset), T::of(pair.bodies[1].inset) * pair.scale];
        let v = self.w.plus(&at[0].normal.times(inset_a)).minus(&self.normal_b.times(inset_b));
        let back = pair.in_b(&at[0].normal).times(T::of(-1.0));
        let lower = self.gap + inset_a + inset_b - pair.scale * pair.bodies[1].excess(&at[1], &back);
        let none = T::of(f64::NAN);
        let apart = lower.if_above(T::of(MEETING) * pair.size, v.dot(&at[0].normal), none);
        (T::of(TOLERANCE) * pair.size).if_above(v.norm() - lower, apart, none)
    }

    /// The point of the core of A (m).
    #[inline(always)]
    fn nearest_of_a(&self) -> Vector<T> {
        let Surface { point, normal, .. } = &self.at[0];
        point.minus(&normal.times(T::of(self.pair.bodies[0].inset)))
    }

    /// Where Newton's method expects the nearest points, in the frames of the bodies (m).
    #[inline(always)]
    fn step(&self) -> [Vector<T>; 2] {
        let Self { pair, at, normal_b, w, gap } = self;
        let [e, f] = tangents(&at[0].normal);
        let [e_b, f_b] = [pair.in_b(&e), pair.in_b(&f)];
        let of_a = at[0].curvature(&e, &f);
        let of_b = at[1].curvature(&e_b, &f_b).map(|row| row.map(|x| x * pair.inverse_scale));
        let across = [e.dot(w), f.dot(w)];
        let one = T::of(1.0);
        let longer =
            [[one + of_a[0][0] * *gap, of_a[0][1] * *gap], [of_a[1][0] * *gap, one + of_a[1][1] * *gap]];
        let floor = T::of(LEAST_CURVATURE) / pair.size;
        let form = |i: usize, k: usize| of_a[i][k] + of_b[i][0] * longer[0][k] + of_b[i][1] * longer[1][k];
        let matrix = [[form(0, 0) + floor, form(0, 1)], [form(1, 0), form(1, 1) + floor]];
        let drag = times(&of_b, &across);
        let move_a = solution(&matrix, [drag[0] - e.dot(normal_b), drag[1] - f.dot(normal_b)]);
        let turn = times(&of_a, &move_a);
        let move_b = [0, 1].map(|i| across[i] - move_a[i] - *gap * turn[i]);
        let along = |e: &Vector<T>, f: &Vector<T>, [x, y]: [T; 2]| e.times(x).plus(&f.times(y));
        [
            at[0].point.plus(&along(&e, &f, move_a)),
            at[1].point.minus(&along(&e_b, &f_b, move_b).times(pair.inverse_scale)),
        ]
    }
}

/// Two unit vectors that make a right-handed basis with a unit vector (Duff et al. 2017).
#[inline(always)]
fn tangents<T: Number>(Vector([x, y, z]): &Vector<T>) -> [Vector<T>; 2] {
    let (x, y, z) = (*x, *y, *z);
    let one = T::of(1.0);
    let sign = T::of(0.0).if_above(z, -one, one);
    let a = -one / (sign + z);
    let b = x * y * a;
    [Vector([one + sign * x * x * a, sign * b, -sign * x]), Vector([b, sign + y * y * a, -y])]
}

#[inline(always)]
fn times<T: Number>(a: &[[T; 2]; 2], x: &[T; 2]) -> [T; 2] {
    [a[0][0] * x[0] + a[0][1] * x[1], a[1][0] * x[0] + a[1][1] * x[1]]
}

/// Solution of a x = y; not numbers or infinite if a is singular.
#[inline(always)]
fn solution<T: Number>(a: &[[T; 2]; 2], y: [T; 2]) -> [T; 2] {
    let inverse = T::of(1.0) / (a[0][0] * a[1][1] - a[0][1] * a[1][0]);
    [(a[1][1] * y[0] - a[0][1] * y[1]) * inverse, (a[0][0] * y[1] - a[1][0] * y[0]) * inverse]
}
