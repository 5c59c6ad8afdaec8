//! The surfaces walls are made of, and their contact with a sphere in closed form.

use super::open_tube::OpenTube;
use crate::bodies::{Meeting, PlacedPart, spread, touch};
use crate::catalogue::FaceContact;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{ContactPatch, Core, GjkError, Mat3, Placement, Simplex, Vec3, WallMesh};
use std::sync::Arc;

/// A piece of wall in the wall's frame.
#[derive(Clone, Debug)]
pub enum Surface {
    /// Half space behind a plane; the unit normal points to the particles' side.
    Plane {
        /// A point of the plane (m).
        point: Vec3,
        /// Unit normal.
        normal: Vec3,
    },
    /// The inside of a cylinder without end, or whose ends others close.
    Tube {
        /// Centre (m).
        center: Vec3,
        /// Unit vector of the axis.
        axis: Vec3,
        /// Radius (m).
        radius: f64,
        /// Half of the length (m), or infinity.
        half_length: f64,
    },
    /// Both sides of a cylinder of no thickness, open at its ends.
    OpenTube(OpenTube),
    /// The outside of a convex body.
    Solid {
        /// The body.
        core: Core,
        /// Its rotation.
        rotation: Mat3,
        /// Its centre (m).
        center: Vec3,
        /// Radius of its bounding sphere (m).
        bounding_radius: f64,
    },
    /// Both sides of a triangle mesh.
    Mesh(Arc<WallMesh>),
}

/// Contact of a convex body with a surface, in the wall's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceContact {
    /// Unit normal from the body into the wall.
    pub(crate) normal: Vec3,
    /// Overlap (m), positive.
    pub(crate) overlap: f64,
    /// Contact point (m).
    pub(crate) point: Vec3,
    /// Where the body touches if not in a point.
    pub(crate) footprint: Option<ContactPatch>,
}

impl SurfaceContact {
    /// Contact of a body whose surface reaches `overlap` behind the wall at `deepest`.
    #[inline(always)]
    pub(crate) fn new(deepest: Vec3, normal: Vec3, overlap: f64, footprint: Option<ContactPatch>) -> Self {
        Self { normal, overlap, point: deepest - normal * (0.5 * overlap), footprint }
    }

    /// The same contact spread over a footprint of the core, which is swept by a ball of radius `crust`.
    fn spread(self, footprint: Option<ContactPatch>, crust: f64) -> Self {
        let Some(ContactPatch { center, overlap, .. }) = footprint else { return self };
        Self::new(center + self.normal * crust, self.normal, overlap, footprint)
    }

    /// Two contacts with one flat patch: the deeper, or both footprints together.
    pub(crate) fn joined(&self, other: &Self) -> Self {
        let deeper = if self.overlap >= other.overlap { self } else { other };
        match (&self.footprint, &other.footprint) {
            (Some(a), Some(b)) => {
                let joined = a.joined(b);
                let share = a.weight / joined.weight;
                Self {
                    normal: self.normal,
                    overlap: joined.overlap,
                    point: self.point * share + other.point * (1.0 - share),
                    footprint: Some(joined),
                }
            }
            // A triangle touched in one point adds nothing to a face that lies on its neighbours.
            (Some(_), None) => *self,
            (None, Some(_)) => *other,
            (None, None) => *deeper,
        }
    }

    /// Contact of a sphere whose surface point deepest in the wall lies along `normal`.
    #[inline(always)]
    pub(super) fn of_sphere(center: &Vec3, radius: f64, normal: Vec3, overlap: f64) -> Self {
        Self::new(center + normal * radius, normal, overlap, None)
    }
}

impl Surface {
    /// Whether periodic images of a particle may meet this surface elsewhere: planes are their own images.
    pub fn is_finite(&self) -> bool {
        match self {
            Surface::Plane { .. } => false,
            Surface::Tube { half_length, .. } => half_length.is_finite(),
            Surface::OpenTube(_) | Surface::Solid { .. } | Surface::Mesh(_) => true,
        }
    }

    /// Calls `found` with every element (triangle, or 0) within `reach` (m) of a point.
    pub(crate) fn for_each_near(&self, center: &Vec3, reach: f64, mut found: impl FnMut(u32)) {
        match self {
            Surface::Plane { point, normal } => {
                if (center - point).dot(normal) < reach {
                    found(0);
                }
            }
            Surface::Tube { center: middle, axis, radius, half_length } => {
                let from = center - middle;
                let along = from.dot(axis);
                let off = (from - axis * along).norm();
                if off > radius - reach && along.abs() < half_length + reach {
                    found(0);
                }
            }
            Surface::OpenTube(tube) => tube.for_each_near(center, reach, found),
            Surface::Solid { center: middle, bounding_radius, .. } => {
                if (center - middle).norm() < bounding_radius + reach {
                    found(0);
                }
            }
            Surface::Mesh(mesh) => {
                let half = Vec3::repeat(reach);
                mesh.for_each_in_box(&(center - half), &(center + half), |t| {
                    if mesh.is_near(t, center, reach) {
                        found(t);
                    }
                });
            }
        }
    }

    /// Contact of a sphere with one element, if they touch.
    #[inline]
    pub(crate) fn meets_sphere(
        &self,
        element: u32,
        center: &Vec3,
        radius: f64,
    ) -> Result<Option<SurfaceContact>, GjkError> {
        let contact = match self {
            Surface::Plane { point, normal } => {
                let overlap = radius - (center - point).dot(normal);
                (overlap > 0.0).then(|| SurfaceContact::of_sphere(center, radius, -normal, overlap))
            }
            Surface::Tube { center: middle, axis, radius: wall_radius, half_length } => {
                let from = center - middle;
                let along = from.dot(axis);
                let outward = from - axis * along;
                let off = outward.norm();
                let overlap = off + radius - wall_radius;
                (overlap > 0.0 && off > 0.0 && along.abs() <= *half_length)
                    .then(|| SurfaceContact::of_sphere(center, radius, outward / off, overlap))
            }
            Surface::OpenTube(tube) => tube.meets_sphere(element, center, radius),
            Surface::Solid { core, rotation, center: middle, .. } => {
                let placement = Placement { matrix: *rotation, translation: middle - center };
                match distance(&Core::Point, core, &placement, radius, &mut Simplex::default())? {
                    Separation::Apart { distance, normal, .. } if distance < radius => {
                        Some(SurfaceContact::of_sphere(center, radius, normal, radius - distance))
                    }
                    // The centre is inside the wall: far beyond any overlap limit, and so reported.
                    Separation::Meeting => Some(SurfaceContact::of_sphere(center, radius, Vec3::z(), radius)),
                    _ => None,
                }
            }
            Surface::Mesh(mesh) => mesh
                .closest_within(element, center, radius)
                .map(|c| SurfaceContact::of_sphere(center, radius, -c.normal, radius - c.distance)),
        };
        Ok(contact)
    }

    /// Contact of a part (placed in the wall's frame, centre at `center`) with one element, if they touch.
    pub(crate) fn meets_part(
        &self,
        element: u32,
        center: &Vec3,
        part: &PlacedPart,
        simplex: &mut Simplex,
        faces: FaceContact,
    ) -> Result<Option<SurfaceContact>, GjkError> {
        let is_spread = faces == FaceContact::Spread;
        match self {
            Surface::Plane { point, normal } => {
                if let Some(vertices) = part.vertices {
                    return Ok(part.vertices_behind(vertices, center, point, normal));
                }
                let deepest = center + part.farthest(&-normal);
                let contact = part.contact_behind(&deepest, -normal, -(deepest - point).dot(normal));
                Ok(contact.map(|contact| {
                    let gap = |p: &Vec3| (center + p - point).dot(normal);
                    let footprint = if is_spread { part.footprint(center, &-normal, gap) } else { None };
                    contact.spread(footprint, part.crust)
                }))
            }
            Surface::Tube { center: middle, axis, radius, half_length } => {
                let (deepest, outward, off) = part.farthest_from_axis(&(center - middle), axis);
                let along = (center - middle + deepest).dot(axis);
                if along.abs() > *half_length {
                    return Ok(None);
                }
                let contact = part.contact_behind(&(center + deepest), outward, off - radius);
                Ok(contact.map(|contact| {
                    let gap = |p: &Vec3| {
                        let from = center - middle + p;
                        radius - (from - axis * from.dot(axis)).norm()
                    };
                    let footprint = if is_spread { part.footprint(center, &outward, gap) } else { None };
                    contact.spread(footprint, part.crust)
                }))
            }
            Surface::OpenTube(tube) => tube.meets_part(element, center, part),
            Surface::Solid { core, rotation, center: middle, .. } => {
                let placement = part.placement(rotation, 1.0, &(middle - center));
                let Meeting::Touching(mut c) = touch(part, core, &placement, 0.0, 0.0, simplex)? else {
                    return Ok(None);
                };
                let footprint = is_spread.then(|| spread(part, core, &placement, 0.0, &mut c)).flatten();
                let point = center + c.point;
                Ok(Some(SurfaceContact { normal: c.normal, overlap: c.overlap, point, footprint }))
            }
            Surface::Mesh(mesh) => {
                let core = Core::Triangle(mesh.mesh().corners(element as usize));
                let placement = part.placement(&Mat3::identity(), 1.0, &-center);
                let Meeting::Touching(mut c) = touch(part, &core, &placement, 0.0, 0.0, simplex)? else {
                    return Ok(None);
                };
                let footprint = is_spread.then(|| spread(part, &core, &placement, 0.0, &mut c)).flatten();
                let point = center + c.point;
                let contact = SurfaceContact { normal: c.normal, overlap: c.overlap, point, footprint };
                // The triangle's point lies half an overlap behind the contact point.
                let on_triangle = point - c.normal * (0.5 * c.overlap);
                let owns = c.cores_met
                    || footprint.is_some()
                    || mesh.owns_local_minimum(element, &on_triangle, &-c.normal);
                Ok(owns.then_some(contact))
            }
        }
    }

    /// Whether a ball is certainly apart from an element: true wherever [`Self::for_each_near`] does not find
    /// the element for the same ball.
    pub(crate) fn is_out_of_reach(&self, element: u32, center: &Vec3, radius: f64) -> bool {
        match self {
            Surface::Plane { .. } | Surface::Tube { .. } => false,
            Surface::Solid { center: middle, bounding_radius, .. } => {
                (center - middle).norm() >= radius + bounding_radius
            }
            Surface::OpenTube(tube) => !tube.is_near(element, center, radius),
            Surface::Mesh(mesh) => !mesh.is_near(element, center, radius),
        }
    }

    /// Whether a contact that ended on one element may go on, with a normal, on another.
    pub(crate) fn goes_on(&self, from: u32, to: u32, normal: &Vec3) -> bool {
        const SIMILAR_DIRECTION: f64 = 0.9;
        match self {
            Surface::OpenTube(tube) => tube.adjoin(from, to),
            _ => self.element_normal(from).is_some_and(|n| n.dot(normal).abs() > SIMILAR_DIRECTION),
        }
    }

    /// Unit normal of an element that has one of its own.
    fn element_normal(&self, element: u32) -> Option<Vec3> {
        match self {
            Surface::Plane { normal, .. } => Some(*normal),
            Surface::Mesh(mesh) => {
                let [a, b, c] = mesh.mesh().corners(element as usize);
                Some((b - a).cross(&(c - a)).normalize())
            }
            _ => None,
        }
    }
}
