//! What defines a granular system.

use super::species::Species;
use crate::bonds::BondKind;
use crate::catalogue::Catalogue;
use crate::contacts::LoadQuanta;
use crate::exchange::ExchangeStrategy;
use crate::flow_planes::FlowPlane;
use crate::hard::CollisionModel;
use crate::heat::Thermal;
use crate::integrate::StepParameters;
use crate::prescribed::PrescribedMotion;
use crate::shear::{Shear, SlidingImages};
use crate::totals::quantum_below;
use crate::verlet::Skin;
use crate::walls::{Wall, WallScene, WallState};
use grains_contact::Lubrication;
use grains_domain::{Balance, Decomposition, GlobalBox};
use std::f64::consts::PI;

/// Everything that defines a granular system, apart from its particles.
#[derive(Clone, Debug)]
pub struct DemSetup {
    /// The box.
    pub global: GlobalBox,
    /// Simple shear of the box; its flow axis must not be divided between ranks.
    pub shear: Option<Shear>,
    /// Faces −x, +x, −y, +y, −z, +z through which particles may leave.
    pub outlets: [bool; 6],
    /// Ranks per axis.
    pub ranks: [usize; 3],
    /// Shapes, materials, laws.
    pub catalogue: Catalogue,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Planes through which particles are counted.
    pub planes: Vec<FlowPlane>,
    /// Gravity and time step.
    pub parameters: StepParameters,
    /// Largest bounding radius of any particle (m).
    pub largest_radius: f64,
    /// Largest admissible overlap over inscribed radius (-).
    pub overlap_limit: f64,
    /// Verlet skin.
    pub skin: Skin,
    /// What happens when bodies meet.
    pub collisions: CollisionModel,
    /// Kinds of bonds.
    pub bonds: Vec<BondKind>,
    /// Lubrication between spheres.
    pub lubrication: Option<Lubrication>,
    /// Species that particles contain.
    pub species: Vec<Species>,
    /// What the temperatures of particles depend on, if they have one.
    pub thermal: Option<Thermal>,
    /// What prescribes the motion of some particles; [`Dem::prescribe`](crate::Dem::prescribe) changes it.
    pub prescribed: Vec<PrescribedMotion>,
    /// How clones are brought up to date.
    pub exchange: ExchangeStrategy,
    /// Whether all ranks rebuild their lists in the same steps, as whoever couples the particles to something needs it. Boxes that are
    /// sheared, hard collisions and the strategies of the thesis need it anyway.
    pub rebuilds_together: bool,
    /// When borders between subdomains move; they stay if there is none.
    pub balance: Option<Balance>,
}

impl DemSetup {
    /// Distance (m) of the centres up to which particles may act on each other before lists are rebuilt.
    pub fn interaction_range(&self) -> f64 {
        let of_contacts = 2.0 * self.largest_radius * (1.0 + self.skin.max) + self.reach() + self.max_slide();
        of_contacts.max(self.longest_bond())
    }

    /// Whether ranks rebuild their lists apart from each other.
    pub(super) fn are_apart(&self, decomposition: &Decomposition) -> bool {
        let needs_all = self.rebuilds_together
            || self.shear.is_some()
            || self.collisions != CollisionModel::Soft
            || self.exchange != ExchangeStrategy::Persistent;
        let moving = self.balance.map_or([f64::INFINITY; 3], |balance| balance.min_width);
        let divided = (0..3).filter(|&a| self.ranks[a] > 1);
        let narrowest = divided.map(|a| moving[a]).fold(decomposition.smallest_width(), f64::min);
        // Partners must be known to the neighbours also while both go to the ends of their allowances.
        let of_bonds = self.longest_bond() + self.skin.max * self.largest_radius;
        let are_bonds_short = self.bonds.is_empty() || 2.0 * of_bonds <= narrowest;
        self.ranks != [1; 3] && !needs_all && are_bonds_short
    }

    /// Largest length (m) of any bond.
    pub fn longest_bond(&self) -> f64 {
        self.bonds.iter().map(|kind| kind.longest(self.largest_radius)).fold(0.0, f64::max)
    }

    /// The multiples to which forces (N) and torques (N m) of contacts are rounded, so that their sums are exact.
    pub fn load_quanta(&self) -> [f64; 2] {
        self.quanta().quanta()
    }

    /// Quanta of contact loads.
    pub(super) fn quanta(&self) -> LoadQuanta {
        let loadings = self.walls.iter().filter_map(|wall| wall.motion.loading());
        self.quanta_up_to(loadings.map(|loading| loading.force.abs()).fold(0.0, f64::max))
    }

    /// The multiple to which torques of contacts (N m) are rounded where no wall is under a load: it stays when walls move otherwise.
    pub(super) fn torque_quantum(&self) -> f64 {
        self.quanta_up_to(0.0).quanta()[1]
    }

    /// A quantum of masses (kg) far below the rounding of that of the heaviest particle there may be.
    pub(super) fn mass_quantum(&self) -> f64 {
        let densest = self.catalogue.densities.iter().copied().fold(0.0, f64::max);
        quantum_below(densest * 4.0 / 3.0 * PI * self.largest_radius.powi(3))
    }

    fn quanta_up_to(&self, wall_load: f64) -> LoadQuanta {
        // Without particles, as beside a fluid alone, there are no loads.
        let radius = if self.largest_radius > 0.0 { self.largest_radius } else { 1.0 };
        let of_bonds = self.bonds.iter().map(|kind| kind.force_bound(radius)).fold(0.0, f64::max);
        let of_contacts = self.catalogue.contacts.force_bound(radius, self.overlap_limit * radius);
        LoadQuanta::new(of_contacts.max(of_bonds), radius, wall_load)
    }

    /// Largest gap (m) at which bodies act on each other, by lubrication, a contact law or the gas between them.
    pub(super) fn reach(&self) -> f64 {
        self.lubrication
            .map_or(0.0, |lubrication| lubrication.range)
            .max(self.catalogue.contacts.reach_up_to(self.largest_radius))
            .max(self.thermal.as_ref().map_or(0.0, |thermal| thermal.reach(self.largest_radius)))
    }

    /// Largest way (m) that sliding images go before lists are rebuilt.
    pub(super) fn max_slide(&self) -> f64 {
        self.sliding_images().map_or(0.0, |images| {
            let of_a_step = images.speed.abs() * self.parameters.dt;
            of_a_step + (self.skin.max * self.largest_radius).max(of_a_step)
        })
    }

    /// The images of a sheared box.
    pub(super) fn sliding_images(&self) -> Option<SlidingImages> {
        // No particle goes farther than its radius in a step.
        let fastest = self.largest_radius / self.parameters.dt;
        self.shear.map(|shear| SlidingImages::new(shear, &self.global, fastest))
    }

    /// The walls as they are at a time (s).
    pub(super) fn wall_scene<'a>(&'a self, states: &'a [WallState], time: f64) -> WallScene<'a> {
        WallScene { walls: &self.walls, states, time, dt: self.parameters.dt, global: &self.global }
    }
}
