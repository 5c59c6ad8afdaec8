//! Boxes.

use super::feature::Feature;
use super::line::{WHOLE_LINE, closed_after, within_slab};
use super::surface_points::{SurfaceElement, on_triangles};
use super::{Convex, FacePlane, Support, offer, signed_axis};
use crate::{Mat3, TriMesh, Vec3};

/// Box of half edges (m).
pub(crate) struct Cuboid(pub Vec3);

impl Support for Cuboid {
    const CURVED: bool = false;
    const FACED: bool = true;

    #[inline(always)]
    fn facing(&self, direction: &Vec3) -> Option<FacePlane> {
        let [x, y, z] = direction.abs().into();
        let number = if x >= y && x >= z { 0 } else { 2 - usize::from(y >= z) };
        let side = |k: usize| if k == number { 1.0_f64.copysign(direction[k]) } else { 0.0 };
        Some(FacePlane { number, normal: Vec3::new(side(0), side(1), side(2)), offset: self.0[number] })
    }

    #[inline(always)]
    fn is_below(&self, face: &FacePlane, point: &Vec3) -> bool {
        (0..3).all(|k| k == face.number || point[k].abs() <= self.0[k])
    }

    #[inline(always)]
    fn corners(&self, face: &FacePlane, to: &mut [Vec3]) -> Option<usize> {
        let (j, k) = ((face.number + 1) % 3, (face.number + 2) % 3);
        let signs = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        for (corner, (sign_j, sign_k)) in to.get_mut(..4)?.iter_mut().zip(signs) {
            *corner = face.normal * face.offset;
            (corner[j], corner[k]) = (sign_j * self.0[j], sign_k * self.0[k]);
        }
        Some(4)
    }

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        self.0.zip_map(direction, f64::copysign)
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        self.0.dot(&direction.abs())
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.0.x + self.0.y + self.0.z
    }

    #[inline(always)]
    fn half_edges(&self) -> Option<Vec3> {
        Some(self.0)
    }
}

impl Convex for Cuboid {
    fn bounds(&self) -> (Vec3, Vec3) {
        (-self.0, self.0)
    }

    fn radius(&self) -> f64 {
        self.0.norm()
    }

    fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64 {
        (rotation.tr_mul(center).abs() + self.0).norm() + crust
    }

    fn for_each_vertex(&self, visit: impl FnMut(Vec3)) {
        (0..8).map(|k| self.vertex(k)).for_each(visit);
    }

    #[inline(always)]
    fn vertex(&self, number: usize) -> Vec3 {
        let sign = |a: usize| (number as u64 >> a) << 63;
        Vec3::from_fn(|a, _| f64::from_bits(self.0[a].to_bits() ^ sign(a)))
    }

    #[inline(always)]
    fn number_of(&self, point: &Vec3) -> Option<u16> {
        let side = |a: usize| u16::from(point[a].is_sign_negative()) << a;
        (point.abs() == self.0).then_some(side(0) | side(1) | side(2))
    }

    #[inline]
    fn offset_from(&self, point: &Vec3) -> Option<Vec3> {
        Some(point.zip_map(&self.0, |x, h| x.clamp(-h, h)) - point)
    }

    fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        let axis = direction.iamax();
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let sign = 1.0_f64.copysign(direction[axis]);
        let corner = |s: f64, t: f64| {
            let mut p = Vec3::zeros();
            (p[axis], p[u], p[v]) = (sign * self.0[axis], sign * s * self.0[u], t * self.0[v]);
            p
        };
        let mut normal = Vec3::zeros();
        normal[axis] = sign;
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        found.set(corners, Some(normal));
        Some(())
    }

    #[inline]
    fn contains(&self, crust: f64, point: &Vec3) -> bool {
        (0..3).all(|a| point[a].abs() <= self.0[a] + crust)
    }

    fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        let half = rotation.abs() * self.0.add_scalar(crust);
        (-half, half)
    }

    fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        (0..3).try_fold(WHOLE_LINE, |chord, a| within_slab(chord, start[a], along[a], self.0[a] + crust))
    }

    fn exit(&self, crust: f64, point: &Vec3, direction: &Vec3) -> f64 {
        (0..3)
            .map(|a| {
                let gap = self.0[a] + crust - point[a] * direction[a].signum();
                closed_after(gap, direction[a].abs())
            })
            .fold(f64::INFINITY, f64::min)
    }

    fn surface_normals(
        &self,
        crust: f64,
        point: &Vec3,
        across: Option<&Vec3>,
        mut visit: impl FnMut(f64, Vec3),
    ) {
        for axis in 0..3 {
            let (half, side) = (self.0[axis] + crust, signed_axis(axis, point[axis]));
            offer(across, half - point[axis].abs(), side, &mut visit);
            offer(across, half + point[axis].abs(), -side, &mut visit);
        }
    }

    fn surface_elements(&self, crust: f64, number: usize, visit: impl FnMut(SurfaceElement)) {
        on_triangles(&triangles(&self.0.add_scalar(crust)), number, visit);
    }

    fn has_exact_area(&self) -> bool {
        true
    }
}

/// The twelve triangles of a box of half edges (m).
pub(crate) fn triangles(half: &Vec3) -> TriMesh {
    let sign = |i: usize, bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
    let vertices =
        (0..8).map(|i| half.component_mul(&Vec3::new(sign(i, 1), sign(i, 2), sign(i, 4)))).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriMesh { vertices, triangles }
}
