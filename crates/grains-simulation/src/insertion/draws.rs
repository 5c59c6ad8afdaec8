//! What of a particle is drawn beside its size: its component, how it is turned.

use crate::random::Draw;
use grains_case::{Component, Orientation};
use grains_geometry::Rotation;
use nalgebra::{Quaternion, Unit};
use std::f64::consts::TAU;

/// What random numbers are for.
pub mod purpose {
    /// Component and scale.
    pub const KIND: u64 = 1;
    /// Orientation.
    pub const ORIENTATION: u64 = 2;
    /// Displacement from a site of a lattice.
    pub const NOISE: u64 = 3;
    /// Attempts to place a particle in a window count up from here.
    pub const ATTEMPT: u64 = 16;
}

/// Index of the component in whose share of [0, 1) a number falls.
pub fn choose(components: &[Component], number: f64) -> usize {
    let total: f64 = components.iter().map(|c| c.share).sum();
    let mut rest = number * total;
    let found = components.iter().position(|c| {
        rest -= c.share;
        rest < 0.0
    });
    found.unwrap_or(components.len() - 1)
}

/// How a particle is turned, body to world.
pub fn orientation(wanted: Option<Orientation>, draw: &mut Draw) -> Rotation {
    match wanted.unwrap_or(Orientation::Random) {
        Orientation::Aligned => Rotation::identity(),
        Orientation::Quaternion(q) => quaternion(q),
        Orientation::Random => {
            // Uniform over all rotations (Shoemake 1992).
            let (u, v, w) = (draw.next(), TAU * draw.next(), TAU * draw.next());
            let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
            quaternion([a * libm::sin(v), a * libm::cos(v), b * libm::sin(w), b * libm::cos(w)])
        }
    }
}

fn quaternion([w, x, y, z]: [f64; 4]) -> Rotation {
    Unit::new_normalize(Quaternion::new(w, x, y, z))
}
