//! How velocities just inside a body follow those in the fluid.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest S of an extrapolated velocity (-): with it forces settle wherever ν Δt/Δx² is at most [`MAX_DIFFUSION_NUMBER`].
///
/// Forces that alternate from step to step obey f = κ (L_ii − W L_oi) f, κ = ν Δt/Δx², with L the sum of differences from the
/// neighbours, i the velocities inside, o those in the fluid, and W the weights of the extrapolation.
/// They die out where κ λ < 1 for the largest eigenvalue λ of L_ii − W L_oi.
/// Into a body with a flat side they decay by 1/S per cell, S = −Σ W_io n_o with n_o neighbours of o inside, which gives
/// λ = S + 1/S − 2 for S > 1, and less than 0 otherwise: no more than ½ for S = 2.
/// Straight lines and parabolas stay below 0 in any pose.
const MAX_RESPONSE: f64 = 2.0;
/// Largest ν Δt/Δx² with cubics (-).
pub const MAX_DIFFUSION_NUMBER: f64 = 2.0;

/// How velocities just inside a particle follow those in the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Extrapolation {
    /// Along a cubic through the surface and three points in the fluid: third order, where boundary layers are several cells
    /// thick; the default where all particles are fixed.
    Cubic,
    /// Along a parabola through the surface and two points: steadier; the default where some move.
    Quadratic,
    /// Along a straight line through the surface and one point.
    Linear,
    /// Not at all: they are those of the particle.
    Rigid,
}

/// How a polynomial is chosen.
#[derive(Clone, Copy)]
pub(crate) struct Rule {
    /// Number of points in the fluid.
    pub samples: usize,
    /// Their distance, in those of the planes between which a cell fits (-).
    pub spacing: f64,
    /// What the weights may sum to in magnitude, times the number of extrapolated velocities about one in the fluid (-).
    pub max_weight: f64,
    /// What may come of velocities that are extrapolated themselves: loops among close bodies must not feed themselves (-).
    pub max_feedback: f64,
    /// S: what the velocities beside extrapolated ones may weigh, times the number of these (-).
    pub max_response: f64,
}

impl Extrapolation {
    /// How its polynomials are chosen; none if velocities are those of the body.
    ///
    /// Far or few samples are less exact; near and many of them amplify what the grid does not resolve.
    pub(crate) fn rule(self) -> Option<Rule> {
        let rule = |samples, spacing, max_weight, max_feedback, max_response| {
            Some(Rule { samples, spacing, max_weight, max_feedback, max_response })
        };
        match self {
            Self::Rigid => None,
            Self::Linear => rule(1, 1.0, 5.0, 0.25, f64::INFINITY),
            Self::Quadratic => rule(2, 1.0, 5.0, 0.25, f64::INFINITY),
            Self::Cubic => rule(3, 0.8, 12.0, 0.5, MAX_RESPONSE),
        }
    }
}
