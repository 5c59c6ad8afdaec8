//! Convex parts where they are now: placement, the planes that part them, and their contact.

use crate::walls::SurfaceContact;
use crate::{Body, Catalogue, Particles};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{
    ContactPatch, Core, DiscreteSurface, GjkError, Mat3, Part, Placement, Shape, Simplex, Vec3,
};

/// A part of a particle where it is now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedPart<'a> {
    pub(crate) core: &'a Core,
    /// Rotation from the part's frame.
    pub(crate) rotation: Mat3,
    pub(crate) scale: f64,
    /// Part centre from the particle's centre of mass, in the world frame (m).
    pub(crate) offset: Vec3,
    /// Crust (m), scaled.
    pub(crate) crust: f64,
    /// Radius of a ball about the part's centre that holds it (m), scaled.
    pub(crate) bounding_radius: f64,
    /// Vertices that find contacts in place of the core (Srinivasan 2019, section 2.4).
    pub(crate) vertices: Option<&'a DiscreteSurface>,
}

/// Whether a part has the frame of its particle: single round bodies and boxes are centred on their principal
/// axes, where polyhedra have a box of their own.
#[inline(always)]
fn has_frame_of_particle(shape: &Shape, part: &Part) -> bool {
    shape.parts.len() == 1 && !matches!(part.core, Core::Polyhedron(_))
}

/// How a particle lies: its shape, rotation from its frame, and scale.
#[derive(Clone, Copy)]
pub(crate) struct Pose<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) frame: &'a Mat3,
    pub(crate) scale: f64,
}

impl<'a> Pose<'a> {
    /// How particle `i` lies.
    #[inline(always)]
    pub(crate) fn of(particles: &'a Particles, i: usize, catalogue: &'a Catalogue) -> Self {
        Self::of_body(&particles.bodies[i], &particles.frames[i], catalogue)
    }

    /// How a body with a frame lies.
    #[inline(always)]
    pub(crate) fn of_body(body: &Body, frame: &'a Mat3, catalogue: &'a Catalogue) -> Self {
        let shape = catalogue.shape(body.kind);
        Self { shape, frame, scale: body.radius / shape.bounding_radius }
    }

    /// Radius of the largest ball about the centre within the body (m).
    #[inline(always)]
    pub(crate) fn inscribed_radius(&self) -> f64 {
        self.shape.inscribed_radius * self.scale
    }

    /// Inverse of the mass (1/kg) that a body of `mass` (kg) sets against a push along the unit `normal` at `arm` (m) from its
    /// centre of mass: 1/m + (r × n)·I⁻¹(r × n).
    ///
    /// Damping by this mass, not by m itself, gives an off-centre hit the restitution of the law.
    #[inline(always)]
    pub(crate) fn inverse_mass_along(&self, mass: f64, arm: &Vec3, normal: &Vec3) -> f64 {
        let lever = self.frame.tr_mul(&arm.cross(normal));
        // Σ l²/I on one denominator: divisions are what this costs. I is that of the shape at unit density, I m/V s².
        let [p, q, r] = self.shape.inertia.into();
        let squares = lever.component_mul(&lever);
        let turned = (squares.x * q + squares.y * p) * r + squares.z * (p * q);
        let whole = p * q * r * (self.scale * self.scale);
        (whole + self.shape.volume * turned) / (whole * mass)
    }

    /// How far a part reaches from the particle's centre along a unit direction (m).
    #[inline(always)]
    fn reach(&self, part: &Part, direction: &Vec3) -> f64 {
        let direction = self.frame.tr_mul(direction);
        let of_core = if has_frame_of_particle(self.shape, part) {
            part.core.support_value(&direction)
        } else {
            direction.dot(&part.center) + part.core.support_value(&part.rotation.tr_mul(&direction))
        };
        (of_core + part.crust) * self.scale
    }

    /// How far the body of surface vertices reaches, whose edges and tips no crust rounds (m).
    fn reach_of_vertices(&self, vertices: &DiscreteSurface, direction: &Vec3) -> f64 {
        vertices.reach(&self.frame.tr_mul(direction)) * self.scale
    }
}

/// Gap up to which bodies are parted by the plane that lasts longest, that of the nearest points, relative to a body.
const SLACK: f64 = 0.05;
/// Share of the size of a pair by which a plane must part it, so that no query can find what touches there.
const CLEARANCE: f64 = 1e-11;

/// Gap (m) of two parts, of particles whose centres are `separation` (m) apart, across a plane of unit normal `axis`.
///
/// If positive it is a proof: no distance query would find that they touch.
#[inline(always)]
pub(crate) fn gap_across(poses: &[Pose; 2], parts: &[u16; 2], separation: &Vec3, axis: &Vec3) -> f64 {
    let [a, b] = poses;
    let size = a.scale * a.shape.bounding_radius + b.scale * b.shape.bounding_radius;
    let along = separation.dot(axis) - CLEARANCE * size;
    if let (Some(of_a), Some(of_b)) = (&a.shape.discrete, &b.shape.discrete) {
        return along - a.reach_of_vertices(of_a, axis) - b.reach_of_vertices(of_b, &-axis);
    }
    let (part_a, part_b) = (&a.shape.parts[parts[0] as usize], &b.shape.parts[parts[1] as usize]);
    along - a.reach(part_a, axis) - b.reach(part_b, &-axis)
}

impl<'a> PlacedPart<'a> {
    #[inline(always)]
    pub(crate) fn of(pose: &Pose<'a>, part: u16) -> Self {
        let Pose { shape, frame, scale } = *pose;
        let part = &shape.parts[part as usize];
        let (rotation, offset) = if has_frame_of_particle(shape, part) {
            (*frame, Vec3::zeros())
        } else {
            (frame * part.rotation, frame * part.center * scale)
        };
        let crust = part.crust * scale;
        let (bounding_radius, vertices) = (part.bounding_radius * scale, shape.discrete.as_deref());
        Self { core: &part.core, rotation, scale, offset, crust, bounding_radius, vertices }
    }

    /// Point of the core farthest along a direction, from the part's centre (m).
    pub(crate) fn farthest(&self, direction: &Vec3) -> Vec3 {
        self.rotation * self.core.support(&self.rotation.tr_mul(direction)) * self.scale
    }

    /// Point of the core farthest from an axis through the origin, the part's centre being at `center`:
    /// the point from that centre, its unit direction away from the axis, and its distance (m).
    pub(crate) fn farthest_from_axis(&self, center: &Vec3, axis: &Vec3) -> (Vec3, Vec3, f64) {
        let local = self.rotation.tr_mul(center) / self.scale;
        let point =
            self.rotation * self.core.farthest_from_axis(&local, &self.rotation.tr_mul(axis)) * self.scale;
        let from = center + point;
        let off = from - axis * from.dot(axis);
        let distance = off.norm();
        (point, if distance > 0.0 { off / distance } else { Vec3::zeros() }, distance)
    }

    /// Contact of the core point `deepest` lying `depth` (m) behind a wall (negative before it), whose
    /// inward normal is `normal`: the body reaches a crust farther.
    pub(crate) fn contact_behind(&self, deepest: &Vec3, normal: Vec3, depth: f64) -> Option<SurfaceContact> {
        let overlap = depth + self.crust;
        (overlap > 0.0).then(|| SurfaceContact::new(deepest + normal * self.crust, normal, overlap, None))
    }

    /// Contact of the vertices of a part, at `center` (m), that lie behind a plane (Srinivasan 2019, 2.36-2.41).
    pub(crate) fn vertices_behind(
        &self,
        vertices: &DiscreteSurface,
        center: &Vec3,
        point: &Vec3,
        normal: &Vec3,
    ) -> Option<SurfaceContact> {
        let local = self.rotation.tr_mul(&(point - center)) / self.scale;
        let found = vertices.contact_with_plane(&local, &self.rotation.tr_mul(normal))?;
        Some(SurfaceContact {
            normal: -normal,
            overlap: found.overlap * self.scale,
            point: center + self.rotation * found.point * self.scale,
            footprint: None,
        })
    }

    /// ContactPatch on a wall deepest along `normal`, where `gap` is the distance (m) before it of a point given
    /// from the part's centre; the footprint's centre is on the core, in the frame `center` (m) is in.
    pub(crate) fn footprint(
        &self,
        center: &Vec3,
        normal: &Vec3,
        gap: impl Fn(&Vec3) -> f64,
    ) -> Option<ContactPatch> {
        let local = |p: &Vec3| gap(&(self.rotation * p * self.scale)) / self.scale;
        let direction = self.rotation.tr_mul(normal);
        let found = ContactPatch::on_surface(self.core, &direction, self.crust / self.scale, local)?;
        Some(found.moved(&self.rotation, self.scale, center))
    }

    /// Placement of another frame (its rotation, scale, and centre from ours in the world) in this part's.
    #[inline]
    pub(crate) fn placement(&self, rotation: &Mat3, scale: f64, separation: &Vec3) -> Placement {
        let inverse = 1.0 / self.scale;
        Placement {
            matrix: self.rotation.tr_mul(rotation) * (scale * inverse),
            translation: self.rotation.tr_mul(separation) * inverse,
        }
    }
}

/// Where two bodies touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartContact {
    /// Unit normal from the first to the second, in the world.
    pub(crate) normal: Vec3,
    /// Overlap (m), positive.
    pub(crate) overlap: f64,
    /// Contact point from the centre of the first part, in the world (m).
    pub(crate) point: Vec3,
    /// Whether the cores met and the penetration routine answered.
    pub(crate) cores_met: bool,
}

/// What a query of two bodies found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Meeting {
    /// They are apart; the normal of a plane between them, towards the second, of any length, in the world.
    Apart(Vec3),
    Touching(PartContact),
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
    let (gap, normal, point_a, point_b, cores_met) =
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
    Ok(Meeting::Touching(PartContact { normal, overlap, point, cores_met }))
}

/// From between the cores to between the surfaces.
#[inline(always)]
fn between_surfaces(part: &PlacedPart, other_crust: f64, normal: &Vec3) -> Vec3 {
    normal * (0.5 * (part.crust - other_crust))
}

/// Where a part and another core, which touch, do so if not in a point; the contact becomes that of its centre.
pub(crate) fn spread(
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
    let mut footprint = found.moved(&part.rotation, part.scale, &Vec3::zeros());
    let ContactPatch { normal, overlap, .. } = footprint;
    footprint.center += between_surfaces(part, other_crust, &normal);
    (contact.normal, contact.overlap, contact.point) = (normal, overlap, footprint.center);
    Some(footprint)
}

/// Meeting of two parts placed in the frame of the first; its point is taken from the centre of the first.
#[inline(always)]
pub(super) fn meet_parts(
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
            cores_met: false,
        }),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use grains_geometry::Spacing;

    /// Two octahedra tip to tip: vertices lie on the sharp bodies, which reach farther than the rounded ones.
    #[test]
    fn no_plane_parts_bodies_whose_vertices_touch() {
        let shape = Shape::superellipsoid(Vec3::repeat(1.0), [2.0; 2], 0.1).unwrap();
        let sharp = shape.clone().with_surface_vertices(8, Spacing::Linear).unwrap();
        let (frame, between) = (Mat3::identity(), Vec3::z() * 1.99);
        let gap = |shape| {
            let pose = Pose { shape, frame: &frame, scale: 1.0 };
            let [a, b] = [0, 1].map(|_| PlacedPart::of(&pose, 0));
            let placement = a.placement(&b.rotation, 1.0, &between);
            let meeting = meet_parts(&a, &b, &placement, &mut Simplex::default()).unwrap();
            let touching = matches!(meeting, Meeting::Touching(_));
            (gap_across(&[pose, pose], &[0, 0], &between, &Vec3::z()), touching)
        };
        let ((rounded, apart), (vertices, touching)) = (gap(&shape), gap(&sharp));
        assert!(rounded > 0.0 && !apart, "{rounded}");
        assert!(vertices <= 0.0 && touching, "{vertices}");
    }
}
