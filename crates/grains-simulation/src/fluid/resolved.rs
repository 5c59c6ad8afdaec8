//! Particles and walls that the grid resolves, and the fluid of one rank.

use super::resolved_scalars::BodyScalar;
use super::walls::FluidWalls;
use crate::error::{RunError, agreed};
use crate::insertion::KindRange;
use grains_case::{Case, Resolved as CaseResolved, ResolvedMethod as CaseMethod};
use grains_comm::MpiTransport;
use grains_contact::Lubrication;
use grains_dem::{Catalogue, Dem};
use grains_fluid::{Centre, Field, Flow};
use grains_resolved::{
    BodyMotion, ConstraintError, Forcing, Method, MultiplierMethod, Resolved, Surroundings, bodies,
};
use std::f64::consts::PI;

/// Width of the halo of all fields (cells): from a velocity inside a body, less than √3 of them, through the surface to two
/// points in the fluid, √3 apart, and the cell about the farther one.
pub const HALO: usize = 7;

/// The lubrication between spheres that the grid of a case does not resolve, if it asks for it.
pub fn lubrication(case: &Case) -> Option<Lubrication> {
    let fluid = case.fluid.as_ref()?;
    let given = fluid.resolved.as_ref()?.lubrication?;
    let widths = (0..3).filter(|&a| fluid.cells[a] > 1).map(|a| fluid.cell_widths(&case.domain, a)[1]);
    let range = given.range * widths.fold(0.0, f64::max);
    Some(Lubrication { viscosity: fluid.viscosity, range, min_gap: given.min_gap })
}

/// The particles of one rank as bodies in the fluid, and its walls.
pub struct ResolvedBodies {
    /// The bodies and what they impose on the fluid.
    pub bodies: Resolved,
    /// Whether the particles stay where they are, if there are any.
    pub is_fixed: bool,
    /// The walls that bound the fluid.
    pub walls: FluidWalls,
    surroundings: Surroundings,
    /// What the particles exchange with scalars.
    pub(super) scalars: Vec<BodyScalar>,
}

impl ResolvedBodies {
    /// The bodies of a case, none yet.
    ///
    /// # Errors
    /// A grid that bodies cannot be resolved on, walls that bound nothing, inlets that blow into them.
    pub fn new(case: &Case, given: &CaseResolved, flow: &mut Flow) -> Result<Self, String> {
        let method = match given.method {
            CaseMethod::Direct => Method::Direct { extrapolation: given.extrapolation(&case.inserts) },
            CaseMethod::Multiplier => Method::Multiplier(MultiplierMethod {
                interpolation: given.interpolation,
                spacing: given.point_spacing,
                tolerance: given.tolerance,
                iterations: given.iterations as usize,
            }),
        };
        let forcing = Forcing { method, explicit: given.explicit_forcing };
        let bodies = Resolved::new(flow, forcing).map_err(|e| case.about("fluid.cells", e.to_string()))?;
        let walls = FluidWalls::new(case)?;
        if let Some(fluid) = &case.fluid {
            walls.check_inlets(case, fluid, &flow.setup.grid)?;
        }
        let surroundings = Surroundings { density: flow.setup.density, active: bodies.subgrid.active };
        // Particles that conduct heat go through steps of their own even where they stay.
        let is_fixed = case.inserts.is_empty() || (case.holds_particles() && case.heat.is_none());
        let scalars = case.fluid.as_ref().map(BodyScalar::all).unwrap_or_default();
        Ok(Self { bodies, is_fixed, walls, surroundings, scalars })
    }

    /// Surface of the largest sphere about a particle of some kinds, in squares of a cell's width (-).
    pub fn largest_surface(&self, catalogue: &Catalogue, kinds: &[KindRange]) -> f64 {
        let width = libm::cbrt(self.bodies.subgrid.cell_volume());
        let radius = |k: &KindRange| catalogue.shape(k.kind).bounding_radius * k.largest / width;
        4.0 * PI * kinds.iter().map(radius).fold(0.0, f64::max).powi(2)
    }

    /// Takes particles and walls where they are for the coming step of the fluid; collective.
    pub fn place(&mut self, dem: &Dem, flow: &mut Flow, transport: &MpiTransport) {
        self.bodies.place_walls(self.walls.placed(dem));
        let catalogue = &dem.setup.catalogue;
        self.bodies.place(bodies(&dem.particles, catalogue), &catalogue.shapes, flow, transport);
        self.place_for_scalars(dem, flow, transport);
        flow.pass_solids(transport);
    }

    /// Takes particles and walls where they are in a fluid that is continued, maybe amid a step of it; collective.
    pub fn resume(&mut self, dem: &Dem, flow: &mut Flow, transport: &MpiTransport) {
        self.bodies.place_walls(self.walls.placed(dem));
        let catalogue = &dem.setup.catalogue;
        self.bodies.resume(bodies(&dem.particles, catalogue), &catalogue.shapes, flow, transport);
        self.place_for_scalars(dem, flow, transport);
    }

    /// Whether nothing moves but walls and fluid.
    pub fn are_walls_alone(&self) -> bool {
        self.is_fixed && self.walls.are_moving
    }

    /// Adds what the flow does to the loads of the particles, in each of their steps.
    pub fn add_loads(&self, dem: &mut Dem) {
        self.surroundings.add_loads(dem);
    }

    /// What moves the particles in a step of the fluid `dt` (s) that follows, if they move; tells the fluid of their contacts. Collective.
    pub fn motions(
        &mut self,
        dem: &Dem,
        flow: &mut Flow,
        dt: f64,
        transport: &MpiTransport,
    ) -> Option<Vec<BodyMotion>> {
        let motions = (!self.is_fixed).then(|| self.surroundings.motions(dem, dt))?;
        self.bodies.add_contact_force(&motions, flow, dt, transport);
        Some(motions)
    }

    /// Imposes the rigid-body velocity of the particles on the fluid after a step of the fluid `dt` (s), with what moves them;
    /// collective.
    ///
    /// # Errors
    /// Multipliers that were not found.
    pub fn impose_rigid_velocity(
        &mut self,
        (dem, motions): (&mut Dem, Option<&[BodyMotion]>),
        flow: &mut Flow,
        dt: f64,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let actions = self.bodies.impose_rigid_velocity(motions, flow, dt, transport);
        let failed = |e: ConstraintError| RunError::unphysical(format!("t = {:.6e} s: {e}", dem.time()));
        let actions = agreed(transport, actions.map_err(failed))?;
        if motions.is_some() {
            self.surroundings.correct(dem, &self.bodies.bodies, &actions, dt);
        } else {
            Surroundings::note(dem, &actions, dt);
        }
        Ok(())
    }

    /// Refuses walls and bodies that shut an inlet off from all outlets: whole sections of cells without fluid; collective.
    ///
    /// # Errors
    /// The region, with a place in it.
    pub fn check_regions(
        &self,
        case: &Case,
        dem: &Dem,
        flow: &Flow,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let [void, ..] = self.void_and_flux(dem);
        let found = flow.check_regions(|place| void.data()[place] > 0.0, transport);
        let about = |e: grains_fluid::SetupError| RunError::case(case.about("fluid.boundary", e.to_string()));
        agreed(transport, found.map_err(about))
    }

    /// Void fraction (-), flux of solid volume along x, y, z (m⁴/s per cell) and solid volume (m³) of the own cells.
    pub fn void_and_flux(&self, dem: &Dem) -> [Field<Centre>; 5] {
        let (layout, cell) = (self.bodies.subgrid.layout, self.bodies.subgrid.cell_volume());
        let mut fields: [Field<Centre>; 5] = std::array::from_fn(|_| Field::new(layout));
        self.bodies.for_each_solid(&dem.setup.catalogue.shapes, |place, volume, velocity| {
            (0..3).for_each(|a| fields[1 + a].data_mut()[place] += volume * velocity[a]);
            fields[4].data_mut()[place] += volume;
        });
        let [void, .., solid] = &mut fields;
        // Where bodies overlap there is no less than nothing.
        let pairs = void.data_mut().iter_mut().zip(solid.data());
        pairs.for_each(|(void, solid)| *void = (1.0 - solid / cell).max(0.0));
        fields
    }
}
