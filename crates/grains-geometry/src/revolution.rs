//! Surfaces of revolution: the turns of a profile about an axis, such as cones, hoppers, funnels and rings.

use crate::closed_surface::some_normal;
use crate::{SignedDistance, TriMesh, Vec3};
use std::f64::consts::TAU;

/// Distance over the size of the profile that counts as rounding (-).
const ROUNDING: f64 = 1e-12;

/// What a profile turned about an axis bounds.
///
/// A profile that comes back to where it starts bounds a ring. Any other one bounds what is between it and the axis. Where it ends
/// at some radius, and not on the axis, the surface goes on as a tube of that radius without end.
#[derive(Clone, Debug, PartialEq)]
pub struct Revolution {
    origin: Vec3,
    axis: Vec3,
    profile: Vec<[f64; 2]>,
    /// Length (m) that counts as rounding.
    rounding: f64,
}

/// A point of the half plane of the profile: heights along the axis, distances from it (m).
type Point = [f64; 2];

/// The nearest point of a piece of the profile.
struct Nearest {
    /// Way (m) to it.
    to: Point,
    squared: f64,
    /// Unit normal of the piece.
    normal: Point,
}

impl Revolution {
    /// The turns of `profile`, heights above `origin` along `axis` (a unit vector) and distances from it (m), two and more.
    pub fn new(origin: Vec3, axis: Vec3, profile: Vec<[f64; 2]>) -> Self {
        let size = profile.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
        Self { origin, axis, profile, rounding: ROUNDING * size }
    }

    /// Whether the profile comes back to its start.
    pub fn is_ring(&self) -> bool {
        self.profile.first() == self.profile.last()
    }

    /// Heights (m) at which it goes on as a tube, and to which side: up the axis, 1, or down, −1.
    fn tubes(&self) -> impl Iterator<Item = (Point, f64)> + '_ {
        let (first, last) = (self.profile[0], self.profile[self.profile.len() - 1]);
        let up = if last[0] >= first[0] { 1.0 } else { -1.0 };
        let is_open = move |end: &(Point, f64)| end.0[1] > 0.0;
        [(first, -up), (last, up)].into_iter().filter(move |end| !self.is_ring() && is_open(end))
    }

    /// Where a point (m) lies.
    pub fn signed_distance(&self, point: &Vec3) -> SignedDistance {
        let from = point - self.origin;
        let along = from.dot(&self.axis);
        let off = from - self.axis * along;
        let distance = off.norm();
        let radial = if distance > 0.0 { off / distance } else { some_normal(&self.axis) };
        let at = [along, distance];
        let pieces = self.profile.windows(2).map(|piece| on_segment(at, [piece[0], piece[1]]));
        let tubes = self.tubes().map(|(end, side)| on_ray(at, end, side));
        // The first of those as near; there is one.
        let nearest = pieces.chain(tubes).reduce(|a, b| if b.squared < a.squared { b } else { a });
        let Some(Nearest { to, squared, normal }) = nearest else {
            return SignedDistance { distance: f64::INFINITY, outward: radial };
        };
        let sign = if self.holds(at) { -1.0 } else { 1.0 };
        let length = squared.sqrt();
        let outward = match length > self.rounding {
            true => to.map(|x| -sign * x / length),
            // On the surface the way to it is rounding: outward is the side of the normal that does not lie inside.
            false => {
                let beside = [0, 1].map(|k| at[k] + normal[k] * 1e3 * self.rounding);
                let sign = if self.holds(beside) { -1.0 } else { 1.0 };
                normal.map(|x| sign * x)
            }
        };
        SignedDistance { distance: sign * length, outward: self.axis * outward[0] + radial * outward[1] }
    }

    /// Whether a point of the half plane is inside: the way from it straight away from the axis crosses the surface an odd
    /// number of times.
    fn holds(&self, at: Point) -> bool {
        let is_crossed = |piece: &[Point]| {
            let [a, b] = [piece[0], piece[1]];
            (a[0] > at[0]) != (b[0] > at[0]) && a[1] + (at[0] - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) > at[1]
        };
        let crossed = self.profile.windows(2).filter(|piece| is_crossed(piece)).count();
        // As of a piece that begins at the end and goes on without end.
        let is_on = |(end, side): &(Point, f64)| (end[0] > at[0]) != (*side > 0.0) && end[1] > at[1];
        let on_tubes = self.tubes().filter(is_on).count();
        (crossed + on_tubes) % 2 == 1
    }

    /// Corners (m) of a box that holds it; none if it has no end.
    pub fn extents(&self) -> Option<[Vec3; 2]> {
        if self.tubes().next().is_some() {
            return None;
        }
        let across = self.axis.map(|n| (1.0 - n * n).max(0.0).sqrt());
        let ends = self.profile.iter().map(|[along, radius]| {
            let center = self.origin + self.axis * *along;
            [center - across * *radius, center + across * *radius]
        });
        ends.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])])
    }

    /// Triangles of the profile's turns, `facets` of them about the axis, whose normals point outward. Sections of the mesh have the
    /// area of those of the surface. Tubes in which the profile goes on are left out.
    pub fn mesh(&self, facets: u32) -> TriMesh {
        let angle = TAU / f64::from(facets);
        // Of a polygon with corners on a circle the area is smaller than the circle's.
        let wider = (angle / libm::sin(angle)).sqrt();
        let first = some_normal(&self.axis);
        let second = self.axis.cross(&first);
        let mut mesh = TriMesh::default();
        let is_ring = self.is_ring();
        let distinct = self.profile.len() - usize::from(is_ring);
        let circles: Vec<Vec<u32>> = self.profile[..distinct]
            .iter()
            .map(|&[along, radius]| {
                let center = self.origin + self.axis * along;
                let start = mesh.vertices.len() as u32;
                if radius == 0.0 {
                    mesh.vertices.push(center);
                    return vec![start; facets as usize];
                }
                mesh.vertices.extend((0..facets).map(|k| {
                    let (sin, cos) = libm::sincos(f64::from(k) * angle);
                    center + (first * cos + second * sin) * (radius * wider)
                }));
                (start..start + facets).collect()
            })
            .collect();
        let is_outward = self.is_outward();
        for piece in 0..self.profile.len() - 1 {
            let [lower, upper] = [piece, (piece + 1) % distinct].map(|k| &circles[k]);
            for k in 0..facets as usize {
                let next = (k + 1) % facets as usize;
                for triangle in [[lower[k], lower[next], upper[next]], [lower[k], upper[next], upper[k]]] {
                    let [a, b, c] = triangle;
                    if a != b && b != c && c != a {
                        mesh.triangles.push(if is_outward { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        mesh
    }

    /// Whether the normals (−r', z') of the profile z(s), r(s) point outward.
    fn is_outward(&self) -> bool {
        // Of the middle of the longest piece.
        let length = |p: &[Point]| libm::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1]);
        let longest = self.profile.windows(2).max_by(|a, b| length(a).total_cmp(&length(b)));
        longest.is_none_or(|piece| {
            let [a, b] = [piece[0], piece[1]];
            let size = length(piece).min(a[1].max(b[1]));
            let step = 1e-6 * size / length(piece);
            let beside =
                [0.5 * (a[0] + b[0]) - (b[1] - a[1]) * step, 0.5 * (a[1] + b[1]) + (b[0] - a[0]) * step];
            !self.holds(beside)
        })
    }
}

/// The nearest point of a straight piece of the profile.
fn on_segment(at: Point, [a, b]: [Point; 2]) -> Nearest {
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let part = ((at[0] - a[0]) * along[0] + (at[1] - a[1]) * along[1]) / squared;
    // Its ends exactly, so that pieces that share one are as near.
    let point = match part {
        _ if part <= 0.0 => a,
        _ if part >= 1.0 => b,
        _ => [a[0] + part * along[0], a[1] + part * along[1]],
    };
    let length = squared.sqrt();
    nearest(at, point, [-along[1] / length, along[0] / length])
}

/// The nearest point of a tube without end.
fn on_ray(at: Point, end: Point, side: f64) -> Nearest {
    let beyond = if (at[0] - end[0]) * side > 0.0 { at[0] } else { end[0] };
    nearest(at, [beyond, end[1]], [0.0, 1.0])
}

fn nearest(at: Point, point: Point, normal: Point) -> Nearest {
    let to = [point[0] - at[0], point[1] - at[1]];
    Nearest { to, squared: to[0] * to[0] + to[1] * to[1], normal }
}
