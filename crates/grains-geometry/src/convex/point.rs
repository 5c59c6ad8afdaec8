//! The core of a sphere: its centre.

use super::feature::Feature;
use super::line::{leave_ball, within_ball};
use super::surface_points::{SurfaceElement, lattice, on_sphere};
use super::{Convex, Support, normal_to};
use crate::{Mat3, Vec3};
use std::f64::consts::PI;

/// The origin.
pub(crate) struct Point;

impl Support for Point {
    const CURVED: bool = false;

    #[inline]
    fn farthest(&self, _direction: &Vec3) -> Vec3 {
        Vec3::zeros()
    }

    #[inline]
    fn height(&self, _direction: &Vec3) -> f64 {
        0.0
    }

    fn extent(&self) -> f64 {
        0.0
    }
}

impl Convex for Point {
    fn bounds(&self) -> (Vec3, Vec3) {
        (Vec3::zeros(), Vec3::zeros())
    }

    fn radius(&self) -> f64 {
        0.0
    }

    fn largest_distance(&self, crust: f64, _rotation: &Mat3, center: &Vec3) -> f64 {
        center.norm() + crust
    }

    fn for_each_vertex(&self, mut visit: impl FnMut(Vec3)) {
        visit(Vec3::zeros());
    }

    #[inline]
    fn offset_from(&self, point: &Vec3) -> Option<Vec3> {
        Some(-point)
    }

    fn contact_feature(&self, _direction: &Vec3, _found: &mut Feature) -> Option<()> {
        None
    }

    #[inline]
    fn contains(&self, crust: f64, point: &Vec3) -> bool {
        point.norm_squared() <= crust * crust
    }

    fn extents(&self, crust: f64, _rotation: &Mat3) -> (Vec3, Vec3) {
        (Vec3::repeat(-crust), Vec3::repeat(crust))
    }

    fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        within_ball(start.norm_squared(), start.dot(along), 1.0, crust)
    }

    fn exit(&self, crust: f64, point: &Vec3, direction: &Vec3) -> f64 {
        leave_ball(point, direction, crust)
    }

    fn surface_normals(
        &self,
        crust: f64,
        point: &Vec3,
        across: Option<&Vec3>,
        mut visit: impl FnMut(f64, Vec3),
    ) {
        let (distance, normal) = radial(point, across, crust);
        visit(distance, normal);
    }

    fn surface_elements(&self, crust: f64, number: usize, mut visit: impl FnMut(SurfaceElement)) {
        let area = 4.0 * PI * crust * crust / number as f64;
        for normal in lattice(number).map(on_sphere) {
            visit(SurfaceElement { point: normal * crust, normal, area });
        }
    }

    fn has_exact_area(&self) -> bool {
        true
    }
}

/// Distance and direction from a point out of a ball about the origin along the radius.
pub(super) fn radial(point: &Vec3, across: Option<&Vec3>, radius: f64) -> (f64, Vec3) {
    let flat = across.map_or(*point, |axis| point - axis * axis.dot(point));
    let any = across.map_or(Vec3::x(), normal_to);
    let direction = flat.try_normalize(f64::MIN_POSITIVE).unwrap_or(any);
    (leave_ball(point, &direction, radius), direction)
}
