//! Radii of superellipsoids: of balls inside and outside, and of curvature; rounded edges.

use super::{EPS_RANGE, Superellipsoid};
use crate::Vec3;
use std::f64::consts::FRAC_PI_2;

/// Samples per parameter of the search for an extremum over an octant.
const SAMPLES: usize = 32;
/// Halvings of the step of that search, from one sample distance.
const HALVINGS: usize = 40;
/// Share by which rounded bodies are made smaller than sampled (-).
const MARGIN: f64 = 1e-9;
/// First and last step in ε of the search for a rounded body.
const FIRST_STEP: f64 = 0.04;
const LAST_STEP: f64 = 1e-4;
/// Largest ε of that search, unless the body's is larger: beyond it edges are too sharp for Newton's method.
const SMOOTH: f64 = 1.95;
/// Relative gain for which that search moves.
const GAIN: f64 = 1e-3;
/// Directions in ε₁, ε₂ and the shift of the axes that it tries.
const DIRECTIONS: [(f64, f64, f64); 7] = [
    (1.0, 1.0, 0.0),
    (1.0, 0.0, 0.0),
    (0.0, 1.0, 0.0),
    (-1.0, 0.0, 0.0),
    (0.0, -1.0, 0.0),
    (0.0, 0.0, -1.0),
    (0.0, 0.0, 1.0),
];

/// Where the extremes over all directions are looked for.
#[derive(Clone, Copy)]
enum Normals {
    /// Among those of a sphere: quickly, for choosing.
    OfSphere,
    /// Also among those of the bodies that are compared: surely.
    OfBodies,
}

/// Radius of the largest ball about the centre: for each norm the smallest c X + d Y on X^(1/ε) + Y^(1/ε) = 1,
/// with squares for variables, is at an end for ε ≤ 1 and (c^s + d^s)^(1/s), s = 1/(1 − ε), beyond (m).
pub(super) fn inscribed_radius(semi_axes: &Vec3, eps: [f64; 2]) -> f64 {
    let min = |c: f64, d: f64, eps: f64| if eps <= 1.0 { c.min(d) } else { mean(c, d, 1.0 / (1.0 - eps)) };
    extreme(semi_axes, eps, min)
}

/// Radius of the smallest ball about the centre that holds the body: as [`inscribed_radius`] with the
/// largest value, which is at an end for ε ≥ 1 (m).
pub(super) fn bounding_radius(semi_axes: &Vec3, eps: [f64; 2]) -> f64 {
    let max = |c: f64, d: f64, eps: f64| if eps >= 1.0 { c.max(d) } else { mean(c, d, 1.0 / (1.0 - eps)) };
    extreme(semi_axes, eps, max)
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
    pub fn min_curvature_radius(&self) -> f64 {
        if self.is_sharp() {
            return 0.0;
        }
        let (min, max) = (self.semi_axes.min(), self.semi_axes.max());
        if self.eps == [1.0; 2] {
            return min * min / max;
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

    /// A smaller superellipsoid which, swept by a ball of the given radius (m), stays within this one and touches it:
    /// bodies with edges have no inner parallel body of their own kind.
    ///
    /// Of those of semi-axes (1 − t)(aᵢ − λ radius) and any exponents the one that leaves the smallest gap,
    /// relative to the body's extent in any direction: a larger ε keeps the tips in place while the faces
    /// between them move inwards.
    pub fn rounded(&self, radius: f64) -> Self {
        let mut best =
            ([self.eps[0], self.eps[1], 1.0], self.within(self.eps, 1.0, radius, Normals::OfSphere));
        let mut step = FIRST_STEP;
        while step > LAST_STEP {
            let mut moved = false;
            for (first, second, share) in DIRECTIONS {
                let [e1, e2, shift] = best.0;
                let eps = [(e1 + first * step, self.eps[0]), (e2 + second * step, self.eps[1])]
                    .map(|(e, own)| e.clamp(*EPS_RANGE.start(), own.max(SMOOTH)));
                let at = [eps[0], eps[1], (shift + share * step / FIRST_STEP).clamp(0.0, 1.0)];
                let found = self.within(eps, at[2], radius, Normals::OfSphere);
                if found.1 < best.1.1 * (1.0 - GAIN) {
                    (best, moved) = ((at, found), true);
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        let [first, second, shift] = best.0;
        let core = self.within([first, second], shift, radius, Normals::OfBodies).0;
        Self { sharp_axes: self.semi_axes, sharp_eps: self.eps, ..core }
    }

    /// The largest body of the given ε and semi-axes in proportion to aᵢ − shift radius which, swept by a ball of the
    /// radius, stays within this one; and the largest gap between the two, relative to the extent of this one.
    fn within(&self, eps: [f64; 2], shift: f64, radius: f64, normals: Normals) -> (Self, f64) {
        let axes = self.semi_axes.add_scalar(-shift * radius);
        let core = Self::build(axes, eps, 0.0);
        let excess = |n: &Vec3| 1.0 - (self.dual(n).0 - radius) / core.dual(n).0;
        let smaller = self.largest_over_normals(&core, normals, excess);
        let core = Self::build(axes * (1.0 - smaller.max(0.0) - MARGIN), eps, 0.0);
        let gap = |n: &Vec3| 1.0 - (core.dual(n).0 + radius) / self.dual(n).0;
        (core, self.largest_over_normals(&core, normals, gap))
    }

    /// Largest value over all directions, sought among directions crowded where a component vanishes, and among the normals of
    /// this body and of another: ridges that are narrow in one of them are wide in another.
    fn largest_over_normals(&self, other: &Self, normals: Normals, value: impl Fn(&Vec3) -> f64) -> f64 {
        let crowded = |angle: f64| {
            let share = angle / FRAC_PI_2;
            angle * share * share * (10.0 - share * (15.0 - 6.0 * share))
        };
        let sphere = Self { semi_axes: Vec3::repeat(1.0), eps: [1.0; 2], ..*self };
        let of_angles = |a: f64, l: f64, _: f64| value(&sphere.normal_at(crowded(a), crowded(l)).normalize());
        let of_body = |body: &Self| {
            largest_over_octant(|a: f64, l: f64, _: f64| value(&body.normal_at(a, l).normalize()))
        };
        let of_all = largest_over_octant(of_angles);
        match normals {
            Normals::OfSphere => of_all,
            Normals::OfBodies => of_all.max(of_body(self)).max(of_body(other)),
        }
    }

    /// Direction of the normal at the point of azimuth φ₁ and latitude φ₂ (rad) in the first octant:
    /// (cos^(2−ε₁) φ₂ cos^(2−ε₂) φ₁/a₁, cos^(2−ε₁) φ₂ sin^(2−ε₂) φ₁/a₂, sin^(2−ε₁) φ₂/a₃).
    fn normal_at(&self, azimuth: f64, latitude: f64) -> Vec3 {
        let snapped = |x: f64| if x < 1e-15 { 0.0 } else { x };
        let [e1, e2] = self.eps.map(|e| 2.0 - e);
        let power = |x: f64, e: f64| libm::pow(snapped(x), e);
        let ring = power(libm::cos(latitude), e1);
        let (c, s) = (power(libm::cos(azimuth), e2), power(libm::sin(azimuth), e2));
        Vec3::new(ring * c, ring * s, power(libm::sin(latitude), e1)).component_div(&self.semi_axes)
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
