//! The contact of a convex body with a surface of a wall.

use crate::narrow_phase::{PartContact, PlacedPart};
use grains_geometry::{ContactPatch, DiscreteSurface, Vec3};

/// Contact of a convex body with a surface, in the wall's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceContact {
    /// Unit normal from the body into the wall.
    pub(crate) normal: Vec3,
    /// Overlap (m); negative where a body within reach is apart.
    pub(crate) overlap: f64,
    /// Contact point (m).
    pub(crate) point: Vec3,
    /// Where the body touches if not in a point.
    pub(crate) footprint: Option<ContactPatch>,
}

/// What a look at a part of a body and an element of a surface found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PartMeeting {
    Touching(SurfaceContact),
    /// They do not; how far (m) they are apart at least, if positive.
    Apart(f64),
}

impl PartMeeting {
    /// No contact, at an unknown distance.
    pub(super) const NONE: Self = Self::Apart(0.0);

    /// The contact, if they touch.
    pub(crate) fn contact(self) -> Option<SurfaceContact> {
        if let Self::Touching(contact) = self { Some(contact) } else { None }
    }
}

/// Contact of a sphere with a surface, in the wall's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereTouch {
    /// Unit normal from the sphere into the wall.
    pub(crate) normal: Vec3,
    /// Overlap (m); negative where a sphere within reach is apart.
    pub(crate) overlap: f64,
}

impl SphereTouch {
    /// The same of a sphere at `center` (m) as a contact of any body.
    pub(super) fn contact(&self, center: &Vec3, radius: f64) -> SurfaceContact {
        SurfaceContact::new(center + self.normal * radius, self.normal, self.overlap, None)
    }
}

impl SurfaceContact {
    /// Contact of a body whose surface lies `overlap` behind the wall at `deepest`.
    #[inline(always)]
    pub(crate) fn new(deepest: Vec3, normal: Vec3, overlap: f64, footprint: Option<ContactPatch>) -> Self {
        Self { normal, overlap, point: deepest - normal * (0.5 * overlap), footprint }
    }

    /// Contact that was found of a part at `center` (m), which it points from.
    pub(super) fn found(found: &PartContact, center: &Vec3, footprint: Option<ContactPatch>) -> Self {
        let PartContact { normal, overlap, point, .. } = *found;
        Self { normal, overlap, point: center + point, footprint }
    }

    /// That of the body as it is, which was swollen by `reach` (m): the overlap may be negative.
    pub(super) fn shrunk(self, reach: f64) -> Self {
        let point = self.point - self.normal * (0.5 * reach);
        Self { overlap: self.overlap - reach, point, ..self }
    }

    /// The same contact over a patch of the core, which is swept by a ball of radius `crust`.
    pub(super) fn over(self, footprint: Option<ContactPatch>, crust: f64) -> Self {
        let Some(ContactPatch { center, overlap, .. }) = footprint else { return self };
        Self::new(center + self.normal * crust, self.normal, overlap, footprint)
    }

    /// Two contacts with one flat patch: the deeper, or both footprints together.
    pub(crate) fn joined(&self, other: &Self) -> Self {
        let deeper = if self.overlap >= other.overlap { self } else { other };
        match (&self.footprint, &other.footprint) {
            (Some(a), Some(b)) => {
                let joined = a.joined(b);
                // The point lies as far off the centre of the joined patch as off that of its own.
                let point = self.point + joined.center - a.center;
                Self { normal: joined.normal, overlap: joined.overlap, point, footprint: Some(joined) }
            }
            // A triangle touched in one point adds nothing to a face that lies on its neighbours.
            (Some(_), None) => *self,
            (None, Some(_)) => *other,
            (None, None) => *deeper,
        }
    }

    /// Contact of the core point `deepest` of a part lying `depth` (m) behind a wall (negative before it), whose
    /// inward normal is `normal`: the surface of the body lies a crust farther.
    pub(super) fn behind(part: &PlacedPart, deepest: &Vec3, normal: Vec3, depth: f64) -> Option<Self> {
        let overlap = depth + part.crust;
        (overlap > 0.0).then(|| Self::new(deepest + normal * part.crust, normal, overlap, None))
    }

    /// Contact of the vertices of a part, at `center` (m), that lie behind a plane (Srinivasan 2019, 2.36-2.41).
    pub(super) fn of_vertices(
        part: &PlacedPart,
        vertices: &DiscreteSurface,
        center: &Vec3,
        point: &Vec3,
        normal: &Vec3,
    ) -> Option<Self> {
        let local = part.rotation.tr_mul(&(point - center)) / part.scale;
        let found = vertices.contact_with_plane(&local, &part.rotation.tr_mul(normal))?;
        Some(Self {
            normal: -normal,
            overlap: found.overlap * part.scale,
            point: center + part.rotation * found.point * part.scale,
            footprint: None,
        })
    }
}
