//! A superellipsoid near a point of its surface: normal, curvature, and a bound of the support function.

use super::{Powers, Superellipsoid};
use crate::Vec3;
use crate::powers::{exp2, log2, natural};

/// Largest curvature of an edge (ε > 1), where it is infinite (1/semi-axis).
const EDGE: f64 = 1e6;
/// Distance of T from 1 up to which its root is a series of [`SERIES`] terms.
pub(super) const NEAR_ONE: f64 = 4e-3;
/// Number of those terms.
pub(super) const SERIES: usize = 6;
/// Distance up to which three terms do.
const NEARER_ONE: f64 = 1e-4;
/// Change of a component of the normal, relative to it, up to which the support function is bounded by
/// its second derivative.
pub(super) const SMALL_TURN: f64 = 0.1;

/// The surface at one of its points, in the body's frame and without its inset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Local {
    /// Point of the surface (m).
    pub point: Vec3,
    /// Outward unit normal (-).
    pub normal: Vec3,
    /// normal·point, which is 1/|∇F| (m).
    height: f64,
    /// Second derivatives of F along the axes, without what they have along ∇F, over |∇F| (1/m).
    diagonal: Vec3,
    /// Factor of nᵢnⱼ, i and j of x and y, in them: q ≠ p couples x and y (1/m).
    coupling: f64,
}

impl Local {
    /// The form of curvature of tangents e and f, e ∇∇F f / |∇F| (1/m): [[ee, ef], [ef, ff]].
    #[inline(always)]
    pub fn curvature(&self, e: &Vec3, f: &Vec3) -> [[f64; 2]; 2] {
        let (de, df) = (self.diagonal.component_mul(e), self.diagonal.component_mul(f));
        let ne = self.normal.x * e.x + self.normal.y * e.y;
        let nf = self.normal.x * f.x + self.normal.y * f.y;
        let (ce, cf) = (self.coupling * ne, self.coupling * nf);
        let mixed = de.dot(f) + ce * nf;
        [[de.dot(e) + ce * ne, mixed], [mixed, df.dot(f) + cf * nf]]
    }
}

impl Superellipsoid {
    /// The surface where the ray from the centre through `near` leaves the body without inset.
    #[inline(always)]
    pub(crate) fn local(&self, near: &Vec3) -> Local {
        let inverse = &self.inverse_axes;
        let x = near.component_mul(inverse);
        let squares = inverse.component_mul(inverse);
        if self.powers == Powers::Squares {
            let gradient = near.component_mul(&squares);
            let point = near * (1.0 / x.norm());
            let normal = gradient * (1.0 / gradient.norm());
            let height = normal.dot(&point);
            return Local { point, normal, height, diagonal: squares * height, coupling: 0.0 };
        }
        let [p, q] = self.exponents;
        let (powers, s) = self.raised(&x);
        let gradient = powers.component_mul(near).component_mul(&squares);
        let normal = gradient * (1.0 / gradient.norm());
        let t = s + powers.z * x.z * x.z;
        let k = root(t, &self.root);
        let point = near * k;
        let height = normal.dot(&point);
        let bend = height / (t * k * k);
        let factors = Vec3::new(p - 1.0, p - 1.0, q - 1.0) * bend;
        let cut = powers.map(|x| if x < EDGE { x } else { EDGE });
        let diagonal = cut.component_mul(&factors).component_mul(&squares);
        let coupling = if p == q || s < f64::MIN_POSITIVE { 0.0 } else { (q - p) * t / (s * height) };
        Local { point, normal, height, diagonal, coupling }
    }

    /// Factors of (X, Y, Z) in ∇F^q/q: S^(q/p−1) |X|^(p−2), the same of Y, |Z|^(q−2); and S^(q/p), with
    /// S = |X|^p + |Y|^p.
    #[inline(always)]
    fn raised(&self, x: &Vec3) -> (Vec3, f64) {
        let [p, q] = self.exponents;
        if let Powers::Natural([n, m, ratio]) = self.powers {
            let (u, v, w) = if n == m {
                natural([x.x.abs(), x.y.abs(), x.z.abs()], n).into()
            } else {
                let [u, v] = natural([x.x.abs(), x.y.abs()], n);
                (u, v, natural([x.z.abs()], m)[0])
            };
            let s = u * x.x * x.x + v * x.y * x.y;
            let c = natural([s], ratio)[0];
            return (Vec3::new(c * u, c * v, w), c * s);
        }
        let [u, v, w] = x.abs().map(|x| if x > f64::MIN_POSITIVE { x } else { f64::MIN_POSITIVE }).into();
        // X and Y over the larger of the two, so that no power of a small S is taken.
        let largest = if p == q {
            1.0
        } else if u > v {
            u
        } else {
            v
        };
        let (across, along) = (u / largest, v / largest);
        let log = log2([across, along, w, largest]);
        let powers = [log[0] * (p - 2.0), log[1] * (p - 2.0), log[2] * (q - 2.0), log[3] * (q - 2.0)];
        let [u, v, w, scale] = exp2(powers);
        let s = u * across * across + v * along * along;
        let c = if p == q { 1.0 } else { scale * exp2([log2([s])[0] * (q / p - 1.0)])[0] };
        (Vec3::new(c * u, c * v, w), c * s * largest * largest)
    }

    /// Upper bound of h(n) − n·y for a direction n (any length) near the normal at the point y of `local`;
    /// exact but for terms of third order in the difference (units of n times m).
    #[inline(always)]
    pub(crate) fn excess(&self, local: &Local, n: &Vec3) -> f64 {
        let reach = n.dot(&local.point);
        if self.powers == Powers::Squares && reach > 0.0 {
            // h² − reach² without the cancellation: |a∘n − reach a∘∇F|².
            let off = n * local.height - local.normal * reach;
            let squared = off.component_mul(&self.semi_axes).norm_squared();
            return squared / (2.0 * reach * local.height * local.height);
        }
        if let Some(excess) = self.second_order(local, n, reach) {
            return excess;
        }
        self.dual(n).0 - reach
    }

    /// A coarser bound of the same that takes no powers: with n = g + off and g along the normal at y,
    /// h(n) ≤ h(g) + h(off) ≤ n·y + Σ aᵢ |offᵢ|; none for an n that points the other way.
    #[inline(always)]
    pub(crate) fn excess_at_most(&self, local: &Local, n: &Vec3) -> f64 {
        let reach = n.dot(&local.point);
        if reach <= 0.0 {
            return f64::INFINITY;
        }
        let off = n - local.normal * (reach / local.height);
        self.semi_axes.dot(&off.abs())
    }

    /// With n = g + off, g = reach ∇F, off·y = 0 and h(∇F) = 1: ½ off·∇∇h·off and the growth of ∇∇h on the way.
    ///
    /// Each of the two nested norms adds at most (P − 1)/2 Σ ωᵢrᵢ² of the relative changes rᵢ of the
    /// components with weights ωᵢ = gᵢyᵢ; the factor 2 is more than the changes of ω and r.
    #[inline(always)]
    fn second_order(&self, local: &Local, n: &Vec3, reach: f64) -> Option<f64> {
        let gradient = local.normal * (reach / local.height);
        let off = n - gradient;
        let mut sum = 0.0;
        let mut small = true;
        let [dual_p, dual_q] = self.conjugates;
        let limit = SMALL_TURN / dual_p.max(dual_q);
        for i in 0..3 {
            let slope = gradient[i];
            small &= off[i].abs() <= limit * slope.abs();
            let term = off[i] * off[i] * local.point[i] / slope;
            sum += if off[i] == 0.0 { 0.0 } else { term };
        }
        (small && reach > 0.0).then_some(sum * (dual_p + dual_q - 2.0))
    }
}

/// t^(−1/q): a series near 1, (1 + x)^s = 1 + s x (1 + (s−1)/2 x (1 + ...)), with the given ratios of its terms.
#[inline(always)]
fn root(t: f64, ratios: &[f64; SERIES]) -> f64 {
    let x = t - 1.0;
    let sum = |terms: &[f64]| terms.iter().rev().fold(1.0, |sum, ratio| 1.0 + ratio * x * sum);
    match x.abs() {
        off if off < NEARER_ONE => sum(&ratios[..3]),
        off if off < NEAR_ONE => sum(ratios),
        _ => exp2([ratios[0] * log2([t])[0]])[0],
    }
}
