//! The surface of a body closest to points inside it.

use crate::{Part, Shape, Vec3};

/// Parts that touch hide the surface between them; gaps up to this share of the body's size are none.
const CLOSED: f64 = 1e-9;

/// A straight way from a point inside a body to its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestSurface {
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
    pub fn closest_surface(&self, point: &Vec3, across: Option<&Vec3>) -> Option<ClosestSurface> {
        let mut best: Option<ClosestSurface> = None;
        for part in &self.parts {
            let turned = across.map(|axis| part.rotation.tr_mul(axis));
            part.for_each_normal(&part.rotation.tr_mul(&(point - part.center)), turned.as_ref(), |way| {
                let min = best.map_or(f64::INFINITY, |best| best.distance);
                if way.distance < min {
                    let direction = part.rotation * way.direction;
                    let distance = self.exit(point, &direction, way.distance);
                    if distance < min {
                        best = Some(ClosestSurface { distance, direction });
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
    /// Calls `visit` with places on the surface of the body with sharp edges whose normals go through a point within (m,
    /// the part's frame).
    fn for_each_normal(&self, point: &Vec3, across: Option<&Vec3>, mut visit: impl FnMut(ClosestSurface)) {
        if self.contains(point) {
            self.core.surface_normals(self.crust, point, across, |distance, direction| {
                visit(ClosestSurface { distance, direction });
            });
        }
    }

    /// Point (m) of the surface of the body with sharp edges on the ray from the part's origin along a unit direction, and
    /// the outward unit normal there, in the part's frame; none if the origin is outside.
    pub fn surface_along(&self, direction: &Vec3) -> Option<(Vec3, Vec3)> {
        let distance = self.exit(&Vec3::zeros(), direction)?;
        let mut closest: Option<ClosestSurface> = None;
        self.for_each_normal(&(direction * (distance * (1.0 - CLOSED))), None, |found| {
            if closest.is_none_or(|best| found.distance < best.distance) {
                closest = Some(found);
            }
        });
        Some((direction * distance, closest?.direction))
    }

    /// Distance (m) from a point within to where a ray of unit direction leaves the body with sharp edges.
    fn exit(&self, point: &Vec3, direction: &Vec3) -> Option<f64> {
        self.contains(point).then(|| self.core.exit(self.crust, point, direction))
    }
}
