//! Straight ways from points inside a body to its surface.

use crate::shape::{Part, Shape};
use crate::{Core, Superellipsoid, Vec3};

/// Directions looked for on a superellipsoid, each the normal where the last one led.
const ROUNDS: usize = 3;
/// Newton steps along a ray to the surface of a superellipsoid.
const STEPS: usize = 30;
/// Parts that touch hide the surface between them; gaps up to this share of the body's size are none.
const CLOSED: f64 = 1e-9;

/// A straight way from a point inside a body to its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayOut {
    /// Length of the way (m).
    pub distance: f64,
    /// Unit vector along it: the outward normal where the way is the shortest.
    pub direction: Vec3,
}

impl Shape {
    /// A short way from a point of the body frame (m, scale 1) to the surface; none from outside.
    ///
    /// From a convex body of flat faces, cylinder or sphere it is the shortest; from a superellipsoid nearly so; from a
    /// composite the shortest of those normal to some face of one of its parts, whose other parts it may pass through. With
    /// `across`, a unit vector, only ways at a right angle to it count: those within a section of a prism.
    pub fn way_out(&self, point: &Vec3, across: Option<&Vec3>) -> Option<WayOut> {
        let mut best: Option<WayOut> = None;
        for part in &self.parts {
            let turned = across.map(|axis| part.rotation.tr_mul(axis));
            part.for_ways_out(&part.rotation.tr_mul(&(point - part.center)), turned.as_ref(), |way| {
                let least = best.map_or(f64::INFINITY, |best| best.distance);
                if way.distance < least {
                    let direction = part.rotation * way.direction;
                    let distance = self.exit(point, &direction, way.distance);
                    if distance < least {
                        best = Some(WayOut { distance, direction });
                    }
                }
            });
        }
        best
    }

    /// Distance (m) from a point to where a ray leaves the body, of which `reached` is known to lie within.
    fn exit(&self, point: &Vec3, direction: &Vec3, mut reached: f64) -> f64 {
        if self.parts.len() == 1 {
            return reached;
        }
        let slack = CLOSED * self.bounding_radius;
        loop {
            let at = point + direction * (reached + slack);
            let further = self.parts.iter().filter_map(|part| {
                let turned = part.rotation.tr_mul(direction);
                part.exit(&part.rotation.tr_mul(&(at - part.center)), &turned)
            });
            let further = further.fold(0.0, f64::max);
            if further <= slack {
                return reached;
            }
            reached += slack + further;
        }
    }
}

impl Part {
    /// Calls `visit` with the ways out of the body with sharp edges normal to its faces, from a point within (m, the part's
    /// frame).
    fn for_ways_out(&self, point: &Vec3, across: Option<&Vec3>, mut visit: impl FnMut(WayOut)) {
        if !self.contains(point) {
            return;
        }
        let mut offer = |distance: f64, direction: Vec3| {
            if across.is_none_or(|axis| axis.dot(&direction).abs() < 1e-6) {
                visit(WayOut { distance, direction });
            }
        };
        let mut along = |axis: usize, half: f64| {
            let side = signed_axis(axis, point[axis]);
            offer(half - point[axis].abs(), side);
            offer(half + point[axis].abs(), -side);
        };
        match &self.core {
            Core::Point => visit(radial(point, across, self.crust)),
            Core::Box(half) => (0..3).for_each(|a| along(a, half[a] + self.crust)),
            Core::Cylinder { radius, half_height } => {
                along(2, half_height + self.crust);
                let side = radial(&Vec3::new(point.x, point.y, 0.0), None, radius + self.crust);
                offer(side.distance, side.direction);
            }
            Core::Polyhedron(hull) => hull
                .faces()
                .iter()
                .for_each(|face| offer(face.offset + self.crust - face.normal.dot(point), face.normal)),
            Core::Triangle(_) => {}
            Core::Superellipsoid(body) => visit(out_of_superellipsoid(body, point, across)),
        }
    }

    /// Distance (m) from a point within to where a ray of unit direction leaves the body with sharp edges.
    fn exit(&self, point: &Vec3, direction: &Vec3) -> Option<f64> {
        if !self.contains(point) {
            return None;
        }
        let through = |gap: f64, speed: f64| if speed > 0.0 { gap / speed } else { f64::INFINITY };
        Some(match &self.core {
            Core::Point => leave_circle(point, direction, self.crust),
            Core::Box(half) => (0..3)
                .map(|a| through(half[a] + self.crust - point[a] * direction[a].signum(), direction[a].abs()))
                .fold(f64::INFINITY, f64::min),
            Core::Cylinder { radius, half_height } => {
                let flat = |v: &Vec3| Vec3::new(v.x, v.y, 0.0);
                let side = leave_circle(&flat(point), &flat(direction), radius + self.crust);
                let gap = half_height + self.crust - point.z * direction.z.signum();
                side.min(through(gap, direction.z.abs()))
            }
            Core::Polyhedron(hull) => hull
                .faces()
                .iter()
                .map(|f| through(f.offset + self.crust - f.normal.dot(point), f.normal.dot(direction)))
                .fold(f64::INFINITY, f64::min),
            Core::Triangle(_) => 0.0,
            Core::Superellipsoid(body) => leave_superellipsoid(body, point, direction),
        })
    }
}

fn signed_axis(axis: usize, value: f64) -> Vec3 {
    let mut direction = Vec3::zeros();
    direction[axis] = 1.0_f64.copysign(value);
    direction
}

/// The way out of a ball about the origin, along the radius.
fn radial(point: &Vec3, across: Option<&Vec3>, radius: f64) -> WayOut {
    let flat = across.map_or(*point, |axis| point - axis * axis.dot(point));
    let any = across.map_or(Vec3::x(), crate::core::normal_to);
    let direction = flat.try_normalize(f64::MIN_POSITIVE).unwrap_or(any);
    WayOut { distance: leave_circle(point, &direction, radius), direction }
}

/// Smallest t >= 0 at which |p + t d| = r, for |p| <= r.
fn leave_circle(point: &Vec3, direction: &Vec3, radius: f64) -> f64 {
    let squared = direction.norm_squared();
    if squared <= 0.0 {
        return f64::INFINITY;
    }
    let along = point.dot(direction);
    let room = (radius * radius - point.norm_squared()).max(0.0);
    let root = (along * along + squared * room).sqrt();
    // The form without cancellation.
    if along > 0.0 { room / (along + root) } else { (root - along) / squared }
}

fn out_of_superellipsoid(body: &Superellipsoid, point: &Vec3, across: Option<&Vec3>) -> WayOut {
    let normal = |at: &Vec3| {
        let gradient = body.gauge(at).1;
        let free = across.map_or(gradient, |axis| gradient - axis * axis.dot(&gradient));
        free.try_normalize(f64::MIN_POSITIVE)
    };
    let mut best: Option<WayOut> = None;
    let mut direction = normal(point);
    for _ in 0..ROUNDS {
        let Some(d) = direction else { break };
        let distance = leave_superellipsoid(body, point, &d);
        if best.is_some_and(|way| way.distance <= distance) {
            break;
        }
        best = Some(WayOut { distance, direction: d });
        direction = normal(&(point + d * distance));
    }
    best.unwrap_or_else(|| {
        let direction = across.map_or(Vec3::x(), crate::core::normal_to);
        WayOut { distance: leave_superellipsoid(body, point, &direction), direction }
    })
}

/// Root of gauge(p + t d) = 1 for a point within: the gauge is convex along the ray, so Newton's method comes from above.
fn leave_superellipsoid(body: &Superellipsoid, point: &Vec3, direction: &Vec3) -> f64 {
    let mut t = 2.0 * body.sharp().semi_axes().norm();
    for _ in 0..STEPS {
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
