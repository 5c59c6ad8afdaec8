//! The neighbours of a subdomain.

use grains_domain::Direction;
use grains_geometry::Vec3;

/// A neighbour direction: who is there, and what it gets.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub(super) direction: Direction,
    pub(crate) rank: usize,
    pub(crate) shift: Vec3,
    /// Owned particles cloned in this direction.
    pub(crate) sent: Vec<u32>,
}
