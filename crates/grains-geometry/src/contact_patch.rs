//! Contact patches: face on face, edge or rim on face, side on side of two cylinders.
//!
//! The nearest points of two flush faces are any pair of them, so a single contact point drifts and
//! bodies at rest spin and creep (thesis 3.3). Where the contact normal is that of a face, the face
//! of the other body that looks at it is clipped to it. The corners of the common polygon are contacts
//! of one potential: with the norm D of their overlaps and its weights w_i ([`DepthNorm`]),
//!
//! ```text
//! D = (Σ δ_i⁸)^(1/8),   w_i = (δ_i/D)⁷,   W = Σ w_i,   c = Σ w_i x_i / W,
//! ```
//!
//! the normal forces w_i F(D) at the corners, all parallel, are W F(D) at c: the gradient of ∫F dD, which
//! stays continuous when a corner touches or leaves.

use crate::convex::feature::{CAPACITY, Feature};
use crate::{Core, DepthNorm, Mat3, Placement, Vec3};

/// Cosine above which a contact normal counts as that of a face.
const ALIGNED: f64 = 0.999;
/// Squared sine below which it is that of the face to the accuracy of the distance query, which on a
/// curved surface has half the digits.
const SAME: f64 = 1e-10;
/// Squared sine of the angle of two axes below which they are parallel.
const PARALLEL: f64 = 2e-3;
/// The deepest corner must have the overlap of the nearest points to within this share of the crusts.
const AGREEMENT: f64 = 0.1;
/// Sine of the angle at which a corner of the joined polygon of several patches is none.
const STRAIGHT: f64 = 1e-6;
/// Largest number of corners of a patch.
const CORNERS: usize = 16;

/// A corner of a patch: where it is, midway between the cores, and its overlap (m), negative if it is apart.
type Corner = (Vec3, f64);

/// Where two bodies touch, as seen along the contact normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPatch {
    /// Unit contact normal, that of a flush face without rounding (-).
    pub normal: Vec3,
    /// Weighted centre c of the corners (m).
    pub center: Vec3,
    /// Norm D of the overlaps (m).
    pub overlap: f64,
    /// W = Σ w_i (-), 1 if one corner touches.
    pub weight: f64,
    /// Second moment Σ (w_i/W) (r_i × n)(r_i × n)ᵀ with r_i = x_i − c (m²).
    pub second: Mat3,
    corners: [Corner; CORNERS],
    len: usize,
}

/// Brings a feature into the frame its body is placed in.
fn place(feature: &mut Feature, placement: &Placement) {
    let scale = placement.matrix.column(0).norm();
    feature.transform(|point| placement.apply(point), |normal| placement.matrix * normal / scale);
}

/// The normal of a face if a contact normal is the same but for the accuracy of the query.
fn normal_instead_of(feature: &Feature, normal: &Vec3) -> Option<Vec3> {
    feature.normal().filter(|outward| outward.cross(normal).norm_squared() < SAME)
}

impl ContactPatch {
    /// ContactPatch of two cores whose nearest points are `gap` (m) apart along the unit `normal` from A to B.
    ///
    /// All in the frame of A, B being put there by `placement`; `crusts` (m) is the sum of the radii swept
    /// over the cores. `None` if the bodies touch in a point: the nearest points then are the contact.
    /// The centre lies midway between the cores.
    pub fn of_cores(
        a: &Core,
        b: &Core,
        placement: &Placement,
        normal: &Vec3,
        gap: f64,
        crusts: f64,
    ) -> Option<Self> {
        let scale = placement.matrix.column(0).norm();
        let of_b = |n: &Vec3, found: &mut Feature| {
            b.contact_feature(&(-placement.matrix.tr_mul(n) / scale), found)?;
            place(found, placement);
            Some(())
        };
        let mut corners = Corners::new(crusts);
        let (mut first, mut second, mut normal) = (Feature::empty(), Feature::empty(), *normal);
        a.contact_feature(&normal, &mut first)?;
        of_b(&normal, &mut second)?;
        if first.alignment().max(second.alignment()) < ALIGNED {
            corners.between_segments(&first, &second);
        } else if first.alignment() >= second.alignment() {
            if let Some(outward) = normal_instead_of(&first, &normal) {
                normal = outward;
                of_b(&normal, &mut second)?;
            }
            corners.clip(&mut second, &first);
        } else {
            if let Some(outward) = normal_instead_of(&second, &normal) {
                normal = -outward;
                a.contact_feature(&normal, &mut first)?;
            }
            corners.clip(&mut first, &second);
        }
        corners.summary(&normal, crusts - gap)
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
        let mut corners = Corners::new(crust);
        for point in feature.points() {
            corners.add(*point, gap(point));
        }
        let deepest = gap(&core.support(normal));
        corners.summary(normal, crust - deepest)
    }

    /// The patch of corners seen along a normal; `None` if none overlaps.
    fn of_corners(normal: &Vec3, all: &[Corner]) -> Option<Self> {
        let touching = all.iter().filter(|(_, overlap)| *overlap > 0.0);
        touching.clone().next()?;
        let norm = DepthNorm::of(touching.clone().map(|(_, overlap)| *overlap));
        let weight: f64 = touching.clone().map(|(_, overlap)| norm.weight(*overlap)).sum();
        let shares = touching.map(|(x, overlap)| (x, norm.weight(*overlap) / weight));
        let center = shares.clone().map(|(x, w)| x * w).sum::<Vec3>();
        let second = shares.map(|(x, w)| {
            let lever = (x - center).cross(normal);
            lever * lever.transpose() * w
        });
        let (mut corners, len) = ([(Vec3::zeros(), 0.0); CORNERS], all.len().min(CORNERS));
        corners[..len].copy_from_slice(&all[..len]);
        let (normal, second) = (*normal, second.sum());
        Some(Self { normal, center, overlap: norm.depth, weight, second, corners, len })
    }

    fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    /// Whether one corner touches alone.
    pub fn is_one_corner(&self) -> bool {
        self.corners().iter().filter(|(_, overlap)| *overlap > 0.0).count() == 1
    }

    /// The contact patch at `scale` times the size, turned and moved: x → rotation x scale + offset.
    pub fn moved(&self, rotation: &Mat3, scale: f64, offset: &Vec3) -> Self {
        let place = |x: &Vec3| rotation * x * scale + offset;
        let mut moved = Self {
            normal: rotation * self.normal,
            center: place(&self.center),
            overlap: self.overlap * scale,
            second: rotation * self.second * rotation.transpose() * (scale * scale),
            ..*self
        };
        for (x, overlap) in &mut moved.corners[..self.len] {
            (*x, *overlap) = (place(x), *overlap * scale);
        }
        moved
    }

    /// The patches of one normal, on pieces of one flat face, as one: its corners are those of the hull of all.
    ///
    /// Where the seams of the face cut the polygon is no corner.
    pub fn joined(&self, other: &Self) -> Self {
        let mut all = [(Vec3::zeros(), 0.0); 2 * CORNERS];
        let count = self.len + other.len;
        all[..self.len].copy_from_slice(self.corners());
        all[self.len..count].copy_from_slice(other.corners());
        let mut hull = [(Vec3::zeros(), 0.0); 4 * CORNERS];
        let len = hull_around(&self.normal, &mut all[..count], &mut hull);
        // The deepest of all is one of the hull or lies between two of its corners as deep.
        Self::of_corners(&self.normal, &hull[..len]).unwrap_or(*self)
    }
}

/// Fills `hull` with the corners of the convex hull seen along a normal, and returns their number (Andrew 1979).
fn hull_around(normal: &Vec3, corners: &mut [Corner], hull: &mut [Corner]) -> usize {
    let across = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
    let other = normal.cross(&across);
    let place = |corner: &Corner| (across.dot(&corner.0), other.dot(&corner.0));
    corners.sort_unstable_by(|a, b| {
        let ((x, y), (s, t)) = (place(a), place(b));
        x.total_cmp(&s).then(y.total_cmp(&t))
    });
    let turns = |a: &Corner, b: &Corner, c: &Corner| {
        let (along, on) = (c.0 - a.0, b.0 - a.0);
        on.cross(&along).dot(normal) > STRAIGHT * along.norm_squared()
    };
    let mut len = 0;
    let mut add = |corner: &Corner, first: usize, len: &mut usize| {
        while *len >= first + 2 && !turns(&hull[*len - 2], &hull[*len - 1], corner) {
            *len -= 1;
        }
        hull[*len] = *corner;
        *len += 1;
    };
    corners.iter().for_each(|corner| add(corner, 0, &mut len));
    // The way back begins at the last corner, which both ways share, as they do the first.
    let first = len - 1;
    corners.iter().rev().skip(1).for_each(|corner| add(corner, first, &mut len));
    (len - 1).max(1)
}

/// The corners of a contact polygon.
struct Corners {
    points: [Corner; CAPACITY],
    len: usize,
    crusts: f64,
    deepest: f64,
}

impl Corners {
    fn new(crusts: f64) -> Self {
        Self { points: [(Vec3::zeros(), 0.0); CAPACITY], len: 0, crusts, deepest: f64::NEG_INFINITY }
    }

    fn add(&mut self, point: Vec3, gap: f64) {
        let overlap = self.crusts - gap;
        self.deepest = self.deepest.max(overlap);
        if self.len < CAPACITY {
            self.points[self.len] = (point, overlap);
            self.len += 1;
        }
    }

    /// Clips the incident feature to the prism over the reference face.
    fn clip(&mut self, incident: &mut Feature, reference: &Feature) {
        let Some(normal) = reference.normal() else { return };
        let mut spare = Feature::empty();
        let (mut whole, mut kept) = (incident, &mut spare);
        let corners = reference.points();
        for (k, p) in corners.iter().enumerate() {
            let outward = (corners[(k + 1) % corners.len()] - p).cross(&normal);
            whole.clip(|x| outward.dot(&(x - p)), kept);
            std::mem::swap(&mut whole, &mut kept);
        }
        for point in whole.points() {
            let gap = normal.dot(&(point - corners[0]));
            self.add(point - normal * (0.5 * gap), gap);
        }
    }

    /// The ends of the common stretch of two nearly parallel segments.
    fn between_segments(&mut self, first: &Feature, second: &Feature) {
        let ([a, b], [c, d]) = (first.points(), second.points()) else { return };
        let (along, other) = (b - a, d - c);
        let (length, slope) = (along.norm_squared(), along.dot(&other));
        if along.cross(&other).norm_squared() > PARALLEL * length * other.norm_squared() {
            return;
        }
        let place = |p: &Vec3| along.dot(&(p - a)) / length;
        let (from, to) = (place(c).min(place(d)).max(0.0), place(c).max(place(d)).min(1.0));
        if from > to {
            return;
        }
        for t in [from, to] {
            let on_first = a + along * t;
            let on_second = c + other * (along.dot(&(on_first - c)) / slope);
            self.add((on_first + on_second) * 0.5, (on_second - on_first).norm());
        }
    }

    /// `None` unless the deepest corner has the overlap of the nearest points.
    fn summary(&self, normal: &Vec3, overlap: f64) -> Option<ContactPatch> {
        if (self.deepest - overlap).abs() > AGREEMENT * self.crusts {
            return None;
        }
        ContactPatch::of_corners(normal, &self.points[..self.len])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rotation;
    use std::f64::consts::FRAC_PI_4;

    fn eighth_root(x: f64) -> f64 {
        x.sqrt().sqrt().sqrt()
    }

    fn at(rotation: Rotation, translation: Vec3) -> Placement {
        Placement { matrix: rotation.to_rotation_matrix().into_inner(), translation }
    }

    #[test]
    fn a_cube_flush_on_a_larger_one_has_the_second_moments_of_its_corners() {
        let (small, large) = (Core::Box(Vec3::repeat(0.5)), Core::Box(Vec3::repeat(2.0)));
        let placement = at(Rotation::from_axis_angle(&Vec3::z_axis(), 0.3), Vec3::new(0.4, -0.2, 2.51));
        let f = ContactPatch::of_cores(&large, &small, &placement, &Vec3::z(), 0.01, 0.03).unwrap();
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
        let f = ContactPatch::of_cores(&large, &small, &placement, &Vec3::z(), lowest, 0.03).unwrap();
        // Turned about y by a positive angle the edge at +x is lower.
        assert!(f.center.x > 0.05 && f.center.y.abs() < 1e-15 && f.weight > 1.0);
        let single = ContactPatch::of_cores(&large, &small, &placement, &Vec3::z(), lowest, lowest + 0.002);
        assert!((single.unwrap().center.x - 0.5 * (tilt.cos() - tilt.sin())).abs() < 1e-3, "only the edge");
    }

    #[test]
    fn faces_that_overlap_in_part_share_the_common_polygon() {
        let cube = Core::Box(Vec3::repeat(0.5));
        let turned = Rotation::from_axis_angle(&Vec3::z_axis(), FRAC_PI_4);
        let f = ContactPatch::of_cores(
            &cube,
            &cube,
            &at(turned, Vec3::new(0.0, 0.0, 1.0)),
            &Vec3::z(),
            0.0,
            0.02,
        );
        // A regular octagon of inradius 1/2: r² = (1/2)²/cos²(22.5°).
        let r2 = 0.25 / (FRAC_PI_4 / 2.0).cos().powi(2);
        assert!((f.unwrap().second.trace() - r2).abs() < 1e-14);
        let shifted = at(Rotation::identity(), Vec3::new(0.8, 0.0, 1.0));
        let f = ContactPatch::of_cores(&cube, &cube, &shifted, &Vec3::z(), 0.0, 0.02).unwrap();
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
        let line = ContactPatch::of_cores(&rod, &rod, &beside, &Vec3::y(), 0.005, 0.02).unwrap();
        assert!((line.center - Vec3::new(0.0, 0.5025, 0.5)).norm() < 1e-15);
        assert!(
            (line.second[(0, 0)] - 2.25).abs() < 1e-14
                && (line.overlap - 0.015 * eighth_root(2.0)).abs() < 1e-15
        );
        let crossed = at(Rotation::from_axis_angle(&Vec3::y_axis(), 1.0), Vec3::new(0.0, 1.005, 0.0));
        assert!(ContactPatch::of_cores(&rod, &rod, &crossed, &Vec3::y(), 0.005, 0.02).is_none());
    }

    #[test]
    fn a_floor_cut_in_triangles_bears_like_a_whole_one() {
        let cube = Core::Box(Vec3::new(1.0, 0.5, 0.25));
        let floor = |corners: [[f64; 2]; 3]| Core::Triangle(corners.map(|[x, y]| Vec3::new(x, y, -0.25)));
        let halves =
            [floor([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0]]), floor([[-2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])];
        let normal = -Vec3::z();
        let [f, g] = halves.map(|half| {
            let placement = at(Rotation::identity(), Vec3::zeros());
            ContactPatch::of_cores(&cube, &half, &placement, &normal, 0.0, 0.02).unwrap()
        });
        let joined = f.joined(&g);
        assert!(joined.center.x.abs() < 1e-14 && joined.center.y.abs() < 1e-14);
        assert!((joined.overlap - 0.02 * eighth_root(4.0)).abs() < 1e-15 && joined.len == 4);
        let moved = joined.moved(&Mat3::identity(), 2.0, &Vec3::x());
        assert!((moved.second - joined.second * 4.0).norm() < 1e-14);
    }
}
