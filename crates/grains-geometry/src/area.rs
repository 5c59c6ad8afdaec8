//! Surface area of shapes: exact surfaces of the parts, less what lies in other parts.

use crate::convex::surface_points::SurfaceElement;
use crate::{Core, Part, Shape, Vec3};

/// Points on the surfaces of all parts together.
const POINTS: usize = 400_000;
/// Fewest points on the surface of a part.
const MIN_POINTS: usize = 2_000;
/// Distance from the surface of the points that tell what is inside, relative to the size of the body.
const OFF_SURFACE: f64 = 1e-7;

impl Shape {
    /// Area of the surface of the body with sharp edges, A = Σ_k ∫ dA over the surface of part k outside all other parts
    /// (m², at scale 1); of a mesh its own area.
    ///
    /// Single spheres, boxes, cylinders and polyhedra are exact to rounding, others to about 1e-4: each part's exact surface
    /// is taken at evenly spread points. A surface that two parts share counts once if their outsides agree, else not.
    pub fn area(&self) -> f64 {
        if let Some(mesh) = &self.report.decomposition {
            return mesh.area;
        }
        if let [Part { core: Core::Polyhedron(_), .. }] = &self.parts[..] {
            return self.surface.area();
        }
        let off = OFF_SURFACE * self.bounding_radius;
        let number = match &self.parts[..] {
            // Nothing is hidden, and one point stands for all of a piece of even density.
            [part] if part.core.has_exact_area() => 1,
            parts => (POINTS / parts.len()).max(MIN_POINTS),
        };
        let mut sum = 0.0;
        for (k, part) in self.parts.iter().enumerate() {
            part.core.surface_elements(part.crust, number, |SurfaceElement { point, normal, area }| {
                let place = |x: Vec3| part.rotation * x + part.center;
                let (outside, inside) = (place(point + normal * off), place(point - normal * off));
                let holds =
                    |other: &Part, x: &Vec3| other.contains(&other.rotation.tr_mul(&(x - other.center)));
                // Of a surface that parts share, the first one's counts.
                let is_hidden = |(j, other): (usize, &Part)| {
                    j != k && (holds(other, &outside) || j < k && holds(other, &inside))
                };
                if !self.parts.iter().enumerate().any(is_hidden) {
                    sum += area;
                }
            });
        }
        sum
    }
}
