//! What the Verlet lists are built from.

use super::skin::Skin;
use crate::catalogue::Catalogue;
use crate::walls::{Wall, WallState};
use grains_domain::Decomposition;

/// What list building needs to know besides the particles.
pub(crate) struct ListContext<'a> {
    pub(crate) decomposition: &'a Decomposition,
    pub(crate) catalogue: &'a Catalogue,
    pub(crate) walls: &'a [Wall],
    pub(crate) states: &'a [WallState],
    pub(crate) skin: Skin,
    /// Largest bounding radius of any particle (m).
    pub(crate) largest_radius: f64,
    /// Largest gap at which bodies act on each other (m).
    pub(crate) reach: f64,
    pub(crate) dt: f64,
    /// Time of the positions (s).
    pub(crate) time: f64,
}
