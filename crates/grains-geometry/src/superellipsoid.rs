//! Superellipsoids and their inner parallel bodies.
//!
//! The body is the unit ball of the norm F(x) = ‖(‖(x/a₁, y/a₂)‖_p, z/a₃)‖_q with p = 2/ε₂, q = 2/ε₁
//! (Srinivasan 2019, eq. 2.1: ε₂ shapes the x-y section, ε₁ the meridian). Its support function is the
//! dual norm, with the conjugate exponents 2/(2 − ε): h(n) = ‖(‖(a₁n₁, a₂n₂)‖_{p'}, a₃n₃)‖_{q'}, and the
//! support point its gradient. Less the inset r the body has the support function h(n) − r|n| and is
//! convex up to the smallest radius of curvature; a ball of radius r swept over it gives the body back.

mod local;
mod size;
mod surface;

use crate::error::check_length;
use crate::powers::{natural, pow};
use crate::{ShapeError, Vec3};
pub(crate) use local::Local;
pub(crate) use size::tangents;
pub(crate) use surface::{RoundBody, Surface};

/// Exponents of roundness allowed: below, powers up to 2/ε lose digits and the body is a box to 2 %.
pub const EPS_RANGE: std::ops::RangeInclusive<f64> = 0.05..=2.0;

/// How powers are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Powers {
    /// Ellipsoid: p = q = 2.
    Squares,
    /// p − 2, q − 2 and q/p − 1 are natural numbers.
    Natural([u32; 3]),
    /// Any exponents.
    Real,
}

/// A convex superellipsoid about the origin of its frame, less an inset all around.
#[derive(Clone, Copy, Debug)]
pub struct Superellipsoid {
    semi_axes: Vec3,
    /// Semi-axes of the body this one is the core of, its edges not rounded (m).
    sharp_axes: Vec3,
    /// Exponents ε of that body (-).
    sharp_eps: [f64; 2],
    /// One over the semi-axes (1/m).
    inverse_axes: Vec3,
    eps: [f64; 2],
    inset: f64,
    /// p = 2/ε₂ and q = 2/ε₁ (-).
    exponents: [f64; 2],
    /// Conjugates p' and q', infinite for ε = 2 (-).
    conjugates: [f64; 2],
    powers: Powers,
    /// Ratios (s − k)/(k + 1) of the terms of (1 + x)^s with s = −1/q (-).
    root: [f64; local::SERIES],
    /// Radius of the largest ball about the centre (m).
    inscribed: f64,
}

impl Superellipsoid {
    /// Superellipsoid of semi-axes a₁, a₂, a₃ (m) and exponents ε₁ (meridian), ε₂ (x-y section) (-).
    ///
    /// # Errors
    /// Semi-axes that are not positive; ε outside [0.05, 2], the range in which the body is convex and
    /// its powers keep their digits.
    pub fn new(semi_axes: Vec3, eps: [f64; 2]) -> Result<Self, ShapeError> {
        semi_axes.iter().try_for_each(|&a| check_length("semi_axes", a))?;
        for value in eps {
            if !EPS_RANGE.contains(&value) {
                let remedy = "1 is an ellipsoid, 0.1 a box with rounded edges, 2 an octahedron";
                return Err(ShapeError::OutOfRange {
                    quantity: "eps",
                    value,
                    allowed: "in [0.05, 2]",
                    remedy,
                });
            }
        }
        Ok(Self::build(semi_axes, eps, 0.0))
    }

    fn build(semi_axes: Vec3, eps: [f64; 2], inset: f64) -> Self {
        let [q, p] = eps.map(|e| 2.0 / e);
        let [dual_q, dual_p] = eps.map(|e| 2.0 / (2.0 - e));
        let whole = [p - 2.0, q - 2.0, q / p - 1.0];
        let powers = if eps == [1.0; 2] {
            Powers::Squares
        } else if whole.iter().all(|n| *n >= 0.0 && n.fract() == 0.0) {
            Powers::Natural(whole.map(|n| n as u32))
        } else {
            Powers::Real
        };
        let inscribed = size::inscribed_radius(&semi_axes, eps);
        Self {
            semi_axes,
            sharp_axes: semi_axes,
            sharp_eps: eps,
            inverse_axes: semi_axes.map(|a| 1.0 / a),
            eps,
            inset,
            exponents: [p, q],
            conjugates: [dual_p, dual_q],
            powers,
            root: std::array::from_fn(|k| (-1.0 / q - k as f64) / (k + 1) as f64),
            inscribed,
        }
    }

    /// The same body less an inset (m), which must not exceed [`Self::min_curvature_radius`].
    pub fn eroded(&self, inset: f64) -> Self {
        Self { inset, ..*self }
    }

    /// The body without inset or rounding.
    pub fn sharp(&self) -> Self {
        Self::build(self.sharp_axes, self.sharp_eps, 0.0)
    }

    /// The body magnified, its inset too.
    pub fn magnified(&self, factor: f64) -> Self {
        let sharp_axes = self.sharp_axes * factor;
        let core = Self::build(self.semi_axes * factor, self.eps, self.inset * factor);
        Self { sharp_axes, sharp_eps: self.sharp_eps, ..core }
    }

    /// Semi-axes of the body without inset (m).
    pub fn semi_axes(&self) -> &Vec3 {
        &self.semi_axes
    }

    /// Semi-axes of the body without inset or rounding (m).
    pub(crate) fn sharp_axes(&self) -> &Vec3 {
        &self.sharp_axes
    }

    /// Exponents p = 2/ε₂ and q = 2/ε₁ of the body without inset or rounding (-).
    fn sharp_exponents(&self) -> [f64; 2] {
        let [first, second] = self.sharp_eps;
        [2.0 / second, 2.0 / first]
    }

    /// Exponents ε₁ (meridian) and ε₂ (x-y section) (-).
    pub fn eps(&self) -> [f64; 2] {
        self.eps
    }

    /// How far the body lies within the superellipsoid (m).
    pub fn inset(&self) -> f64 {
        self.inset
    }

    /// Radius of the largest ball about the centre that fits in the body without inset (m).
    pub fn inscribed_radius(&self) -> f64 {
        self.inscribed
    }

    /// Inside-outside function (2.1, 2.21) of the body without inset or rounding: 1 on its surface, less
    /// inside (-).
    pub fn inside_outside(&self, point: &Vec3) -> f64 {
        let [x, y, z] = point.component_div(&self.sharp_axes).abs().into();
        let [p, q] = self.sharp_exponents();
        match if self.sharp_eps == self.eps { self.powers } else { Powers::Real } {
            Powers::Squares => x * x + y * y + z * z,
            Powers::Natural([n, m, ratio]) => {
                let [xp, yp] = natural([x, y], n);
                let s = xp * x * x + yp * y * y;
                s * natural([s], ratio)[0] + natural([z], m)[0] * z * z
            }
            Powers::Real => {
                let [xp, yp, zq] = pow([x, y, z], [p, p, q]);
                if p == q { xp + yp + zq } else { pow([xp + yp], [q / p])[0] + zq }
            }
        }
    }

    /// Gauge of the body without inset or rounding, F^(ε₁/2): the factor by which it is to be magnified for `point` to
    /// lie on its surface (-); and its gradient (1/m), which is along the outward normal.
    pub fn gauge(&self, point: &Vec3) -> (f64, Vec3) {
        let scaled = point.component_div(&self.sharp_axes);
        let largest = scaled.amax();
        if largest.is_nan() || largest <= 0.0 {
            return (0.0, Vec3::zeros());
        }
        let (gauge, gradient) = dual_norm((scaled / largest).abs(), self.sharp_exponents());
        let signed = gradient.zip_map(point, f64::copysign);
        (gauge * largest, signed.component_div(&self.sharp_axes))
    }

    /// Whether the body is an ellipsoid.
    #[inline(always)]
    pub fn is_ellipsoid(&self) -> bool {
        self.powers == Powers::Squares
    }

    /// Whether the surface has normals and points that Newton's method can follow; ε = 2 makes flat faces.
    pub(crate) fn is_smooth(&self) -> bool {
        self.eps[0] < 2.0 && self.eps[1] < 2.0
    }

    /// Whether edges or corners of infinite curvature make normals, not points, the smooth variable.
    pub fn is_sharp(&self) -> bool {
        self.eps[0] > 1.0 || self.eps[1] > 1.0
    }

    /// Factor by which the body without inset fits into this one: (1 − t) K + t K = K, and t K holds a ball of
    /// the inset for t = inset / inscribed radius.
    pub(crate) fn shrinking(&self) -> f64 {
        1.0 - self.inset / self.inscribed
    }

    /// Dual norm h of `n` and its gradient, the support point of the body without inset.
    pub(crate) fn dual(&self, n: &Vec3) -> (f64, Vec3) {
        let scaled = n.component_mul(&self.semi_axes);
        if self.powers == Powers::Squares {
            let h = scaled.norm();
            let point = if h > 0.0 { scaled / h } else { Vec3::x() };
            return (h, point.component_mul(&self.semi_axes));
        }
        let largest = scaled.amax();
        if largest.is_nan() || largest <= 0.0 {
            return (0.0, Vec3::new(self.semi_axes.x, 0.0, 0.0));
        }
        let (h, point) = dual_norm((scaled / largest).abs(), self.conjugates);
        let signed = point.zip_map(n, f64::copysign);
        (h * largest, signed.component_mul(&self.semi_axes))
    }
}

/// ‖(‖(u, v)‖_p, w)‖_q and its gradient, for components in [0, 1], one of them 1.
fn dual_norm(x: Vec3, [p, q]: [f64; 2]) -> (f64, Vec3) {
    let [u, v, w] = x.into();
    if p == q && p < f64::INFINITY {
        let [up, vp, wp] = pow([u, v, w], [p - 1.0; 3]);
        let s = u * up + v * vp + w * wp;
        let h = pow([s], [1.0 / p])[0];
        return (h, Vec3::new(up, vp, wp) * (h / s));
    }
    // ‖(u, v)‖_p = m and its gradient.
    let (m, along) = plane_norm([u, v], p);
    let (h, [h_m, h_w]) = plane_norm([m, w], q);
    (h, Vec3::new(along[0] * h_m, along[1] * h_m, h_w))
}

/// ‖(u, v)‖_p and its gradient, for components that are not negative.
#[inline(always)]
fn plane_norm([u, v]: [f64; 2], p: f64) -> (f64, [f64; 2]) {
    let largest = if u > v { u } else { v };
    if p == f64::INFINITY || largest <= 0.0 {
        return (largest, if u >= v { [1.0, 0.0] } else { [0.0, 1.0] });
    }
    let (u, v) = (u / largest, v / largest);
    let [up, vp] = if p == 2.0 { [u, v] } else { pow([u, v], [p - 1.0; 2]) };
    let s = u * up + v * vp;
    let m = if p == 2.0 { s.sqrt() } else { pow([s], [1.0 / p])[0] };
    (m * largest, [up * m / s, vp * m / s])
}
