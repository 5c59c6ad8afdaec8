//! The surfaces walls are made of, and their contact with a sphere in closed form.

use super::facets::{facet_meets_part, triangle_of_facet};
use super::open_tube::OpenTube;
use super::surface_contact::{PartMeeting, SphereTouch, SurfaceContact};
use crate::catalogue::FaceContact;
use crate::narrow_phase::{Meeting, PartContact, PlacedPart, contact_patch, patch_on_triangle, touch};
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Core, GjkError, Mat3, Placement, Simplex, Vec3, WallMesh};
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

impl Surface {
    /// Whether periodic images of a particle may meet this surface elsewhere: planes are their own images.
    pub fn is_finite(&self) -> bool {
        match self {
            Surface::Plane { .. } => false,
            Surface::Tube { half_length, .. } => half_length.is_finite(),
            Surface::OpenTube(_) | Surface::Solid { .. } | Surface::Mesh(_) => true,
        }
    }

    /// Number of its elements that wear apart: triangles of a mesh, else the whole.
    pub(super) fn worn_elements(&self) -> usize {
        if let Surface::Mesh(mesh) = self { mesh.mesh().triangles.len() } else { 1 }
    }

    /// Whether there is such a triangle; surfaces that are no meshes have elements of their own, which wear as one.
    pub(crate) fn has_worn_element(&self, element: u32) -> bool {
        !matches!(self, Surface::Mesh(_)) || (element as usize) < self.worn_elements()
    }

    /// Whether there is such a triangle or facet of a mesh; of other surfaces any.
    pub(crate) fn has_element(&self, element: u32) -> bool {
        self.has_worn_element(triangle_of_facet(element).unwrap_or(element))
    }

    /// What wears where an element is touched at a point (m): a triangle of a mesh.
    pub(super) fn worn_element(&self, element: u32, point: &Vec3) -> u32 {
        match (self, triangle_of_facet(element)) {
            (Surface::Mesh(mesh), Some(triangle)) => mesh.triangle_below(triangle, point),
            _ => element,
        }
    }

    /// Whether an element found by [`Surface::for_each_near`] is another, or on its facet.
    pub(crate) fn is_of(&self, found: u32, element: u32) -> bool {
        match (self, triangle_of_facet(element)) {
            (Surface::Mesh(mesh), Some(triangle)) => mesh.facet(found).first == mesh.facet(triangle).first,
            _ => found == element,
        }
    }

    /// Corners (m) of a box that holds it; none if it has no end.
    pub fn extents(&self) -> Option<[Vec3; 2]> {
        let around = |center: &Vec3, reach: f64| Some([center.add_scalar(-reach), center.add_scalar(reach)]);
        match self {
            Surface::Mesh(mesh) => Some([mesh.report().mesh.lower, mesh.report().mesh.upper]),
            Surface::Solid { center, bounding_radius, .. } => around(center, *bounding_radius),
            Surface::OpenTube(tube) => around(&tube.center, libm::hypot(tube.half_length, tube.radius)),
            Surface::Plane { .. } | Surface::Tube { .. } => None,
        }
    }

    /// Whether some of it may lie in the box of eight corners (m), in the wall's frame.
    pub(crate) fn meets_box(&self, corners: &[Vec3; 8]) -> bool {
        if let Surface::Plane { point, normal } = self {
            let is_before = |corner: &Vec3| normal.dot(&(corner - point)) >= 0.0;
            let is_behind = |corner: &Vec3| normal.dot(&(corner - point)) <= 0.0;
            return corners.iter().any(is_before) && corners.iter().any(is_behind);
        }
        let lower = corners.iter().fold(corners[0], |low, corner| low.inf(corner));
        let upper = corners.iter().fold(corners[0], |high, corner| high.sup(corner));
        self.extents().is_none_or(|[from, to]| (0..3).all(|a| from[a] <= upper[a] && to[a] >= lower[a]))
    }

    /// Whether contacts of all shapes with an element need no distance query.
    pub(crate) fn has_closed_form(&self, element: u32) -> bool {
        match self {
            Surface::Plane { .. } | Surface::Tube { .. } | Surface::OpenTube(_) => true,
            Surface::Mesh(_) => triangle_of_facet(element).is_some(),
            Surface::Solid { .. } => false,
        }
    }

    /// Calls `found` with every element (triangle, or 0; no facet) that may lie within `range` (m) of a point.
    pub(crate) fn for_each_near(&self, center: &Vec3, range: f64, mut found: impl FnMut(u32)) {
        let is_near = |element: u32| self.distance_bound(element, center) < range;
        match self {
            Surface::OpenTube(tube) => tube.for_each_near(center, range, found),
            Surface::Mesh(mesh) => {
                let half = Vec3::repeat(range);
                mesh.for_each_in_box(&(center - half), &(center + half), |t| {
                    if is_near(t) {
                        found(t);
                    }
                });
            }
            _ if is_near(0) => found(0),
            _ => {}
        }
    }

    /// Lower bound (m) on the distance of an element from a point; behind a plane or a tube it is negative.
    pub(crate) fn distance_bound(&self, element: u32, center: &Vec3) -> f64 {
        match self {
            Surface::Plane { point, normal } => (center - point).dot(normal),
            Surface::Tube { center: middle, axis, radius, half_length } => {
                let from = center - middle;
                let along = from.dot(axis);
                let off = (from - axis * along).norm();
                (radius - off).max(along.abs() - half_length)
            }
            Surface::OpenTube(tube) => tube.distance_bound(element, center),
            Surface::Solid { center: middle, bounding_radius, .. } => {
                (center - middle).norm() - bounding_radius
            }
            Surface::Mesh(mesh) => match triangle_of_facet(element) {
                Some(triangle) => mesh.facet(triangle).height(center).abs(),
                None => mesh.distance_bound(element, center),
            },
        }
    }

    /// Way (m) that a sphere, which does not touch an element, may go in the wall's frame before it can; not positive where one
    /// step may bring it.
    pub(crate) fn free_path(&self, element: u32, center: &Vec3, radius: f64) -> f64 {
        match self {
            Surface::Mesh(mesh) => mesh.free_path(element, center, radius),
            Surface::OpenTube(tube) if !tube.is_for_spheres(element) => f64::INFINITY,
            Surface::Solid { core, rotation, center: middle, .. } => {
                let placement = Placement { matrix: *rotation, translation: middle - center };
                let gap = match distance(&Core::Point, core, &placement, radius, &mut Simplex::default()) {
                    Ok(Separation::Beyond { axis }) => gap_across_axis(&Core::Point, core, &placement, &axis),
                    Ok(Separation::Apart { distance, .. }) => distance,
                    _ => 0.0,
                };
                gap.max(self.distance_bound(element, center)) - radius
            }
            _ => self.distance_bound(element, center) - radius,
        }
    }

    /// Contact of a sphere with one element, if they touch.
    #[inline(always)]
    pub(crate) fn meets_sphere(
        &self,
        element: u32,
        center: &Vec3,
        radius: f64,
    ) -> Result<Option<SphereTouch>, GjkError> {
        let touch = match self {
            Surface::Plane { point, normal } => {
                let overlap = radius - (center - point).dot(normal);
                (overlap > 0.0).then(|| SphereTouch { normal: -normal, overlap })
            }
            Surface::Tube { center: middle, axis, radius: wall_radius, half_length } => {
                let from = center - middle;
                let along = from.dot(axis);
                let outward = from - axis * along;
                let off = outward.norm();
                let overlap = off + radius - wall_radius;
                (overlap > 0.0 && off > 0.0 && along.abs() <= *half_length)
                    .then(|| SphereTouch { normal: outward / off, overlap })
            }
            Surface::OpenTube(tube) => tube.meets_sphere(element, center, radius),
            Surface::Solid { core, rotation, center: middle, .. } => {
                sphere_meets_solid((core, rotation, middle), center, radius)?
            }
            Surface::Mesh(mesh) => mesh
                .closest_within(element, center, radius)
                .map(|c| SphereTouch { normal: -c.normal, overlap: radius - c.distance }),
        };
        Ok(touch)
    }

    /// How a part (placed in the wall's frame, centre at `center`) meets one element.
    pub(crate) fn meets_part(
        &self,
        element: u32,
        center: &Vec3,
        part: &PlacedPart,
        simplex: &mut Simplex,
        faces: FaceContact,
    ) -> Result<PartMeeting, GjkError> {
        let is_multi_point = faces == FaceContact::MultiPoint;
        match self {
            Surface::Plane { point, normal } => {
                Ok(plane_meets_part((point, normal), center, part, is_multi_point))
            }
            Surface::Tube { center: middle, axis, radius, half_length } => {
                let (deepest, outward, off) = part.farthest_from_axis(&(center - middle), axis);
                let along = (center - middle + deepest).dot(axis);
                if along.abs() > *half_length {
                    return Ok(PartMeeting::NONE);
                }
                let contact = SurfaceContact::behind(part, &(center + deepest), outward, off - radius);
                let Some(contact) = contact else { return Ok(PartMeeting::Apart(radius - off - part.crust)) };
                let gap = |p: &Vec3| {
                    let from = center - middle + p;
                    radius - (from - axis * from.dot(axis)).norm()
                };
                let patch = if is_multi_point { part.footprint(center, &outward, gap) } else { None };
                Ok(PartMeeting::Touching(contact.over(patch, part.crust)))
            }
            Surface::OpenTube(tube) => {
                let contact = tube.meets_part(element, center, part)?;
                Ok(contact.map_or(PartMeeting::NONE, PartMeeting::Touching))
            }
            Surface::Solid { core, rotation, center: middle, .. } => {
                let placement = part.placement(rotation, 1.0, &(middle - center));
                let mut found = match core_meets_part(core, &placement, part, simplex)? {
                    Ok(found) => found,
                    Err(gap) => return Ok(PartMeeting::Apart(gap)),
                };
                let patch =
                    is_multi_point.then(|| contact_patch(part, core, &placement, 0.0, &mut found)).flatten();
                Ok(PartMeeting::Touching(SurfaceContact::found(&found, center, patch)))
            }
            Surface::Mesh(mesh) => {
                if let Some(triangle) = triangle_of_facet(element) {
                    let meets_plane = |plane: (&Vec3, &Vec3), part: &PlacedPart| {
                        plane_meets_part(plane, center, part, is_multi_point)
                    };
                    return Ok(facet_meets_part(mesh.facet(triangle), center, part, meets_plane));
                }
                let core = Core::Triangle(mesh.mesh().corners(element as usize));
                let placement = part.placement(&Mat3::identity(), 1.0, &-center);
                let mut found = match core_meets_part(&core, &placement, part, simplex)? {
                    Ok(found) => found,
                    Err(gap) => return Ok(PartMeeting::Apart(gap)),
                };
                let point = center + found.point;
                if is_multi_point
                    && let Ok(patch) = patch_on_triangle(part, center, (mesh, element), (&found, &point))
                {
                    return Ok(patch.map_or(PartMeeting::NONE, |patch| {
                        (found.normal, found.overlap) = (patch.normal, patch.overlap);
                        found.point = patch.center - center;
                        PartMeeting::Touching(SurfaceContact::found(&found, center, Some(patch)))
                    }));
                }
                // The triangle's point lies half an overlap behind the contact point.
                let on_triangle = point - found.normal * (0.5 * found.overlap);
                let stands_alone = found.is_deep_penetration
                    || mesh.owns_local_minimum(element, &on_triangle, &-found.normal);
                Ok(match stands_alone {
                    true => PartMeeting::Touching(SurfaceContact::found(&found, center, None)),
                    false => PartMeeting::NONE,
                })
            }
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
                if let Some(triangle) = triangle_of_facet(element) {
                    return Some(mesh.facet(triangle).normal);
                }
                let [a, b, c] = mesh.mesh().corners(element as usize);
                Some((b - a).cross(&(c - a)).normalize())
            }
            _ => None,
        }
    }
}

/// Contact of a sphere at `center` (m) with a solid of this rotation and centre (m).
fn sphere_meets_solid(
    (core, rotation, middle): (&Core, &Mat3, &Vec3),
    center: &Vec3,
    radius: f64,
) -> Result<Option<SphereTouch>, GjkError> {
    let placement = Placement { matrix: *rotation, translation: middle - center };
    Ok(match distance(&Core::Point, core, &placement, radius, &mut Simplex::default())? {
        Separation::Apart { distance, normal, .. } if distance < radius => {
            Some(SphereTouch { normal, overlap: radius - distance })
        }
        // The centre is inside the wall: far beyond any overlap limit, and so reported.
        Separation::Meeting => Some(SphereTouch { normal: Vec3::z(), overlap: radius }),
        _ => None,
    })
}

/// How a part at `center` (m) meets a plane, by its vertices if it has any.
fn plane_meets_part(
    (point, normal): (&Vec3, &Vec3),
    center: &Vec3,
    part: &PlacedPart,
    is_multi_point: bool,
) -> PartMeeting {
    if let Some(vertices) = part.vertices {
        let contact = SurfaceContact::of_vertices(part, vertices, center, point, normal);
        let lowest = vertices.reach(&part.rotation.tr_mul(&-normal)) * part.scale;
        return contact
            .map_or(PartMeeting::Apart((center - point).dot(normal) - lowest), PartMeeting::Touching);
    }
    let deepest = center + part.farthest(&-normal);
    let before = (deepest - point).dot(normal);
    let Some(contact) = SurfaceContact::behind(part, &deepest, -normal, -before) else {
        return PartMeeting::Apart(before - part.crust);
    };
    let gap = |p: &Vec3| (center + p - point).dot(normal);
    let patch = if is_multi_point { part.footprint(center, &-normal, gap) } else { None };
    PartMeeting::Touching(contact.over(patch, part.crust))
}

/// Contact of a part with a core placed in its frame, or how far (m) they are apart at least, if positive.
fn core_meets_part(
    core: &Core,
    placement: &Placement,
    part: &PlacedPart,
    simplex: &mut Simplex,
) -> Result<Result<PartContact, f64>, GjkError> {
    Ok(match touch(part, core, placement, 0.0, 0.0, simplex)? {
        Meeting::Touching(contact) => Ok(contact),
        Meeting::Apart(axis) => {
            let gap = gap_across_axis(part.core, core, placement, &part.rotation.tr_mul(&axis));
            Err(gap * part.scale - part.crust)
        }
    })
}

/// Gap of two cores, the second placed in the frame of the first, across a plane of this normal in it, of any length (m).
fn gap_across_axis(first: &Core, second: &Core, placement: &Placement, axis: &Vec3) -> f64 {
    let axis = axis / axis.norm();
    let nearest = axis.dot(&placement.translation) - second.support_value(&placement.matrix.tr_mul(&-axis));
    nearest - first.support_value(&axis)
}
