//! What the Verlet lists are built from.

use super::skin::Skin;
use crate::bonds::Forming;
use crate::catalogue::Catalogue;
use crate::dem::DemSetup;
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
    /// Whether ranks rebuild their lists apart from each other.
    pub(crate) is_apart: bool,
    /// How far (m) the fastest particle goes until a neighbour can take it over.
    pub(crate) stray: f64,
    pub(crate) dt: f64,
    /// Time of the positions (s).
    pub(crate) time: f64,
}

impl<'a> ListContext<'a> {
    /// Context of a system at rest at time zero, where nothing slides, bonds or leaves.
    pub(crate) fn new(
        setup: &'a DemSetup,
        decomposition: &'a Decomposition,
        (states, images): (&'a [WallState], Option<&'a SlidingImages>),
        reach: f64,
    ) -> Self {
        Self {
            decomposition,
            catalogue: &setup.catalogue,
            walls: &setup.walls,
            states,
            skin: setup.skin,
            largest_radius: setup.largest_radius,
            reach,
            images,
            slide: 0.0,
            forming: None,
            conducts: setup.thermal.is_some(),
            may_leave: false,
            is_apart: false,
            stray: 0.0,
            dt: setup.parameters.dt,
            time: 0.0,
        }
    }

    /// What two particles may be apart (m), beside what they go themselves, to act on each other before lists are rebuilt.
    pub(crate) fn gap(&self) -> f64 {
        self.reach + self.slide
    }
}
