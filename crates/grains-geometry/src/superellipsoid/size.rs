//! Radii of superellipsoids: of balls inside and outside, and of curvature; rounded edges.

use super::Superellipsoid;
use crate::Vec3;
use std::f64::consts::FRAC_PI_2;

/// Samples per parameter of the search for an extremum over an octant.
const SAMPLES: usize = 32;
/// Halvings of the step of that search, from one sample distance.
const HALVINGS: usize = 40;
/// Safety margin of the sampled shift of the axes of rounded bodies (-).
const MARGIN: f64 = 1.0 + 1e-9;

/// Radius of the largest ball about the centre: for each norm the least c X + d Y on X^(1/ε) + Y^(1/ε) = 1,
/// with squares for variables, is at an end for ε ≤ 1 and (c^s + d^s)^(1/s), s = 1/(1 − ε), beyond (m).
pub(super) fn inscribed_radius(semi_axes: &Vec3, eps: [f64; 2]) -> f64 {
    let least = |c: f64, d: f64, eps: f64| if eps <= 1.0 { c.min(d) } else { mean(c, d, 1.0 / (1.0 - eps)) };
    extreme(semi_axes, eps, least)
}

/// Radius of the smallest ball about the centre that holds the body: as [`inscribed_radius`] with the
/// largest value, which is at an end for ε ≥ 1 (m).
pub(super) fn bounding_radius(semi_axes: &Vec3, eps: [f64; 2]) -> f64 {
    let most = |c: f64, d: f64, eps: f64| if eps >= 1.0 { c.max(d) } else { mean(c, d, 1.0 / (1.0 - eps)) };
    extreme(semi_axes, eps, most)
}

fn extreme(semi_axes: &Vec3, eps: [f64; 2], of: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let largest = semi_axes.amax();
    let [a, b, c] = (semi_axes / largest).map(|a| a * a).into();
    largest * of(of(a, b, eps[1]), c, eps[0]).sqrt()
}

/// (c^s + d^s)^(1/s).
fn mean(c: f64, d: f64, s: f64) -> f64 {
    let (largest, ratio) = if (c > d) == (s > 0.0) { (c, d / c) } else { (d, c / d) };
    largest * libm::pow(1.0 + libm::pow(ratio, s), 1.0 / s)
}

impl Superellipsoid {
    /// Radius of the smallest ball about the centre that holds the body without inset (m).
    pub fn bounding_radius(&self) -> f64 {
        bounding_radius(&self.semi_axes, self.eps)
    }

    /// Point of the surface of the parametric form (2.2) at azimuth φ₁ and latitude φ₂ (rad), without inset:
    /// x = a₁ cos^ε₁ φ₂ cos^ε₂ φ₁, y = a₂ cos^ε₁ φ₂ sin^ε₂ φ₁, z = a₃ sin^ε₁ φ₂ (m).
    pub fn surface_point(&self, azimuth: f64, latitude: f64) -> Vec3 {
        // Sines of multiples of π are zero but for rounding, which a small power would magnify.
        let snapped = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
        let signed = |x: f64, e: f64| libm::copysign(libm::pow(snapped(x.abs()), e), x);
        let [e1, e2] = self.eps;
        let ring = signed(libm::cos(latitude), e1);
        Vec3::new(
            self.semi_axes.x * ring * signed(libm::cos(azimuth), e2),
            self.semi_axes.y * ring * signed(libm::sin(azimuth), e2),
            self.semi_axes.z * signed(libm::sin(latitude), e1),
        )
    }

    /// Smallest radius of curvature (m): c²/a of the axes of an ellipsoid, zero with an edge (an ε > 1),
    /// else sought over an octant.
    pub fn least_curvature_radius(&self) -> f64 {
        if self.is_sharp() {
            return 0.0;
        }
        let (least, most) = (self.semi_axes.min(), self.semi_axes.max());
        if self.eps == [1.0; 2] {
            return least * least / most;
        }
        1.0 / largest_over_octant(|azimuth, latitude, _| self.largest_curvature(azimuth, latitude))
    }

    /// Larger principal curvature at a point of the surface (1/m).
    fn largest_curvature(&self, azimuth: f64, latitude: f64) -> f64 {
        let local = self.local(&self.surface_point(azimuth, latitude));
        let [e, f] = tangents(&local.normal);
        let [[a, b], [_, d]] = local.curvature(&e, &f);
        0.5 * (a + d) + libm::hypot(0.5 * (a - d), b)
    }

    /// A smaller superellipsoid of the same ε which, swept by a ball of the given radius (m), stays within
    /// this one and touches it: bodies with edges have no inner parallel body of their own kind.
    ///
    /// Of the two that either reduce all semi-axes by one length or all by one factor, the larger.
    pub fn rounded(&self, radius: f64) -> Self {
        let factor = 1.0 - radius / self.inscribed;
        let shrunk = self.semi_axes * factor;
        let shift = MARGIN * self.least_shift(radius);
        let shifted = self.semi_axes.add_scalar(-shift);
        let larger = shifted.min() > 0.0 && shifted.product() > shrunk.product();
        let core = Self::build(if larger { shifted } else { shrunk }, self.eps, 0.0);
        Self { sharp_axes: self.semi_axes, ..core }
    }

    /// Least length by which all semi-axes must be shorter for the rounded body to stay within (m).
    fn least_shift(&self, radius: f64) -> f64 {
        let fits = |shift: f64, n: &Vec3| {
            let shorter = Self { semi_axes: self.semi_axes.add_scalar(-shift), ..*self };
            shorter.dual(n).0 + radius <= self.dual(n).0
        };
        largest_over_octant(|azimuth, latitude, least| {
            let (s, c) = (libm::sin(latitude), libm::cos(latitude));
            let n = Vec3::new(c * libm::cos(azimuth), c * libm::sin(azimuth), s);
            let mut range = [least.max(radius), self.semi_axes.min()];
            if fits(range[0], &n) {
                return range[0];
            }
            for _ in 0..HALVINGS {
                let shift = 0.5 * (range[0] + range[1]);
                range[usize::from(fits(shift, &n))] = shift;
            }
            range[1]
        })
    }
}

/// Two unit vectors that make a right-handed basis with the unit vector `n` (Duff et al. 2017).
#[inline(always)]
pub(crate) fn tangents(n: &Vec3) -> [Vec3; 2] {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y)]
}

/// Largest value over the parameters in [0, π/2]²: best of a grid, then a pattern search with halved steps.
///
/// `value` also gets the largest so far, and may answer that if it would be less.
fn largest_over_octant(value: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let step = FRAC_PI_2 / SAMPLES as f64;
    let mut best = ([0.0; 2], f64::NEG_INFINITY);
    for i in 0..=SAMPLES {
        for k in 0..=SAMPLES {
            let at = [i as f64 * step, k as f64 * step];
            let found = value(at[0], at[1], best.1);
            if found > best.1 {
                best = (at, found);
            }
        }
    }
    let mut step = step;
    for _ in 0..HALVINGS {
        let mut moved = false;
        for (da, dl) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let at = [best.0[0] + da * step, best.0[1] + dl * step].map(|x: f64| x.clamp(0.0, FRAC_PI_2));
            let found = value(at[0], at[1], best.1);
            if found > best.1 {
                (best, moved) = ((at, found), true);
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    best.1
}
