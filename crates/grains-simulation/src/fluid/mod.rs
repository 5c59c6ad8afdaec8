//! The fluid of a run: its steps between those of the particles, and what is written of it.
//!
//! ```text
//! particle step s = the fluid's time?  void fraction and drag → fluid step of n particle steps → fluid velocity set
//! every particle step                  contact forces + drag, pressure gradient, buoyancy → advance
//! ```
//!
//! Of particles that the grid resolves the order is the other way round: they go through the n steps with the flow's last force,
//! then the fluid through its own, and both get one velocity.
//!
//! ```text
//! every particle step                  contact forces + force and torque of the flow, buoyancy → advance
//! particle step s = end of the span    bodies placed → fluid step of n particle steps → rigid-body velocity imposed
//! ```
//!
//! Where particles are, borders between ranks move to the work, which is that of the cells too: cells then change hands as
//! at a restart.
//!
//! A step of the fluid spans a whole number of particle steps, as many as the CFL number allows, and never passes a time
//! at which something is written: states on disk have particles and fluid at the same time. Without particles the clock
//! ticks in small fractions of the output interval, and the particles' part of the step is left out.

mod borders;
pub mod check;
mod enclosure;
mod exchange;
mod files;
mod imposed;
mod kernel_grid;
mod max_dt;
mod observe;
mod profile;
mod resolved;
mod resolved_scalars;
mod restart;
mod scalars;
mod seconds;
mod settling;
mod setup;
mod span;
mod steady;
mod transfer;
mod volumes;
mod walls;

use crate::error::{RunError, agreed};
use crate::insertion::KindRange;
pub use borders::rebalance;
use enclosure::EnclosingWalls;
use exchange::Exchange;
pub use files::{FluidFiles, Opening};
use grains_case::{Case, Fluid as CaseFluid};
use grains_comm::MpiTransport;
use grains_coupling::{Coupling, CouplingError, add_drag};
use grains_dem::{Catalogue, Dem, DemSetup};
use grains_domain::Decomposition;
use grains_fluid::{Flow, FlowSetup, Halo, StepReport};
pub use imposed::fastest;
use kernel_grid::{check_kernel, halo_width};
pub use max_dt::{FluidStepLimit, max_dt};
use observe::There;
pub use observe::{FluidProgress, Sums, columns};
use profile::Sampler;
use resolved::ResolvedBodies;
pub use resolved::lubrication;
use scalars::ScalarNames;
pub use scalars::interned;
pub use seconds::Seconds;
pub use setup::condition_number;
use span::SpanRule;
use std::cell::Cell;
use std::time::Instant;
use steady::Steady;

/// Work in a step of the fluid, in units of a pair of spheres in a step of the particles (some 7 ns where these were measured):
/// in a cell; for an iteration for its pressure; with a particle smaller than the cells; and with a resolved one, for the
/// square of a cell's width on its surface.
const WORK_OF_CELL: f64 = 20.0;
const WORK_OF_ITERATION: f64 = 3.0;
const WORK_OF_DRAG: f64 = 90.0;
const WORK_OF_SURFACE: f64 = 120.0;

/// The fluid of a run on this rank.
pub struct FluidPhase {
    /// The flow.
    pub flow: Flow,
    /// The exchange with particles smaller than the cells, if there are any.
    pub exchange: Option<Exchange>,
    /// Walls around a flow averaged over particles, if there are any.
    enclosing: Option<EnclosingWalls>,
    /// Particles that the grid resolves, if there are any.
    pub resolved: Option<ResolvedBodies>,
    /// The search for a steady flow, if the case asks for one.
    pub steady: Option<Steady>,
    /// Particle step at which the fluid's state is.
    pub next_step: u64,
    /// What the last step did.
    pub report: StepReport,
    /// Steps of the fluid since the run began or was continued.
    pub steps: u64,
    /// Iterations for the pressure in these.
    pub iterations: u64,
    /// What took how long.
    pub seconds: Seconds,
    /// Sums of the fields since the case's `mean_from`, if it has one.
    pub means: Option<Sums>,
    /// Particle step of the last sample in these.
    sampled: Option<u64>,
    /// Names of the scalars' arrays.
    scalar_names: Vec<ScalarNames>,
    /// Lines and planes that are written.
    pub profiles: Vec<Sampler>,
    halo: Halo,
    /// Work with a particle in a step of the fluid.
    work_of_particle: f64,
    /// How often borders had moved when the cells were shared out.
    moves: u64,
    /// Particle steps of the last step of the fluid.
    last_span: u64,
    /// How many particle steps a step of the fluid takes.
    rule: SpanRule,
    /// Whether the run was told that fluid comes back through outlets.
    is_told_of_backflow: Cell<bool>,
}

impl FluidPhase {
    /// The fluid of a case, at rest or as the case begins, with options for PETSc, for the kinds of particles that can be
    /// inserted; collective.
    ///
    /// # Errors
    /// Anything the solver or the coupling refuses, with its key.
    pub fn new(
        case: &Case,
        petsc: &[String],
        dem: &mut Dem,
        kinds: &[KindRange],
        transport: &MpiTransport,
    ) -> Result<Option<Self>, RunError> {
        let Some(fluid) = &case.fluid else { return Ok(None) };
        let built = Parts::of(case, fluid, (&dem.setup, kinds), &dem.decomposition);
        let parts = agreed(transport, built.map_err(RunError::case))?;
        let exchange =
            parts.exchange().map_err(|e| RunError::case(case.about("fluid.coupling", e.to_string())));
        let exchange = agreed(transport, exchange)?;
        let solver = setup::pressure_solver(fluid, petsc, &parts.setup, transport);
        let about = |e: String| RunError::case(case.about("fluid.pressure", e));
        let solver = agreed(transport, solver.map_err(about))?;
        let about = |e: grains_fluid::SetupError| RunError::case(case.about("fluid", e.to_string()));
        let mut flow = agreed(transport, Flow::with_solver(parts.setup, solver, transport).map_err(about))?;
        let initialised = setup::initialise(case, &mut flow, fluid, transport).map_err(RunError::case);
        agreed(transport, initialised)?;
        agreed(transport, scalars::add(case, fluid, &mut flow, transport).map_err(RunError::case))?;
        let (mut exchange, mut enclosing) = (exchange, None);
        if let Some(exchange) = &mut exchange {
            exchange.transfers = transfer::Transfer::all(fluid);
            enclosing = agreed(transport, EnclosingWalls::new(case).map_err(RunError::case))?;
            if let Some(walls) = &mut enclosing {
                walls.enclose(case, (&mut flow, exchange), (dem, dem.time()), transport)?;
            }
        }
        let steady = fluid.steady.map(|given| Steady::new(given, &mut flow));
        let resolved = case.resolved().map(|given| ResolvedBodies::new(case, given, &mut flow)).transpose();
        let resolved = agreed(transport, resolved.map_err(RunError::case))?;
        if exchange.is_some() || resolved.is_some() {
            dem.particles.carry();
        }
        let setup = &flow.setup;
        let halo = Halo::new(&setup.grid, &setup.partition, flow.layout());
        let has_particles = exchange.is_some() || resolved.is_some();
        dem.other_work.nodes = std::array::from_fn(|a| setup.grid.axis(a).nodes().to_vec());
        let work_of_particle = match &resolved {
            Some(resolved) => WORK_OF_SURFACE * resolved.largest_surface(&dem.setup.catalogue, kinds),
            None => WORK_OF_DRAG,
        };
        let scalar_names = ScalarNames::of(fluid);
        let there = There {
            particles: has_particles,
            viscosity: flow.setup.viscosity_law.is_some(),
            scalars: scalar_names.len(),
        };
        let means = fluid.output.mean_from.map(|_| Sums::new(flow.layout(), there));
        let profiles = fluid.profile.iter().map(|p| Sampler::new(p, &flow)).collect();
        Ok(Some(Self {
            flow,
            exchange,
            enclosing,
            resolved,
            steady,
            next_step: 0,
            report: StepReport::default(),
            steps: 0,
            iterations: 0,
            seconds: Seconds::default(),
            means,
            sampled: None,
            scalar_names,
            profiles,
            halo,
            work_of_particle,
            moves: dem.report.moves,
            last_span: 1,
            rule: SpanRule::new(case, fluid),
            is_told_of_backflow: Cell::new(false),
        }))
    }

    /// Adds what the cells hold now to the means, if it is time and they are not in them; collective.
    ///
    /// # Errors
    /// A particle beyond the halo.
    pub fn take_means(&mut self, case: &Case, dem: &Dem, transport: &MpiTransport) -> Result<(), RunError> {
        let from = case.fluid.as_ref().and_then(|f| f.output.mean_from);
        if from.is_none_or(|from| dem.time() < from) || self.sampled == Some(dem.step) {
            return Ok(());
        }
        self.sampled = Some(dem.step);
        let sample = self.sample(dem, transport)?;
        if let Some(means) = &mut self.means {
            means.add(&sample);
        }
        Ok(())
    }

    /// Whether nothing moves but the fluid and its walls.
    pub fn is_alone(&self) -> bool {
        self.exchange.is_none() && self.resolved.as_ref().is_none_or(|resolved| resolved.is_fixed)
    }

    /// Takes the particles as they are for the void fraction from which the first step begins; collective.
    ///
    /// # Errors
    /// A particle beyond the halo, a cell too full, walls and bodies that shut an inlet off.
    pub fn begin(&mut self, case: &Case, dem: &Dem, transport: &MpiTransport) -> Result<(), RunError> {
        if let Some(resolved) = &mut self.resolved {
            resolved.place(dem, &mut self.flow, transport);
            if resolved.is_fixed {
                resolved.check_regions(case, dem, &self.flow, transport)?;
            }
        }
        if let (Some(exchange), Some(mixture)) = (&mut self.exchange, &mut self.flow.mixture) {
            exchange.fill_void_fraction(&dem.particles, &mut mixture.void_fraction, transport)?;
            mixture.begin();
            exchange.forget_passages();
            self.flow.synchronise(transport);
        }
        self.flow.begin_scalars(|_| true);
        Ok(())
    }

    /// Notes the particles that came or went since it was last called: to be called before borders move.
    pub fn note_passages(&mut self, dem: &mut Dem) {
        let passages = std::mem::take(&mut dem.passages);
        if let Some(exchange) = &mut self.exchange {
            exchange.note(passages);
        }
    }

    /// Makes the state hold all passages that were noted: to be called before it is read; collective.
    ///
    /// # Errors
    /// A particle that came or went beyond the halo.
    pub fn settle_passages(&mut self, transport: &MpiTransport) -> Result<(), RunError> {
        if let (Some(exchange), Some(mixture)) = (&mut self.exchange, &mut self.flow.mixture) {
            exchange.settle_passages(mixture, transport)?;
            self.flow.settle_scalars();
        }
        Ok(())
    }

    /// Steps the fluid if it is its turn, and adds drag, pressure gradient and buoyancy to the loads of the particles;
    /// `event` is the next particle step at which something is written. Collective.
    ///
    /// # Errors
    /// A state that cannot be trusted any longer.
    pub fn before_particle_step(
        &mut self,
        dem: &mut Dem,
        event: u64,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        if dem.step >= self.next_step {
            match &self.steady {
                Some(steady) if steady.is_flow_settled() => self.rule.carry_scalars(),
                Some(steady) => self.rule.longest_settling = steady.longest,
                None => {}
            }
            let begun = Instant::now();
            self.last_span = self.rule.choose((dem, &self.flow), self.last_span, event, transport)?;
            self.next_step = dem.step + self.last_span;
            self.seconds.choice += begun.elapsed().as_secs_f64();
            // Resolved particles and walls go through the step before the fluid does.
            if let Some(resolved) = self.resolved.as_mut().filter(|resolved| resolved.are_walls_alone()) {
                let begun = Instant::now();
                dem.resume_at(self.next_step);
                resolved.place(dem, &mut self.flow, transport);
                self.seconds.exchange += begun.elapsed().as_secs_f64();
            }
            if self.is_alone() || self.exchange.is_some() {
                self.step(dem, transport)?;
            }
        }
        let begun = Instant::now();
        if let Some(exchange) = &mut self.exchange {
            add_drag(&mut dem.particles, &dem.setup.parameters, &mut exchange.account.ledger);
        }
        if let Some(resolved) = self.resolved.as_ref().filter(|resolved| !resolved.is_fixed) {
            resolved.add_loads(dem);
        }
        self.seconds.loads += begun.elapsed().as_secs_f64();
        Ok(())
    }

    /// Steps the fluid over what resolved particles have just gone through, if it is its turn; collective.
    ///
    /// # Errors
    /// A state that cannot be trusted any longer.
    pub fn after_particle_step(&mut self, dem: &mut Dem, transport: &MpiTransport) -> Result<(), RunError> {
        if self.is_alone() || dem.step < self.next_step {
            return Ok(());
        }
        if let Some(resolved) = &mut self.resolved {
            let begun = Instant::now();
            resolved.place(dem, &mut self.flow, transport);
            self.seconds.exchange += begun.elapsed().as_secs_f64();
            self.step(dem, transport)?;
        }
        Ok(())
    }

    fn step(&mut self, dem: &mut Dem, transport: &MpiTransport) -> Result<(), RunError> {
        let begun = Instant::now();
        let dt = self.last_span as f64 * dem.setup.parameters.dt;
        if let Some(exchange) = &mut self.exchange {
            if let Some(walls) = &mut self.enclosing {
                walls.advance((&mut self.flow, exchange), dem, transport)?;
            }
            let of_particles = (&mut dem.particles, dem.setup.thermal.as_ref());
            exchange.before_step(of_particles, &mut self.flow, dt, transport)?;
        }
        if self.steady.as_ref().is_some_and(Steady::is_flow_settled) {
            return self.step_scalars(dem, dt, transport);
        }
        if let Some(steady) = &mut self.steady {
            steady.begin(&mut self.flow, dt);
        }
        let resolved = self.resolved.as_mut();
        let motions = resolved.and_then(|resolved| resolved.motions(dem, &mut self.flow, dt, transport));
        let exchanged = begun.elapsed().as_secs_f64();
        let outcome = self.flow.step(dt, transport);
        let failed =
            |e: grains_fluid::StepError| RunError::unphysical(format!("t = {:.6e} s: {e}", dem.time()));
        self.report = agreed(transport, outcome.map_err(failed))?;
        let stepped = begun.elapsed().as_secs_f64();
        if let Some(walls) = &mut self.enclosing {
            walls.note_loads(&self.flow, transport);
        }
        if let Some(exchange) = &mut self.exchange {
            exchange.after_step(&mut dem.particles, &self.flow, dt, transport)?;
            exchange.after_scalars(dem, &self.flow, dt, transport)?;
        }
        if let Some(resolved) = &mut self.resolved {
            resolved.after_scalars(dem, &mut self.flow, dt, transport);
            resolved.impose_rigid_velocity((dem, motions.as_deref()), &mut self.flow, dt, transport)?;
        }
        if let Some(steady) = &mut self.steady {
            let bodies = self.resolved.as_ref().map(|resolved| &resolved.bodies);
            steady.end((dem, bodies), &mut self.flow, dt, transport);
        }
        self.seconds.flow += stepped - exchanged;
        self.seconds.exchange += exchanged + begun.elapsed().as_secs_f64() - stepped;
        self.steps += 1;
        self.iterations += self.report.solve.iterations as u64;
        self.tell_work(dem);
        Ok(())
    }

    /// Tells those who move borders what the fluid works per step of the particles; counted, not timed, it is the same on all
    /// ranks and in every run.
    fn tell_work(&self, dem: &mut Dem) {
        let per_step = |work: f64| work / self.last_span as f64;
        let of_cell = WORK_OF_CELL + WORK_OF_ITERATION * self.report.solve.iterations as f64;
        dem.other_work.per_cell = per_step(of_cell);
        dem.other_work.per_particle = per_step(self.work_of_particle).round() as u64;
    }
}

/// Nodes (m) of the cells that ranks share by number: those of a fluid alone, as they are all the work.
///
/// # Errors
/// Cells that cannot be.
pub fn shared_nodes(case: &Case) -> Result<Option<[Vec<f64>; 3]>, String> {
    let Some(fluid) = case.fluid.as_ref().filter(|_| case.inserts.is_empty()) else { return Ok(None) };
    let grid = setup::grid(case, fluid)?;
    Ok(Some(std::array::from_fn(|a| grid.axis(a).nodes().to_vec())))
}

/// Width (m) that a subdomain needs along each axis for the halo of the fluid; 0 without one. Particles may be `drift`
/// (m) outside theirs.
///
/// # Errors
/// What [`FluidPhase::new`] refuses.
pub fn min_widths(
    case: &Case,
    catalogue: &Catalogue,
    kinds: &[KindRange],
    drift: f64,
) -> Result<[f64; 3], String> {
    let Some(fluid) = &case.fluid else { return Ok([0.0; 3]) };
    let grid = setup::grid(case, fluid)?;
    let halo = match coupling(case, fluid, catalogue)? {
        Some(coupling) => halo(case, fluid, (&coupling, kinds), drift)?,
        None => plain_halo(fluid),
    };
    // Cuts fall anywhere in a cell; those of a fluid alone share them by number, so that a mean one counts.
    let width = |a: usize| match case.inserts.is_empty() {
        true => grid.axis(a).length() / grid.axis(a).cells() as f64,
        false => setup::cell_widths(&grid, a).fold(0.0, f64::max),
    };
    Ok(std::array::from_fn(|a| (halo + 1) as f64 * width(a)))
}

/// Width of the halo of all fields (cells) without kernels.
fn plain_halo(fluid: &CaseFluid) -> usize {
    if fluid.resolved.is_some() { resolved::HALO } else { 2 }
}

fn coupling(case: &Case, fluid: &CaseFluid, catalogue: &Catalogue) -> Result<Option<Coupling>, String> {
    if case.inserts.is_empty() { Ok(None) } else { setup::coupling(case, fluid, catalogue) }
}

/// Width of the halo of all fields (cells).
fn halo(
    case: &Case,
    fluid: &CaseFluid,
    (coupling, kinds): (&Coupling, &[KindRange]),
    drift: f64,
) -> Result<usize, String> {
    let diameter = setup::largest_diameter(coupling, kinds);
    let grid = setup::grid(case, fluid)?;
    let narrowest = [0, 1, 2].map(|a| setup::cell_widths(&grid, a).fold(f64::INFINITY, f64::min));
    Ok(halo_width(&coupling.kernel, diameter, drift, narrowest))
}

/// Longest step of the fluid (s) about bodies that its grid resolves, if it does.
pub fn max_body_time_step(case: &Case) -> Option<f64> {
    let fluid = case.fluid.as_ref()?;
    let resolved = fluid.resolved.as_ref()?;
    let by_diffusion = setup::diffusion_step(case, fluid, resolved);
    Some(fluid.max_dt.map_or(by_diffusion, |longest| longest.min(by_diffusion)))
}

/// What a phase is made of.
struct Parts {
    setup: FlowSetup,
    /// The coupling to particles, if there are any.
    coupling: Option<Coupling>,
}

impl Parts {
    fn of(
        case: &Case,
        fluid: &CaseFluid,
        (dem, kinds): (&DemSetup, &[KindRange]),
        decomposition: &Decomposition,
    ) -> Result<Self, String> {
        let Some(coupling) = coupling(case, fluid, &dem.catalogue)? else {
            let setup = setup::flow_setup(case, fluid, decomposition, plain_halo(fluid))?;
            return Ok(Self { setup, coupling: None });
        };
        let halo = halo(case, fluid, (&coupling, kinds), dem.skin.max * dem.largest_radius)?;
        let setup = setup::flow_setup(case, fluid, decomposition, halo)?;
        let diameter = setup::largest_diameter(&coupling, kinds);
        check_kernel(&coupling, (&setup.grid, &setup.partition, halo), diameter)
            .map_err(|e| case.about("fluid.coupling.kernel", e.to_string()))?;
        Ok(Self { setup, coupling: Some(coupling) })
    }

    fn exchange(&self) -> Result<Option<Exchange>, CouplingError> {
        let Some(coupling) = &self.coupling else { return Ok(None) };
        let FlowSetup { grid, partition, halo, .. } = &self.setup;
        Exchange::new(coupling.clone(), (grid, partition, *halo)).map(Some)
    }
}

/// Refuses what a run would refuse of the fluid before its first step.
///
/// # Errors
/// Subdomains too narrow for the halo, kernels that cover too many cells, conditions that cannot be, with the key.
pub fn verify(
    case: &Case,
    (dem, kinds): (&DemSetup, &[KindRange]),
    decomposition: &Decomposition,
) -> Result<(), String> {
    let Some(fluid) = &case.fluid else { return Ok(()) };
    let walls = walls::FluidWalls::new(case)?;
    // Of walls in an averaged flow inlets keep to what these leave open.
    if case.resolved().is_some() {
        walls.check_inlets(case, fluid, &setup::grid(case, fluid)?)?;
    }
    Parts::of(case, fluid, (dem, kinds), decomposition).map(drop)
}
