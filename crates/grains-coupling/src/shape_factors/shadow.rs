//! The area of the shadow of several convex parts together.

use crate::CouplingError;
use crate::shape_factors::sharp::SharpPart;
use crate::shape_factors::table::plane;
use grains_geometry::{Core, Mat3, Shape, Vec3};
use std::cell::RefCell;
use std::f64::consts::TAU;

/// Lines across the shadow along which the parts' chords are joined.
const LINES: usize = 384;
/// Corners of the polygons drawn for round outlines.
const CORNERS: usize = 192;

/// Parts whose shadows are joined.
pub(super) struct Shadows {
    parts: Vec<(SharpPart, Mat3, Vec3)>,
    scratch: RefCell<Scratch>,
}

#[derive(Default)]
struct Scratch {
    /// Outline of each part as a convex polygon, by its edges in any order (m).
    edges: Vec<[[f64; 2]; 2]>,
    /// Where the edges of each part end.
    ends: Vec<usize>,
    points: Vec<[f64; 2]>,
    /// Chords by part and line.
    chords: Vec<[f64; 2]>,
    line: Vec<[f64; 2]>,
}

impl Shadows {
    /// The parts of a shape.
    ///
    /// Errors: a part without usable faces.
    pub(super) fn new(shape: &Shape) -> Result<Self, CouplingError> {
        let sharp = |part| Ok((SharpPart::of(part)?, part.rotation, part.center));
        let parts = shape.parts.iter().map(sharp).collect::<Result<_, CouplingError>>()?;
        Ok(Self { parts, scratch: RefCell::default() })
    }

    /// Area (m²) of the shadow along a unit direction of the body frame, to some 1e-4 of it.
    ///
    /// The union of the chords along [`LINES`] even lines, by the midpoint rule.
    pub(super) fn area(&self, direction: &Vec3) -> f64 {
        let axes = plane(direction);
        let scratch = &mut *self.scratch.borrow_mut();
        scratch.edges.clear();
        scratch.ends.clear();
        for (part, rotation, center) in &self.parts {
            outline(part, rotation, center, &axes, &mut scratch.points);
            let corners = scratch.points.len();
            let edge = |k: usize| [scratch.points[k], scratch.points[(k + 1) % corners]];
            scratch.edges.extend((0..corners).map(edge));
            scratch.ends.push(scratch.edges.len());
        }
        let heights = scratch.edges.iter().map(|e| e[0][1]);
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(y), h.max(y)));
        let spacing = (high - low) / LINES as f64;
        scratch.cut(low, spacing);
        (0..LINES).map(|line| scratch.covered(line)).sum::<f64>() * spacing
    }
}

impl Scratch {
    /// Finds the chord of every part on every line.
    fn cut(&mut self, low: f64, spacing: f64) {
        self.chords.clear();
        self.chords.resize(self.ends.len() * LINES, [f64::MAX, f64::MIN]);
        let mut begin = 0;
        for (part, &end) in self.ends.iter().enumerate() {
            let chords = &mut self.chords[part * LINES..][..LINES];
            for [a, b] in &self.edges[begin..end] {
                let ([x0, y0], [x1, y1]) = if a[1] <= b[1] { (*a, *b) } else { (*b, *a) };
                let first = ((y0 - low) / spacing - 0.5).ceil().max(0.0) as usize;
                let slope = (x1 - x0) / (y1 - y0);
                for (line, chord) in chords.iter_mut().enumerate().skip(first) {
                    let y = low + (line as f64 + 0.5) * spacing;
                    if y > y1 {
                        break;
                    }
                    let x = if y1 > y0 { x0 + (y - y0) * slope } else { x0 };
                    *chord = [chord[0].min(x), chord[1].max(x)];
                }
            }
            begin = end;
        }
    }

    /// Length of the union of the chords of a line (m).
    fn covered(&mut self, line: usize) -> f64 {
        let chords = self.chords.iter().skip(line).step_by(LINES);
        self.line.clear();
        self.line.extend(chords.filter(|c| c[0] < c[1]));
        self.line.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut length, mut reached) = (0.0, f64::MIN);
        for [from, to] in &self.line {
            length += (to - from.max(reached)).max(0.0);
            reached = reached.max(*to);
        }
        length
    }
}

/// The corners of a part's shadow in a plane's axes, counter-clockwise.
fn outline(part: &SharpPart, turn: &Mat3, center: &Vec3, axes: &(Vec3, Vec3), corners: &mut Vec<[f64; 2]>) {
    let flat = |p: &Vec3| [axes.0.dot(p), axes.1.dot(p)];
    corners.clear();
    // A polygon on a circle is smaller than it by (2π/n)²/6: drawn larger by half of that per length.
    let angle = TAU / CORNERS as f64;
    let larger = (angle / angle.sin()).sqrt();
    let directions = (0..CORNERS).map(|k| (angle * k as f64).sin_cos());
    match part {
        SharpPart::Ball(radius) => {
            let [x, y] = flat(center);
            let radius = radius * larger;
            corners.extend(directions.map(|(sine, cosine)| [x + radius * cosine, y + radius * sine]));
        }
        SharpPart::Points(points) => {
            corners.extend(points.iter().map(|p| flat(&(turn * p + center))));
            convex_hull(corners);
        }
        SharpPart::Core(core) => {
            let support = |(sine, cosine): (f64, f64)| {
                let direction = turn.tr_mul(&(axes.0 * cosine + axes.1 * sine));
                flat(&(turn * round_support(core, &direction, larger) + center))
            };
            corners.extend(directions.map(support));
            convex_hull(corners);
        }
    }
}

/// Farthest point of a core, cylinders with the radius that makes their polygon's area right.
fn round_support(core: &Core, direction: &Vec3, larger: f64) -> Vec3 {
    let point = core.support(direction);
    match core {
        Core::Cylinder { .. } => Vec3::new(point.x * larger, point.y * larger, point.z),
        _ => point,
    }
}

/// Leaves the corners of the convex hull of points, counter-clockwise.
fn convex_hull(points: &mut Vec<[f64; 2]>) {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return;
    }
    let mut hull: Vec<[f64; 2]> = Vec::with_capacity(2 * points.len());
    let turns_left = |h: &[[f64; 2]], p: &[f64; 2]| {
        let [a, b] = [h[h.len() - 2], h[h.len() - 1]];
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0
    };
    let mut add = |p: &[f64; 2], min: usize| {
        while hull.len() >= min && !turns_left(&hull, p) {
            hull.pop();
        }
        hull.push(*p);
        hull.len()
    };
    let mut length = 0;
    for p in points.iter() {
        length = add(p, 2);
    }
    for p in points.iter().rev().skip(1) {
        add(p, length + 1);
    }
    hull.pop();
    *points = hull;
}
