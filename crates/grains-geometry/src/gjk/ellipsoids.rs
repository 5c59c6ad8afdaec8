//! Distance of two ellipsoids: the direction in which their gap is widest.
//!
//! With the forms A = diag(a²) and B = M diag(b²) Mᵀ of the two bodies in the frame of the first, t the centre
//! of the second, and h(n) = √(n·A n) the support function, the gap across the plane of normal n is
//!
//! ```text
//! g(n) = n·t − h_A(n) − h_B(n),   p_A = A n / h_A,   p_B = t − B n / h_B,
//! ```
//!
//! and its maximum over unit n, the signed distance, is where w = p_B − p_A is along n. On the sphere g has the
//! gradient τ = w − g n and the second derivatives −(R_A + R_B + g 1), with R = (A − p pᵀ)/h the radii of
//! curvature; Newton's method is [R_A + R_B + g 1] δ = τ, and no powers or features are needed.
//!
//! The cores, an inset r within their bodies, have the gap g + r_A + r_B, which |w + (r_A + r_B) n| bounds from
//! above: the answer is certified as any other.

use super::query::Query;
use super::{MEETING, Separation, Simplex, TOLERANCE};
use crate::superellipsoid::Superellipsoid;
use crate::{Mat3, Vec3};

/// Newton steps before giving up; a start 1e-4 off takes one or two.
const MAX_STEPS: usize = 10;

/// Distance of two ellipsoids less their insets, from the normal at the first point of the simplex.
#[inline(always)]
pub(super) fn pair(
    a: &Superellipsoid,
    b: &Superellipsoid,
    query: &Query,
    size: f64,
    simplex: &mut Simplex,
) -> Option<Separation> {
    let (matrix, t) = (&query.placement.matrix, &query.placement.translation);
    let form_a = a.semi_axes().component_mul(a.semi_axes());
    let squares = b.semi_axes().component_mul(b.semi_axes());
    let form_b = scaled_columns(matrix, &squares) * matrix.transpose();
    let scale = matrix.column(0).norm();
    let insets = a.inset() + b.inset() * scale;
    let gradient = simplex.a[0].component_div(&form_a);
    let mut normal = gradient * (1.0 / gradient.norm());
    for _ in 0..MAX_STEPS {
        let (across_a, across_b) = (form_a.component_mul(&normal), form_b * normal);
        let (height_a, height_b) = (across_a.dot(&normal).sqrt(), across_b.dot(&normal).sqrt());
        let (inverse_a, inverse_b) = (1.0 / height_a, 1.0 / height_b);
        let (point_a, reach_b) = (across_a * inverse_a, across_b * inverse_b);
        let w = t - reach_b - point_a;
        let gap = w.dot(&normal);
        let (aside, lower) = (w - normal * gap, gap + insets);
        let is_beyond = lower > query.cutoff;
        // |v| − lower = |τ|²/(|v| + lower)
        if is_beyond || (lower > MEETING * size && aside.norm_squared() <= 2.0 * lower * TOLERANCE * size) {
            let point_b = matrix.tr_mul(&reach_b) * (-1.0 / (scale * scale));
            (simplex.len, simplex.a[0], simplex.b[0]) = (1, point_a, point_b);
            if is_beyond {
                return Some(Separation::Beyond { axis: normal });
            }
            let point_a = point_a - normal * a.inset();
            let point_b = point_a + normal * lower;
            return Some(Separation::Apart { distance: lower, normal, point_a, point_b });
        }
        // δ is across n whatever stands for the curvature along n: there R n = 0.
        let along = (inverse_a + inverse_b) * size * size;
        let mut curvature = form_b * inverse_b;
        curvature.ger(-inverse_b, &reach_b, &reach_b, 1.0);
        curvature.ger(-inverse_a, &point_a, &point_a, 1.0);
        curvature.ger(along, &normal, &normal, 1.0);
        for axis in 0..3 {
            curvature[(axis, axis)] += form_a[axis] * inverse_a + gap;
        }
        let turned = normal + solve(&curvature, &aside)?;
        normal = turned * (1.0 / turned.norm());
    }
    None
}

/// The matrix with its columns multiplied.
#[inline(always)]
fn scaled_columns(matrix: &Mat3, factors: &Vec3) -> Mat3 {
    let [x, y, z] = [0, 1, 2].map(|k| matrix.column(k) * factors[k]);
    Mat3::from_columns(&[x, y, z])
}

/// Solution of m x = y for a symmetric m by its adjugate; `None` if m is singular.
#[inline(always)]
fn solve(m: &Mat3, y: &Vec3) -> Option<Vec3> {
    let [p, q, r] = [0, 1, 2].map(|k| m.column(k).into_owned());
    let (qr, rp, pq) = (q.cross(&r), r.cross(&p), p.cross(&q));
    let x = Vec3::new(qr.dot(y), rp.dot(y), pq.dot(y)) * (1.0 / p.dot(&qr));
    x.x.is_finite().then_some(x)
}
