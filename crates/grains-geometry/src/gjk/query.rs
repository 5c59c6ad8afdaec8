//! What is asked of a pair of cores, and what is told of the answer.

use super::{STALLED_TOLERANCE, Simplex, TOLERANCE};
use crate::{Placement, Vec3};

/// What is asked of a pair of cores.
pub(super) struct Query<'a> {
    pub placement: &'a Placement,
    pub cutoff: f64,
}

/// The point of A with the given weights on the vertices.
#[inline(always)]
pub(super) fn combine(simplex: &Simplex, weights: &[f64; 4]) -> Vec3 {
    let mut point = simplex.a[0] * weights[0];
    for (i, weight) in weights.iter().enumerate().take(simplex.len as usize).skip(1) {
        point += simplex.a[i] * *weight;
    }
    point
}

/// What the support points in direction ∓v say of the distance, for v from a point of A to one of B.
///
/// With the support function h, height/|v| = (v·t − h_A(v) − h_B(−v))/|v| is a lower bound, and |v| an upper one. They are compared in
/// squares to spare the root.
pub(super) struct Bounds {
    /// |v|² (m²).
    pub squared: f64,
    /// v·t − h_A(v) − h_B(−v) (m²).
    pub height: f64,
}

impl Bounds {
    /// Whether the lower bound is above a cutoff (m).
    #[inline(always)]
    pub(super) fn are_beyond(&self, cutoff: f64) -> bool {
        (self.height > 0.0) & (self.height * self.height > cutoff * cutoff * self.squared)
    }

    /// Whether v is the distance to a tolerance (m).
    ///
    /// A lower bound clearly above |v| says that v joins no points of the cores: that is no answer either. Rounding may put it a little above.
    #[inline(always)]
    pub(super) fn are_closed(&self, tolerance: f64) -> bool {
        let slack = self.slack();
        let off = slack * slack;
        let above = STALLED_TOLERANCE / TOLERANCE * tolerance;
        (slack <= 0.0) & (off <= above * above * self.squared) | (off <= tolerance * tolerance * self.squared)
    }

    /// |v| times the difference of the bounds (m²).
    #[inline(always)]
    pub(super) fn slack(&self) -> f64 {
        self.squared - self.height
    }
}
