//! The face or line of a body that touches another.

use crate::Vec3;
use nalgebra::Vector2;

/// Largest number of corners taken of a face.
pub(crate) const SIDES: usize = 8;
/// Corners that stand for a disc of radius 1.
const OCTAGON: [[f64; 2]; SIDES] = {
    const H: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [[1.0, 0.0], [H, H], [0.0, 1.0], [-H, H], [-1.0, 0.0], [-H, -H], [0.0, -1.0], [H, -H]]
};

/// Sine below which a disc is flush: the accuracy of a contact normal on a curved surface.
const FLUSH: f64 = 1e-5;

/// A face as a loop of points, counter-clockwise seen from outside; two points are a segment.
pub(crate) struct Feature {
    points: [Vec3; SIDES],
    len: usize,
    /// Outward normal, if the feature is a face.
    face: Option<Vec3>,
    /// Whether it has all corners of the core there: a disc has a few only.
    pub is_whole: bool,
    /// Whether the corners of a disc keep their places in its body.
    is_fixed: bool,
}

impl Feature {
    pub fn empty() -> Self {
        let points = [Vec3::zeros(); SIDES];
        Self { points, len: 0, face: None, is_whole: true, is_fixed: false }
    }

    /// One that takes the corners of a disc where they are in its body, whichever way it is seen.
    pub fn fixed() -> Self {
        Self { is_fixed: true, ..Self::empty() }
    }

    /// Fills the loop anew; it is too large to be handed about.
    pub fn set(&mut self, points: impl IntoIterator<Item = Vec3>, face: Option<Vec3>) {
        (self.len, self.face, self.is_whole) = (0, face, true);
        points.into_iter().for_each(|p| self.push(p));
    }

    /// Fills the loop with the end of a body of revolution about z: a disc at a height (m) seen along `direction`.
    ///
    /// Its first corner is the rim's farthest point that way, so that a tilted disc touches there first.
    pub fn set_disc(&mut self, radius: f64, z: f64, direction: &Vec3) {
        let sign = 1.0_f64.copysign(direction.z);
        let seen = direction.xy().try_normalize(FLUSH).filter(|_| !self.is_fixed);
        let farthest = seen.unwrap_or_else(Vector2::x) * radius;
        let corners = OCTAGON.map(|[c, s]| {
            let (x, y) = (farthest * c, Vector2::new(-farthest.y, farthest.x) * (sign * s));
            Vec3::new(x.x + y.x, x.y + y.y, z)
        });
        self.set(corners, Some(Vec3::new(0.0, 0.0, sign)));
        self.is_whole = false;
    }

    fn push(&mut self, point: Vec3) {
        if self.len < SIDES {
            self.points[self.len] = point;
            self.len += 1;
        }
    }

    pub fn points(&self) -> &[Vec3] {
        &self.points[..self.len]
    }

    /// Outward normal, if the feature is a face.
    pub fn normal(&self) -> Option<Vec3> {
        self.face
    }

    /// Replaces the points by `place` of them and the normal by `turn` of it.
    pub fn transform(&mut self, place: impl Fn(&Vec3) -> Vec3, turn: impl Fn(&Vec3) -> Vec3) {
        for point in &mut self.points[..self.len] {
            *point = place(point);
        }
        self.face = self.face.map(|normal| turn(&normal));
    }

    /// From a point before the face to the nearest of the loop (m).
    pub fn offset_from(&self, point: &Vec3) -> Vec3 {
        let points = self.points();
        let edges = || points.iter().zip(points.iter().cycle().skip(1));
        let is_beyond = |(p, q): &(&Vec3, &Vec3)| {
            self.normal().is_none_or(|normal| (*q - *p).cross(&normal).dot(&(point - *p)) > 0.0)
        };
        let beyond = edges().filter(is_beyond).map(|(p, q)| to_segment(point, p, q));
        let nearest = beyond.reduce(|a, b| if b.norm_squared() < a.norm_squared() { b } else { a });
        match (nearest, self.normal()) {
            (Some(offset), _) => offset,
            (None, Some(normal)) => normal * normal.dot(&(points[0] - point)),
            (None, None) => Vec3::zeros(),
        }
    }
}

/// From a point to the nearest of a segment (m).
pub(crate) fn to_segment(point: &Vec3, from: &Vec3, to: &Vec3) -> Vec3 {
    let along = to - from;
    let t = along.dot(&(point - from)) / along.norm_squared();
    from + along * t.clamp(0.0, 1.0) - point
}
