//! Distance of superellipsoids, solved as equations.
//!
//! Unknown are the nearest points of the two surfaces. With n the normal of A there, W_A and W_B the forms of
//! curvature, d the signed distance, w_t the part across n of the vector w from the point of A to that of
//! B and β that of the opposite normal of B, Newton's method moves them along the surfaces by α and −γ:
//!
//! ```text
//! [W_A + W_B (1 + d W_A)] α = β + W_B w_t      (opposite normals)
//! γ = w_t − α − d W_A α                        (on one normal)
//! ```
//!
//! Flat faces are W = 0 here, where the equations in the normal, with radii of curvature, would have infinite
//! coefficients; and they need the powers of (2.1) only, whole numbers for most shapes in use. Edges (ε > 1)
//! are the opposite: there the normal is moved by W_A α and the point follows from the support mapping.
//!
//! The answer is certified by its duality gap: the cores' points bound the distance from above, the planes
//! across n from below, B's support function to second order in its normal's error. Any failure sends the
//! pair back to the search.

mod element;
mod feature;

use super::query::{Query, combine};
use super::{MEETING, Separation, Simplex, TOLERANCE};
use crate::superellipsoid::{Local, Superellipsoid, tangents};
use crate::{Placement, Vec3};
pub(super) use feature::{feature, feature_first};

/// Newton steps before giving up; a start 1e-4 off takes one or two, flat faces more.
const MAX_STEPS: usize = 40;
/// Steps without a smaller error before giving up.
const PATIENCE: usize = 8;
/// Longest step, relative to the largest semi-axis.
const LONGEST_STEP: f64 = 0.5;
/// Distance of the points across the normal, relative to the size, and sine of the angle of the normals, at
/// which a penetration is settled; the depth is then exact to its square.
const SETTLED: f64 = 1e-9;
/// Curvature of two flat faces, times the size, taken for the smallest.
pub(super) const LEAST_CURVATURE: f64 = 1e-13;

type Matrix2 = [[f64; 2]; 2];

/// The two bodies and what stays the same during the steps.
struct Pair<'a> {
    a: &'a Superellipsoid,
    b: &'a Superellipsoid,
    placement: &'a Placement,
    scale: f64,
    inverse_scale: f64,
    /// Smallest curvature (1/m).
    floor: f64,
    is_sharp: bool,
}

/// Newton's equations at a pair of surface points.
struct Linear<'a> {
    pair: &'a Pair<'a>,
    a: &'a Local,
    b: &'a Local,
    normal: Vec3,
    /// Outward normal of B in the frame of A.
    normal_b: Vec3,
    /// From the point of A to that of B (m).
    w: Vec3,
    /// Signed distance of the surfaces along the normal (m).
    gap: f64,
}

/// Distance of two superellipsoids less their insets, from the nearest points of the last step.
#[inline(always)]
pub(super) fn pair(
    a: &Superellipsoid,
    b: &Superellipsoid,
    query: &Query,
    size: f64,
    simplex: &mut Simplex,
    weights: Option<&[f64; 4]>,
) -> Option<Separation> {
    if !(a.is_smooth() && b.is_smooth()) {
        return None;
    }
    let (near_a, near_b) = start(query.placement, simplex, weights);
    let pair = Pair::new(a, b, query.placement, size);
    let (answer, [a, b]) = pair.solve([a.local(&near_a), b.local(&near_b)], query.cutoff, size)?;
    (simplex.len, simplex.a[0], simplex.b[0]) = (1, a, b);
    Some(answer)
}

/// How deep two superellipsoids less their insets are in each other: depth (m), normal from A to B, and the
/// deepest point of A (m), in the frame of A.
///
/// The nearest smallest depth to the points of the simplex, found by Newton's method like the distance; `None` if
/// it fails or the bodies are deeper than half of the thinner one, where another direction may be shorter.
pub(crate) fn penetration(
    a: &Superellipsoid,
    b: &Superellipsoid,
    placement: &Placement,
    size: f64,
    simplex: &Simplex,
) -> Option<(f64, Vec3, Vec3)> {
    if simplex.len != 1 || !(a.is_smooth() && b.is_smooth()) {
        return None;
    }
    let pair = Pair::new(a, b, placement, size);
    let mut at = [a.local(&simplex.a[0]), b.local(&simplex.b[0])];
    let insets = [a.inset(), b.inset() * pair.scale];
    let deepest = 0.5 * a.inscribed_radius().min(b.inscribed_radius() * pair.scale);
    for _ in 0..MAX_STEPS {
        let linear = Linear::new(&pair, &at[0], &at[1]);
        let v = linear.w + linear.normal * insets[0] - linear.normal_b * insets[1];
        let depth = -v.dot(&linear.normal);
        let aside = (v + linear.normal * depth).norm();
        if depth.is_nan() || depth >= deepest {
            return None;
        }
        if aside + size * (linear.normal + linear.normal_b).norm() <= SETTLED * size {
            let point = at[0].point - linear.normal * insets[0];
            return (linear.is_least() && depth >= 0.0).then_some((depth, linear.normal, point));
        }
        at = linear.step()?;
    }
    None
}

/// The points to start from.
#[inline(always)]
fn start(placement: &Placement, simplex: &Simplex, weights: Option<&[f64; 4]>) -> (Vec3, Vec3) {
    if simplex.len == 1 {
        return (simplex.a[0], simplex.b[0]);
    }
    let nearest = match weights {
        Some(weights) => *weights,
        None => {
            let w: [Vec3; 4] = std::array::from_fn(|i| placement.apply(&simplex.b[i]) - simplex.a[i]);
            super::nearest_weights(&w[..simplex.len as usize])
        }
    };
    let swapped = Simplex { len: simplex.len, a: simplex.b, b: simplex.a };
    (combine(simplex, &nearest), combine(&swapped, &nearest))
}

impl<'a> Pair<'a> {
    #[inline(always)]
    fn new(a: &'a Superellipsoid, b: &'a Superellipsoid, placement: &'a Placement, size: f64) -> Self {
        let scale = placement.matrix.column(0).norm();
        let is_sharp = a.is_sharp() || b.is_sharp();
        Self { a, b, placement, scale, inverse_scale: 1.0 / scale, floor: LEAST_CURVATURE / size, is_sharp }
    }
}

impl Pair<'_> {
    /// The answer and the nearest points of the surfaces, each in its own frame.
    #[inline(always)]
    fn solve(&self, mut at: [Local; 2], cutoff: f64, size: f64) -> Option<(Separation, [Vec3; 2])> {
        let insets = [self.a.inset(), self.b.inset() * self.scale];
        let mut best = (f64::INFINITY, 0);
        for step in 0..MAX_STEPS {
            let linear = Linear::new(self, &at[0], &at[1]);
            let points = [at[0].point, at[1].point];
            let v = linear.w + linear.normal * insets[0] - linear.normal_b * insets[1];
            // B's support function is at least what its point reaches: a bound that may yet be too high.
            let hoped = linear.gap + insets[0] + insets[1];
            let depth = -v.dot(&linear.normal);
            let aside = (v + linear.normal * depth).norm();
            // Where edges make the points the stiff variable, they must be as close as the bounds.
            let is_near = if self.is_sharp { aside } else { v.norm() - hoped } <= TOLERANCE * size;
            if hoped > cutoff || is_near {
                let facing = -self.in_b(&linear.normal);
                if hoped - self.scale * self.b.excess_at_most(&at[1], &facing) > cutoff {
                    return Some((Separation::Beyond { axis: linear.normal }, points));
                }
                let lower = hoped - self.scale * self.b.excess(&at[1], &facing);
                if lower > cutoff {
                    return Some((Separation::Beyond { axis: linear.normal }, points));
                }
                if v.norm() - lower <= TOLERANCE * size && lower > MEETING * size {
                    return Some((linear.answer(&v, at[0].point - linear.normal * insets[0]), points));
                }
            }
            // A ball of the depth in the core that rolls inside its body holds the other's point.
            let in_a = depth < insets[0] && aside < 0.5 * depth;
            let in_b = depth < insets[1] && (v - linear.normal_b * depth).norm() < 0.5 * depth;
            if depth > MEETING * size && (in_a || in_b) {
                return Some((Separation::Meeting, points));
            }
            let off = aside + size * (linear.normal + linear.normal_b).norm();
            if off < best.0 {
                best = (off, step);
            } else if step > best.1 + PATIENCE || off.is_nan() {
                return None;
            }
            at = linear.step()?;
        }
        None
    }

    /// A vector of the frame of A in that of B, in the length of A.
    #[inline(always)]
    fn in_b(&self, v: &Vec3) -> Vec3 {
        self.placement.matrix.tr_mul(v) * self.inverse_scale
    }
}

impl<'a> Linear<'a> {
    #[inline(always)]
    fn new(pair: &'a Pair<'a>, a: &'a Local, b: &'a Local) -> Self {
        let normal = a.normal;
        let normal_b = pair.placement.matrix * (b.normal * pair.inverse_scale);
        let w = pair.placement.apply(&b.point) - a.point;
        Self { pair, a, b, normal, normal_b, w, gap: w.dot(&normal) }
    }

    /// The answer for the points of the cores that are `v` (m) apart, across the normal by less than the root of
    /// the tolerance.
    #[inline(always)]
    fn answer(&self, v: &Vec3, point_a: Vec3) -> Separation {
        let (distance, normal) = (v.dot(&self.normal), self.normal);
        Separation::Apart { distance, normal, point_a, point_b: point_a + normal * distance }
    }

    /// Whether moving the points along the surfaces makes the overlap smaller in no direction: W_A + W_B (1 + d W_A)
    /// is positive.
    fn is_least(&self) -> bool {
        let [e, f] = tangents(&self.normal);
        let (of_a, of_b) = self.curvatures(&e, &f);
        let mut longer = of_a.map(|row| row.map(|x| x * self.gap));
        (longer[0][0], longer[1][1]) = (longer[0][0] + 1.0, longer[1][1] + 1.0);
        let matrix = sum(&of_a, &product(&of_b, &longer));
        let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
        determinant >= 0.0 && matrix[0][0] + matrix[1][1] >= 0.0
    }

    /// The forms of curvature of both bodies in two tangents.
    #[inline(always)]
    fn curvatures(&self, e: &Vec3, f: &Vec3) -> (Matrix2, Matrix2) {
        let (e_b, f_b) = (self.pair.in_b(e), self.pair.in_b(f));
        let of_b = self.b.curvature(&e_b, &f_b).map(|row| row.map(|x| x * self.pair.inverse_scale));
        (self.a.curvature(e, f), of_b)
    }

    /// The surfaces at the points where Newton's method expects the nearest ones.
    #[inline(always)]
    fn step(&self) -> Option<[Local; 2]> {
        let pair = self.pair;
        let [e, f] = tangents(&self.normal);
        let [e_b, f_b] = [pair.in_b(&e), pair.in_b(&f)];
        let (of_a, of_b) = self.curvatures(&e, &f);
        let off = [-e.dot(&self.normal_b), -f.dot(&self.normal_b)];
        let across = [e.dot(&self.w), f.dot(&self.w)];
        let mut longer = of_a.map(|row| row.map(|x| x * self.gap));
        (longer[0][0], longer[1][1]) = (longer[0][0] + 1.0, longer[1][1] + 1.0);
        let mut matrix = sum(&of_a, &product(&of_b, &longer));
        (matrix[0][0], matrix[1][1]) = (matrix[0][0] + pair.floor, matrix[1][1] + pair.floor);
        let drag = apply(&of_b, across);
        let move_a = solve(&matrix, [off[0] + drag[0], off[1] + drag[1]])?;
        let turn = apply(&of_a, move_a);
        let move_b: [f64; 2] = std::array::from_fn(|i| across[i] - move_a[i] - self.gap * turn[i]);
        let limit_a = limit(move_a, pair.a);
        let limit_b = limit(move_b, pair.b) * pair.scale;
        let damping = limit_a.min(limit_b).min(1.0);
        let [move_a, move_b, turn] = [move_a, move_b, turn].map(|v| v.map(|x| x * damping));
        let normal = self.normal + e * turn[0] + f * turn[1];
        let near_a = if pair.a.is_sharp() {
            pair.a.dual(&normal).1
        } else {
            self.a.point + e * move_a[0] + f * move_a[1]
        };
        let near_b = if pair.b.is_sharp() {
            pair.b.dual(&-pair.in_b(&normal)).1
        } else {
            self.b.point - (e_b * move_b[0] + f_b * move_b[1]) * pair.inverse_scale
        };
        Some([pair.a.local(&near_a), pair.b.local(&near_b)])
    }
}

/// Factor by which a step of a body is too long, as a factor to shorten it; beyond 1 if it is not.
#[inline(always)]
fn limit(step: [f64; 2], body: &Superellipsoid) -> f64 {
    LONGEST_STEP * body.semi_axes().max() / step[0].abs().max(step[1].abs())
}

#[inline(always)]
fn product(a: &Matrix2, b: &Matrix2) -> Matrix2 {
    std::array::from_fn(|i| std::array::from_fn(|k| a[i][0] * b[0][k] + a[i][1] * b[1][k]))
}

#[inline(always)]
fn sum(a: &Matrix2, b: &Matrix2) -> Matrix2 {
    std::array::from_fn(|i| std::array::from_fn(|k| a[i][k] + b[i][k]))
}

#[inline(always)]
fn apply(a: &Matrix2, x: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|i| a[i][0] * x[0] + a[i][1] * x[1])
}

/// Solution of a x = y; `None` if a is singular.
#[inline(always)]
fn solve(a: &Matrix2, y: [f64; 2]) -> Option<[f64; 2]> {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    let x = [a[1][1] * y[0] - a[0][1] * y[1], a[0][0] * y[1] - a[1][0] * y[0]].map(|x| x / determinant);
    (x[0] + x[1]).is_finite().then_some(x)
}
