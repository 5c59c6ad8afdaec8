//! The core of a capsule: its axis between the centres of the caps.

use super::feature::Feature;
use super::line::{within_ball, within_slab};
use super::point::radial;
use super::surface_points::{SurfaceElement, lattice, on_circle, on_sphere};
use super::{Convex, END, Support};
use crate::{Mat3, Vec3};
use std::f64::consts::{PI, TAU};

/// Segment of the z axis; with a radius for crust, a capsule.
pub(crate) struct Segment {
    /// Half of the length (m).
    pub half_length: f64,
}

impl Segment {
    /// The end on a side of the middle.
    #[inline(always)]
    fn end(&self, side: f64) -> Vec3 {
        Vec3::new(0.0, 0.0, self.half_length.copysign(side))
    }

    /// From the nearest point of the segment to a point.
    fn off_nearest(&self, point: &Vec3) -> Vec3 {
        Vec3::new(point.x, point.y, point.z - point.z.clamp(-self.half_length, self.half_length))
    }
}

impl Support for Segment {
    const CURVED: bool = false;

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        self.end(direction.z)
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        self.half_length * direction.z.abs()
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.half_length
    }
}

impl Convex for Segment {
    fn bounds(&self) -> (Vec3, Vec3) {
        (self.end(-1.0), self.end(1.0))
    }

    fn radius(&self) -> f64 {
        self.half_length
    }

    fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64 {
        [-1.0, 1.0].map(|side| (rotation * self.end(side) + center).norm()).into_iter().fold(0.0, f64::max)
            + crust
    }

    fn for_each_vertex(&self, visit: impl FnMut(Vec3)) {
        [self.end(-1.0), self.end(1.0)].into_iter().for_each(visit);
    }

    #[inline]
    fn offset_from(&self, point: &Vec3) -> Option<Vec3> {
        Some(-self.off_nearest(point))
    }

    fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        if direction.z.abs() > END {
            return None;
        }
        found.set([self.end(-1.0), self.end(1.0)], None);
        Some(())
    }

    #[inline]
    fn contains(&self, crust: f64, point: &Vec3) -> bool {
        self.off_nearest(point).norm_squared() <= crust * crust
    }

    fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        let half = rotation.column(2).abs() * self.half_length;
        let half = half.add_scalar(crust);
        (-half, half)
    }

    /// From the first to the last point of the side and the two balls at its ends.
    fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        let (p, d) = (start.xy(), along.xy());
        let side = within_ball(p.norm_squared(), p.dot(&d), d.norm_squared(), crust)
            .and_then(|round| within_slab(round, start.z, along.z, self.half_length));
        let balls = [-1.0, 1.0].map(|side| {
            let from = start - self.end(side);
            within_ball(from.norm_squared(), from.dot(along), along.norm_squared(), crust)
        });
        [side, balls[0], balls[1]].into_iter().flatten().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    fn exit(&self, crust: f64, point: &Vec3, direction: &Vec3) -> f64 {
        self.chord(crust, point, direction).map_or(0.0, |(_, leaves)| leaves.max(0.0))
    }

    fn surface_normals(
        &self,
        crust: f64,
        point: &Vec3,
        across: Option<&Vec3>,
        mut visit: impl FnMut(f64, Vec3),
    ) {
        let (from, axis) = (self.off_nearest(point), Vec3::z());
        // On the axis all directions across it are alike.
        let free = across.unwrap_or(&axis);
        let is_on_axis = from.norm_squared() <= 0.0;
        let (distance, normal) = radial(&from, if is_on_axis { Some(free) } else { across }, crust);
        visit(distance, normal);
    }

    fn surface_elements(&self, crust: f64, number: usize, mut visit: impl FnMut(SurfaceElement)) {
        let (side, caps) = (2.0 * TAU * crust * self.half_length, 4.0 * PI * crust * crust);
        let share = |area: f64| (number as f64 * area / (side + caps)).ceil();
        for [u, v] in lattice(share(side) as usize) {
            let normal = on_circle(v);
            let point = normal * crust + self.end(1.0) * (2.0 * u - 1.0);
            visit(SurfaceElement { point, normal, area: side / share(side) });
        }
        for normal in lattice(share(caps) as usize).map(on_sphere) {
            let point = normal * crust + self.end(normal.z);
            visit(SurfaceElement { point, normal, area: caps / share(caps) });
        }
    }

    fn has_exact_area(&self) -> bool {
        true
    }
}
