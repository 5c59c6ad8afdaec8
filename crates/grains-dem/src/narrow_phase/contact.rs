//! The contact of two convex parts, and the planes that separate them.

use super::placed_part::{PlacedPart, Pose};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{ContactPatch, Core, GjkError, Placement, Simplex, Vec3};

/// Gap up to which bodies are separated by the plane that lasts longest, that of the nearest points, relative to a body.
const SLACK: f64 = 0.05;
/// Share of the size of a pair by which a plane must separate it, so that no query can find what touches there.
const CLEARANCE: f64 = 1e-11;

/// Gap (m) of two parts, of particles whose centres are `separation` (m) apart, across a plane of unit normal `axis`.
///
/// If positive it is a proof: no distance query would find that they touch.
#[inline(always)]
pub(crate) fn gap_across_plane(poses: &[Pose; 2], parts: &[u16; 2], separation: &Vec3, axis: &Vec3) -> f64 {
    let [a, b] = poses;
    let size = a.scale * a.shape.bounding_radius + b.scale * b.shape.bounding_radius;
    let along = separation.dot(axis) - CLEARANCE * size;
    if let (Some(of_a), Some(of_b)) = (&a.shape.discrete, &b.shape.discrete) {
        return along - a.support_value_of_vertices(of_a, axis) - b.support_value_of_vertices(of_b, &-axis);
    }
    let (part_a, part_b) = (&a.shape.parts[parts[0] as usize], &b.shape.parts[parts[1] as usize]);
    along - a.support_value(part_a, axis) - b.support_value(part_b, &-axis)
}

/// Where two bodies touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartContact {
    /// Unit normal from the first to the second, in the world.
    pub(crate) normal: Vec3,
    /// Overlap (m); negative where bodies within reach are apart.
    pub(crate) overlap: f64,
    /// Contact point from the centre of the first part, in the world (m).
    pub(crate) point: Vec3,
    /// Whether the cores overlap and the penetration routine answered.
    pub(crate) is_deep_penetration: bool,
}

/// What a query of two bodies found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Meeting {
    /// They are apart; the normal of a plane between them, towards the second, of any length, in the world.
    Apart(Vec3),
    Touching(PartContact),
}

impl Meeting {
    /// That of the first body as it is, which was swollen by `reach` (m): the overlap may be negative.
    pub(crate) fn shrunk(self, reach: f64) -> Self {
        match self {
            Self::Apart(_) => self,
            Self::Touching(contact) => Self::Touching(PartContact {
                overlap: contact.overlap - reach,
                point: contact.point - contact.normal * (0.5 * reach),
                ..contact
            }),
        }
    }
}

/// Meeting of a part with another core placed in its frame: δ = r1 + r2 − d (thesis eqs 3.14-3.16).
///
/// `other_crust` is in metres. The contact point is midway between the two deepest surface points. Beyond a gap of
/// `slack` (m) any plane that proves it will do.
#[inline(always)]
pub(crate) fn touch(
    part: &PlacedPart,
    other: &Core,
    placement: &Placement,
    other_crust: f64,
    slack: f64,
    simplex: &mut Simplex,
) -> Result<Meeting, GjkError> {
    let crusts = part.crust + other_crust;
    let cutoff = (crusts + slack) / part.scale;
    let (gap, normal, point_a, point_b, is_deep_penetration) =
        match distance(part.core, other, placement, cutoff, simplex)? {
            Separation::Beyond { axis } => return Ok(Meeting::Apart(part.rotation * axis)),
            Separation::Apart { distance, normal, point_a, point_b } => {
                (distance, normal, point_a, point_b, false)
            }
            Separation::Meeting => {
                let p = penetration(part.core, other, placement, simplex)?;
                (-p.depth, p.normal, p.point_a, p.point_b, true)
            }
        };
    let overlap = crusts - gap * part.scale;
    if overlap <= 0.0 {
        return Ok(Meeting::Apart(part.rotation * normal));
    }
    let normal = part.rotation * normal;
    let point = part.rotation * (point_a + point_b) * (0.5 * part.scale)
        + between_surfaces(part, other_crust, &normal);
    Ok(Meeting::Touching(PartContact { normal, overlap, point, is_deep_penetration }))
}

/// From between the cores to between the surfaces.
#[inline(always)]
fn between_surfaces(part: &PlacedPart, other_crust: f64, normal: &Vec3) -> Vec3 {
    normal * (0.5 * (part.crust - other_crust))
}

/// Patch in which a part and another core touch, if not in a point; the contact becomes that of its centre.
pub(crate) fn contact_patch(
    part: &PlacedPart,
    other: &Core,
    placement: &Placement,
    other_crust: f64,
    contact: &mut PartContact,
) -> Option<ContactPatch> {
    let crusts = part.crust + other_crust;
    let gap = (crusts - contact.overlap) / part.scale;
    let normal = part.rotation.tr_mul(&contact.normal);
    let found = ContactPatch::of_cores(part.core, other, placement, &normal, gap, crusts / part.scale)?;
    // On a triangle it may be a corner of a face that lies on the neighbours too.
    if found.is_one_corner() && !matches!(other, Core::Triangle(_)) {
        return None;
    }
    let mut footprint = found.moved(&part.rotation, part.scale, &Vec3::zeros());
    let ContactPatch { normal, overlap, .. } = footprint;
    footprint.center += between_surfaces(part, other_crust, &normal);
    (contact.normal, contact.overlap, contact.point) = (normal, overlap, footprint.center);
    Some(footprint)
}

/// Meeting of two parts placed in the frame of the first; its point is taken from the centre of the first.
#[inline(always)]
pub(crate) fn meet_parts(
    a: &PlacedPart,
    b: &PlacedPart,
    placement: &Placement,
    simplex: &mut Simplex,
) -> Result<Meeting, GjkError> {
    let (Some(vertices), Some(others)) = (a.vertices, b.vertices) else {
        return touch(a, b.core, placement, b.crust, SLACK * a.bounding_radius, simplex);
    };
    Ok(match vertices.contact(others, placement) {
        None => Meeting::Apart(a.rotation * placement.translation),
        Some(found) => Meeting::Touching(PartContact {
            normal: a.rotation * found.normal,
            overlap: found.overlap * a.scale,
            point: a.rotation * found.point * a.scale,
            is_deep_penetration: false,
        }),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use grains_geometry::{Mat3, Shape, Spacing};

    /// Two octahedra tip to tip: vertices lie on the sharp bodies, which extend farther than the rounded ones.
    #[test]
    fn no_plane_separates_bodies_whose_vertices_touch() {
        let shape = Shape::superellipsoid(Vec3::repeat(1.0), [2.0; 2], 0.1).unwrap();
        let sharp = shape.clone().with_surface_vertices(8, Spacing::Linear).unwrap();
        let (frame, between) = (Mat3::identity(), Vec3::z() * 1.99);
        let gap = |shape| {
            let pose = Pose { shape, frame: &frame, scale: 1.0 };
            let [a, b] = [0, 1].map(|_| PlacedPart::of(&pose, 0));
            let placement = a.placement(&b.rotation, 1.0, &between);
            let meeting = meet_parts(&a, &b, &placement, &mut Simplex::default()).unwrap();
            let touching = matches!(meeting, Meeting::Touching(_));
            (gap_across_plane(&[pose, pose], &[0, 0], &between, &Vec3::z()), touching)
        };
        let ((rounded, apart), (vertices, touching)) = (gap(&shape), gap(&sharp));
        assert!(rounded > 0.0 && !apart, "{rounded}");
        assert!(vertices <= 0.0 && touching, "{vertices}");
    }
}
