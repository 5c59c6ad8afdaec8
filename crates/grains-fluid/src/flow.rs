//! A flow: what defines it, its state, and how it begins.

use crate::boundary::{BoundaryData, Kind, fill_velocity, open_faces};
use crate::clock::Clock;
use crate::fans::Fans;
use crate::grid::AXES;
use crate::metrics::Local;
use crate::mixture::Mixture;
use crate::mixture_model::MixtureModel;
use crate::momentum::{Advection, Diffusion, Implicit};
use crate::openings::{Enclosure, Openings};
use crate::pressure::{ConjugateGradients, FastSolver, PressureProblem, PressureSolver, SolveReport};
use crate::scalar::Scalars;
use crate::viscosity::{ViscosityField, ViscosityLaw};
use crate::{
    Boundaries, CellPartition, Centre, Condition, Faces, Field, Grid, Halo, Layout, Location, Profile,
    SetupError, StepError,
};
use grains_domain::Transport;

/// What drives the flow along a periodic axis.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Drive {
    /// Nothing.
    #[default]
    None,
    /// A mean pressure gradient dp/dx (Pa/m); negative drives towards higher coordinates.
    PressureGradient(f64),
    /// The mean of ε u over the box (m/s), kept by adjusting the mean pressure gradient in every step.
    MeanVelocity(f64),
    /// The mean of ε u + (1 − ε) v over the box (m/s), v of the particles, kept so too: that of [`Mixture::solid`]; without a
    /// mixture the same as a mean velocity.
    MeanFlux(f64),
}

/// Everything that defines a flow and does not change.
#[derive(Clone, Debug)]
pub struct FlowSetup {
    /// Global grid.
    pub grid: Grid,
    /// Cells of the ranks.
    pub partition: CellPartition,
    /// Width of the halo of all fields (cells), at least 2.
    pub halo: usize,
    /// Density ρ (kg/m³).
    pub density: f64,
    /// Dynamic viscosity μ (Pa s).
    pub viscosity: f64,
    /// What makes the viscosity vary; none if it is constant. Of a rheology μ above is not read by the fluid.
    pub viscosity_law: Option<ViscosityLaw>,
    /// Conditions on the faces of the box.
    pub boundaries: Boundaries,
    /// Scheme of the advective terms.
    pub advection: Advection,
    /// Treatment of the viscous terms.
    pub diffusion: Diffusion,
    /// What drives the flow along periodic axes.
    pub drive: [Drive; 3],
    /// How particles enter the equations; none for a single phase.
    pub mixture: Option<MixtureModel>,
}

impl FlowSetup {
    /// Single phase between walls at rest, on one rank, with the default schemes.
    pub fn new(grid: Grid, density: f64, viscosity: f64) -> Self {
        Self {
            partition: CellPartition::serial(&grid),
            grid,
            halo: 2,
            density,
            viscosity,
            viscosity_law: None,
            boundaries: Boundaries::default(),
            advection: Advection::default(),
            diffusion: Diffusion::default(),
            drive: [Drive::None; 3],
            mixture: None,
        }
    }

    /// The pressure equation of this flow.
    pub fn pressure_problem(&self) -> PressureProblem {
        PressureProblem::new(&self.grid, &self.partition, self.halo, &self.boundaries)
    }

    /// Refuses what cannot be computed.
    pub fn check(&self) -> Result<(), SetupError> {
        let positive = |key, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(SetupError::Value { key, value, range: "positive and finite" }),
        };
        positive("fluid.density", self.density)?;
        positive("fluid.viscosity", self.viscosity)?;
        if self.viscosity_law.is_some() && self.diffusion == Diffusion::Explicit {
            return Err(SetupError::ExplicitVariable);
        }
        self.partition.check(self.halo)?;
        self.boundaries.check(&self.grid)?;
        let undriven = |a: usize| self.drive[a] == Drive::None || self.grid.axis(a).is_periodic();
        match (0..3).find(|&a| !undriven(a)) {
            Some(a) => Err(SetupError::DriveNotPeriodic { axis: AXES[a] }),
            None => Ok(()),
        }
    }

    /// Whether the coefficients of the pressure equation are constant, as the [`FastSolver`] needs them: one phase, and
    /// no face that is an outlet in part.
    pub fn has_constant_coefficients(&self) -> bool {
        let is_outlet = Condition::imposes_pressure;
        let is_partial = open_faces(&self.grid).any(|face| {
            let first = is_outlet(&self.boundaries.faces[face.index()]);
            self.boundaries.on(face).any(|c| is_outlet(c) != first)
        });
        self.mixture.is_none() && !is_partial
    }

    /// The solver that suits, to 1e-10 of the right-hand side where it iterates; collective.
    pub fn suitable_solver(&self, transport: &dyn Transport) -> Box<dyn PressureSolver> {
        self.suitable_solver_to(1e-10, 500, transport)
    }

    /// The solver that suits: direct for constant coefficients, else [`ConjugateGradients`] within `max_iterations` to
    /// a residual of `tolerance` times the right-hand side; collective.
    pub fn suitable_solver_to(
        &self,
        tolerance: f64,
        max_iterations: usize,
        transport: &dyn Transport,
    ) -> Box<dyn PressureSolver> {
        let problem = self.pressure_problem();
        if self.has_constant_coefficients() {
            Box::new(FastSolver::new(&problem, transport))
        } else {
            Box::new(ConjugateGradients::new(&problem, tolerance, max_iterations, transport))
        }
    }
}

/// What steps are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum March {
    /// The flow over time, of second order.
    #[default]
    Time,
    /// A steady flow, the same one: advection is implicit too, by upwind differences of the change alone (Euler).
    PseudoTime,
}

/// Places of own faces that bodies hold, of one component.
#[derive(Clone, Debug, Default)]
pub struct HeldFaces {
    /// Those that have the velocity of the body.
    pub deep: Vec<u32>,
    /// Those next to its surface, with velocities that follow the fluid's.
    pub near: Vec<u32>,
}

/// Places where stresses act between velocities of which bodies hold all, own and in the layer about them.
#[derive(Clone, Debug, Default)]
pub struct SolidStresses {
    /// Cells, for the stresses at their centres.
    pub centres: Vec<u32>,
    /// Cells, for the stresses on the edges along each axis, at their upper faces.
    pub edges: [Vec<u32>; 3],
}

/// Places of some faces and values there, per component.
pub type ValuesOnFaces = [Vec<(u32, f64)>; 3];

/// Rigid bodies in the fluid, as its steps see them.
#[derive(Clone, Debug)]
pub struct Immersed {
    /// What the bodies do to the fluid (N/m³), own faces; part of the momentum equation as it is.
    pub force: Faces,
    /// Extrapolated velocities inside bodies less those of the bodies (m/s), of own faces, if they are extrapolated: nothing
    /// flows by them.
    pub extrapolated: Option<ValuesOnFaces>,
    /// What passes faces that walls cut beyond their velocities (m/s), halo included, if there are walls.
    pub passing: Option<Faces>,
    /// Places of own cells inside walls, in ascending order: they have no pressure of a flow.
    pub sealed: Vec<u32>,
    /// Whether walls move: no pressure makes up for what flows into sealed cells where such a wall meets the end of the box.
    pub walls_move: bool,
    /// Faces that bodies at rest hold, per component; empty where the flow marches in time.
    pub held: [HeldFaces; 3],
    /// Where stresses act between velocities that bodies hold; empty where the viscosity is the same everywhere.
    pub solid: SolidStresses,
}

impl Immersed {
    /// No bodies.
    pub fn new(layout: Layout) -> Self {
        let force = Faces::new(layout);
        let (held, solid) = Default::default();
        Self { force, extrapolated: None, passing: None, sealed: Vec::new(), walls_move: false, held, solid }
    }
}

/// All that must be kept to continue a flow.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowState {
    /// Velocity (m/s); on the faces of the box the boundary values, lower ones in the halo.
    pub velocity: Faces,
    /// Pressure without the imposed mean gradient (Pa), of the middle of the last step.
    pub pressure: Field<Centre>,
    /// Advective (and other explicit) terms of the last step (m/s²); of no cells in pseudo-time.
    pub advective: Faces,
    /// Last pressure correction over the step, the first guess of the next (Pa, or m²/s for one phase).
    pub correction: Field<Centre>,
    /// Time (s).
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Last time step (s), zero before the first.
    pub last_dt: f64,
    /// Force of the imposed mean pressure gradients, −dp/dx (Pa/m).
    pub force: [f64; 3],
    /// Pressure rises of the fans (Pa), in the order of the faces and then of the patches that have one.
    pub fans: Vec<f64>,
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Time step (s).
    pub dt: f64,
    /// The pressure solve.
    pub solve: SolveReport,
}

/// An incompressible flow on one subdomain of the grid.
pub struct Flow {
    /// Its definition.
    pub setup: FlowSetup,
    /// Its state.
    pub state: FlowState,
    /// Void fraction, drag and sources of the particles; none for a single phase.
    pub mixture: Option<Mixture>,
    /// Rigid bodies whose velocity is imposed on the fluid.
    pub immersed: Option<Immersed>,
    /// What steps are for.
    pub march: March,
    /// Scalars that the fluid carries; none without.
    pub scalars: Option<Scalars>,
    /// The viscosity, where it varies.
    pub(crate) viscosity: Option<ViscosityField>,
    /// Time spent per phase of the step.
    pub clock: Clock,
    pub(crate) local: Local,
    pub(crate) boundary_data: Vec<BoundaryData>,
    pub(crate) halo: Halo,
    pub(crate) solver: Box<dyn PressureSolver>,
    pub(crate) implicit: Implicit,
    /// What a step adds to the velocities (m/s); in pseudo-time the velocities before it, once it has.
    pub(crate) increments: Faces,
    pub(crate) rhs: Field<Centre>,
    pub(crate) rows: [Vec<f64>; 2],
    pub(crate) fans: Fans,
}

impl Flow {
    /// Fluid at rest, with the solver that suits; collective.
    pub fn new(setup: FlowSetup, transport: &dyn Transport) -> Result<Self, SetupError> {
        setup.check()?;
        let solver = setup.suitable_solver(transport);
        Self::with_solver(setup, solver, transport)
    }

    /// Fluid at rest; collective.
    pub fn with_solver(
        setup: FlowSetup,
        mut solver: Box<dyn PressureSolver>,
        transport: &dyn Transport,
    ) -> Result<Self, SetupError> {
        setup.check()?;
        let local = Local::new(&setup.grid, &setup.partition, setup.halo);
        let layout = local.layout;
        let mut boundary_data = BoundaryData::all(&setup.grid, &local, &setup.boundaries);
        BoundaryData::weigh(&mut boundary_data, (&local, &setup.boundaries), None, transport);
        let fans = Fans::new(&setup.boundaries, layout);
        let mut ones = Faces::new(layout);
        ones.fill(1.0);
        close_faces(&boundary_data, &mut ones);
        if setup.mixture.is_none() {
            solver.set_coefficients(&ones, transport)?;
        }
        let mut flow = Self {
            state: FlowState {
                velocity: Faces::new(layout),
                pressure: Field::new(layout),
                advective: Faces::new(layout),
                correction: Field::new(layout),
                time: 0.0,
                step: 0,
                last_dt: 0.0,
                force: setup.drive.map(|d| if let Drive::PressureGradient(g) = d { -g } else { 0.0 }),
                fans: fans.at_rest(),
            },
            mixture: setup.mixture.map(|model| Mixture::new(model, layout)),
            immersed: None,
            march: March::Time,
            scalars: None,
            viscosity: setup.viscosity_law.map(|law| {
                let properties = [setup.density, setup.viscosity];
                ViscosityField::new(law, properties, (&setup.grid, &local), &setup.boundaries)
            }),
            clock: Clock::default(),
            boundary_data,
            halo: Halo::new(&setup.grid, &setup.partition, layout),
            solver,
            implicit: Implicit::new(&setup.grid, &setup.partition, &setup.boundaries),
            increments: Faces::new(layout),
            rhs: Field::new(layout),
            rows: [vec![0.0; layout.cells[0]], vec![0.0; layout.cells[0]]],
            fans,
            local,
            setup,
        };
        flow.synchronise(transport);
        flow.check_inflow(transport)?;
        Ok(flow)
    }

    /// Looks for the steady flow from here on: steps are pseudo-steps, which need no terms of the last one.
    pub fn seek_steady(&mut self) {
        self.march = March::PseudoTime;
        self.state.advective = Faces::new(Layout { cells: [0; 3], halo: 0 });
    }

    /// Bounds a mixture by walls; collective.
    ///
    /// # Errors
    /// More fluid that enters what is open than leaves it.
    pub fn enclose(&mut self, walls: &dyn Enclosure, transport: &dyn Transport) -> Result<(), SetupError> {
        let Some(mixture) = &mut self.mixture else { return Ok(()) };
        let is_closed = !self.setup.boundaries.has_outlet(&self.setup.grid);
        mixture.enclose(Openings::new(&self.setup.grid, &self.local, walls), is_closed);
        if let Some(number) = self.weigh_inlets(transport) {
            return Err(SetupError::CoveredInlet { face: self.setup.boundaries.face_of(number).to_string() });
        }
        self.synchronise(transport);
        self.place_enclosure(walls, transport);
        self.check_inflow(transport)
    }

    /// Takes the walls of a mixture as they are at the beginning of the coming step, before its void fraction is set; `is_changed`
    /// tells whether some appeared or vanished. Collective.
    ///
    /// # Errors
    /// An inlet whose flow has nothing to go through.
    pub fn move_walls(
        &mut self,
        walls: &dyn Enclosure,
        is_changed: bool,
        transport: &dyn Transport,
    ) -> Result<(), StepError> {
        let Some(mixture) = &mut self.mixture else { return Ok(()) };
        let old = mixture.openings.as_ref().map(|old| old.cells.clone());
        mixture.move_walls(Openings::new(&self.setup.grid, &self.local, walls), is_changed);
        mixture.close_velocity(&mut self.state.velocity);
        if let (Some(old), Some(openings)) = (old, &mixture.openings) {
            open_pressure(&mut self.state.pressure, &old, &openings.cells);
        }
        self.place_enclosure(walls, transport);
        match self.fill_openings(transport) {
            None => Ok(()),
            Some(number) => {
                let (step, face) = (self.state.step, self.setup.boundaries.face_of(number).to_string());
                Err(StepError::ShutOff { step, source: SetupError::CoveredInlet { face } })
            }
        }
    }

    /// Takes the walls of a mixture as they were in the last step of a flow that is continued: velocity and pressure are already those
    /// among them. Collective.
    pub fn resume_walls(&mut self, walls: &dyn Enclosure, transport: &dyn Transport) {
        if let Some(mixture) = &mut self.mixture {
            mixture.move_walls(Openings::new(&self.setup.grid, &self.local, walls), false);
            self.fill_openings(transport);
            self.place_enclosure(walls, transport);
        }
    }

    /// Lets in otherwise from the next step on, through an inlet of a number: 0 to 5 those of the faces, in the order of
    /// [`BoxFace::all`](crate::BoxFace::all), then those of the patches. Nothing happens if it is no inlet; collective.
    pub fn set_inlet(&mut self, number: usize, profile: Profile, transport: &dyn Transport) {
        let boundaries = &mut self.setup.boundaries;
        let condition = match number.checked_sub(6) {
            Some(k) => boundaries.patches.get_mut(k).map(|patch| &mut patch.condition),
            None => boundaries.faces.get_mut(number),
        };
        if let Some(Condition::Inlet { profile: old }) = condition {
            *old = profile;
            // A step evaluates what may change in time, and takes the change as one over the step.
            let face = boundaries.face_of(number);
            self.boundary_data
                .iter_mut()
                .filter(|data| data.face == face)
                .for_each(|data| data.is_unsteady = true);
            self.weigh_inlets(transport);
        }
    }

    /// Boundary values of what walls leave open, and halos; returns the number of an inlet whose flow has nothing to go through;
    /// collective.
    fn fill_openings(&mut self, transport: &dyn Transport) -> Option<usize> {
        let covered = self.weigh_inlets(transport);
        let time = self.state.time;
        for face_data in &mut self.boundary_data {
            if face_data.depends_on_walls {
                face_data.evaluate(&self.setup.grid, &self.local, &self.setup.boundaries, time);
            }
            face_data.fill_normal(&mut self.state.velocity, self.setup.halo);
        }
        let state = &mut self.state;
        let [x, y, z] = state.velocity.components_mut();
        self.halo.fill(&mut [x, y, z, state.pressure.data_mut()], transport);
        fill_velocity(&self.boundary_data, &mut state.velocity, self.setup.halo);
        self.impose_pressures();
        covered
    }

    /// Sizes inlets to what walls leave open; returns the number of one whose flow has nothing to go through; collective.
    pub(crate) fn weigh_inlets(&mut self, transport: &dyn Transport) -> Option<usize> {
        let openings = self.mixture.as_ref().and_then(|mixture| mixture.openings.as_ref());
        BoundaryData::weigh(
            &mut self.boundary_data,
            (&self.local, &self.setup.boundaries),
            openings,
            transport,
        )
    }

    /// Sets the imposed pressures to those at the present velocity, and the ghosts of the pressure.
    pub(crate) fn impose_pressures(&mut self) {
        let Self { boundary_data, fans, state, setup, .. } = self;
        for face_data in boundary_data {
            face_data.set_pressures(setup.density, |k| fans.rise(&state.fans, k), &state.velocity);
            face_data.fill_pressure(&mut state.pressure, 1.0);
        }
    }

    /// Sets velocity (m/s) and pressure (Pa) by functions of position (m); imposed boundary values stay; collective.
    pub fn initialise(
        &mut self,
        velocity: impl Fn([f64; 3]) -> [f64; 3],
        pressure: impl Fn([f64; 3]) -> f64,
        transport: &dyn Transport,
    ) {
        let (grid, local) = (&self.setup.grid, &self.local);
        let state = &mut self.state;
        sample(grid, local, &mut state.velocity.x, |x| velocity(x)[0]);
        sample(grid, local, &mut state.velocity.y, |x| velocity(x)[1]);
        sample(grid, local, &mut state.velocity.z, |x| velocity(x)[2]);
        sample(grid, local, &mut state.pressure, &pressure);
        self.synchronise(transport);
    }

    /// Fills all halos and ghosts: to be called when the state was changed from outside; collective.
    pub fn synchronise(&mut self, transport: &dyn Transport) {
        let state = &mut self.state;
        for component in (0..3).filter(|&c| !self.local.active[c]) {
            state.velocity.component_mut(component).fill(0.0);
        }
        if let Some(mixture) = &self.mixture {
            mixture.close_velocity(&mut state.velocity);
        }
        for face_data in self.boundary_data.iter_mut() {
            face_data.evaluate(&self.setup.grid, &self.local, &self.setup.boundaries, state.time);
        }
        // Imposed values before the exchange: on thin subdomains neighbours see those on the upper face.
        self.boundary_data
            .iter()
            .for_each(|face_data| face_data.fill_normal(&mut state.velocity, self.setup.halo));
        let [x, y, z] = state.velocity.components_mut();
        self.halo.fill(&mut [x, y, z, state.pressure.data_mut()], transport);
        fill_velocity(&self.boundary_data, &mut state.velocity, self.setup.halo);
        self.impose_pressures();
        if let Some(mixture) = &mut self.mixture {
            mixture.settle_faces(&self.local, &self.boundary_data, &mut self.halo, transport);
        }
        self.synchronise_scalars(transport);
    }

    /// Extent of the fields.
    pub fn layout(&self) -> Layout {
        self.local.layout
    }

    /// Places of the faces of outlets and pressure inlets, per axis they are normal to.
    pub fn outlets(&self) -> [Vec<u32>; 3] {
        let mut places: [Vec<u32>; 3] = Default::default();
        for face_data in self.boundary_data.iter().filter(|face_data| face_data.has_outlet) {
            let axis = face_data.face.axis;
            places[axis].extend(face_data.own_outlets(self.local.layout).map(|place| place as u32));
        }
        places
    }

    /// Global number of own cell 0 per axis.
    pub fn first_cell(&self) -> [usize; 3] {
        self.local.first
    }

    /// Refuses a box, or a region of it between walls, into which more flows than leaves.
    pub(crate) fn check_inflow(&self, transport: &dyn Transport) -> Result<(), SetupError> {
        let has_walls = self.mixture.as_ref().is_some_and(|mixture| mixture.openings.is_some());
        if self.setup.boundaries.has_outlet(&self.setup.grid) && !has_walls {
            return Ok(());
        }
        self.check_regions(|_| true, transport)
    }
}

/// Sets a field, halo included, by a function of position.
pub(crate) fn sample<L: Location>(
    grid: &Grid,
    local: &Local,
    field: &mut Field<L>,
    value: impl Fn([f64; 3]) -> f64,
) {
    let (layout, h) = (local.layout, local.layout.halo as isize);
    let [nx, ny, nz] = layout.cells.map(|n| n as isize);
    for k in -h..nz + h {
        for j in -h..ny + h {
            for i in -h..nx + h {
                let place = [i, j, k];
                let at = std::array::from_fn(|a| {
                    let cell = place[a] + local.first[a] as isize;
                    let axis = grid.axis(a);
                    if L::FACE == Some(a) { axis.node(cell + 1) } else { axis.centre(cell) }
                });
                field.set(i, j, k, value(at));
            }
        }
    }
}

/// Gives cells that have opened the mean pressure (Pa) of those beside them that were open.
fn open_pressure(pressure: &mut Field<Centre>, old: &Field<Centre>, new: &Field<Centre>) {
    let layout = pressure.layout();
    let strides = layout.strides();
    for row in layout.rows() {
        for p in row..row + layout.cells[0] {
            if old.data()[p] > 0.0 || new.data()[p] == 0.0 {
                continue;
            }
            let beside = strides.iter().flat_map(|stride| [p - stride, p + stride]);
            let values = beside.filter(|&q| old.data()[q] > 0.0).map(|q| pressure.data()[q]);
            let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value));
            pressure.data_mut()[p] = if count > 0 { sum / f64::from(count) } else { 0.0 };
        }
    }
}

/// Zeroes coefficients on all boundary faces but outlets.
pub(crate) fn close_faces(boundary_data: &[BoundaryData], coefficients: &mut Faces) {
    let layout = coefficients.layout();
    for face_data in boundary_data {
        let axis = face_data.face.axis;
        for m2 in 0..face_data.extents[1] {
            for m1 in 0..face_data.extents[0] {
                if face_data.kinds[axis][m2 * face_data.extents[0] + m1] != Kind::Free {
                    let b = face_data.boundary(layout, face_data.inside(layout, m1, m2));
                    coefficients.component_mut(axis)[b] = 0.0;
                }
            }
        }
    }
}
