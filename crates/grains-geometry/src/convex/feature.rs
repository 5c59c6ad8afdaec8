//! The face or line of a body that touches another.

use crate::Vec3;
use nalgebra::Vector2;

/// Corners of a clipped polygon.
pub(crate) const CAPACITY: usize = 24;
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
    points: [Vec3; CAPACITY],
    len: usize,
    /// Outward normal and its cosine to the direction asked for, if the feature is a face.
    face: Option<(Vec3, f64)>,
}

impl Feature {
    pub fn empty() -> Self {
        Self { points: [Vec3::zeros(); CAPACITY], len: 0, face: None }
    }

    /// Fills the loop anew; it is too large to be handed about.
    pub fn set(&mut self, points: impl IntoIterator<Item = Vec3>, face: Option<(Vec3, f64)>) {
        (self.len, self.face) = (0, face);
        points.into_iter().for_each(|p| self.push(p));
    }

    /// Fills the loop with the end of a body of revolution about z: a disc at a height (m) seen along `direction`.
    ///
    /// Its first corner is the rim's farthest point that way, so that a tilted disc touches there first.
    pub fn set_disc(&mut self, radius: f64, z: f64, direction: &Vec3) {
        let sign = 1.0_f64.copysign(direction.z);
        let farthest = direction.xy().try_normalize(FLUSH).unwrap_or_else(Vector2::x) * radius;
        let corners = OCTAGON.map(|[c, s]| {
            let (x, y) = (farthest * c, Vector2::new(-farthest.y, farthest.x) * (sign * s));
            Vec3::new(x.x + y.x, x.y + y.y, z)
        });
        self.set(corners, Some((Vec3::new(0.0, 0.0, sign), direction.z.abs())));
    }

    fn push(&mut self, point: Vec3) {
        if self.len < CAPACITY {
            self.points[self.len] = point;
            self.len += 1;
        }
    }

    pub fn points(&self) -> &[Vec3] {
        &self.points[..self.len]
    }

    /// Outward normal, if the feature is a face.
    pub fn normal(&self) -> Option<Vec3> {
        self.face.map(|(normal, _)| normal)
    }

    /// Cosine of the face's normal to the direction asked for; -1 of a line.
    pub fn alignment(&self) -> f64 {
        self.face.map_or(-1.0, |(_, cosine)| cosine)
    }

    /// Replaces the points by `place` of them and the normal by `turn` of it.
    pub fn transform(&mut self, place: impl Fn(&Vec3) -> Vec3, turn: impl Fn(&Vec3) -> Vec3) {
        for point in &mut self.points[..self.len] {
            *point = place(point);
        }
        self.face = self.face.map(|(normal, cosine)| (turn(&normal), cosine));
    }

    /// The part of the loop where `height` is not positive, into `kept` (Sutherland and Hodgman 1974).
    pub fn clip(&self, height: impl Fn(&Vec3) -> f64, kept: &mut Self) {
        kept.set([], self.face);
        let Some(first) = self.points().first() else { return };
        let mut next = height(first);
        for (k, p) in self.points().iter().enumerate() {
            let q = &self.points[if k + 1 < self.len { k + 1 } else { 0 }];
            let above = next;
            next = height(q);
            if above <= 0.0 {
                kept.push(*p);
            }
            if (above < 0.0 && next > 0.0) || (above > 0.0 && next < 0.0) {
                kept.push(p + (q - p) * (above / (above - next)));
            }
        }
    }
}
