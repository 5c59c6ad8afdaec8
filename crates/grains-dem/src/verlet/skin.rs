//! How far particles may move before the Verlet lists are rebuilt.

use grains_geometry::Vec3;

/// How far particles may move before lists are rebuilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// Smallest allowance over radius (-).
    pub min: f64,
    /// Largest allowance over radius (-).
    pub max: f64,
    /// Steps a particle should go at its present speed (-).
    pub horizon: f64,
}

impl Default for Skin {
    fn default() -> Self {
        Self { min: 0.025, max: 0.4, horizon: 60.0 }
    }
}

/// Where a particle was when the lists were built, and how far it may go from there.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Reference {
    pub(crate) position: Vec3,
    /// Allowance (m).
    pub(crate) allowance: f64,
}
