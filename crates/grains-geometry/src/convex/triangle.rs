//! Triangles of wall meshes: a core without a body.

use super::feature::Feature;
use super::polyhedron::larger;
use super::surface_points::SurfaceElement;
use super::{Convex, Support, bounds_of, radius_of};
use crate::gjk::nearest::on_triangle;
use crate::{Mat3, Vec3};

/// Triangle (m).
pub(crate) struct Triangle(pub [Vec3; 3]);

impl Support for Triangle {
    const CURVED: bool = false;

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let [a, b, c] = &self.0;
        let (ha, hb, hc) = (a.dot(direction), b.dot(direction), c.dot(direction));
        let (first, height) = if hb > ha { (b, hb) } else { (a, ha) };
        if hc > height { *c } else { *first }
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        let [a, b, c] = self.0.map(|corner| corner.dot(direction));
        larger(larger(a, b), c)
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.0.iter().fold(0.0, |extent, corner| corner.amax().max(extent))
    }
}

impl Convex for Triangle {
    fn bounds(&self) -> (Vec3, Vec3) {
        bounds_of(&self.0)
    }

    fn radius(&self) -> f64 {
        radius_of(&self.0)
    }

    fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64 {
        radius_of(&self.0.map(|corner| rotation * corner + center)) + crust
    }

    fn for_each_vertex(&self, visit: impl FnMut(Vec3)) {
        self.0.into_iter().for_each(visit);
    }

    #[inline]
    fn offset_from(&self, point: &Vec3) -> Option<Vec3> {
        let [p, q, r] = &self.0;
        Some(on_triangle(&(p - point), &(q - point), &(r - point)).point)
    }

    fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        let [a, b, c] = self.0;
        let normal = (b - a).cross(&(c - a)).normalize();
        let cosine = normal.dot(direction);
        let corners = if cosine < 0.0 { [a, c, b] } else { [a, b, c] };
        found.set(corners, Some(normal * 1.0_f64.copysign(cosine)));
        Some(())
    }

    fn contains(&self, _crust: f64, _point: &Vec3) -> bool {
        false
    }

    fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        let (lower, upper) = bounds_of(&self.0.map(|corner| rotation * corner));
        (lower.add_scalar(-crust), upper.add_scalar(crust))
    }

    fn chord(&self, _crust: f64, _start: &Vec3, _along: &Vec3) -> Option<(f64, f64)> {
        None
    }

    fn exit(&self, _crust: f64, _point: &Vec3, _direction: &Vec3) -> f64 {
        0.0
    }

    fn surface_normals(&self, _: f64, _: &Vec3, _: Option<&Vec3>, _: impl FnMut(f64, Vec3)) {}

    fn surface_elements(&self, _crust: f64, _number: usize, _visit: impl FnMut(SurfaceElement)) {}

    fn has_exact_area(&self) -> bool {
        false
    }
}
