//! Features of two cylinders that touch: their nearest points.
//!
//! Features are rims, lines of the sides, and the disc of an end with a rim over it: all but those of parallel axes. Rim and line have a point on
//! a circle, the line a way along its axis too. Ways along lines and discs are projected out, and the angles on the circles are found by
//! Newton's method as for [other features](crate::gjk::curved); two lines or a disc fix the normal. A step has no branches, so that many pairs take
//! it at once in the lanes of the processor.

use super::marks::{CylinderMarks, Kind, Mark};
use crate::convex::cylinder::Cylinder;
use crate::convex::{Rims, Support as _};
use crate::gjk::curved::{CLOSURE, Circle, LAST_STEP, MAX_STEPS, PARALLEL, Touch, newton_step};
use crate::gjk::query::Bounds;
use crate::gjk::{MEETING, Simplex, TOLERANCE};
use crate::{Mat3, Placement, Vec3};

/// A rim, a line of the side or the disc of an end of a cylinder, with the angle of a point of the circle of the first two.
#[derive(Clone, Copy)]
pub(super) struct Feature {
    /// The cylinder it is of.
    pub rims: Rims,
    /// Height of a rim or disc over the middle of the cylinder (m); 0 of a line.
    pub height: f64,
    /// Half of the length of a line (m); 0 of others.
    pub reach: f64,
    /// Radius of a disc (m); 0 of others.
    pub disc: f64,
    /// Cosine and sine of the angle about the axis; of a feature that is marked, times its radius (m).
    pub angle: [f64; 2],
}

impl Feature {
    /// The feature of a mark, at the marked point.
    #[inline(always)]
    pub(super) fn of(rims: Rims, mark: &Mark) -> Self {
        let (height, reach, disc) = match mark.kind {
            Kind::Rim { is_upper } => (rims.height(is_upper), 0.0, 0.0),
            Kind::Line => (0.0, rims.half_height, 0.0),
            Kind::Disc { is_upper } => (rims.height(is_upper), 0.0, rims.radius),
        };
        Self { rims, height, reach, disc, angle: mark.point }
    }

    /// The same with the cosine and sine of the angle of its point.
    #[inline(always)]
    pub(super) fn turned(self) -> Self {
        let [x, y] = self.angle;
        let inverse = 1.0 / (x * x + y * y).sqrt();
        Self { angle: [x * inverse, y * inverse], ..self }
    }

    #[inline(always)]
    fn is_line(&self) -> bool {
        self.reach > 0.0
    }

    #[inline(always)]
    fn is_disc(&self) -> bool {
        self.disc > 0.0
    }

    #[inline(always)]
    fn cylinder(&self) -> Cylinder {
        let Rims { radius, half_height } = self.rims;
        Cylinder { radius, half_height }
    }
}

/// Features of two cylinders in the frame of the first.
pub(in crate::gjk) struct Touching {
    features: [Feature; 2],
    circles: [Circle; 2],
    matrix: Mat3,
    translation: Vec3,
    /// Scale of the second cylinder (-).
    scale: f64,
    /// From the middle of the circle of the first to that of the second (m).
    center: Vec3,
    /// Unit vector along the axis of the second.
    axis: Vec3,
    /// Orthonormal basis of the ways along lines or a disc; zero where there is none.
    basis: [Vec3; 2],
    /// Sine of the angle of the axes (-).
    sine: f64,
}

/// Points of two features that are nearest each other.
pub(super) struct Nearest {
    /// From the first cylinder to the second (m).
    pub v: Vec3,
    /// Point of the first (m).
    pub point_a: Vec3,
    /// Whether they are points of the features.
    pub is_within: bool,
}

impl Touching {
    /// The features that a simplex of two cylinders marks.
    #[inline(always)]
    pub(in crate::gjk) fn of(rims: [Rims; 2], placement: &Placement, simplex: &Simplex) -> Option<Self> {
        let features = Self::features(rims, &CylinderMarks::of(rims, simplex)?)?;
        Some(Self::new(features.map(Feature::turned), placement.matrix, placement.translation))
    }

    /// The features that are marked, at the marked points, unless a disc has anything but a rim over it.
    #[inline(always)]
    pub(super) fn features(rims: [Rims; 2], CylinderMarks([a, b]): &CylinderMarks) -> Option<[Feature; 2]> {
        let is_solvable = |on: &Mark, other: &Mark| {
            !matches!(on.kind, Kind::Disc { .. }) || matches!(other.kind, Kind::Rim { .. })
        };
        (is_solvable(a, b) && is_solvable(b, a)).then(|| [Feature::of(rims[0], a), Feature::of(rims[1], b)])
    }

    #[inline(always)]
    pub(super) fn new(features: [Feature; 2], matrix: Mat3, translation: Vec3) -> Self {
        let [a, b] = &features;
        let along = matrix.column(2);
        let scale = along.norm();
        let axis = along * (1.0 / scale);
        let across = Vec3::new(axis.x, axis.y, 0.0);
        let sine = across.norm();
        let select = |holds: bool, v: Vec3, other: Vec3| if holds { v } else { other };
        let inverse = 1.0 / scale;
        let first = select(b.is_line(), axis, Vec3::zeros());
        let first = select(b.is_disc(), matrix.column(0) * inverse, first);
        let first = select(a.is_line(), Vec3::z(), first);
        let second = select(a.is_line() & b.is_line(), across * (1.0 / sine), Vec3::zeros());
        let second = select(b.is_disc(), matrix.column(1) * inverse, second);
        let basis = [select(a.is_disc(), Vec3::x(), first), select(a.is_disc(), Vec3::y(), second)];
        let circle = |cosine: Vec3, sine: Vec3, angle| Circle { cosine, sine, angle, idle: 0.0 };
        // Of a disc: its middle.
        let [of_a, of_b] = [a, b].map(|feature| if feature.is_disc() { 0.0 } else { feature.rims.radius });
        Self {
            circles: [
                circle(Vec3::x() * of_a, Vec3::y() * of_a, a.angle),
                circle(matrix.column(0) * of_b, matrix.column(1) * of_b, b.angle),
            ],
            center: translation + along * b.height - Vec3::z() * a.height,
            basis,
            features,
            matrix,
            translation,
            scale,
            axis,
            sine,
        }
    }

    /// Cosines and sines of the points on the circles.
    #[inline(always)]
    pub(super) fn angles(&self) -> [[f64; 2]; 2] {
        self.circles.each_ref().map(|circle| circle.angle)
    }

    #[inline(always)]
    fn are_lines(&self) -> bool {
        self.features[0].is_line() & self.features[1].is_line()
    }

    /// Whether the features fix the normal.
    #[inline(always)]
    fn has_normal(&self) -> bool {
        self.are_lines() | self.features[0].is_disc() | self.features[1].is_disc()
    }

    /// The part of a vector across lines and disc.
    #[inline(always)]
    fn outside(&self, v: &Vec3) -> Vec3 {
        let [p, q] = &self.basis;
        v - p * p.dot(v) - q * q.dot(v)
    }

    /// From the point on the first circle to that on the second (m).
    #[inline(always)]
    fn between(&self) -> Vec3 {
        self.center + self.circles[1].radial() - self.circles[0].radial()
    }

    /// Moves the points on the circles to where they look at each other if the normal is fixed; no steps are needed then.
    #[inline(always)]
    pub(super) fn face(&mut self) {
        let [p, q] = &self.basis;
        let normal = p.cross(q);
        let normal = if normal.dot(&self.between()) < 0.0 { -normal } else { normal };
        let has_normal = self.has_normal();
        for (circle, direction) in self.circles.iter_mut().zip([normal, -normal]) {
            let facing = circle.facing(&direction);
            let [cosine, sine] = circle.angle;
            circle.angle =
                [if has_normal { facing[0] } else { cosine }, if has_normal { facing[1] } else { sine }];
        }
    }

    /// Turns the points on the circles by a step of Newton's method; returns its length (rad), infinite where they are not near a minimum.
    #[inline(always)]
    pub(super) fn turn(&mut self) -> f64 {
        let [a, b] = &self.circles;
        let steps = newton_step(a, b, &self.center, |v| self.outside(v));
        let has_normal = self.has_normal();
        let steps = steps.map(|step| if has_normal { 0.0 } else { step });
        for (circle, step) in self.circles.iter_mut().zip(steps) {
            circle.turn(step);
        }
        steps[0].abs().max(steps[1].abs())
    }

    /// The nearest points, with the points on the circles as they are.
    #[inline(always)]
    pub(super) fn nearest(&self) -> Nearest {
        let [a, b] = &self.features;
        let w = self.between();
        let v = self.outside(&self.outside(&w));
        let along = v - w;
        let only_second = if b.is_line() { self.axis.dot(&along) } else { 0.0 };
        let on_b = if self.are_lines() { self.basis[1].dot(&along) / self.sine } else { only_second };
        let on_a = if a.is_line() { self.axis.z * on_b - along.z } else { 0.0 };
        let [p, q] = &self.basis;
        let on_disc = p * p.dot(&along) + q * q.dot(&along);
        let of_disc = |feature: &Feature| if feature.is_disc() { on_disc } else { Vec3::zeros() };
        let (aside_a, aside_b) = (-of_disc(a), of_disc(b));
        let is_on_lines = (on_a.abs() <= a.reach) & (on_b.abs() <= b.reach * self.scale);
        let is_in = |aside: &Vec3, radius: f64| aside.norm_squared() <= radius * radius;
        let is_on_discs = is_in(&aside_a, a.disc) & is_in(&aside_b, b.disc * self.scale);
        // Lines at a small angle cost digits of the ways along them.
        let is_parallel = self.are_lines() & (self.sine * self.sine <= PARALLEL);
        let open = w + self.axis * on_b + aside_b - Vec3::z() * on_a - aside_a - v;
        let is_closed = open.norm_squared() <= CLOSURE * CLOSURE * w.norm_squared();
        let point_a = self.circles[0].radial() + Vec3::z() * (a.height + on_a) + aside_a;
        Nearest { v, point_a, is_within: is_on_lines & is_on_discs & !is_parallel & is_closed }
    }

    /// Solves for the nearest points; `None` where the features do not have them.
    #[inline(always)]
    pub(in crate::gjk) fn solved(mut self) -> Option<Touch> {
        self.face();
        for _ in 0..MAX_STEPS {
            let step = self.turn();
            if step.is_infinite() {
                return None;
            }
            if step < LAST_STEP {
                let Nearest { v, point_a, is_within } = self.nearest();
                let rims = self.rim_points();
                return is_within.then(|| Touch::new(v, point_a, rims));
            }
        }
        None
    }

    /// The points on the circles, as x and y in the frames of their cylinders (m).
    fn rim_points(&self) -> [Option<[f64; 2]>; 2] {
        let point = |k: usize| self.circles[k].angle.map(|x| x * self.features[k].rims.radius);
        [0, 1].map(|k| (!self.features[k].is_disc()).then(|| point(k)))
    }

    /// Whether the support points prove that nothing is nearer.
    #[inline(always)]
    pub(super) fn is_certain(&self, nearest: &Nearest) -> bool {
        let [a, b] = self.features.each_ref().map(Feature::cylinder);
        let t = &self.translation;
        let size =
            a.extent() + b.extent() * self.matrix.column(0).lp_norm(1) + t.x.abs() + t.y.abs() + t.z.abs();
        let v = &nearest.v;
        let bounds = Bounds {
            squared: v.norm_squared(),
            height: v.dot(t) - a.height(v) - b.height(&-self.matrix.tr_mul(v)),
        };
        let meeting = MEETING * size;
        nearest.is_within & (bounds.squared > meeting * meeting) & bounds.are_closed(TOLERANCE * size)
    }
}
