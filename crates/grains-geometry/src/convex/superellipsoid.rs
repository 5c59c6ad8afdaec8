//! Superellipsoids as convex bodies.

use super::feature::Feature;
use super::surface_points::{SurfaceElement, lattice, on_sphere};
use super::{Convex, Support, normal_to};
use crate::superellipsoid::Superellipsoid;
use crate::{Mat3, Vec3};
use std::f64::consts::PI;

/// Directions in which the closest place on the surface is sought, each the normal where the last one led.
const ROUNDS: usize = 3;
/// Newton steps along a ray to the surface.
const RAY_STEPS: usize = 30;
/// Halvings that look for a point of a line inside; the body is passed by if it is that flat there.
const HALVINGS: usize = 40;
/// Newton steps to an end of a chord, which approach it from outside.
const CHORD_STEPS: usize = 100;
/// Step at which an end is found (relative to the size).
const FOUND: f64 = 1e-13;

impl Support for Superellipsoid {
    const CURVED: bool = true;

    #[inline]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let (_, point) = self.dual(direction);
        let length = direction.norm();
        if self.inset() > 0.0 && length > 0.0 {
            return point - direction * (self.inset() / length);
        }
        // A zero direction gets the end of the first axis.
        if self.inset() > 0.0 { point * self.shrinking() } else { point }
    }

    #[inline]
    fn height(&self, direction: &Vec3) -> f64 {
        let whole = if self.is_ellipsoid() {
            direction.component_mul(self.semi_axes()).norm()
        } else {
            self.dual(direction).0
        };
        whole - self.inset() * direction.norm()
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.semi_axes().amax()
    }

    #[inline(always)]
    fn superellipsoid(&self) -> Option<&Superellipsoid> {
        Some(self)
    }
}

impl Convex for Superellipsoid {
    fn bounds(&self) -> (Vec3, Vec3) {
        let half = self.semi_axes().add_scalar(-self.inset());
        (-half, half)
    }

    fn radius(&self) -> f64 {
        self.bounding_radius() - self.inset()
    }

    fn largest_distance(&self, _crust: f64, _rotation: &Mat3, center: &Vec3) -> f64 {
        center.norm() + self.sharp().bounding_radius()
    }

    fn for_each_vertex(&self, _visit: impl FnMut(Vec3)) {}

    fn offset_from(&self, _point: &Vec3) -> Option<Vec3> {
        None
    }

    fn contact_feature(&self, _direction: &Vec3, _found: &mut Feature) -> Option<()> {
        None
    }

    #[inline]
    fn contains(&self, _crust: f64, point: &Vec3) -> bool {
        self.inside_outside(point) <= 1.0
    }

    fn extents(&self, _crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        let half = rotation.abs() * self.sharp_axes();
        (-half, half)
    }

    /// Where the gauge, which is convex, is at most 1.
    fn chord(&self, _crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        let gauge = |s: f64| {
            let (gauge, gradient) = self.gauge(&(start + along * s));
            (gauge, gradient.dot(along))
        };
        let (size, nearest) = (self.sharp_axes().norm(), -start.dot(along));
        let ends = (nearest - size, nearest + size);
        let (mut low, mut high) = ends;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let (value, slope) = gauge(middle);
            if value <= 1.0 {
                let end = |mut s: f64| {
                    for _ in 0..CHORD_STEPS {
                        let (value, slope) = gauge(s);
                        let step = (value - 1.0) / slope;
                        s -= step;
                        if step.abs() <= FOUND * size {
                            break;
                        }
                    }
                    s
                };
                return Some((end(ends.0), end(ends.1)));
            }
            // The tangent is below the gauge.
            if value - slope.abs() * 0.5 * (high - low) > 1.0 {
                return None;
            }
            if slope > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        None
    }

    fn exit(&self, _crust: f64, point: &Vec3, direction: &Vec3) -> f64 {
        distance_along(self, point, direction)
    }

    fn surface_normals(
        &self,
        _crust: f64,
        point: &Vec3,
        across: Option<&Vec3>,
        mut visit: impl FnMut(f64, Vec3),
    ) {
        let (distance, normal) = near_closest(self, point, across);
        visit(distance, normal);
    }

    /// dA = a₁a₂a₃ |∇g| dω/g³ with the gauge g and its gradient at a∘ω, ω a unit vector.
    fn surface_elements(&self, _crust: f64, number: usize, mut visit: impl FnMut(SurfaceElement)) {
        let axes = self.sharp_axes();
        let solid_angle = 4.0 * PI / number as f64;
        for along in lattice(number).map(on_sphere).map(|w| w.component_mul(axes)) {
            let (gauge, gradient) = self.gauge(&along);
            let steepness = gradient.norm();
            let area = axes.product() * steepness / gauge.powi(3) * solid_angle;
            visit(SurfaceElement { point: along / gauge, normal: gradient / steepness, area });
        }
    }

    fn has_exact_area(&self) -> bool {
        false
    }
}

/// Distance and direction of a place on the surface near the closest one to a point within.
fn near_closest(body: &Superellipsoid, point: &Vec3, across: Option<&Vec3>) -> (f64, Vec3) {
    let normal = |at: &Vec3| {
        let gradient = body.gauge(at).1;
        let free = across.map_or(gradient, |axis| gradient - axis * axis.dot(&gradient));
        free.try_normalize(f64::MIN_POSITIVE)
    };
    let mut best: Option<(f64, Vec3)> = None;
    let mut direction = normal(point);
    for _ in 0..ROUNDS {
        let Some(d) = direction else { break };
        let distance = distance_along(body, point, &d);
        if best.is_some_and(|best| best.0 <= distance) {
            break;
        }
        best = Some((distance, d));
        direction = normal(&(point + d * distance));
    }
    best.unwrap_or_else(|| {
        let direction = across.map_or(Vec3::x(), normal_to);
        (distance_along(body, point, &direction), direction)
    })
}

/// Root of gauge(p + t d) = 1 for a point within: the gauge is convex along the ray, so Newton's method comes from above.
fn distance_along(body: &Superellipsoid, point: &Vec3, direction: &Vec3) -> f64 {
    let mut t = 2.0 * body.sharp().semi_axes().norm();
    for _ in 0..RAY_STEPS {
        let (gauge, gradient) = body.gauge(&(point + direction * t));
        let slope = gradient.dot(direction);
        if slope <= 0.0 {
            break;
        }
        let next = t - (gauge - 1.0) / slope;
        let is_done = (t - next).abs() <= 1e-12 * t.abs();
        t = next.max(0.0);
        if is_done {
            break;
        }
    }
    t
}
