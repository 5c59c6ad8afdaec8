//! Circular cylinders.

use super::feature::Feature;
use super::line::{closed_after, leave_ball, within_ball, within_slab};
use super::point::radial;
use super::surface_points::{SurfaceElement, on_frustum};
use super::{Convex, END, NO_DIRECTION, Rims, Support, offer, signed_axis};
use crate::{Mat3, Vec3};

/// Cylinder about z.
pub(crate) struct Cylinder {
    /// Radius (m).
    pub radius: f64,
    /// Half of the height (m).
    pub half_height: f64,
}

impl Support for Cylinder {
    const CURVED: bool = true;

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let squared = direction.x * direction.x + direction.y * direction.y;
        let z = self.half_height.copysign(direction.z);
        if squared > NO_DIRECTION {
            let scale = self.radius / squared.sqrt();
            Vec3::new(direction.x * scale, direction.y * scale, z)
        } else {
            Vec3::new(self.radius, 0.0, z)
        }
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        let radial = (direction.x * direction.x + direction.y * direction.y).sqrt();
        self.radius * radial + self.half_height * direction.z.abs()
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.radius + self.half_height
    }

    #[inline(always)]
    fn rims(&self) -> Option<Rims> {
        Some(Rims { radius: self.radius, half_height: self.half_height })
    }
}

impl Convex for Cylinder {
    fn bounds(&self) -> (Vec3, Vec3) {
        let half = Vec3::new(self.radius, self.radius, self.half_height);
        (-half, half)
    }

    fn radius(&self) -> f64 {
        libm::hypot(self.radius, self.half_height)
    }

    fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64 {
        let from_axis = rotation.tr_mul(center).abs();
        libm::hypot(from_axis.xy().norm() + self.radius, from_axis.z + self.half_height) + crust
    }

    fn for_each_vertex(&self, _visit: impl FnMut(Vec3)) {}

    #[inline]
    fn offset_from(&self, point: &Vec3) -> Option<Vec3> {
        let radial = point.xy().norm();
        let inward = if radial > self.radius { self.radius / radial - 1.0 } else { 0.0 };
        let axial = point.z.clamp(-self.half_height, self.half_height) - point.z;
        Some(Vec3::new(point.x * inward, point.y * inward, axial))
    }

    fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        if direction.z.abs() > END {
            found.set_disc(self.radius, 1.0_f64.copysign(direction.z) * self.half_height, direction);
            return Some(());
        }
        let away = Vec3::new(direction.x, direction.y, 0.0).normalize() * self.radius;
        found.set([-1.0, 1.0].map(|s| away + Vec3::z() * (s * self.half_height)), None);
        found.is_whole = false;
        Some(())
    }

    #[inline]
    fn contains(&self, crust: f64, point: &Vec3) -> bool {
        point.z.abs() <= self.half_height + crust && libm::hypot(point.x, point.y) <= self.radius + crust
    }

    fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        let half = Vec3::from_fn(|a, _| {
            let across = rotation.fixed_view::<1, 2>(a, 0).norm();
            (self.radius + crust) * across + (self.half_height + crust) * rotation[(a, 2)].abs()
        });
        (-half, half)
    }

    fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        let (p, d) = (start.xy(), along.xy());
        let round = within_ball(p.norm_squared(), p.dot(&d), d.norm_squared(), self.radius + crust)?;
        within_slab(round, start.z, along.z, self.half_height + crust)
    }

    fn exit(&self, crust: f64, point: &Vec3, direction: &Vec3) -> f64 {
        let flat = |v: &Vec3| Vec3::new(v.x, v.y, 0.0);
        let side = leave_ball(&flat(point), &flat(direction), self.radius + crust);
        let gap = self.half_height + crust - point.z * direction.z.signum();
        side.min(closed_after(gap, direction.z.abs()))
    }

    fn surface_normals(
        &self,
        crust: f64,
        point: &Vec3,
        across: Option<&Vec3>,
        mut visit: impl FnMut(f64, Vec3),
    ) {
        let (half, end) = (self.half_height + crust, signed_axis(2, point.z));
        offer(across, half - point.z.abs(), end, &mut visit);
        offer(across, half + point.z.abs(), -end, &mut visit);
        let (distance, side) = radial(&Vec3::new(point.x, point.y, 0.0), None, self.radius + crust);
        offer(across, distance, side, &mut visit);
    }

    fn surface_elements(&self, crust: f64, number: usize, visit: impl FnMut(SurfaceElement)) {
        let (radius, half) = (self.radius + crust, self.half_height + crust);
        on_frustum([-half, half], [radius; 2], number, visit);
    }

    fn has_exact_area(&self) -> bool {
        true
    }
}
