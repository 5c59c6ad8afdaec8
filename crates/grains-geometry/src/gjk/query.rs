//! What is asked of a pair of cores, and what is told of the answer.

use super::Simplex;
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
