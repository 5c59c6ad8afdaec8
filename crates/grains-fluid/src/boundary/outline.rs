//! Outlines of patches: rectangles, discs, annuli and polygons on a face of the box.

use super::image_from;
use crate::Grid;
use std::f64::consts::{PI, TAU};

/// Corners of the polygon that stands for a circle: of the circle's area, and off it by 1e-4 of the radius at most.
const CORNERS: usize = 256;

/// What lies on the edge counts as inside, to this share of the extent (-).
const SLACK: f64 = 1e-9;

/// Form and place of a patch; coordinates (m) normal to its face are not read.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A rectangle along the axes.
    Rectangle {
        /// Lower corner (m).
        lower: [f64; 3],
        /// Upper corner (m).
        upper: [f64; 3],
    },
    /// A disc, or an annulus.
    Disc {
        /// Centre (m).
        center: [f64; 3],
        /// Radius (m).
        radius: f64,
        /// Radius of the hole (m), 0 if there is none.
        inner_radius: f64,
    },
    /// A polygon whose edges do not cross.
    Polygon {
        /// Corners (m), in order.
        corners: Vec<[f64; 3]>,
    },
}

/// A point of a face along its two tangential axes (m).
pub(super) type Point = [f64; 2];

impl Outline {
    /// Bounds (m): begin and end along each of two axes.
    pub(super) fn bounds(&self, tangents: [usize; 2]) -> [[f64; 2]; 2] {
        tangents.map(|t| match self {
            Outline::Rectangle { lower, upper } => [lower[t], upper[t]],
            Outline::Disc { center, radius, .. } => [center[t] - radius, center[t] + radius],
            Outline::Polygon { corners } => {
                let all = corners.iter().map(|corner| corner[t]);
                [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
            }
        })
    }

    /// Edges of the polygons that bound it; what an odd number of them encloses is inside.
    pub(super) fn edges(&self, tangents: [usize; 2]) -> Vec<[Point; 2]> {
        let on_face = |at: &[f64; 3]| tangents.map(|t| at[t]);
        match self {
            Outline::Rectangle { lower, upper } => {
                let ([x0, y0], [x1, y1]) = (on_face(lower), on_face(upper));
                closed(vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
            }
            Outline::Disc { center, radius, inner_radius } => {
                let [x, y] = on_face(center);
                let circle = |radius: f64| {
                    let angle = TAU / CORNERS as f64;
                    let beyond = radius * (angle / angle.sin()).sqrt();
                    let corner = |k: usize| {
                        let (sin, cos) = (angle * k as f64).sin_cos();
                        [x + beyond * cos, y + beyond * sin]
                    };
                    closed((0..CORNERS).map(corner).collect())
                };
                let hole = if *inner_radius > 0.0 { circle(*inner_radius) } else { Vec::new() };
                circle(*radius).into_iter().chain(hole).collect()
            }
            Outline::Polygon { corners } => closed(corners.iter().map(on_face).collect()),
        }
    }

    /// Area (m²).
    pub fn area(&self, axis: usize) -> f64 {
        let tangents = tangents_of(axis);
        match self {
            Outline::Disc { radius, inner_radius, .. } => {
                PI * (radius * radius - inner_radius * inner_radius)
            }
            _ => {
                let edges = self.edges(tangents);
                // About a corner, so that a place far from the origin costs no digits.
                let [x, y] = edges.first().map_or([0.0; 2], |edge| edge[0]);
                let cross = |[[x0, y0], [x1, y1]]: &[Point; 2]| (x0 - x) * (y1 - y) - (x1 - x) * (y0 - y);
                (0.5 * edges.iter().map(cross).sum::<f64>()).abs()
            }
        }
    }

    /// Whether a point (m) of a face, or an image of it along periodic axes, lies in it, edges included.
    pub(crate) fn contains(&self, grid: &Grid, axis: usize, mut at: [f64; 3]) -> bool {
        let tangents = tangents_of(axis);
        for (t, [begin, end]) in tangents.into_iter().zip(self.bounds(tangents)) {
            at[t] = image_from(grid.axis(t), begin - SLACK * (end - begin), at[t]);
        }
        self.holds(axis, at)
    }

    /// Whether a point (m) of a face normal to an axis lies in it, edges included.
    pub fn holds(&self, axis: usize, at: [f64; 3]) -> bool {
        let tangents = tangents_of(axis);
        let at = tangents.map(|t| at[t]);
        let is_within = |([begin, end], x): ([f64; 2], f64)| {
            let slack = SLACK * (end - begin);
            x >= begin - slack && x <= end + slack
        };
        if !self.bounds(tangents).into_iter().zip(at).all(is_within) {
            return false;
        }
        match self {
            Outline::Rectangle { .. } => true,
            Outline::Disc { center, radius, inner_radius } => {
                let distance = (at[0] - center[tangents[0]]).hypot(at[1] - center[tangents[1]]);
                distance <= radius * (1.0 + SLACK) && distance >= inner_radius * (1.0 - SLACK)
            }
            Outline::Polygon { .. } => encloses(&self.edges(tangents), at),
        }
    }

    /// Why it is none, if so.
    pub fn fault(&self, axis: usize) -> Option<&'static str> {
        let edges = self.edges(tangents_of(axis));
        let is_finite = edges.as_flattened().as_flattened().iter().all(|x| x.is_finite());
        match self {
            _ if !is_finite => Some("it has coordinates that are no numbers"),
            Outline::Disc { radius, inner_radius, .. } if inner_radius >= radius => {
                Some("its inner radius must be below its radius")
            }
            Outline::Polygon { corners } if corners.len() < 3 => Some("a polygon has three corners and more"),
            Outline::Polygon { .. } if cross_each_other(&edges) => {
                Some("its edges cross; list the corners in order")
            }
            _ if self.area(axis) <= 0.0 => Some("it has no area"),
            _ => None,
        }
    }
}

/// Tangential axes of a face normal to an axis.
pub(super) fn tangents_of(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

/// Edges of a polygon.
fn closed(corners: Vec<Point>) -> Vec<[Point; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(from, to)| [*from, *to]).collect()
}

/// Whether an odd number of polygons encloses a point.
pub(super) fn encloses(edges: &[[Point; 2]], [x, y]: Point) -> bool {
    let is_above = |[[x0, y0], [x1, y1]]: &&[Point; 2]| {
        (*x0 <= x) != (*x1 <= x) && y0 + (x - x0) / (x1 - x0) * (y1 - y0) > y
    };
    edges.iter().filter(is_above).count() % 2 == 1
}

/// Where two edges meet along the first axis (m), if they cross.
pub(super) fn crossing([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<f64> {
    let [u, v, w] = [[b, a], [d, c], [c, a]].map(|[to, from]| [to[0] - from[0], to[1] - from[1]]);
    let cross = |p: Point, q: Point| p[0] * q[1] - p[1] * q[0];
    let area = cross(u, v);
    let (s, t) = (cross(w, v) / area, cross(w, u) / area);
    let is_inside = area != 0.0 && (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    is_inside.then_some(a[0] + s * u[0])
}

/// Whether edges of a polygon that are not neighbours meet.
fn cross_each_other(edges: &[[Point; 2]]) -> bool {
    let n = edges.len();
    (0..n).any(|i| (i + 2..n).any(|j| (i, j) != (0, n - 1) && crossing(edges[i], edges[j]).is_some()))
}
