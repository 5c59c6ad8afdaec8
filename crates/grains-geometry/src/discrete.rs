//! Contacts of superellipsoids found by vertices on their surfaces (Srinivasan 2019, sections 2.1 and 2.4,
//! with its misprints corrected), kept for comparison with the distance of the bodies.
//!
//! A vertex of one body is in contact if the inside-outside function (2.21) of the other says that it is inside.
//! The contact point is midway between the means of the two sets of such vertices, the normal the
//! mean of their unit normals, the overlap the largest extent of the sets along it. As in the source there
//! is no contact unless both bodies have a vertex inside the other, so coarse surfaces meet late.

use crate::convex::Support;
use crate::superellipsoid::Superellipsoid;
use crate::{Placement, ShapeError, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How the latitudes φ₂ of the vertices are spaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Evenly from pole to pole.
    Linear,
    /// φ₂ = ±π/2 (e^(κ|t|) − 1)/(e^κ − 1) at even t in [−1, 1]: crowded at the equator, since on a body with flat
    /// ends (small ε₁) all but the smallest latitudes lie on the ends. κ makes the first ring about
    /// as high as if the heights were spaced evenly.
    Exponential,
}

/// Vertices on the surface of a superellipsoid.
#[derive(Clone, Debug)]
pub struct DiscreteSurface {
    body: Superellipsoid,
    /// (m).
    vertices: Vec<Vec3>,
    /// Outward unit normals at the vertices: ∇f (2.28) over its length (-).
    normals: Vec<Vec3>,
    /// Radius of the smallest ball about the centre that holds the body (m).
    radius: f64,
}

/// Where two bodies touch, in the frame of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteContact {
    /// Unit normal from the first body to the second, or into the wall (-).
    pub normal: Vec3,
    /// Largest overlap along the normal (m), positive.
    pub overlap: f64,
    /// Mean contact point (m).
    pub point: Vec3,
}

/// Sums over the vertices of one body inside the other.
#[derive(Clone, Copy)]
struct Flagged {
    count: usize,
    points: Vec3,
    normals: Vec3,
}

impl DiscreteSurface {
    /// Vertices of the parametric form (2.2), `per_direction` longitudes φ₁ and latitudes φ₂; at a pole, where the
    /// vertices of a latitude coincide, there is one.
    ///
    /// # Errors
    /// Fewer than 4 vertices per direction.
    pub fn new(body: &Superellipsoid, per_direction: usize, spacing: Spacing) -> Result<Self, ShapeError> {
        if per_direction < 4 {
            return Err(ShapeError::OutOfRange {
                quantity: "surface_vertices.per_direction",
                value: per_direction as f64,
                allowed: "at least 4",
                remedy: "try 20, that is 400 vertices",
            });
        }
        let body = body.sharp();
        let mut vertices = vec![body.surface_point(0.0, -FRAC_PI_2), body.surface_point(0.0, FRAC_PI_2)];
        vertices.iter_mut().for_each(|pole| (pole.x, pole.y) = (0.0, 0.0));
        for row in 1..per_direction - 1 {
            let latitude = latitude(row, per_direction, body.eps()[0], spacing);
            let longitude = |k: usize| TAU * k as f64 / per_direction as f64 - PI;
            vertices.extend((0..per_direction).map(|k| body.surface_point(longitude(k), latitude)));
        }
        let normals = vertices.iter().map(|vertex| body.local(vertex).normal).collect();
        Ok(Self { radius: body.bounding_radius(), body, vertices, normals })
    }

    /// The vertices (m).
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// How far the body of the vertices reaches along a direction, max d·x (m times the length of d).
    pub fn reach(&self, direction: &Vec3) -> f64 {
        self.body.height(direction)
    }

    /// Contact with another body put at `placement` in the frame of this one.
    pub fn contact(&self, other: &Self, placement: &Placement) -> Option<DiscreteContact> {
        let inverse = placement.inverse();
        let ours = self.flagged(other, &inverse);
        let theirs = other.flagged(self, placement);
        if ours.count == 0 || theirs.count == 0 {
            return None;
        }
        let scale = placement.matrix.column(0).norm();
        let normal_b = placement.matrix * theirs.normals / (scale * theirs.count as f64);
        let normal = (ours.normals / ours.count as f64 - normal_b).try_normalize(f64::MIN_POSITIVE)?;
        // (2.34): largest signed projection over all pairs of flagged vertices.
        let reach = self.farthest(other, &inverse, &normal);
        let reach_b = other.farthest(self, placement, &-(placement.matrix.tr_mul(&normal)));
        let overlap = reach + reach_b - placement.translation.dot(&normal);
        let mean_b = placement.apply(&(theirs.points / theirs.count as f64));
        let point = (ours.points / ours.count as f64 + mean_b) * 0.5;
        (overlap > 0.0).then_some(DiscreteContact { normal, overlap, point })
    }

    /// Contact with a wall that fills the half-space behind the plane through `point` (m) with the unit
    /// `inward` normal, into the space of the particle, both in the frame of this body (2.36-2.40).
    pub fn contact_with_plane(&self, point: &Vec3, inward: &Vec3) -> Option<DiscreteContact> {
        let (mut count, mut sum, mut overlap) = (0, Vec3::zeros(), 0.0f64);
        for vertex in &self.vertices {
            let depth = inward.dot(&(point - vertex));
            if depth >= 0.0 {
                (count, sum, overlap) = (count + 1, sum + vertex, overlap.max(depth));
            }
        }
        (overlap > 0.0).then(|| DiscreteContact { normal: -inward, overlap, point: sum / f64::from(count) })
    }

    /// The vertices of this body inside the other, in which frame `to_other` places them.
    fn flagged(&self, other: &Self, to_other: &Placement) -> Flagged {
        let mut flagged = Flagged { count: 0, points: Vec3::zeros(), normals: Vec3::zeros() };
        for (vertex, normal) in self.vertices.iter().zip(&self.normals) {
            if other.holds(&to_other.apply(vertex)) {
                flagged.count += 1;
                flagged.points += vertex;
                flagged.normals += normal;
            }
        }
        flagged
    }

    /// Largest d·x over the vertices of this body inside the other.
    fn farthest(&self, other: &Self, to_other: &Placement, direction: &Vec3) -> f64 {
        let mut farthest = f64::NEG_INFINITY;
        for vertex in &self.vertices {
            let reach = direction.dot(vertex);
            if reach > farthest && other.holds(&to_other.apply(vertex)) {
                farthest = reach;
            }
        }
        farthest
    }

    /// Whether a point of the body's frame is inside: the bounding sphere first, then (2.21).
    #[inline]
    fn holds(&self, point: &Vec3) -> bool {
        point.norm_squared() <= self.radius * self.radius && self.body.inside_outside(point) <= 1.0
    }
}

/// Latitude of a row of vertices, row 0 at the south pole (rad).
fn latitude(row: usize, rows: usize, eps: f64, spacing: Spacing) -> f64 {
    let t = 2.0 * row as f64 / (rows - 1) as f64 - 1.0;
    match spacing {
        Spacing::Linear => FRAC_PI_2 * t,
        Spacing::Exponential => {
            // Evenly spaced heights z = sin^ε φ ask the first ring for t₁^(1/ε) = κ t₁ e^(−κ), nearly.
            let first = 2.0 / (rows - 1) as f64;
            let target = -(1.0 / eps - 1.0).max(0.0) * libm::log(first);
            let kappa = (0..20).fold(target.max(1.0), |kappa: f64, _| target + libm::log(kappa.max(1.0)));
            if kappa <= 0.0 {
                return FRAC_PI_2 * t;
            }
            libm::copysign(FRAC_PI_2 * libm::expm1(kappa * t.abs()) / libm::expm1(kappa), t)
        }
    }
}
