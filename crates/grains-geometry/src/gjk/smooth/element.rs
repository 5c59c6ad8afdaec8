//! Vertices, edges and faces of polyhedral cores and rim, side and ends of cylinders, as they face a superellipsoid.

use super::super::nearest::on_triangle;
use crate::convex::{NO_DIRECTION, Rims, Support};
use crate::{Placement, Vec3};

/// Cosine between points of a circle above which they mark one point of it, below which a disc.
const SAME_POINT: f64 = 0.9;
/// Squared sine of the angle with the axis below which a point is far along it.
const NEAR_AXIS: f64 = 1e-6;
/// The same below which rounding leaves no direction away from the axis.
const ON_AXIS: f64 = 1e-28;
/// Points of a circle that mark its disc, as cosine and sine.
const DISC: [[f64; 2]; 3] = [[1.0, 0.0], [-0.5, 0.866_025_403_784_438_6], [-0.5, -0.866_025_403_784_438_6]];

/// What faces the superellipsoid, in its frame (m).
#[derive(Clone, Copy)]
pub(super) enum Element {
    Vertex(Vec3),
    Edge([Vec3; 2]),
    Face([Vec3; 3]),
    /// Side of a cylinder: its axis from end to end, and the radius.
    Side([Vec3; 2], f64),
    /// Edge of a cylinder: centre, unit axis, radius.
    Rim([Vec3; 2], f64),
    /// End of a cylinder: centre, unit axis, radius.
    End([Vec3; 2], f64),
}

impl Element {
    /// The element that points of the core mark; `None` if they mark none.
    #[inline(always)]
    pub(super) fn of<B: Support>(core: &B, points: &[Vec3], placement: &Placement) -> Option<Self> {
        if let Some(cylinder) = core.rims() {
            return Self::of_cylinder(&cylinder, points, placement);
        }
        if B::CURVED {
            return None;
        }
        let (count, distinct) = distinct(points)?;
        let [p, q, r] = distinct.map(|point| placement.apply(&point));
        Some(match count {
            1 => Self::Vertex(p),
            2 => Self::Edge([p, q]),
            _ => Self::Face([p, q, r]),
        })
    }

    fn of_cylinder(cylinder: &Rims, points: &[Vec3], placement: &Placement) -> Option<Self> {
        let first = points[0];
        let limit = SAME_POINT * cylinder.radius * cylinder.radius;
        let one_end = points.iter().all(|p| p.z == first.z);
        let together = points.iter().all(|p| p.x * first.x + p.y * first.y >= limit);
        let scale = placement.matrix.column(0).norm();
        let radius = cylinder.radius * scale;
        let at = |z: f64| placement.apply(&Vec3::new(0.0, 0.0, z));
        let axis = || placement.matrix.column(2).into_owned() / scale;
        match (one_end, together) {
            (true, true) => Some(Self::Rim([at(first.z), axis()], radius)),
            (true, false) => Some(Self::End([at(first.z), axis()], radius)),
            (false, true) => Some(Self::Side([at(-cylinder.half_height), at(cylinder.half_height)], radius)),
            (false, false) => None,
        }
    }

    /// Length by which the element reaches beyond its skeleton, the axis of a cylinder for its side (m).
    #[inline(always)]
    pub(super) fn reach(&self) -> f64 {
        if let Self::Side(_, radius) = self { *radius } else { 0.0 }
    }

    /// Direction, from the origin, of the normal of a face or end.
    #[inline(always)]
    pub(super) fn plane(&self) -> Option<Vec3> {
        let (across, at) = match self {
            Self::Face([p, q, r]) => ((q - p).cross(&(r - p)), p),
            Self::End([center, axis], _) => (*axis, center),
            _ => return None,
        };
        Some(if across.dot(at) < 0.0 { -across } else { across })
    }

    /// The point of the skeleton nearest `from`; `None` if that is off its end.
    #[inline(always)]
    pub(super) fn nearest(&self, from: &Vec3) -> Option<Vec3> {
        match self {
            Self::Vertex(p) => Some(*p),
            Self::Edge([p, q]) | Self::Side([p, q], _) => {
                let edge = q - p;
                let t = (from - p).dot(&edge) / edge.norm_squared();
                (0.0..=1.0).contains(&t).then(|| p + edge * t)
            }
            Self::Face([p, q, r]) => {
                let found = on_triangle(&(p - from), &(q - from), &(r - from));
                found.weights[..3].iter().all(|weight| *weight > 0.0).then(|| from + found.point)
            }
            Self::Rim([center, axis], radius) => {
                let off = from - center;
                let mut radial = off - axis * axis.dot(&off);
                let (mut squared, whole) = (radial.norm_squared(), off.norm_squared());
                // Of a long way along the axis rounding leaves a part along it.
                if squared < NEAR_AXIS * whole {
                    radial -= axis * axis.dot(&radial);
                    squared = radial.norm_squared();
                }
                (squared > NO_DIRECTION && squared > ON_AXIS * whole)
                    .then(|| center + radial * (radius / squared.sqrt()))
            }
            Self::End([center, axis], radius) => {
                let off = from - center;
                let height = axis.dot(&off);
                let inside = (off - axis * height).norm_squared() <= radius * radius;
                inside.then(|| from - axis * height)
            }
        }
    }

    /// Tangent at the point x of a curve, of any length, and the curvature by which it turns towards the
    /// direction `n` (1/m).
    #[inline(always)]
    pub(super) fn tangent(&self, x: &Vec3, n: &Vec3) -> Option<(Vec3, f64)> {
        match self {
            Self::Edge([p, q]) | Self::Side([p, q], _) => Some((q - p, 0.0)),
            Self::Rim([center, axis], radius) => {
                let radial = x - center;
                Some((axis.cross(&radial), n.dot(&radial) / (radius * radius)))
            }
            _ => None,
        }
    }

    /// Points of the core, in its frame, that mark the element, given the point found on its skeleton and the
    /// normal there in the frame of the superellipsoid.
    #[inline(always)]
    pub(super) fn mark<B: Support>(
        &self,
        core: &B,
        points: &mut [Vec3; 4],
        len: usize,
        towards: &Vec3,
    ) -> Option<usize> {
        let Some(cylinder) = core.rims() else {
            let (count, distinct) = distinct(&points[..len])?;
            points[..3].copy_from_slice(&distinct);
            return Some(count);
        };
        let (radius, z) = (cylinder.radius, points[0].z);
        let [x, y] = [towards.x, towards.y].map(|c| c * radius / towards.xy().norm());
        Some(match self {
            Self::Side(..) => {
                let half = cylinder.half_height;
                (points[0], points[1]) = (Vec3::new(x, y, -half), Vec3::new(x, y, half));
                2
            }
            Self::End(..) => {
                for (point, [c, s]) in points.iter_mut().zip(DISC) {
                    *point = Vec3::new(radius * c, radius * s, z);
                }
                3
            }
            _ => {
                points[0] = Vec3::new(x, y, z);
                1
            }
        })
    }
}

/// The distinct ones of the points, if there are at most three.
#[inline(always)]
fn distinct(points: &[Vec3]) -> Option<(usize, [Vec3; 3])> {
    let mut own = [points[0]; 3];
    let mut count = 1;
    for point in &points[1..] {
        if own[..count].contains(point) {
            continue;
        }
        if count == 3 {
            return None;
        }
        own[count] = *point;
        count += 1;
    }
    Some((count, own))
}
