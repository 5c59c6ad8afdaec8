//! Particles that the grid resolves, and the fluid of one rank.

use grains_case::{Case, Extrapolation as CaseExtrapolation, Resolved as CaseResolved};
use grains_comm::MpiTransport;
use grains_dem::Dem;
use grains_fluid::Flow;
use grains_resolved::{Extrapolation, Forcing, Resolved, Surroundings, bodies};

/// Width of the halo of all fields (cells): from a velocity inside a body, less than √3 of them, through the surface to two
/// points in the fluid, √3 apart, and the cell about the farther one.
pub const HALO: usize = 7;

/// The particles of one rank as bodies in the fluid.
pub struct ResolvedBodies {
    /// The bodies and what they impose on the fluid.
    pub bodies: Resolved,
    /// Whether the particles stay where they are.
    pub is_fixed: bool,
    surroundings: Surroundings,
}

impl ResolvedBodies {
    /// The bodies of a case, none yet.
    ///
    /// # Errors
    /// A grid that bodies cannot be resolved on.
    pub fn new(case: &Case, given: &CaseResolved, flow: &mut Flow) -> Result<Self, String> {
        let forcing = Forcing {
            extrapolation: match given.extrapolation {
                CaseExtrapolation::Quadratic => Extrapolation::Quadratic,
                CaseExtrapolation::Linear => Extrapolation::Linear,
                CaseExtrapolation::Rigid => Extrapolation::Rigid,
            },
            explicit: given.explicit_forcing,
        };
        let bodies = Resolved::new(flow, forcing).map_err(|e| case.about("fluid.cells", e.to_string()))?;
        let surroundings = Surroundings { density: flow.setup.density, active: bodies.subgrid.active };
        Ok(Self { bodies, is_fixed: case.holds_particles(), surroundings })
    }

    /// Takes the particles where they are; collective.
    pub fn place(&mut self, dem: &Dem, flow: &mut Flow, transport: &MpiTransport) {
        let catalogue = &dem.setup.catalogue;
        self.bodies.place(bodies(&dem.particles, catalogue), &catalogue.shapes, flow, transport);
    }

    /// Adds what the flow does to the loads of the particles, in each of their steps.
    pub fn add_loads(&self, dem: &mut Dem) {
        self.surroundings.add_loads(dem);
    }

    /// Makes fluid and particles follow each other after a step of the fluid `dt` (s); collective.
    pub fn follow(&mut self, dem: &mut Dem, flow: &mut Flow, dt: f64, transport: &MpiTransport) {
        if self.is_fixed {
            self.bodies.follow(None, flow, dt, transport);
            return;
        }
        let motions = self.surroundings.motions(dem, dt);
        let actions = self.bodies.follow(Some(&motions), flow, dt, transport);
        self.surroundings.correct(dem, &self.bodies.bodies, &actions, dt);
    }
}
