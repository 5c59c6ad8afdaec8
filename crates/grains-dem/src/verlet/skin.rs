//! How far particles may move before the Verlet lists are rebuilt.

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
        Self { min: 0.025, max: 0.4, horizon: 80.0 }
    }
}
