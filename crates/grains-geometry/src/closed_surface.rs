//! Closed surfaces by their signed distance.

use crate::{ClosedMesh, Revolution, Vec3};
use std::sync::Arc;

/// Relative difference of distances that counts as rounding.
const TIE: f64 = 1e-10;

/// Where a point lies seen from a closed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// Distance from the surface (m), negative inside.
    pub distance: f64,
    /// Unit vector along which it grows: at the surface its outward normal.
    pub outward: Vec3,
}

/// A closed surface.
#[derive(Clone, Debug)]
pub enum ClosedSurface {
    /// A plane, behind which everything is inside.
    Plane {
        /// A point of the plane (m).
        point: Vec3,
        /// Outward unit normal.
        normal: Vec3,
    },
    /// A circular cylinder with flat ends.
    Cylinder {
        /// Centre (m).
        center: Vec3,
        /// Unit vector of the axis.
        axis: Vec3,
        /// Radius (m).
        radius: f64,
        /// Half of the length (m), or infinity.
        half_length: f64,
    },
    /// A box along the axes.
    Box {
        /// Lower corner (m).
        lower: Vec3,
        /// Upper corner (m).
        upper: Vec3,
    },
    /// A closed mesh of outward triangles.
    Mesh(Arc<ClosedMesh>),
    /// A surface of revolution.
    Revolution(Revolution),
}

impl ClosedSurface {
    /// Where a point (m) lies. With `across`, the number of an axis along which nothing varies, faces normal to it do not count;
    /// of meshes and surfaces of revolution all do.
    pub fn signed_distance(&self, point: &Vec3, across: Option<usize>) -> SignedDistance {
        match self {
            Self::Plane { point: start, normal } => {
                SignedDistance { distance: (point - start).dot(normal), outward: *normal }
            }
            Self::Cylinder { center, axis, radius, half_length } => {
                let from = point - center;
                let along = from.dot(axis);
                let off = from - axis * along;
                let distance = off.norm();
                let radial = if distance > 0.0 { off / distance } else { some_normal(axis) };
                let ends = match across.is_some_and(|a| axis[a].abs() > 0.5) {
                    true => f64::NEG_INFINITY,
                    false => along.abs() - half_length,
                };
                beside(&[(distance - radius, radial), (ends, axis * along.signum())])
            }
            Self::Box { lower, upper } => {
                let face = |a: usize| {
                    let mut outward = Vec3::zeros();
                    let [below, above] = [lower[a] - point[a], point[a] - upper[a]];
                    outward[a] = if below > above { -1.0 } else { 1.0 };
                    (if across == Some(a) { f64::NEG_INFINITY } else { below.max(above) }, outward)
                };
                beside(&[0, 1, 2].map(face))
            }
            Self::Mesh(mesh) => mesh.signed_distance(point),
            Self::Revolution(revolution) => revolution.signed_distance(point),
        }
    }

    /// Corners (m) of a box that holds it; none if it has no end.
    pub fn extents(&self) -> Option<[Vec3; 2]> {
        match self {
            Self::Plane { .. } => None,
            Self::Cylinder { center, axis, radius, half_length } => {
                let reach = axis.map(|n| half_length * n.abs() + radius * (1.0 - n * n).max(0.0).sqrt());
                half_length.is_finite().then(|| [center - reach, center + reach])
            }
            Self::Box { lower, upper } => Some([*lower, *upper]),
            Self::Mesh(mesh) => Some(mesh.mesh().extents().into()),
            Self::Revolution(revolution) => revolution.extents(),
        }
    }
}

/// Signed distance from the intersection of solids whose faces lie at right angles, of the distances from each and their normals.
fn beside(faces: &[(f64, Vec3)]) -> SignedDistance {
    let outside: Vec3 = faces.iter().filter(|(d, _)| *d > 0.0).map(|(d, outward)| outward * *d).sum();
    let distance = outside.norm();
    if distance > 0.0 {
        return SignedDistance { distance, outward: outside / distance };
    }
    // Of faces as near, but for rounding, the first one.
    let deepest = |a: (f64, Vec3), b: &(f64, Vec3)| if b.0 - a.0 > TIE * b.0.abs() { *b } else { a };
    let (distance, outward) = faces[1..].iter().fold(faces[0], deepest);
    SignedDistance { distance, outward }
}

/// Some unit vector at a right angle to one.
pub(crate) fn some_normal(axis: &Vec3) -> Vec3 {
    axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize()
}
