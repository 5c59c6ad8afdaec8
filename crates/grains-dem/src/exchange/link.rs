//! The neighbours of a subdomain.

use crate::particles::Image;
use grains_domain::Direction;
use grains_geometry::Vec3;

/// A neighbour direction: who is there, and what it gets.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub(super) direction: Direction,
    pub(crate) rank: usize,
    /// What they see there of a particle.
    pub(crate) image: Image,
    /// From a particle to its image in a box that nothing shears (m).
    pub(super) at_rest: Vec3,
    /// Owned particles cloned in this direction.
    pub(crate) sent: Vec<u32>,
}
