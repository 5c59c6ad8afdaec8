//! Whether and how bodies collide.

use crate::integrate::StepParameters;
use grains_contact::ImpulseScheme;

/// What happens when bodies meet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CollisionModel {
    /// They overlap, and the overlap makes a force.
    #[default]
    Soft,
    /// They do not deform: an instant impulse.
    Hard(HardModel),
    /// They never do: all are fixed where they are, and no neighbours are looked for.
    Fixed,
}

/// Parameters of collisions by impulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HardModel {
    /// How friction and restitution are brought together.
    pub scheme: ImpulseScheme,
    /// How often all contacts of a step are worked off (-); 1 in the source. More carry the weight of a deep
    /// bed farther in one step.
    pub sweeps: u32,
    /// Approach speed (m/s) below which restitution is taken as 0.
    pub rest_speed: f64,
}

impl HardModel {
    /// Exact restitution, one sweep, and rest below 2 |g| dt: nothing rests without gravity.
    pub fn new(parameters: &StepParameters) -> Self {
        let rest_speed = 2.0 * parameters.gravity.norm() * parameters.dt;
        Self { scheme: ImpulseScheme::Exact, sweeps: 1, rest_speed }
    }
}
