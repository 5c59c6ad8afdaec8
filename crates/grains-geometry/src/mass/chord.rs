//! Where a line along x crosses a convex part with sharp edges.

use crate::mesh::leaders;
use crate::{ConvexHull, Core, Part, Superellipsoid, Vec3};

/// Corners closer than this are one (relative to the size of a polyhedron).
const COINCIDENT: f64 = 4e-9;
/// Halvings that look for a point of a line inside a superellipsoid; it is passed by if it is that flat there.
const HALVINGS: usize = 40;
/// Newton steps to an end of a chord, which approach it from outside.
const STEPS: usize = 100;
/// Step at which an end is found (relative to the size of the superellipsoid).
const FOUND: f64 = 1e-13;

/// A convex part with sharp edges, ready to be cut by lines along x.
pub(super) struct Solid<'a> {
    part: &'a Part,
    /// Direction of x in the part's frame.
    along: Vec3,
    /// Lower corner of the axis-aligned box around the part (m).
    pub lower: Vec3,
    /// Upper corner of that box (m).
    pub upper: Vec3,
}

impl<'a> Solid<'a> {
    pub fn new(part: &'a Part) -> Self {
        let (lower, upper) = sharp_extents(part);
        Self { part, along: part.rotation.row(0).transpose(), lower, upper }
    }

    /// Whether a line along x through a point can cross the part.
    pub fn meets_row(&self, point: &Vec3) -> bool {
        (1..3).all(|a| self.lower[a] <= point[a] && point[a] <= self.upper[a])
    }

    /// Where the line from `origin` along x enters and leaves the part, to rounding (m from the origin).
    pub fn chord(&self, origin: &Vec3) -> Option<(f64, f64)> {
        let (part, along) = (self.part, &self.along);
        let start = part.rotation.tr_mul(&(origin - part.center));
        match &part.core {
            Core::Point => within_ball(start.norm_squared(), start.dot(along), 1.0, part.crust),
            Core::Box(half) => (0..3).try_fold(WHOLE_LINE, |chord, a| {
                within_slab(chord, start[a], along[a], half[a] + part.crust)
            }),
            Core::Cylinder { radius, half_height } => {
                let (p, d) = (start.xy(), along.xy());
                let round = within_ball(p.norm_squared(), p.dot(&d), d.norm_squared(), radius + part.crust)?;
                within_slab(round, start.z, along.z, half_height + part.crust)
            }
            Core::Polyhedron(hull) => hull.faces().iter().try_fold(WHOLE_LINE, |chord, face| {
                let room = face.offset + part.crust - face.normal.dot(&start);
                below(chord, face.normal.dot(along), room)
            }),
            Core::Superellipsoid(body) => within_superellipsoid(body, &start, along),
            // A piece of a wall has no inside.
            Core::Triangle(_) => None,
        }
    }
}

const WHOLE_LINE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Part of a chord where |p + s d|² <= r², for |p|², p·d and |d|².
fn within_ball(pp: f64, pd: f64, dd: f64, radius: f64) -> Option<(f64, f64)> {
    if dd < f64::EPSILON * f64::EPSILON {
        return (pp <= radius * radius).then_some(WHOLE_LINE);
    }
    let root = pd * pd - dd * (pp - radius * radius);
    (root >= 0.0).then(|| ((-pd - root.sqrt()) / dd, (-pd + root.sqrt()) / dd))
}

/// Part of a line where the gauge, which is convex, is at most 1.
fn within_superellipsoid(body: &Superellipsoid, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
    let gauge = |s: f64| {
        let (gauge, gradient) = body.gauge(&(start + along * s));
        (gauge, gradient.dot(along))
    };
    let (size, nearest) = (body.sharp_axes().norm(), -start.dot(along));
    let ends = (nearest - size, nearest + size);
    let (mut low, mut high) = ends;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let (value, slope) = gauge(middle);
        if value <= 1.0 {
            let end = |mut s: f64| {
                for _ in 0..STEPS {
                    let (value, slope) = gauge(s);
                    let step = (value - 1.0) / slope;
                    s -= step;
                    if step.abs() <= FOUND * size {
                        break;
                    }
                }
                s
            };
            return Some((end(ends.0), end(ends.1)));
        }
        // The tangent is below the gauge.
        if value - slope.abs() * 0.5 * (high - low) > 1.0 {
            return None;
        }
        if slope > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    None
}

/// Part of a chord where |p + s d| <= half.
fn within_slab(chord: (f64, f64), p: f64, d: f64, half: f64) -> Option<(f64, f64)> {
    below(below(chord, d, half - p)?, -d, half + p)
}

/// Part of a chord where s d <= room.
fn below((near, far): (f64, f64), d: f64, room: f64) -> Option<(f64, f64)> {
    let chord = if d > f64::EPSILON {
        (near, far.min(room / d))
    } else if d < -f64::EPSILON {
        (near.max(room / d), far)
    } else if room >= 0.0 {
        (near, far)
    } else {
        return None;
    };
    (chord.0 <= chord.1).then_some(chord)
}

/// Corners of the axis-aligned box around a part with sharp edges, in the frame it is placed in (m).
pub(crate) fn sharp_extents(part: &Part) -> (Vec3, Vec3) {
    let rows = part.rotation.abs();
    let half = match &part.core {
        Core::Point => Vec3::repeat(part.crust),
        Core::Cylinder { radius, half_height } => Vec3::from_fn(|a, _| {
            let (across, along) = (part.rotation.fixed_view::<1, 2>(a, 0).norm(), rows[(a, 2)]);
            (radius + part.crust) * across + (half_height + part.crust) * along
        }),
        Core::Polyhedron(_) => return points_extents(part, &sharp_corners(part)),
        _ => rows * part.half_extents,
    };
    (part.center - half, part.center + half)
}

fn points_extents(part: &Part, points: &[Vec3]) -> (Vec3, Vec3) {
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let placed = points.iter().map(|p| part.rotation * p + part.center);
    placed.fold(start, |(lower, upper), p| (lower.inf(&p), upper.sup(&p)))
}

/// Corners of a polyhedral part with sharp edges, in its frame (m); none for other parts.
pub(crate) fn sharp_corners(part: &Part) -> Vec<Vec3> {
    let Core::Polyhedron(core) = &part.core else { return Vec::new() };
    let vertices = core.vertices().to_vec();
    let centre = vertices.iter().sum::<Vec3>() / vertices.len() as f64;
    let hull = ConvexHull { vertices, faces: core.faces().to_vec() };
    let corners = hull.eroded_vertices(&centre, -part.crust).unwrap_or_default();
    let size = corners.iter().map(|v| (v - centre).amax()).fold(0.0, f64::max);
    let leader = leaders(&corners, COINCIDENT * size);
    let kept = corners.iter().zip(&leader).enumerate().filter(|(k, (_, leader))| *k as u32 == **leader);
    kept.map(|(_, (corner, _))| *corner).collect()
}
