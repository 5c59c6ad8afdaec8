//! Surfaces of superellipsoids without edges (ε ≤ 1) near their points, without branches.
//!
//! The same as [`Local`](super::Local), but only where a point is nearly on the surface: elsewhere nothing is a number.

use super::local::{NEAR_ONE, SERIES, SMALL_TURN};
use super::{Powers, Superellipsoid};
use crate::Vec3;
use crate::lanes::{Number, Vector, natural};

/// A superellipsoid without edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundBody {
    /// Semi-axes without inset, their inverses, and the squares of these (m, 1/m, 1/m²).
    axes: Vec3,
    inverse: Vec3,
    squares: Vec3,
    /// p − 2, q − 2 and q/p − 1, if all are natural numbers.
    natural: Option<[u32; 3]>,
    /// p and q.
    exponents: [f64; 2],
    /// Sum of their conjugates less 2, and relative change of the normal up to which the support function is bounded by its second
    /// derivative.
    growth: f64,
    limit: f64,
    root: [f64; SERIES],
    /// Inset (m).
    pub(crate) inset: f64,
}

/// The surface at one of its points, in the body's frame and without its inset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<T> {
    /// Point of the surface (m).
    pub(crate) point: Vector<T>,
    /// Outward unit normal.
    pub(crate) normal: Vector<T>,
    /// normal·point (m).
    height: T,
    /// Form of curvature along the axes, and its factor of nᵢnⱼ, i and j of x and y (1/m).
    diagonal: Vector<T>,
    coupling: T,
}

impl Superellipsoid {
    /// The body, if it has no edges.
    #[inline(always)]
    pub(crate) fn round(&self) -> Option<RoundBody> {
        if self.is_sharp() {
            return None;
        }
        let natural = match self.powers {
            Powers::Squares => Some([0; 3]),
            Powers::Natural(powers) => Some(powers),
            Powers::Real => None,
        };
        let [dual_p, dual_q] = self.conjugates;
        Some(RoundBody {
            axes: self.semi_axes,
            inverse: self.inverse_axes,
            squares: self.inverse_axes.component_mul(&self.inverse_axes),
            natural,
            exponents: self.exponents,
            growth: dual_p + dual_q - 2.0,
            limit: SMALL_TURN / dual_p.max(dual_q),
            root: self.root,
            inset: self.inset,
        })
    }
}

impl RoundBody {
    /// Sum of the semi-axes (m).
    #[inline(always)]
    pub(crate) fn size(&self) -> f64 {
        self.axes.x + self.axes.y + self.axes.z
    }

    /// The surface where the ray from the centre through `near` leaves the body; not numbers if that is far from `near`.
    #[inline(always)]
    pub(crate) fn surface<T: Number>(&self, near: &Vector<T>) -> Surface<T> {
        let one = T::of(1.0);
        let squares = Vector::of(&self.squares);
        let x = near.by_component(&Vector::of(&self.inverse));
        let (powers, s) = self.raised(&x);
        let gradient = powers.by_component(near).by_component(&squares);
        let normal = gradient.times(one / gradient.norm());
        let [_, _, z] = x.0;
        let t = s + powers.0[2] * (z * z);
        let k = self.root(t);
        let point = near.times(k);
        let height = normal.dot(&point);
        let bend = height / (t * k * k);
        let [p, q] = self.exponents;
        let factors = [p - 1.0, p - 1.0, q - 1.0].map(|factor| T::of(factor) * bend);
        let diagonal = powers.by_component(&Vector(factors)).by_component(&squares);
        let zero = T::of(0.0);
        let coupling = if p == q {
            zero
        } else {
            s.if_above(T::of(f64::MIN_POSITIVE), T::of(q - p) * t / (s * height), zero)
        };
        Surface { point, normal, height, diagonal, coupling }
    }

    /// Factors of (X, Y, Z) in ∇F^q/q, and S^(q/p), with S = |X|^p + |Y|^p, as those of [`Local`](super::Local).
    #[inline(always)]
    fn raised<T: Number>(&self, x: &Vector<T>) -> (Vector<T>, T) {
        let [u, v, w] = x.0.map(Number::abs);
        if let Some([n, m, ratio]) = self.natural {
            let (up, vp) = (natural(u, n), natural(v, n));
            let s = up * (u * u) + vp * (v * v);
            let c = natural(s, ratio);
            return (Vector([c * up, c * vp, natural(w, m)]), c * s);
        }
        let [p, q] = self.exponents;
        let (one, smallest) = (T::of(1.0), T::of(f64::MIN_POSITIVE));
        let [u, v, w] = [u, v, w].map(|x| x.if_above(smallest, x, smallest));
        // X and Y over the larger of the two, so that no power of a small S is taken.
        let largest = if p == q { one } else { u.if_above(v, u, v) };
        let (across, along) = (u / largest, v / largest);
        let power = |x: T, exponent: f64| (x.log2() * T::of(exponent)).exp2();
        let (up, vp, wp) = (power(across, p - 2.0), power(along, p - 2.0), power(w, q - 2.0));
        let s = up * (across * across) + vp * (along * along);
        let c = if p == q { one } else { power(largest, q - 2.0) * power(s, q / p - 1.0) };
        (Vector([c * up, c * vp, wp]), c * s * (largest * largest))
    }

    /// t^(−1/q) near 1 by its series; elsewhere not a number.
    #[inline(always)]
    fn root<T: Number>(&self, t: T) -> T {
        let one = T::of(1.0);
        let x = t - one;
        let mut sum = one;
        for ratio in self.root.iter().rev() {
            sum = one + T::of(*ratio) * x * sum;
        }
        T::of(NEAR_ONE).if_above(x.abs(), sum, T::of(f64::NAN))
    }

    /// Upper bound of h(n) − n·y for a direction n (any length) near the normal at the point y of the surface, as
    /// [`Superellipsoid::excess`]; not a number where n is too far from that normal.
    #[inline(always)]
    pub(crate) fn excess<T: Number>(&self, at: &Surface<T>, n: &Vector<T>) -> T {
        let (zero, none) = (T::of(0.0), T::of(f64::NAN));
        let reach = n.dot(&at.point);
        let gradient = at.normal.times(reach / at.height);
        let off = n.minus(&gradient);
        let mut sum = zero;
        for axis in 0..3 {
            let (off, slope) = (off.0[axis], gradient.0[axis]);
            let term = off.if_equal(zero, zero, off * off * at.point.0[axis] / slope);
            sum = off.abs().if_above(T::of(self.limit) * slope.abs(), none, sum + term);
        }
        reach.if_above(zero, sum * T::of(self.growth), none)
    }
}

impl<T: Number> Surface<T> {
    /// The form of curvature of tangents e and f (1/m): [[ee, ef], [ef, ff]].
    #[inline(always)]
    pub(crate) fn curvature(&self, e: &Vector<T>, f: &Vector<T>) -> [[T; 2]; 2] {
        let (of_e, of_f) = (self.diagonal.by_component(e), self.diagonal.by_component(f));
        let [x, y, _] = self.normal.0;
        let along_e = x * e.0[0] + y * e.0[1];
        let along_f = x * f.0[0] + y * f.0[1];
        let (coupled_e, coupled_f) = (self.coupling * along_e, self.coupling * along_f);
        let mixed = of_e.dot(f) + coupled_e * along_f;
        [[of_e.dot(e) + coupled_e * along_e, mixed], [mixed, of_f.dot(f) + coupled_f * along_f]]
    }
}
