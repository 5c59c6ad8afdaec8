//! Distance of two touching features, one of them of a cylinder, solved as equations.
//!
//! The points of the simplex tell the features: vertex, edge or face of a polyhedral core, rim, side
//! or end of a cylinder. Each is a base point plus at most two linear freedoms plus, for rim and side,
//! a circle. The linear freedoms are projected out; what is left is the smallest |v|² over the angles on
//! the circles, at most two, found by Newton's method. A wrong guess of the features does no harm: the
//! caller certifies the result by support points and carries on without it.

use super::Simplex;
use crate::convex::{NO_DIRECTION, Rims, Support};
use crate::{Placement, Vec3};

/// Newton steps before giving up; a start 1e-4 off takes two.
pub(super) const MAX_STEPS: usize = 6;
/// Step (rad) after which the next one, its square, would change the normal by less than asked.
pub(super) const LAST_STEP: f64 = 1e-5;
/// Largest credible step (rad).
const LONGEST_STEP: f64 = 0.5;
/// Squared sine of the angle below which two linear freedoms are one.
pub(super) const PARALLEL: f64 = 1e-14;
/// Error of the nearest points, relative to their distance from the bases, still taken for rounding.
pub(super) const CLOSURE: f64 = 1e-14;
/// Cosine between points of a circle above which they mark one point of it, below which a disc.
pub(super) const SAME_POINT: f64 = 0.9;

/// Range of the linear freedoms of a feature, in units of its edges.
#[derive(Clone, Copy)]
enum Range {
    /// Convex hull: all c ≥ 0, Σc ≤ 1.
    Hull,
    /// Side of a cylinder: |c| ≤ 1.
    Axis,
    /// End of a cylinder: c0² + c1² ≤ 1.
    Disc,
}

impl Range {
    #[inline]
    fn holds(self, c: [f64; 2]) -> bool {
        match self {
            Self::Hull => c[0] >= 0.0 && c[1] >= 0.0 && c[0] + c[1] <= 1.0,
            Self::Axis => c[0].abs() <= 1.0,
            Self::Disc => c[0] * c[0] + c[1] * c[1] <= 1.0,
        }
    }
}

/// Circle: centre + cosine·c + sine·s with (c, s) the present point. All zero if there is none, so
/// that the equations need no cases.
#[derive(Clone, Copy)]
pub(super) struct Circle {
    pub cosine: Vec3,
    pub sine: Vec3,
    /// Cosine and sine of the angle of the present point.
    pub angle: [f64; 2],
    /// 1 if there is no circle: the second derivative by an angle that does not matter.
    pub idle: f64,
}

impl Circle {
    #[inline(always)]
    fn none() -> Self {
        Self { cosine: Vec3::zeros(), sine: Vec3::zeros(), angle: [1.0, 0.0], idle: 1.0 }
    }

    #[inline(always)]
    pub(super) fn radial(&self) -> Vec3 {
        self.cosine * self.angle[0] + self.sine * self.angle[1]
    }

    #[inline(always)]
    fn tangent(&self) -> Vec3 {
        self.sine * self.angle[0] - self.cosine * self.angle[1]
    }

    /// Moves the point by `step` radians, to third order.
    #[inline(always)]
    pub(super) fn turn(&mut self, step: f64) {
        let [c, s] = self.angle;
        let inverse = 1.0 / (1.0 + step * step).sqrt();
        self.angle = [(c - s * step) * inverse, (s + c * step) * inverse];
    }

    /// Cosine and sine of the point farthest along `direction`; those of the present one if all points are equally far.
    #[inline(always)]
    pub(super) fn facing(&self, direction: &Vec3) -> [f64; 2] {
        let (c, s) = (self.cosine.dot(direction), self.sine.dot(direction));
        let squared = c * c + s * s;
        let norm = squared.sqrt();
        let is_direction = squared > NO_DIRECTION;
        let [present_c, present_s] = self.angle;
        [if is_direction { c / norm } else { present_c }, if is_direction { s / norm } else { present_s }]
    }
}

/// A feature: base + Σ c_i edges_i + circle.
struct Feature {
    base: Vec3,
    edges: [Vec3; 2],
    freedoms: usize,
    range: Range,
    circle: Circle,
}

impl Feature {
    #[inline(always)]
    fn of<S: Support>(core: &S, points: &[Vec3]) -> Option<Self> {
        match core.rims() {
            Some(rims) => Self::of_cylinder(&rims, points),
            None if S::CURVED => None,
            None => Self::of_vertices(points),
        }
    }

    /// Hull of the distinct points, at most three.
    #[inline(always)]
    fn of_vertices(points: &[Vec3]) -> Option<Self> {
        let base = points[0];
        let mut edges = [Vec3::zeros(); 2];
        let mut freedoms = 0;
        for point in &points[1..] {
            let edge = point - base;
            if *point == base || (freedoms > 0 && edge == edges[0]) {
                continue;
            }
            if freedoms == 2 {
                return None;
            }
            edges[freedoms] = edge;
            freedoms += 1;
        }
        Some(Self { base, edges, freedoms, range: Range::Hull, circle: Circle::none() })
    }

    #[inline(always)]
    fn of_cylinder(cylinder: &Rims, points: &[Vec3]) -> Option<Self> {
        let (radius, height) = (cylinder.radius, cylinder.half_height);
        let first = points[0];
        let one_end = points.iter().all(|p| p.z == first.z);
        let together = points.iter().all(|p| p.x * first.x + p.y * first.y >= SAME_POINT * radius * radius);
        let (cosine, sine) = (Vec3::new(radius, 0.0, 0.0), Vec3::new(0.0, radius, 0.0));
        let end = Vec3::new(0.0, 0.0, first.z);
        let mut feature = Self {
            base: end,
            edges: [cosine, sine],
            freedoms: 2,
            range: Range::Disc,
            circle: Circle::none(),
        };
        if !together {
            return one_end.then_some(feature);
        }
        let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.x, y + p.y));
        let norm = (x * x + y * y).sqrt();
        feature.circle = Circle { cosine, sine, angle: [x / norm, y / norm], idle: 0.0 };
        (feature.edges, feature.freedoms) = ([Vec3::zeros(); 2], 0);
        if !one_end {
            feature.base = Vec3::zeros();
            feature.edges[0].z = height;
            (feature.freedoms, feature.range) = (1, Range::Axis);
        }
        Some(feature)
    }

    /// The feature in the frame its body is placed in.
    #[inline(always)]
    fn placed(mut self, placement: &Placement) -> Self {
        self.base = placement.apply(&self.base);
        self.edges = self.edges.map(|edge| placement.matrix * edge);
        self.circle.cosine = placement.matrix * self.circle.cosine;
        self.circle.sine = placement.matrix * self.circle.sine;
        self
    }

    #[inline(always)]
    fn point(&self, coefficients: [f64; 2]) -> Vec3 {
        self.base + self.circle.radial() + self.edges[0] * coefficients[0] + self.edges[1] * coefficients[1]
    }
}

/// Orthonormal basis of the linear freedoms of both features, zero for the freedoms there are not:
/// edge 0 = length 0 basis 0, edge 1 = shear basis 0 + length 1 basis 1.
struct Span {
    rank: usize,
    basis: [Vec3; 2],
    lengths: [f64; 2],
    shear: f64,
}

impl Span {
    /// `None` if more than two freedoms or two parallel ones.
    #[inline(always)]
    fn of(a: &Feature, b: &Feature) -> Option<Self> {
        let rank = a.freedoms + b.freedoms;
        let edges = match (a.freedoms, b.freedoms) {
            (0, _) => b.edges,
            (1, 1) => [a.edges[0], b.edges[0]],
            (_, 0) => a.edges,
            _ => return None,
        };
        let mut span = Self { rank, basis: [Vec3::zeros(); 2], lengths: [1.0; 2], shear: 0.0 };
        if rank > 0 {
            span.lengths[0] = edges[0].norm();
            span.basis[0] = edges[0] / span.lengths[0];
        }
        if rank > 1 {
            span.shear = span.basis[0].dot(&edges[1]);
            let across = edges[1] - span.basis[0] * span.shear;
            let squared = across.norm_squared();
            if squared <= PARALLEL * edges[1].norm_squared() {
                return None;
            }
            span.lengths[1] = squared.sqrt();
            span.basis[1] = across / span.lengths[1];
        }
        Some(span)
    }

    /// The part of `v` orthogonal to the freedoms.
    #[inline(always)]
    fn outside(&self, v: &Vec3) -> Vec3 {
        let [p, q] = &self.basis;
        v - p * p.dot(v) - q * q.dot(v)
    }

    /// Coefficients of the edges that add up to `v`, a vector of the span.
    #[inline(always)]
    fn coefficients(&self, v: &Vec3) -> [f64; 2] {
        let second = self.basis[1].dot(v) / self.lengths[1];
        let first = (self.basis[0].dot(v) - self.shear * second) / self.lengths[0];
        [first, second]
    }
}

/// Nearest points of two features.
pub(super) struct Touch {
    /// From A to B, in the frame of A (m).
    pub v: Vec3,
    /// Point of A, in its frame (m).
    pub point_a: Vec3,
    /// Point on the rim of A, as x and y in its own frame (m), where the feature has a circle.
    rim_a: Option<[f64; 2]>,
    /// The same of B.
    rim_b: Option<[f64; 2]>,
}

/// Solves for the nearest points of the features the simplex marks; `None` if they are not regular,
/// Newton's method fails, or a point is off its feature.
pub(super) fn touch<A: Support, B: Support>(
    core_a: &A,
    core_b: &B,
    placement: &Placement,
    simplex: &Simplex,
) -> Option<Touch> {
    let len = simplex.len as usize;
    let mut a = Feature::of(core_a, &simplex.a[..len])?;
    let mut b = Feature::of(core_b, &simplex.b[..len])?.placed(placement);
    let span = Span::of(&a, &b)?;
    let center = b.base - a.base;
    let solved = match span.rank {
        0 => descend(&mut a.circle, &mut b.circle, &center, |v| *v),
        1 => descend(&mut a.circle, &mut b.circle, &center, |v| v - span.basis[0] * span.basis[0].dot(v)),
        _ => face(&mut a.circle, &mut b.circle, &center, &span.basis[0].cross(&span.basis[1])),
    };
    if !solved {
        return None;
    }
    let w = center + b.circle.radial() - a.circle.radial();
    let v = span.outside(&span.outside(&w));
    let coefficients = span.coefficients(&(v - w));
    let (of_a, of_b) = match (a.freedoms, b.freedoms) {
        (0, _) => ([0.0; 2], coefficients),
        (1, 1) => ([-coefficients[0], 0.0], [coefficients[1], 0.0]),
        _ => (coefficients.map(|c| -c), [0.0; 2]),
    };
    if !(a.range.holds(of_a) && b.range.holds(of_b)) {
        return None;
    }
    let (point_a, point_b) = (a.point(of_a), b.point(of_b));
    // Freedoms at a small angle cost digits of the coefficients.
    if (point_b - point_a - v).norm_squared() > CLOSURE * CLOSURE * w.norm_squared() {
        return None;
    }
    let rim = |core: Option<Rims>, circle: &Circle| {
        core.filter(|_| circle.idle == 0.0).map(|c| circle.angle.map(|x| x * c.radius))
    };
    Some(Touch { v, point_a, rim_a: rim(core_a.rims(), &a.circle), rim_b: rim(core_b.rims(), &b.circle) })
}

/// Two linear freedoms fix the normal: each circle shows its farthest point.
#[inline(always)]
fn face(a: &mut Circle, b: &mut Circle, center: &Vec3, normal: &Vec3) -> bool {
    let w = center + b.radial() - a.radial();
    let normal = if normal.dot(&w) < 0.0 { -normal } else { *normal };
    a.angle = a.facing(&normal);
    b.angle = b.facing(&-normal);
    true
}

/// Newton's method for the smallest ½|v|² over the angles; false if it leaves the neighbourhood.
#[inline(always)]
fn descend(a: &mut Circle, b: &mut Circle, center: &Vec3, outside: impl Fn(&Vec3) -> Vec3) -> bool {
    for _ in 0..MAX_STEPS {
        let [step_a, step_b] = newton_step(a, b, center, &outside);
        if step_a.is_infinite() {
            return false;
        }
        a.turn(step_a);
        b.turn(step_b);
        if step_a.abs().max(step_b.abs()) < LAST_STEP {
            return true;
        }
    }
    false
}

/// A step of Newton's method for the smallest ½|v|² over the angles (rad); infinite if it leaves the neighbourhood.
///
/// `outside` is the projection P beside the freedoms. With v = P(center + b − a): ∂v/∂α = −P a', ∂v/∂β = P b', and a'' = −a, b'' = −b for circles.
#[inline(always)]
pub(super) fn newton_step(
    a: &Circle,
    b: &Circle,
    center: &Vec3,
    outside: impl Fn(&Vec3) -> Vec3,
) -> [f64; 2] {
    let (radial_a, radial_b) = (a.radial(), b.radial());
    let v = outside(&(center + radial_b - radial_a));
    let (along_a, along_b) = (outside(&-a.tangent()), outside(&b.tangent()));
    let haa = along_a.norm_squared() + v.dot(&radial_a) + a.idle;
    let hbb = along_b.norm_squared() - v.dot(&radial_b) + b.idle;
    let (ga, gb, hab) = (v.dot(&along_a), v.dot(&along_b), along_a.dot(&along_b));
    let determinant = haa * hbb - hab * hab;
    let inverse = 1.0 / determinant;
    let steps = [(hab * gb - hbb * ga) * inverse, (hab * ga - haa * gb) * inverse];
    let is_minimum = (haa > 0.0) & (determinant > 0.0);
    let is_near = is_minimum & (steps[0].abs().max(steps[1].abs()) <= LONGEST_STEP);
    steps.map(|step| if is_near { step } else { f64::INFINITY })
}

impl Touch {
    /// Nearest points of features of two cylinders, with those on their circles (m).
    pub(super) fn new(v: Vec3, point_a: Vec3, [rim_a, rim_b]: [Option<[f64; 2]>; 2]) -> Self {
        Self { v, point_a, rim_a, rim_b }
    }

    /// Moves the points of the simplex on the circles to where the bodies touch now.
    pub(super) fn refresh(&self, simplex: &mut Simplex) {
        let len = simplex.len as usize;
        let mut kept = 0;
        for i in 0..len {
            let (mut a, mut b) = (simplex.a[i], simplex.b[i]);
            if let Some([x, y]) = self.rim_a {
                (a.x, a.y) = (x, y);
            }
            if let Some([x, y]) = self.rim_b {
                (b.x, b.y) = (x, y);
            }
            let known = (0..kept).any(|j| simplex.a[j] == a && simplex.b[j] == b);
            if !known {
                (simplex.a[kept], simplex.b[kept]) = (a, b);
                kept += 1;
            }
        }
        simplex.len = kept as u8;
    }
}
