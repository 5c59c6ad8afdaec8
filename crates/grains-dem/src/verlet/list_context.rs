//! What the Verlet lists are built from.

use super::skin::Skin;
use crate::bonds::Forming;
use crate::catalogue::Catalogue;
use crate::shear::SlidingImages;
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
    /// Images of a sheared box.
    pub(crate) images: Option<&'a SlidingImages>,
    /// How far these may slide before the lists are rebuilt (m).
    pub(crate) slide: f64,
    /// Bonds to be made.
    pub(crate) forming: Option<&'a Forming<'a>>,
    /// Whether pairs that exert no forces exchange heat.
    pub(crate) conducts: bool,
    /// Whether a bonded particle may have left the box.
    pub(crate) may_leave: bool,
    pub(crate) dt: f64,
    /// Time of the positions (s).
    pub(crate) time: f64,
}

impl ListContext<'_> {
    /// What two particles may be apart (m), beside what they go themselves, to act on each other before lists are rebuilt.
    pub(crate) fn gap(&self) -> f64 {
        self.reach + self.slide
    }
}
