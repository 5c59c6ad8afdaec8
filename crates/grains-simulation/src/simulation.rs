//! A simulation in progress, and the order of a step.
//!
//! ```text
//! step n   insert what is due → migrate, update clones, rebuild lists → borders follow the work
//!          → contact forces                                        loads at t_n
//!          → write what is due at t_n, the checkpoint last
//!          → fluid, if it is its turn → kick, drift                state at t_{n+1}
//! ```
//!
//! A checkpoint of step n is the state of step n before its contacts are evaluated, since they change what contacts remember. It
//! is written after all else that is due at step n. So the files of a directory are complete up to the step of each of its
//! checkpoints, whenever a simulation is stopped or killed, and one that continues writes at this step only what the files lack.

use crate::error::{RunError, agreed};
use crate::files::Files;
use crate::fluid::{self, FluidPhase};
use crate::insertion::Insertions;
use crate::plausibility;
use crate::prediction::Prediction;
use crate::restart::{self, State, suspects};
use crate::schedule::Schedule;
use crate::summary::{Done, Progress, Summary};
use crate::system::{self, System};
use crate::views::{FluidView, ParticleView, WallView};
use crate::wall_triangles::triangles_of;
use grains_case::Case;
use grains_comm::{Job, MpiTransport};
use grains_dem::{Dem, Failure, Phase};
use grains_domain::Transport;
use grains_output::CheckpointFile;
use std::path::PathBuf;
use std::time::Instant;

/// How a simulation begins, and what it writes.
#[derive(Clone, Debug)]
pub struct Options {
    /// Checkpoint to continue from; `latest` for the last valid one of the case's output directory.
    pub restart: Option<PathBuf>,
    /// Whether it writes the files of the case's `[output]`.
    pub writes_files: bool,
    /// Name and version of the program, for its files.
    pub program: String,
    /// Options for PETSc.
    pub petsc: Vec<String>,
}

impl Default for Options {
    fn default() -> Self {
        let program = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")).into();
        Self { restart: None, writes_files: true, program, petsc: Vec::new() }
    }
}

/// Whether a simulation goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// There are more steps.
    Running,
    /// It has come to the end of the case, or its stop condition holds.
    Finished,
    /// It was asked to stop; its last checkpoint is of this step.
    Stopped,
}

/// A simulation in progress on this rank; its methods are collective where they say so.
pub struct Simulation {
    pub(crate) case: Case,
    pub(crate) dem: Dem,
    /// Freed after the messages `dem` has prepared.
    pub(crate) transport: MpiTransport,
    pub(crate) fluid: Option<FluidPhase>,
    pub(crate) insertions: Insertions,
    files: Option<Files>,
    schedule: Schedule,
    petsc: Vec<String>,
    begun: Instant,
    first_step: u64,
    begin: f64,
    /// Particles of this rank, summed over the steps.
    particle_steps: u64,
    /// Whether what is due at the present step is inserted: a checkpoint holds what was inserted at its step.
    is_inserted: bool,
    /// What a restart has changed that may fail at once.
    suspects: String,
    /// Whether the fluid begins with this simulation.
    is_fluid_new: bool,
    is_asked_to_stop: bool,
    /// Whether the stop condition of the case has been met.
    is_stop_met: bool,
    status: Status,
    progress: Option<Progress>,
    prediction: Prediction,
}

impl Simulation {
    /// Builds a case on the ranks of a job, and fills it or takes a checkpoint; collective.
    ///
    /// # Errors
    /// Anything wrong with the case, its files or the checkpoint.
    pub fn new(case: &Case, job: &Job, options: Options) -> Result<Self, RunError> {
        Self::begun(case, job, options, None)
    }

    /// As [`Simulation::new`], from the content of a checkpoint that has been read, whatever `options.restart` says; collective.
    ///
    /// # Errors
    /// As for [`Simulation::new`].
    pub fn continued(
        case: &Case,
        job: &Job,
        options: Options,
        checkpoint: CheckpointFile,
    ) -> Result<Self, RunError> {
        Self::begun(case, job, options, Some(checkpoint))
    }

    fn begun(
        case: &Case,
        job: &Job,
        options: Options,
        read: Option<CheckpointFile>,
    ) -> Result<Self, RunError> {
        let (system, mut insertions) = build(case, job.transport())?;
        let warnings = plausibility::warnings(case, &system, &insertions);
        let System { setup, step } = system;
        let transport = system::transport(case, &setup, job)?;
        let mut dem = system::dem(case, setup, transport.rank()).map_err(RunError::case)?;
        dem.prescribe(insertions.prescribed_motions(case));
        if transport.rank() == 0 {
            step.warning.iter().chain(&warnings).for_each(|w| log::warn!("{w}"));
            log::info!("time step {:e} s: {}; {}", step.dt, step.resolution(case), step.reason);
        }
        let walls = triangles_of(&dem, &dem.worn_volumes(&transport));
        let prediction = Prediction::of(case, (&dem, &insertions), &step, &walls, &transport);
        let Options { restart, writes_files, program, petsc } = options;
        let mut fluid = FluidPhase::new(case, &petsc, &mut dem, insertions.kinds(), &transport)?;
        let open = |path: &PathBuf| restart::open(case, &transport, path);
        let checkpoint =
            read.map_or_else(|| restart.as_ref().map(open).transpose(), |read| Ok(Some(read)))?;
        let restore = |file: &CheckpointFile| {
            restart::restore(case, &transport, file, (&mut dem, &mut fluid), &mut insertions)
        };
        let continued = checkpoint.as_ref().map(restore).transpose()?;
        let open = || Files::open(case, &program, &transport, continued.as_ref(), (&dem, &fluid));
        let files = writes_files.then(open).transpose()?;
        let mut schedule = match writes_files {
            true => Schedule::new(case, dem.setup.parameters.dt, &dem.origin),
            false => Schedule::without_files(case, dem.setup.parameters.dt, &dem.origin),
        };
        let (first_step, begin) = (dem.step, dem.time());
        let is_stop_met = continued.as_ref().is_some_and(|continued| continued.is_at_end);
        if is_stop_met {
            schedule.end = first_step;
        }
        let suspects = continued.as_ref().map(|continued| suspects(&continued.changes)).unwrap_or_default();
        let is_fluid_new = continued.is_none_or(|continued| continued.is_fluid_new);
        Ok(Self {
            case: case.without_meshes(),
            transport,
            dem,
            fluid,
            insertions,
            files,
            schedule,
            petsc,
            begun: Instant::now(),
            first_step,
            begin,
            particle_steps: 0,
            is_inserted: checkpoint.is_some(),
            suspects,
            is_fluid_new,
            is_asked_to_stop: false,
            is_stop_met,
            status: Status::Running,
            progress: None,
            prediction,
        })
    }

    /// Inserts what is due at the present step, which its next step would do: to look at the particles before that. Collective.
    ///
    /// # Errors
    /// Particles that do not fit.
    pub fn insert_due(&mut self) -> Result<(), RunError> {
        match std::mem::replace(&mut self.is_inserted, true) {
            true => Ok(()),
            false => self.insert(),
        }
    }

    /// One step, with what is to be written before it; collective.
    ///
    /// # Errors
    /// A state that can no longer be trusted, or a file that cannot be written.
    pub fn step(&mut self) -> Result<Status, RunError> {
        if self.status != Status::Running {
            return Ok(self.status);
        }
        let step = self.dem.step;
        let is_last = step >= self.schedule.end;
        if is_last || self.dem.interrupt || self.schedule.is_due(step) {
            // Nothing is written of a state that another rank may know to be wrong.
            self.dem.settle(&self.transport).map_err(|e| self.failed(e))?;
        }
        let is_saved = self.dem.interrupt || is_last || self.schedule.checkpoint.is_due(step);
        let state = self.assemble(is_saved && step > self.first_step && self.files.is_some())?;
        if let Some(fluid) = self.fluid.as_mut().filter(|_| is_last || self.dem.interrupt) {
            fluid.forget_steps();
        }
        let is_met = self.observe(is_last);
        let is_met = self.explained(is_met)?;
        if let Some(state) = state {
            self.checkpoint(state)?;
        }
        if is_last {
            self.dem.settle(&self.transport).map_err(|e| self.failed(e))?;
            self.tell_of_steady();
            self.status = Status::Finished;
        } else if self.dem.interrupt {
            self.status = Status::Stopped;
        } else {
            if is_met {
                self.end_soon();
            }
            self.dem.interrupt = self.is_asked_to_stop;
            self.advance()?;
            if self.fluid.as_ref().is_some_and(FluidPhase::is_settled) {
                self.schedule.end = self.dem.step;
            }
        }
        Ok(self.status)
    }

    /// Steps up to the step nearest to a time (s), or to the end; collective.
    ///
    /// # Errors
    /// As for [`Simulation::step`].
    pub fn run_to(&mut self, time: f64) -> Result<Status, RunError> {
        self.pause_at(time);
        while !self.is_paused() && self.status == Status::Running {
            self.step()?;
        }
        Ok(self.status)
    }

    /// Makes the step nearest to a time (s) one at which particles and fluid are at the same time.
    pub fn pause_at(&mut self, time: f64) {
        self.schedule.pause = self.dem.origin.step_at(time, self.dem.setup.parameters.dt);
    }

    /// Whether it has come to the step of [`Simulation::pause_at`].
    pub fn is_paused(&self) -> bool {
        self.dem.step >= self.schedule.pause
    }

    /// One step without looking at what is due: for timing; collective.
    ///
    /// # Errors
    /// A state that can no longer be trusted.
    pub fn step_unobserved(&mut self) -> Result<(), RunError> {
        self.assemble(false)?;
        self.advance()
    }

    /// Asks for the end, on any rank: one of the next ten steps, the same on all ranks, writes a checkpoint and is the last.
    pub fn stop(&mut self) {
        self.is_asked_to_stop = true;
    }

    /// Ends the simulation, with a checkpoint if it was still running, and says what it has done; collective.
    ///
    /// # Errors
    /// As for [`Simulation::step`].
    pub fn close(mut self) -> Result<Summary, RunError> {
        if self.status == Status::Running && self.files.is_some() {
            self.dem.interrupt = true;
            self.step()?;
        }
        let Self { dem, fluid, insertions, particle_steps, .. } = &self;
        let (seconds, steps, particle_steps) = (self.seconds(), self.steps_done(), *particle_steps);
        let done = Done { dem, fluid: fluid.as_ref(), insertions, seconds, steps, particle_steps };
        Ok(Summary::of(&done, &self.transport))
    }

    /// Inserts, migrates, balances and evaluates the contacts: the loads of the present step. The state for a checkpoint is taken
    /// before the contacts, if it is asked for.
    fn assemble(&mut self, is_saved: bool) -> Result<Option<State>, RunError> {
        self.insert_due()?;
        self.is_inserted = false;
        // Until the contacts of this step nothing looks at clones.
        self.dem.start_refresh(&self.transport).map_err(|e| self.failed(e))?;
        if let Some(fluid) = &mut self.fluid {
            fluid.note_passages(&mut self.dem);
        }
        self.rebalance()?;
        if std::mem::take(&mut self.is_fluid_new)
            && let Some(fluid) = &mut self.fluid
        {
            fluid.begin(&self.case, &self.dem, &self.transport)?;
        }
        let state = is_saved.then(|| {
            // What follows waits for all ranks; neighbours may still wait for this one to take their clones.
            self.dem.finish_update(&self.transport);
            self.state()
        });
        self.dem.add_forces(&self.transport);
        Ok(state)
    }

    /// The step of the fluid if it is its turn, and that of the particles.
    fn advance(&mut self) -> Result<(), RunError> {
        let Self { fluid, dem, transport, schedule, .. } = self;
        if let Some(fluid) = fluid {
            fluid.before_particle_step(dem, schedule.next(dem.step), transport)?;
            if fluid.is_alone() {
                // Nothing else moves: on to the next step of the fluid.
                dem.resume_at(fluid.next_step);
                dem.interrupt = transport.any(dem.interrupt);
                return Ok(());
            }
        }
        self.dem.advance(&self.transport).map_err(|e| self.failed(e))?;
        self.particle_steps += self.dem.particles.owned as u64;
        match &mut self.fluid {
            Some(fluid) => fluid.after_particle_step(&mut self.dem, &self.transport),
            None => Ok(()),
        }
    }

    /// Gives each rank the cells of the fluid that lie within its borders, if they have moved.
    fn rebalance(&mut self) -> Result<(), RunError> {
        let Self { case, dem, fluid, petsc, insertions, transport, files, .. } = self;
        let moved = fluid::rebalance(fluid, (case, petsc), dem, insertions.kinds(), transport)?;
        match (fluid, files) {
            (Some(fluid), Some(files)) if moved => files.divide(fluid),
            _ => Ok(()),
        }
    }

    /// The stop condition of the case holds: one more state is written, the last.
    fn end_soon(&mut self) {
        if self.transport.rank() == 0 {
            log::info!("stop condition met at t = {:.6} s", self.dem.time());
        }
        // To the fluid a single step of the particles is too short.
        self.is_stop_met = true;
        let step = self.dem.step;
        self.schedule.end = if self.fluid.is_some() { self.schedule.next(step) } else { step + 1 };
    }

    /// Says how far a steady flow has settled at the end.
    fn tell_of_steady(&self) {
        let Some(fluid) = self.fluid.as_ref().filter(|_| self.transport.rank() == 0) else { return };
        match fluid.told_of_steady() {
            Some(told) if fluid.is_settled() => log::info!("{told}"),
            Some(told) => log::warn!("{told}"),
            None => {}
        }
    }

    fn failed(&self, failure: Failure) -> RunError {
        let message = match failure {
            Failure::Here { error, step } => {
                let (time, rank) = (self.dem.time_of(step), self.transport.rank());
                // What a restart has changed shows in its first steps.
                let suspects = if step <= self.first_step + 2 { &*self.suspects } else { "" };
                format!("step {step} (t = {time:.6e} s), rank {rank}: {error}{suspects}")
            }
            Failure::Elsewhere => String::new(),
        };
        RunError::unphysical(message)
    }

    fn insert(&mut self) -> Result<(), RunError> {
        self.dem.clock.start();
        let inserted =
            self.insertions.insert_due(&self.case, &mut self.dem, &self.transport).map_err(RunError::case)?;
        self.dem.clock.charge(Phase::Insertion);
        if !inserted {
            return Ok(());
        }
        self.dem.refresh(&self.transport).map_err(|e| self.failed(e))?;
        let overlap = self.insertions.starting_overlap(&self.case, &self.dem);
        match self.transport.any(overlap.is_some()) {
            false => Ok(()),
            true => Err(RunError::case(overlap.unwrap_or_default())),
        }
    }

    /// The granular state of a checkpoint, to be taken before the contacts of its step.
    fn state(&mut self) -> State {
        self.dem.clock.start();
        let mut state = restart::state(&mut self.dem, &self.insertions, &self.transport);
        if self.is_stop_met && self.dem.step >= self.schedule.end {
            state.1.push((restart::STOP_MET.into(), "true".into()));
        }
        self.dem.clock.charge(Phase::Output);
        state
    }

    fn checkpoint(&mut self, state: State) -> Result<(), RunError> {
        let Self { fluid, files: Some(files), dem, transport, .. } = self else { return Ok(()) };
        if let Some(fluid) = fluid {
            fluid.settle_passages(transport)?;
        }
        dem.clock.start();
        let written = files.checkpoint((dem, fluid), state, transport);
        files.explained(written, transport)?;
        dem.clock.charge(Phase::Output);
        Ok(())
    }

    /// The outcome of writing; what fails because the directory is gone is told as that.
    fn explained<T>(&self, outcome: Result<T, RunError>) -> Result<T, RunError> {
        match &self.files {
            Some(files) => files.explained(outcome, &self.transport),
            None => outcome,
        }
    }

    /// Writes what is due and not yet in the files; returns whether the case's stop condition holds.
    fn observe(&mut self, is_last: bool) -> Result<bool, RunError> {
        let Self { fluid, files: Some(files), dem, transport, schedule, case, insertions, .. } = self else {
            return Ok(false);
        };
        let step = dem.step;
        let (row, snapshot, surfaces, of_fluid) = (
            schedule.series.is_due(step) || is_last,
            schedule.particles.is_due(step) || is_last,
            schedule.surfaces.is_due(step),
            fluid.is_some() && (schedule.fluid.is_due(step) || is_last),
        );
        if !(row || snapshot || surfaces || of_fluid) {
            return Ok(false);
        }
        dem.clock.start();
        if let Err(error) = dem.check_ledger(transport) {
            let step = dem.step;
            return Err(self.failed(Failure::Here { error, step }));
        }
        files.verify(transport)?;
        if snapshot && case.output.particles > 0.0 {
            files.snapshot(dem, transport)?;
        }
        if surfaces {
            files.surfaces(dem)?;
        }
        if let Some(phase) = fluid {
            if row {
                phase.take_means(case, dem, transport)?;
            }
            if of_fluid {
                files.fluid_snapshot(phase, dem, transport)?;
            }
        }
        let mut is_met = false;
        if row {
            let of_fluid = fluid.as_ref().map_or(Vec::new(), |f| f.row(case, dem, transport));
            let values = files.row(dem, &of_fluid, transport)?;
            let (stop, all) = (&case.stop, insertions.moving() as i64);
            let passed = stop.all_passed.is_some_and(|k| values.crossings[k] >= all);
            let settled = stop.kinetic_energy_below.is_some_and(|limit| values.kinetic_energy < limit);
            is_met = insertions.is_complete() && dem.time() >= stop.after && (passed || settled);
            self.progress = Some(Progress {
                step,
                time: dem.time(),
                end: schedule.end,
                totals: values,
                fluid: fluid.as_ref().map(|fluid| fluid.progress(&of_fluid)),
            });
        }
        self.dem.clock.charge(Phase::Output);
        Ok(is_met)
    }

    /// The case.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// What every file of this run says of its origin, by names: program, `case`, `case_sha256`, `inputs`, seed; nothing if none are
    /// written.
    pub fn origin(&self, name: &str) -> Option<&str> {
        let mut texts = self.files.iter().flat_map(|files| files.metadata());
        texts.find(|(own, _)| own == name).map(|(_, text)| text.as_str())
    }

    /// Time of the present state (s).
    pub fn time(&self) -> f64 {
        self.dem.time()
    }

    /// Time at which the simulation began or was continued (s).
    pub fn begin(&self) -> f64 {
        self.begin
    }

    /// Steps of the particles so far, those before a restart included.
    pub fn steps(&self) -> u64 {
        self.dem.step
    }

    /// The particles of this rank.
    pub fn particles(&self) -> impl Iterator<Item = ParticleView<'_>> {
        (0..self.dem.particles.owned).map(|i| ParticleView::new(&self.dem, i))
    }

    /// The walls, with the loads by this rank's particles.
    pub fn walls(&self) -> impl Iterator<Item = WallView<'_>> {
        (0..self.dem.setup.walls.len()).map(|k| WallView::new(&self.dem, k))
    }

    /// The fluid, if there is one.
    pub fn fluid(&self) -> Option<FluidView<'_>> {
        self.fluid.as_ref().map(FluidView::new)
    }

    /// The granular phase of this rank.
    pub fn dem(&self) -> &Dem {
        &self.dem
    }

    /// Forgets the times spent so far.
    pub fn reset_clock(&mut self) {
        self.dem.clock = grains_dem::Clock::default();
    }

    /// Whether this is rank 0, which tells what is the same on all.
    pub fn is_first_rank(&self) -> bool {
        self.transport.rank() == 0
    }

    /// Sum of a number over the ranks; collective.
    pub fn sum(&self, value: f64) -> f64 {
        let mut sums = [value];
        self.transport.sum(&mut sums);
        sums[0]
    }

    /// Largest of a number over the ranks; collective.
    pub fn max(&self, value: f64) -> f64 {
        let mut largest = [value];
        self.transport.max(&mut largest);
        largest[0]
    }

    /// Messages among the ranks of the simulation.
    pub fn transport(&self) -> &MpiTransport {
        &self.transport
    }

    /// The last row of the time series, if there is one.
    pub fn progress(&self) -> Option<&Progress> {
        self.progress.as_ref()
    }

    /// What the whole case is expected to take, as `check` says it, with the bonds that there are now; collective.
    pub fn prediction(&self) -> Prediction {
        let mut ends = [self.dem.bonds_of_each().into_iter().map(u64::from).sum()];
        self.transport.sum_counts(&mut ends);
        self.prediction.with_bonds(ends[0] / 2)
    }

    /// Steps done since the simulation was built.
    pub fn steps_done(&self) -> u64 {
        self.dem.step - self.first_step
    }

    /// Wall-clock time since the simulation was built (s).
    pub fn seconds(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }
}

/// The system of a case and its insertions; collective, each rank reads its share of their files.
fn build(case: &Case, world: &MpiTransport) -> Result<(System, Insertions), RunError> {
    let catalogue = agreed(world, system::catalogue(case).map_err(RunError::case))?;
    let insertions = Insertions::read(case, &catalogue, world)?;
    let system = system::build(case, world.size(), catalogue, insertions.kinds());
    Ok((agreed(world, system.map_err(RunError::case))?, insertions))
}
