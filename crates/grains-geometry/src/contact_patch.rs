//! Contact patches: face on face, edge or rim on face, side on side of two cylinders.
//!
//! The nearest points of two flush faces are any pair of them, so a single contact point drifts and
//! bodies at rest spin and creep (thesis 3.3). So the features of both that look at each other touch: each corner the
//! other body, and edges that cross each other (`pairs`). The overlap of each of these pairs is a continuous function
//! of how both bodies lie, with the derivative n_i along the line through its nearest points, and so is their norm
//!
//! ```text
//! D⁸ = Σ T_i,   T = δ⁸ of a corner,   T = δ⁸ Π (1 − (δ_k/δ)⁸) of two edges whose ends k overlap the other edge by δ_k.
//! ```
//!
//! What the ends stand for is not counted twice: where a corner leaves the other body over an edge, or edges become
//! parallel, nothing jumps. The deepest of all never is above D. The forces w_i F(D) n_i, w_i = ∂D/∂δ_i, are the gradient
//! of ∫F dD; together they are a wrench, the force W F(D) n at c and the couple W F(D) p n (Ball 1900).

mod pairs;

use crate::convex::feature::Feature;
use crate::{Core, Mat3, Placement, Vec3, WallMesh};
use pairs::{Edges, PAIRS, Pair, PlacedCore, Sum};

/// Cosine above which a contact normal on a triangle counts as that of its face.
const FACING: f64 = 0.9;
/// Gap of two cores, relative to the crusts, below which directions between their features would be lost.
const APART: f64 = 1e-3;

/// Where two bodies touch: a screw, along which they press each other, and how wide they do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPatch {
    /// Unit normal n (-).
    pub normal: Vec3,
    /// A point c of the axis of the wrench, that nearest the weighted mean of the nearest points (m).
    pub center: Vec3,
    /// Norm D of the overlaps (m).
    pub overlap: f64,
    /// W = |Σ w_i n_i| (-), 1 if one corner touches.
    pub weight: f64,
    /// Pitch p of the wrench: its couple over its force (m).
    pub pitch: f64,
    /// Second moment Σ (w_i/W) (r_i × n)(r_i × n)ᵀ with r_i = x_i − c (m²).
    pub second: Mat3,
}

/// The nearest points of two cores.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Unit normal from A to B (-).
    pub normal: Vec3,
    /// Midway between both points (m).
    pub point: Vec3,
    /// Their distance (m).
    pub gap: f64,
    /// Sum of the radii swept over the cores (m).
    pub crusts: f64,
}

impl Nearest {
    /// The same with B moved (m) along the normal until cores that meet are apart, under thicker crusts.
    fn lifted(&self) -> (Self, Vec3) {
        let lift = (APART * self.crusts - self.gap).max(0.0);
        let (gap, crusts) = (self.gap + lift, self.crusts + lift);
        let offset = self.normal * lift;
        (Self { point: self.point + offset * 0.5, gap, crusts, ..*self }, offset)
    }
}

impl ContactPatch {
    /// Patch of two cores, B being put by `placement` in the frame of A, in which all is.
    ///
    /// `None` if the bodies touch in a point: the nearest points then are the contact. The centre lies midway between
    /// the cores.
    pub fn of_cores(a: &Core, b: &Core, placement: &Placement, nearest: &Nearest) -> Option<Self> {
        let (nearest, lift) = nearest.lifted();
        let placement = Placement { translation: placement.translation + lift, ..*placement };
        let (mut first, mut second) = (Feature::fixed(), Feature::fixed());
        let sides = [PlacedCore::unmoved(a), PlacedCore::at(b, &placement)];
        sides[0].feature(&nearest.normal, &mut first)?;
        sides[1].feature(&-nearest.normal, &mut second)?;
        let mut pairs;
        let mut sum = Sum::new(&nearest);
        if !(first.is_whole && second.is_whole) {
            pairs = [Pair::NONE; PAIRS];
            sum.keep_in(&mut pairs);
        }
        sum.add_corners(&first, 1.0, |corner| Some(sides[1].offset_from(&second, corner)));
        sum.add_corners(&second, -1.0, |corner| Some(sides[0].offset_from(&first, corner)));
        sum.add_edges(&Edges::of(&first), &Edges::of(&second), |_, _| true);
        sum.add_nearest();
        if sum.is_point() { None } else { sum.patch(&lift) }
    }

    /// Patch of a core, put by `placement` in the frame of a mesh, on triangle `t` of it, of which `nearest` are the nearest
    /// points. No place of the surface counts twice: flat seams and valleys have no corners and edges.
    ///
    /// `Err` if the core touches in points only, as a ball does; `Ok(None)` if other triangles bear all of it.
    pub fn on_triangle(
        core: &Core,
        placement: &Placement,
        (mesh, t): (&WallMesh, u32),
        nearest: &Nearest,
    ) -> Result<Option<Self>, TouchesInAPoint> {
        let (nearest, lift) = nearest.lifted();
        // It is the core that moves here.
        let nearest = Nearest { point: nearest.point - lift, ..nearest };
        let placement = Placement { translation: placement.translation - lift, ..*placement };
        let (mut first, mut second) = (Feature::empty(), Feature::empty());
        let triangle = mesh.mesh().corners(t as usize);
        let face = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0])).normalize();
        let cosine = face.dot(&nearest.normal);
        let direction = if cosine.abs() > FACING { face * cosine.signum() } else { nearest.normal };
        let side = PlacedCore::at(core, &placement);
        side.feature(&direction, &mut first).ok_or(TouchesInAPoint)?;
        second.set(triangle, Some(-face * cosine.signum()));
        let mut sum = Sum::new(&nearest);
        sum.add_corners(&first, 1.0, |corner| {
            let found = mesh.closest_within(t, corner, nearest.crusts)?;
            Some(found.point - corner)
        });
        sum.add_corners(&second, -1.0, |corner| {
            let offset = side.offset_from(&first, corner);
            let k = triangle.iter().position(|x| x == corner)?;
            mesh.ridges(t, &offset)[1][k].then_some(offset)
        });
        sum.add_edges(&Edges::of(&first), &Edges::of(&second), |k, toward| mesh.ridges(t, toward)[0][k]);
        Ok(sum.patch(&-lift))
    }

    /// ContactPatch of a core on the half-space {x : normal·x ≥ offset} behind a plane, in the core's frame.
    ///
    /// `normal` points from the core into the wall; the centre lies on the core.
    pub fn on_plane(core: &Core, normal: &Vec3, offset: f64, crust: f64) -> Option<Self> {
        Self::on_surface(core, normal, crust, |p| offset - normal.dot(p))
    }

    /// ContactPatch of a core on a surface, `gap` (m) being the distance of a point from it; deepest along `normal`.
    pub fn on_surface(core: &Core, normal: &Vec3, crust: f64, gap: impl Fn(&Vec3) -> f64) -> Option<Self> {
        let mut feature = Feature::empty();
        core.contact_feature(normal, &mut feature)?;
        let point = core.support(normal);
        let mut sum = Sum::new(&Nearest { normal: *normal, point, gap: gap(&point), crusts: crust });
        for corner in feature.points() {
            sum.add_corner(corner, normal, gap(corner));
        }
        sum.patch(&Vec3::zeros())
    }

    /// The contact patch at `scale` times the size, turned and moved: x → rotation x scale + offset.
    pub fn moved(&self, rotation: &Mat3, scale: f64, offset: &Vec3) -> Self {
        Self {
            normal: rotation * self.normal,
            center: rotation * self.center * scale + offset,
            overlap: self.overlap * scale,
            weight: self.weight,
            pitch: self.pitch * scale,
            second: rotation * self.second * rotation.transpose() * (scale * scale),
        }
    }

    /// Two patches as one: the norm of both, and the wrench of both.
    pub fn joined(&self, other: &Self) -> Self {
        Sum::of_patches([self, other]).patch(&Vec3::zeros()).unwrap_or(*self)
    }
}

/// A core has no faces or lines to touch with.
#[derive(Clone, Copy, Debug)]
pub struct TouchesInAPoint;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gjk::{Separation, distance};
    use crate::{Rotation, SMOOTH_ANGLE, Simplex, TriMesh};
    use std::f64::consts::FRAC_PI_4;

    fn eighth_root(x: f64) -> f64 {
        x.sqrt().sqrt().sqrt()
    }

    /// Patch of cores whose nearest points are a gap apart along a normal.
    fn patch(
        a: &Core,
        b: &Core,
        placement: &Placement,
        normal: Vec3,
        [gap, crusts]: [f64; 2],
    ) -> Option<ContactPatch> {
        let on_a = a.support(&normal);
        let nearest = Nearest { normal, point: on_a + normal * (0.5 * gap), gap, crusts };
        ContactPatch::of_cores(a, b, placement, &nearest)
    }

    fn at(rotation: Rotation, translation: Vec3) -> Placement {
        Placement { matrix: rotation.to_rotation_matrix().into_inner(), translation }
    }

    #[test]
    fn a_cube_flush_on_a_larger_one_has_the_second_moments_of_its_corners() {
        let (small, large) = (Core::Box(Vec3::repeat(0.5)), Core::Box(Vec3::repeat(2.0)));
        let placement = at(Rotation::from_axis_angle(&Vec3::z_axis(), 0.3), Vec3::new(0.4, -0.2, 2.51));
        let f = patch(&large, &small, &placement, Vec3::z(), [0.01, 0.03]).unwrap();
        assert!(
            (f.center - Vec3::new(0.4, -0.2, 2.005)).norm() < 1e-14
                && (f.overlap - 0.02 * eighth_root(4.0)).abs() < 1e-15
        );
        // Corners at (±1/2, ±1/2): x² and y² have the mean 1/4 in any turn about the normal.
        let expected = Mat3::from_diagonal(&Vec3::new(0.25, 0.25, 0.0));
        assert!((f.second - expected).norm() < 1e-14);
    }

    #[test]
    fn a_tilted_cube_leans_on_its_lower_edge_and_the_moment_rights_it() {
        let (small, large) = (Core::Box(Vec3::repeat(0.5)), Core::Box(Vec3::repeat(2.0)));
        let tilt = 0.01;
        let placement = at(Rotation::from_axis_angle(&Vec3::y_axis(), tilt), Vec3::new(0.0, 0.0, 2.51));
        let lowest = 2.51 - 0.5 * (tilt.sin() + tilt.cos()) - 2.0;
        let f = patch(&large, &small, &placement, Vec3::z(), [lowest, 0.03]).unwrap();
        // Turned about y by a positive angle the edge at +x is lower.
        assert!(f.center.x > 0.05 && f.center.y.abs() < 1e-15 && f.weight > 1.0);
        let single = patch(&large, &small, &placement, Vec3::z(), [lowest, lowest + 0.002]);
        assert!((single.unwrap().center.x - 0.5 * (tilt.cos() - tilt.sin())).abs() < 1e-3, "only the edge");
    }

    #[test]
    fn faces_that_overlap_in_part_share_the_common_polygon() {
        let cube = Core::Box(Vec3::repeat(0.5));
        let turned = Rotation::from_axis_angle(&Vec3::z_axis(), FRAC_PI_4);
        let f = patch(&cube, &cube, &at(turned, Vec3::new(0.0, 0.0, 1.0)), Vec3::z(), [0.0, 0.02]);
        // A regular octagon of inradius 1/2: r² = (1/2)²/cos²(22.5°).
        let r2 = 0.25 / (FRAC_PI_4 / 2.0).cos().powi(2);
        assert!((f.unwrap().second.trace() - r2).abs() < 1e-14);
        let shifted = at(Rotation::identity(), Vec3::new(0.8, 0.0, 1.0));
        let f = patch(&cube, &cube, &shifted, Vec3::z(), [0.0, 0.02]).unwrap();
        assert!((f.center - Vec3::new(0.4, 0.0, 0.5)).norm() < 1e-15);
    }

    #[test]
    fn cylinders_rest_on_lines_and_ends_and_lie_side_by_side() {
        let rod = Core::Cylinder { radius: 0.5, half_height: 2.0 };
        let side = ContactPatch::on_plane(&rod, &Vec3::x(), 0.5, 0.01).unwrap();
        assert!((side.center - Vec3::new(0.5, 0.0, 0.0)).norm() < 1e-15);
        assert!((side.second[(1, 1)] - 4.0).abs() < 1e-14 && side.second[(2, 2)].abs() < 1e-14);
        let end = ContactPatch::on_plane(&rod, &-Vec3::z(), 2.0, 0.01).unwrap();
        assert!((end.second.trace() - 0.25).abs() < 1e-14);
        let beside = at(Rotation::identity(), Vec3::new(0.0, 1.005, 1.0));
        let line = patch(&rod, &rod, &beside, Vec3::y(), [0.005, 0.02]).unwrap();
        assert!((line.center - Vec3::new(0.0, 0.5025, 0.5)).norm() < 1e-15);
        assert!(
            (line.second[(0, 0)] - 2.25).abs() < 1e-14
                && (line.overlap - 0.015 * eighth_root(2.0)).abs() < 1e-15
        );
        let crossed = at(Rotation::from_axis_angle(&Vec3::y_axis(), 1.0), Vec3::new(0.0, 1.005, 0.0));
        assert!(patch(&rod, &rod, &crossed, Vec3::y(), [0.005, 0.02]).is_none());
    }

    #[test]
    fn a_floor_cut_in_triangles_bears_like_a_whole_one() {
        let cube = Core::Box(Vec3::new(1.0, 0.5, 0.25));
        let corner = |x: f64, y: f64| Vec3::new(x, y, -0.25);
        let vertices = vec![corner(-2.0, -2.0), corner(2.0, -2.0), corner(2.0, 2.0), corner(-2.0, 2.0)];
        let floor = TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] };
        let floor = WallMesh::new(&floor, SMOOTH_ANGLE).unwrap();
        let nearest = Nearest { normal: -Vec3::z(), point: corner(0.0, 0.0), gap: 0.0, crusts: 0.02 };
        let [f, g] = [0, 1].map(|t| {
            let placement = at(Rotation::identity(), Vec3::zeros());
            ContactPatch::on_triangle(&cube, &placement, (&floor, t), &nearest).unwrap().unwrap()
        });
        let joined = f.joined(&g);
        assert!(joined.center.x.abs() < 1e-14 && joined.center.y.abs() < 1e-14);
        assert!((joined.overlap - 0.02 * eighth_root(4.0)).abs() < 1e-15 && joined.pitch.abs() < 1e-15);
        let moved = joined.moved(&Mat3::identity(), 2.0, &Vec3::x());
        assert!((moved.second - joined.second * 4.0).norm() < 1e-14);
    }

    /// D of two cores with their crusts (m), and the negative of its gradient over a motion of B: force and torque about the
    /// origin.
    fn wrench(a: &Core, b: &Core, placement: &Placement, crusts: f64) -> (f64, Vec3, Vec3) {
        let found = distance(a, b, placement, 10.0, &mut Simplex::default()).unwrap();
        let Separation::Apart { distance: gap, normal, point_a, point_b } = found else {
            panic!("they meet")
        };
        let point = (point_a + point_b) * 0.5;
        match ContactPatch::of_cores(a, b, placement, &Nearest { normal, point, gap, crusts }) {
            None => (crusts - gap, normal, point.cross(&normal)),
            Some(ContactPatch { normal, center, overlap, weight, pitch, .. }) => {
                let force = normal * weight;
                (overlap, force, center.cross(&force) + force * pitch)
            }
        }
    }

    /// Pairs of bodies laid on each other nearly flush, with edges that cross, lie side by side or nearly so.
    #[test]
    fn the_wrench_is_the_gradient_of_the_depth() {
        const CRUSTS: f64 = 0.04;
        let cores = [
            Core::Box(Vec3::new(0.6, 0.5, 0.4)),
            Core::Cylinder { radius: 0.4, half_height: 0.6 },
            crate::Shape::regular(crate::RegularSolid::Octahedron, 0.7, 0.02).unwrap().parts[0].core.clone(),
        ];
        let number = |k: usize| (k as f64 * 0.618_033_988_75).fract() - 0.5;
        let mut worst = [[0.0_f64; 3]; 3];
        for case in 0..1800 {
            let (i, j) = (case % 3, case / 3 % 3);
            let random =
                |k: usize| Vec3::new(number(case + 7 * k), number(5 * case + k), number(13 * case + 3 * k));
            let tilt = random(1) * [1e-3, 0.03, 0.3, 6.0][case / 9 % 4];
            let yaw = if case / 36 % 2 == 0 { 0.0 } else { number(17 * case) };
            let turn = Rotation::new(tilt) * Rotation::from_axis_angle(&Vec3::z_axis(), yaw);
            let aside = random(5).component_mul(&Vec3::new(1.5, 1.5, 0.0));
            let mut placement = at(turn, aside + Vec3::z() * 3.0);
            let depth = 0.002;
            let mut gap = f64::INFINITY;
            for _ in 0..300 {
                let found =
                    distance(&cores[i], &cores[j], &placement, 10.0, &mut Simplex::default()).unwrap();
                let Separation::Apart { distance, .. } = found else { break };
                gap = distance;
                placement.translation.z -= (gap - (CRUSTS - depth)).max(0.0);
            }
            if gap > CRUSTS - 0.5 * depth || placement.translation.z < -1.0 {
                continue;
            }
            let (_, force, torque) = wrench(&cores[i], &cores[j], &placement, CRUSTS);
            let step = 1e-7;
            let slope = |translation: Vec3, turn: Vec3| {
                let depth = |by: f64| {
                    let rotation = Rotation::new(turn * by);
                    let moved = Placement {
                        matrix: rotation.to_rotation_matrix().into_inner() * placement.matrix,
                        translation: rotation * placement.translation + translation * by,
                    };
                    wrench(&cores[i], &cores[j], &moved, CRUSTS).0
                };
                (depth(-step) - depth(step)) / (2.0 * step)
            };
            for axis in 0..3 {
                let unit = Vec3::ith(axis, 1.0);
                let errors =
                    [slope(unit, Vec3::zeros()) - force[axis], slope(Vec3::zeros(), unit) - torque[axis]];
                let error = errors[0].abs().max(errors[1].abs());
                worst[i][j] = worst[i][j].max(error);
            }
        }
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            // The line along which the side of a cylinder is met turns in it.
            let limit = if [i, j].contains(&1) { 1e-2 } else { 1e-7 };
            assert!(worst[i][j] < limit, "{worst:?}");
        }
    }
}
