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
//!
//! A step has no branches, so that many pairs take it at once in the lanes of the processor.

mod lanes;
mod symmetric;

use super::query::Query;
use super::{MEETING, Separation, Simplex, TOLERANCE};
use crate::superellipsoid::Superellipsoid;
use crate::{Mat3, Vec3};
pub use lanes::EllipsoidQueries;
use symmetric::Symmetric;

/// Newton steps before giving up; a start 1e-4 off takes one or two.
const MAX_STEPS: usize = 10;

/// Distance of two ellipsoids less their insets, from the normal at the first point of the simplex.
#[inline(always)]
pub(super) fn pair(
    a: &Superellipsoid,
    b: &Superellipsoid,
    query: &Query,
    simplex: &mut Simplex,
) -> Option<Separation> {
    let (matrix, translation) = (&query.placement.matrix, query.placement.translation);
    let pair = Pair::new([*a.semi_axes(), *b.semi_axes()], [a.inset(), b.inset()], matrix, translation);
    let mut normal = pair.normal_at(&simplex.a[0]);
    for _ in 0..MAX_STEPS {
        let plane = pair.across(&normal);
        let is_beyond = plane.lower > query.cutoff;
        if is_beyond || pair.has_nearest_points(&plane) {
            (simplex.len, simplex.a[0]) = (1, plane.point_a);
            simplex.b[0] = pair.in_frame_of_b(matrix, &plane.point_b);
            if is_beyond {
                return Some(Separation::Beyond { axis: normal });
            }
            let point_a = plane.point_a - normal * a.inset();
            let point_b = point_a + normal * plane.lower;
            return Some(Separation::Apart { distance: plane.lower, normal, point_a, point_b });
        }
        normal = pair.turned(&normal, &plane);
    }
    None
}

/// Two ellipsoids in the frame of the first.
struct Pair {
    /// Squares of the semi-axes of A (m²).
    form_a: Vec3,
    /// B (m²).
    form_b: Symmetric,
    /// Centre of B (m).
    translation: Vec3,
    /// Sum of the insets (m).
    insets: f64,
    /// Square of the scale of B (-).
    scale_squared: f64,
    /// A length like the largest coordinate (m).
    size: f64,
}

/// Both bodies as seen along a unit normal.
struct Plane {
    /// Surface point of A farthest along the normal (m).
    point_a: Vec3,
    /// Surface point of B farthest against it, from the centre of B (m).
    point_b: Vec3,
    /// Inverse support values of both (1/m).
    inverses: [f64; 2],
    /// Gap of the bodies (m).
    gap: f64,
    /// Gap of the cores, a lower bound of their distance (m).
    lower: f64,
    /// From the point of A to that of B, across the normal (m).
    aside: Vec3,
}

impl Pair {
    /// Ellipsoids of these semi-axes and insets (m), B at `matrix`, a rotation times a scale, and `translation` (m).
    #[inline(always)]
    fn new([a, b]: [Vec3; 2], insets: [f64; 2], matrix: &Mat3, translation: Vec3) -> Self {
        let scale_squared = matrix.column(0).norm_squared();
        let scale = scale_squared.sqrt();
        Self {
            form_a: a.component_mul(&a),
            form_b: Symmetric::turned(&b.component_mul(&b), matrix),
            translation,
            insets: insets[0] + insets[1] * scale,
            scale_squared,
            size: largest(&a) + largest(&b) * scale + largest(&translation),
        }
    }

    /// Unit normal of A at a point of its surface.
    #[inline(always)]
    fn normal_at(&self, point: &Vec3) -> Vec3 {
        let gradient = point.component_div(&self.form_a);
        gradient * (1.0 / gradient.norm())
    }

    /// The bodies as a unit normal sees them.
    #[inline(always)]
    fn across(&self, normal: &Vec3) -> Plane {
        let (across_a, across_b) = (self.form_a.component_mul(normal), self.form_b.times(normal));
        let inverses = [1.0 / across_a.dot(normal).sqrt(), 1.0 / across_b.dot(normal).sqrt()];
        let (point_a, point_b) = (across_a * inverses[0], across_b * -inverses[1]);
        let w = self.translation + point_b - point_a;
        let gap = w.dot(normal);
        Plane { point_a, point_b, inverses, gap, lower: gap + self.insets, aside: w - normal * gap }
    }

    /// Whether the points that a normal sees are the nearest of cores that are apart: |v| − lower = |τ|²/(|v| + lower).
    #[inline(always)]
    fn has_nearest_points(&self, plane: &Plane) -> bool {
        let Plane { lower, aside, .. } = plane;
        (*lower > MEETING * self.size) & (aside.norm_squared() <= 2.0 * lower * TOLERANCE * self.size)
    }

    /// The normal after a step of Newton's method; not a number where it fails.
    #[inline(always)]
    fn turned(&self, normal: &Vec3, plane: &Plane) -> Vec3 {
        let Plane { point_a, point_b, inverses: [inverse_a, inverse_b], gap, aside, .. } = plane;
        // δ is across n whatever stands for the curvature along n: there R n = 0.
        let along = (inverse_a + inverse_b) * self.size * self.size;
        let mut curvature = self.form_b.scaled(*inverse_b);
        curvature.diagonal += (self.form_a * *inverse_a).add_scalar(*gap);
        curvature.add_square(normal, along);
        curvature.add_square(point_a, -inverse_a);
        curvature.add_square(point_b, -inverse_b);
        let turned = normal + curvature.solution(aside);
        turned * (1.0 / turned.norm())
    }

    /// A point given from the centre of B, in the frame of B (m).
    #[inline(always)]
    fn in_frame_of_b(&self, matrix: &Mat3, point: &Vec3) -> Vec3 {
        matrix.tr_mul(point) * (1.0 / self.scale_squared)
    }
}

/// Largest component of a vector, without a sign.
#[inline(always)]
fn largest(v: &Vec3) -> f64 {
    v.x.abs().max(v.y.abs()).max(v.z.abs())
}
