//! Circular cones and their frustums.

use super::feature::Feature;
use super::line::{WHOLE_LINE, within_slab};
use super::surface_points::{SurfaceElement, on_frustum};
use super::{Convex, NO_DIRECTION, Support, offer};
use crate::{Mat3, Vec3};

/// Cone about z between two heights; an end of radius zero is an apex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Heights of the lower and the upper end (m).
    pub heights: [f64; 2],
    /// Radii at the lower and the upper end (m), not both zero.
    pub radii: [f64; 2],
}

impl Cone {
    /// Change of the radius with the height, m = dr/dz (-).
    fn slope(&self) -> f64 {
        (self.radii[1] - self.radii[0]) / (self.heights[1] - self.heights[0])
    }

    /// Length of the side over its height, √(1 + m²) (-).
    fn slant(&self) -> f64 {
        libm::hypot(1.0, self.slope())
    }

    /// Radius of the side at a height (m).
    fn radius_at(&self, z: f64) -> f64 {
        self.radii[0] + self.slope() * (z - self.heights[0])
    }

    /// The cone with its ends and side moved outwards by a distance (m), or inwards by a negative one; an apex moves
    /// by √(1 + m²)/|m| times that.
    pub fn grown(&self, distance: f64) -> Self {
        let (slope, slant) = (self.slope(), self.slant());
        let mut grown = *self;
        for (k, outwards) in [-1.0, 1.0].into_iter().enumerate() {
            if self.radii[k] > 0.0 {
                grown.heights[k] += outwards * distance;
                grown.radii[k] += distance * (slant + outwards * slope);
            } else {
                grown.heights[k] += outwards * distance * slant / slope.abs();
            }
        }
        grown
    }

    /// Largest distance by which the ends can move inwards before the smaller of them vanishes (m).
    pub(crate) fn largest_erosion(&self) -> f64 {
        let (slope, slant) = (self.slope(), self.slant());
        let of_end = |k: usize, outwards: f64| {
            if self.radii[k] > 0.0 { self.radii[k] / (slant + outwards * slope) } else { f64::INFINITY }
        };
        of_end(0, -1.0).min(of_end(1, 1.0))
    }

    /// Radius of the largest ball about the origin, which is within (m).
    pub(crate) fn inscribed_radius(&self) -> f64 {
        let side = self.radius_at(0.0) / self.slant();
        // An apex is farther than the side.
        (-self.heights[0]).min(self.heights[1]).min(side)
    }

    /// Point of a rim on the side of a direction, of which the distance from the axis squared is given.
    #[inline(always)]
    fn on_rim(&self, end: usize, direction: &Vec3, squared: f64) -> Vec3 {
        if squared > NO_DIRECTION {
            let scale = self.radii[end] / squared.sqrt();
            Vec3::new(direction.x * scale, direction.y * scale, self.heights[end])
        } else {
            Vec3::new(self.radii[end], 0.0, self.heights[end])
        }
    }
}

impl Support for Cone {
    const CURVED: bool = true;

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let squared = direction.x * direction.x + direction.y * direction.y;
        let radial = squared.sqrt();
        let [low, high] = [0, 1].map(|k| self.radii[k] * radial + self.heights[k] * direction.z);
        self.on_rim(usize::from(high > low), direction, squared)
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        let radial = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let [low, high] = [0, 1].map(|k| self.radii[k] * radial + self.heights[k] * direction.z);
        if high > low { high } else { low }
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.radii[0].max(self.radii[1]) + self.heights[0].abs().max(self.heights[1].abs())
    }
}

impl Convex for Cone {
    fn bounds(&self) -> (Vec3, Vec3) {
        let radius = self.radii[0].max(self.radii[1]);
        (Vec3::new(-radius, -radius, self.heights[0]), Vec3::new(radius, radius, self.heights[1]))
    }

    fn radius(&self) -> f64 {
        let [low, high] = [0, 1].map(|k| libm::hypot(self.radii[k], self.heights[k]));
        low.max(high)
    }

    fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64 {
        let from = rotation.tr_mul(center);
        let off_axis = from.xy().norm();
        let [low, high] = [0, 1].map(|k| libm::hypot(off_axis + self.radii[k], from.z + self.heights[k]));
        low.max(high) + crust
    }

    fn for_each_vertex(&self, _visit: impl FnMut(Vec3)) {}

    /// The nearest point of the section, a quadrilateral in distance from the axis and height.
    fn offset_from(&self, point: &Vec3) -> Option<Vec3> {
        let radial = point.xy().norm();
        if self.contains(0.0, point) {
            return Some(Vec3::zeros());
        }
        let [low, high] = self.heights;
        let [bottom, top] = self.radii;
        let corners = [[0.0, low], [bottom, low], [top, high], [0.0, high]];
        let mut best = (f64::INFINITY, [0.0; 2]);
        for (from, to) in corners.into_iter().zip(corners.into_iter().skip(1)) {
            let (edge, off) = ([to[0] - from[0], to[1] - from[1]], [radial - from[0], point.z - from[1]]);
            let squared = edge[0] * edge[0] + edge[1] * edge[1];
            let share = (off[0] * edge[0] + off[1] * edge[1]) / squared;
            let t = if squared > 0.0 { share.clamp(0.0, 1.0) } else { 0.0 };
            // Straight before the edge the way is along its normal to the last digit.
            let aside = (off[0] * edge[1] - off[1] * edge[0]) / squared;
            let is_before = 0.0 < share && share < 1.0;
            let way = if is_before {
                [-edge[1] * aside, edge[0] * aside]
            } else {
                [edge[0] * t - off[0], edge[1] * t - off[1]]
            };
            let distance = libm::hypot(way[0], way[1]);
            // Rounding may take an end of the edge for as near.
            let is_nearest = is_before && aside > 0.0;
            if distance < best.0 || is_nearest {
                best = (distance, way);
            }
            if is_nearest {
                break;
            }
        }
        let inward = if radial > 0.0 { best.1[0] / radial } else { 0.0 };
        Some(Vec3::new(point.x * inward, point.y * inward, best.1[1]))
    }

    /// The end or the line of the side whose normal is nearest the direction.
    fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        let radial = libm::hypot(direction.x, direction.y);
        let side = (radial - self.slope() * direction.z) / self.slant();
        let end = usize::from(direction.z > 0.0);
        if self.radii[end] > 0.0 && direction.z.abs() > side {
            found.set_disc(self.radii[end], self.heights[end], direction);
            return Some(());
        }
        let squared = radial * radial;
        found.set([0, 1].map(|k| self.on_rim(k, direction, squared)), None);
        found.is_whole = false;
        Some(())
    }

    fn contains(&self, crust: f64, point: &Vec3) -> bool {
        let body = self.grown(crust);
        let [low, high] = body.heights;
        low <= point.z && point.z <= high && libm::hypot(point.x, point.y) <= body.radius_at(point.z)
    }

    fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        let body = self.grown(crust);
        let along = |k: usize, side: f64| {
            Vec3::from_fn(|a, _| {
                let across = rotation.fixed_view::<1, 2>(a, 0).norm();
                body.heights[k] * rotation[(a, 2)] + side * body.radii[k] * across
            })
        };
        (along(0, -1.0).inf(&along(1, -1.0)), along(0, 1.0).sup(&along(1, 1.0)))
    }

    /// Between the ends the body is where |p + s d|² of the part across z is at most the square of the radius there.
    fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        let body = self.grown(crust);
        let [low, high] = body.heights;
        let (near, far) = within_slab(WHOLE_LINE, start.z - 0.5 * (low + high), along.z, 0.5 * (high - low))?;
        let (radius, slope) = (body.radius_at(start.z), body.slope() * along.z);
        let (p, d) = (start.xy(), along.xy());
        let a = d.norm_squared() - slope * slope;
        let b = p.dot(&d) - radius * slope;
        let c = p.norm_squared() - radius * radius;
        if a.abs() <= f64::EPSILON {
            // Along the side: one end only, 2 b s + c <= 0.
            let end = -0.5 * c / b;
            let stretch = if b > 0.0 { (near, far.min(end)) } else { (near.max(end), far) };
            return (stretch.0 <= stretch.1).then_some(stretch);
        }
        let root = b * b - a * c;
        if root < 0.0 {
            return (a < 0.0).then_some((near, far));
        }
        // Roots without cancellation, in order.
        let q = -(b + root.sqrt().copysign(b));
        let (first, second) = (q / a, if q != 0.0 { c / q } else { 0.0 });
        let (first, second) = (first.min(second), first.max(second));
        if a > 0.0 {
            let stretch = (near.max(first), far.min(second));
            return (stretch.0 <= stretch.1).then_some(stretch);
        }
        // Steeper than the side: within before the first root or after the second, on either side of the apex.
        let (before, after) = ((near, far.min(first)), (near.max(second), far));
        [before, after].into_iter().find(|stretch| stretch.0 <= stretch.1)
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
        let body = self.grown(crust);
        for (k, outwards) in [-1.0, 1.0].into_iter().enumerate() {
            if body.radii[k] > 0.0 {
                let distance = outwards * (body.heights[k] - point.z);
                offer(across, distance, Vec3::z() * outwards, &mut visit);
            }
        }
        let off_axis = Vec3::new(point.x, point.y, 0.0);
        let radial = off_axis.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vec3::x);
        let distance = (body.radius_at(point.z) - off_axis.norm()) / body.slant();
        offer(across, distance, (radial - Vec3::z() * body.slope()) / body.slant(), &mut visit);
    }

    fn surface_elements(&self, crust: f64, number: usize, visit: impl FnMut(SurfaceElement)) {
        let body = self.grown(crust);
        on_frustum(body.heights, body.radii, number, visit);
    }

    fn has_exact_area(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_eroded_and_grown_again_is_the_same_cone() {
        for radii in [[1.0, 0.0], [0.0, 0.7], [1.0, 0.3], [0.5, 0.5]] {
            let cone = Cone { heights: [-0.4, 0.9], radii };
            let back = cone.grown(-0.05).grown(0.05);
            for k in 0..2 {
                assert!((back.heights[k] - cone.heights[k]).abs() < 1e-14);
                assert!((back.radii[k] - cone.radii[k]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn the_nearest_point_of_a_cone_to_its_axis_beyond_the_apex_is_the_apex() {
        let cone = Cone { heights: [-1.0, 1.0], radii: [1.0, 0.0] };
        let to = |x: f64, z: f64| cone.offset_from(&Vec3::new(x, 0.0, z)).expect("closed form");
        assert!((to(0.0, 3.0) - Vec3::new(0.0, 0.0, -2.0)).norm() < 1e-15);
        assert!((to(2.0, -1.0) - Vec3::new(-1.0, 0.0, 0.0)).norm() < 1e-15);
        // Straight before the middle of the side, whose normal is (2, 1)/√5.
        assert!((to(0.5 + 2.0, 1.0) - Vec3::new(-2.0, 0.0, -1.0)).norm() < 1e-15);
    }
}
