//! The contact of two convex parts, and the planes that separate them.

use super::placed_part::{PlacedPart, Pose, SweptFrame};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{
    ContactPatch, Core, GjkError, Mat3, Nearest, Placement, Simplex, TouchesInAPoint, Vec3, WallMesh,
};

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

/// The widest of the gaps (m) of two parts across planes normal to some axes, of any length, and the unit normal of that plane.
pub(crate) fn widest_gap(
    poses: &[Pose; 2],
    parts: &[u16; 2],
    separation: &Vec3,
    axes: &[Vec3],
) -> (f64, Vec3) {
    let across = |axis: &Vec3| {
        let normal = axis * (1.0 / axis.norm());
        (gap_across_plane(poses, parts, separation, &normal), normal)
    };
    let wider = |a: (f64, Vec3), b: (f64, Vec3)| if b.0 > a.0 { b } else { a };
    axes.iter().map(across).fold((f64::NEG_INFINITY, Vec3::x()), wider)
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
    let cutoff = (part.crust + other_crust + slack) / part.scale;
    let found = distance(part.core, other, placement, cutoff, simplex)?;
    let frame = part.swept_frame();
    if let Some(meeting) = across_gap(&frame, other_crust, &found) {
        return Ok(meeting);
    }
    let p = penetration(part.core, other, placement, simplex)?;
    Ok(at_nearest_points(&frame, other_crust, (-p.depth, &p.normal), (p.point_a + p.point_b, true)))
}

/// Whether a part touches another one placed in its frame; one whose distance cannot be found is taken to.
pub(crate) fn overlaps(part: &PlacedPart, other: &PlacedPart, placement: &Placement) -> bool {
    let crusts = part.crust + other.crust;
    match distance(part.core, other.core, placement, crusts / part.scale, &mut Simplex::default()) {
        Ok(Separation::Apart { distance, .. }) => crusts - distance * part.scale > 0.0,
        Ok(Separation::Beyond { .. }) => false,
        Ok(Separation::Meeting) | Err(_) => true,
    }
}

/// Meeting of a part with another core whose distance was found; `None` if the cores meet.
#[inline(always)]
pub(crate) fn across_gap(frame: &SweptFrame, other_crust: f64, found: &Separation) -> Option<Meeting> {
    match found {
        Separation::Beyond { axis } => Some(Meeting::Apart(frame.rotation * axis)),
        Separation::Apart { distance, normal, point_a, point_b } => {
            Some(at_nearest_points(frame, other_crust, (*distance, normal), (point_a + point_b, false)))
        }
        Separation::Meeting => None,
    }
}

/// Meeting across a gap of the cores along a normal, with the sum of their nearest points, in the frame of the part; whether it is of a
/// deep penetration.
#[inline(always)]
fn at_nearest_points(
    frame: &SweptFrame,
    other_crust: f64,
    (gap, normal): (f64, &Vec3),
    (points, is_deep_penetration): (Vec3, bool),
) -> Meeting {
    let SweptFrame { rotation, scale, crust } = frame;
    let overlap = crust + other_crust - gap * scale;
    let normal = turned(rotation, normal);
    if overlap <= 0.0 {
        return Meeting::Apart(normal);
    }
    let point = turned(rotation, &points) * (0.5 * scale) + between_surfaces([*crust, other_crust], &normal);
    Meeting::Touching(PartContact { normal, overlap, point, is_deep_penetration })
}

/// A vector in the frame that a rotation leads to; nalgebra's product is a call of its own.
#[inline(always)]
fn turned(rotation: &Mat3, vector: &Vec3) -> Vec3 {
    rotation.column(0) * vector.x + rotation.column(1) * vector.y + rotation.column(2) * vector.z
}

/// From between the cores to between the surfaces.
#[inline(always)]
fn between_surfaces([crust, other]: [f64; 2], normal: &Vec3) -> Vec3 {
    normal * (0.5 * (crust - other))
}

/// Patch in which a part and another core touch, if not in a point; the contact becomes that of its centre.
pub(crate) fn contact_patch(
    part: &PlacedPart,
    other: &Core,
    placement: &Placement,
    other_crust: f64,
    contact: &mut PartContact,
) -> Option<ContactPatch> {
    let (crusts, inverse) = (part.crust + other_crust, 1.0 / part.scale);
    let between_cores = contact.point - between_surfaces([part.crust, other_crust], &contact.normal);
    let nearest = Nearest {
        normal: part.rotation.tr_mul(&contact.normal),
        point: part.rotation.tr_mul(&between_cores) * inverse,
        gap: (crusts - contact.overlap) * inverse,
        crusts: crusts * inverse,
    };
    let found = ContactPatch::of_cores(part.core, other, placement, &nearest)?;
    let mut footprint = found.moved(&part.rotation, part.scale, &Vec3::zeros());
    let ContactPatch { normal, overlap, .. } = footprint;
    footprint.center += between_surfaces([part.crust, other_crust], &normal);
    (contact.normal, contact.overlap, contact.point) = (normal, overlap, footprint.center);
    Some(footprint)
}

/// Contact of a part at `center` (m) with a triangle of a mesh, over the patch that no other triangle bears.
///
/// `point` is that of the nearest points; `Err` if the part touches in points only.
pub(crate) fn patch_on_triangle(
    part: &PlacedPart,
    center: &Vec3,
    on: (&WallMesh, u32),
    (contact, point): (&PartContact, &Vec3),
) -> Result<Option<ContactPatch>, TouchesInAPoint> {
    let PartContact { normal, overlap, .. } = *contact;
    let point = point - between_surfaces([part.crust, 0.0], &normal);
    let nearest = Nearest { normal, point, gap: part.crust - overlap, crusts: part.crust };
    let placement = Placement { matrix: part.rotation * part.scale, translation: *center };
    let patch = ContactPatch::on_triangle(part.core, &placement, on, &nearest)?;
    Ok(patch.map(|patch| {
        let center = patch.center + between_surfaces([part.crust, 0.0], &patch.normal);
        ContactPatch { center, ..patch }
    }))
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
