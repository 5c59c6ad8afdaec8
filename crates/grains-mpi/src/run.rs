//! The run loop: refresh, contacts, output, checkpoint, advance.
//!
//! A checkpoint of step n is the state of step n before its contacts are evaluated, since they change what contacts remember. It
//! is written after all else that is due at step n. So the files of a directory are complete up to the step of each of its
//! checkpoints, whenever the run is stopped or killed, and one that continues writes at this step only what the files lack.

use crate::duration::duration;
use crate::error::{RunError, agreed};
use crate::files::Files;
use crate::fluid::{self, FluidPhase};
use crate::plausibility;
use crate::population::Population;
use crate::restart::{self, State};
use crate::system::{self, System};
use grains_case::Case;
use grains_comm::{Job, MpiTransport, exit};
use grains_dem::{Dem, Failure, Origin, Phase};
use grains_domain::Transport;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How a run is started.
pub struct RunOptions {
    /// Checkpoint to continue from, or `latest`.
    pub restart: Option<PathBuf>,
    /// Wall-clock time after which a checkpoint is written and the run leaves (s).
    pub max_walltime: f64,
    /// Whether a signal asked the run to leave.
    pub interrupted: Arc<AtomicBool>,
    /// Options for PETSc from the command line.
    pub petsc: Vec<String>,
}

/// The system of a case and its insertions; collective, each rank reads its share of their files.
///
/// # Errors
/// Anything wrong with the case or its files.
pub fn build(case: &Case, world: &MpiTransport) -> Result<(System, Population), RunError> {
    let catalogue = agreed(world, system::catalogue(case).map_err(RunError::case))?;
    let population = Population::read(case, &catalogue, world)?;
    let system = system::build(case, world.size(), catalogue, population.kinds());
    Ok((agreed(world, system.map_err(RunError::case))?, population))
}

/// Steps at which something is written every `interval` (s): those nearest to its multiples, so that the events of
/// intervals that are multiples of each other coincide.
#[derive(Clone, Copy)]
struct Events {
    /// Steps between two of them, not whole in general; infinite for never.
    every: f64,
    /// The step at which time would be zero: zero until the time step changes.
    zero: f64,
}

impl Events {
    fn new(interval: f64, dt: f64, origin: &Origin) -> Self {
        let zero = origin.step as f64 - origin.time / dt;
        Self { every: if interval > 0.0 { (interval / dt).max(1.0) } else { f64::INFINITY }, zero }
    }

    /// Step of the event with a number; halves fall to the same side, however their intervals are rounded.
    fn at(self, number: f64) -> u64 {
        (self.zero + number * self.every - 1e-4).round() as u64
    }

    /// The first event after a step.
    fn next(self, step: u64) -> u64 {
        let number = ((step as f64 - self.zero) / self.every).floor();
        [0.0, 1.0, 2.0]
            .map(|n| self.at(number + n))
            .into_iter()
            .find(|&event| event > step)
            .unwrap_or(u64::MAX)
    }

    fn is_due(self, step: u64) -> bool {
        step == 0 && self.every.is_finite() || step > 0 && self.next(step - 1) == step
    }
}

/// When a run writes what, and its last step.
struct Schedule {
    particles: Events,
    series: Events,
    checkpoint: Events,
    surfaces: Events,
    fluid: Events,
    end: u64,
}

impl Schedule {
    fn new(case: &Case, dt: f64, origin: &Origin) -> Self {
        let (every, out) = (|seconds| Events::new(seconds, dt, origin), &case.output);
        Self {
            particles: every(out.particles),
            series: every(out.series),
            checkpoint: every(out.checkpoint),
            surfaces: every(out.surfaces),
            fluid: every(case.fluid.as_ref().map_or(0.0, |f| f.output.interval.unwrap_or(out.particles))),
            end: every(case.time.end).at(1.0),
        }
    }

    /// The next step at which something is written, after `step`.
    fn next(&self, step: u64) -> u64 {
        let events = [self.particles, self.series, self.checkpoint, self.surfaces, self.fluid];
        events.into_iter().map(|events| events.next(step)).fold(self.end, u64::min)
    }
}

/// A run in progress.
pub struct Run<'a> {
    case: &'a Case,
    /// The granular phase.
    pub dem: Dem,
    /// Freed after the messages `dem` has prepared.
    transport: MpiTransport,
    fluid: Option<FluidPhase>,
    population: Population,
    files: Files,
    schedule: Schedule,
    options: RunOptions,
    begun: Instant,
    first_step: u64,
    /// Whether the fluid begins with this run.
    is_fluid_new: bool,
    last_progress: Instant,
}

impl<'a> Run<'a> {
    /// Prepares a run: builds the system, and fills it or takes a checkpoint.
    ///
    /// # Errors
    /// Anything wrong with the case, its files or the checkpoint.
    pub fn prepare(
        case: &'a Case,
        job: &Job,
        world: &MpiTransport,
        options: RunOptions,
    ) -> Result<Self, RunError> {
        let (system, mut population) = build(case, world)?;
        let warnings = plausibility::warnings(case, &system, &population);
        let System { setup, step } = system;
        let transport = system::transport(case, &setup, job)?;
        let mut dem = system::dem(case, setup, transport.rank()).map_err(RunError::case)?;
        dem.guide(population.guides(case));
        if transport.rank() == 0 {
            step.warning.iter().chain(&warnings).for_each(|w| eprintln!("warning: {w}"));
            say!("time step {:e} s: {}; {}", step.dt, step.resolution(case), step.reason);
        }
        let mut fluid = FluidPhase::new(case, &options.petsc, &mut dem, population.kinds(), &transport)?;
        let continued = match &options.restart {
            Some(checkpoint) => {
                let state = (&mut dem, &mut fluid);
                Some(restart::restore(case, &transport, checkpoint, state, &mut population)?)
            }
            None => None,
        };
        let files = Files::open(case, &transport, continued.as_ref(), &dem, &fluid)?;
        let schedule = Schedule::new(case, dem.setup.rates.dt, &dem.origin);
        let first_step = dem.step;
        let is_fluid_new = continued.is_none_or(|continued| continued.is_fluid_new);
        Ok(Self {
            case,
            transport,
            dem,
            fluid,
            population,
            files,
            schedule,
            options,
            begun: Instant::now(),
            first_step,
            is_fluid_new,
            last_progress: Instant::now(),
        })
    }

    /// Runs to the end, or until a signal, the walltime or the case's stop condition.
    ///
    /// # Errors
    /// A state that can no longer be trusted, or a file that cannot be written.
    pub fn go(&mut self) -> Result<(), RunError> {
        let mut is_inserted = self.options.restart.is_some();
        loop {
            // A checkpoint holds what was inserted at its step.
            if !std::mem::take(&mut is_inserted) {
                self.insert()?;
            }
            let step = self.dem.step;
            // Until the contacts of this step nothing looks at clones.
            self.dem.start_refresh(&self.transport).map_err(|e| self.failed(e))?;
            if let Some(fluid) = &mut self.fluid {
                fluid.note_passages(&mut self.dem);
            }
            self.follow_borders()?;
            if step == self.first_step
                && self.is_fluid_new
                && let Some(fluid) = &mut self.fluid
            {
                fluid.begin(&self.dem, &self.transport)?;
            }
            let is_last = step >= self.schedule.end;
            let is_saved = self.dem.interrupt || self.schedule.checkpoint.is_due(step) || is_last;
            let state = (is_saved && step > self.first_step).then(|| self.state());
            self.dem.add_forces(&self.transport);
            let finished = self.observe(is_last);
            let finished = self.files.explained(finished, &self.transport)?;
            if let Some(state) = state {
                self.checkpoint(state)?;
            }
            if is_last {
                self.dem.check(&self.transport).map_err(|e| self.failed(e))?;
                break;
            }
            if self.dem.interrupt {
                self.say(&format!(
                    "stopped at step {step}, t = {:.6} s: continue with --restart latest",
                    self.dem.time()
                ));
                break;
            }
            if finished {
                self.say(&format!("stop condition met at t = {:.6} s", self.dem.time()));
                // The last step writes all there is to write; to the fluid a single one of the particles is too short.
                let next = if self.fluid.is_some() { self.schedule.next(step) } else { step + 1 };
                self.schedule.end = next;
            }
            let asked = self.options.interrupted.load(Ordering::Relaxed);
            let out_of_time = self.begun.elapsed().as_secs_f64() > self.options.max_walltime;
            self.dem.interrupt = asked || out_of_time;
            self.advance()?;
        }
        self.summary();
        Ok(())
    }

    /// The step of the fluid if it is its turn, and that of the particles.
    fn advance(&mut self) -> Result<(), RunError> {
        let Self { fluid, dem, transport, schedule, .. } = self;
        if let Some(fluid) = fluid {
            fluid.act(dem, schedule.next(dem.step), transport)?;
            if fluid.is_alone() {
                // Nothing else moves: on to the next step of the fluid.
                dem.resume_at(fluid.next_step);
                dem.interrupt = transport.any(dem.interrupt);
                return Ok(());
            }
        }
        self.dem.advance(&self.transport).map_err(|e| self.failed(e))?;
        match &mut self.fluid {
            Some(fluid) => fluid.catch_up(&mut self.dem, &self.transport),
            None => Ok(()),
        }
    }

    /// Gives each rank the cells of the fluid that lie within its borders, if they have moved.
    fn follow_borders(&mut self) -> Result<(), RunError> {
        let Self { case, dem, fluid, options, population, transport, .. } = self;
        let moved = fluid::follow_borders(fluid, (case, &options.petsc), dem, population.kinds(), transport)?;
        match fluid {
            Some(fluid) if moved => self.files.divide(fluid),
            _ => Ok(()),
        }
    }

    fn say(&self, text: &str) {
        if self.transport.rank() == 0 {
            say!("{text}");
        }
    }

    fn failed(&self, failure: Failure) -> RunError {
        let message = match failure {
            Failure::Here(error) => {
                let (step, time, rank) = (self.dem.step, self.dem.time(), self.transport.rank());
                format!("step {step} (t = {time:.6e} s), rank {rank}: {error}")
            }
            Failure::Elsewhere => String::new(),
        };
        RunError { code: exit::UNSTABLE, message }
    }

    fn insert(&mut self) -> Result<(), RunError> {
        let inserted =
            self.population.insert_due(self.case, &mut self.dem, &self.transport).map_err(RunError::case)?;
        if !inserted {
            return Ok(());
        }
        self.dem.refresh(&self.transport).map_err(|e| self.failed(e))?;
        let overlap = self.population.starting_overlap(self.case, &self.dem);
        match self.transport.any(overlap.is_some()) {
            false => Ok(()),
            true => Err(RunError::case(overlap.unwrap_or_default())),
        }
    }

    /// The granular state of a checkpoint, to be taken before the contacts of its step.
    fn state(&mut self) -> State {
        self.dem.clock.start();
        let state = restart::state(&mut self.dem, &self.population, &self.transport);
        self.dem.clock.charge(Phase::Output);
        state
    }

    fn checkpoint(&mut self, state: State) -> Result<(), RunError> {
        if let Some(fluid) = &mut self.fluid {
            fluid.settle_passages(&self.transport)?;
        }
        self.dem.clock.start();
        let written = self.files.checkpoint((&self.dem, &self.fluid), state, &self.transport);
        self.files.explained(written, &self.transport)?;
        self.dem.clock.charge(Phase::Output);
        Ok(())
    }

    /// Writes what is due and not yet in the files; returns whether the case's stop condition holds.
    fn observe(&mut self, is_last: bool) -> Result<bool, RunError> {
        let step = self.dem.step;
        let wants = |events: Events| events.is_due(step) || is_last;
        let (row, snapshot, surfaces, fluid) = (
            wants(self.schedule.series),
            wants(self.schedule.particles),
            self.schedule.surfaces.is_due(step),
            self.fluid.is_some() && wants(self.schedule.fluid),
        );
        if !(row || snapshot || surfaces || fluid) {
            return Ok(false);
        }
        self.dem.clock.start();
        self.dem.check_ledger(&self.transport).map_err(|e| self.failed(Failure::Here(e)))?;
        self.files.verify(&self.transport)?;
        if snapshot && self.case.output.particles > 0.0 {
            self.files.snapshot(&self.dem, &self.transport)?;
        }
        if surfaces {
            self.files.surfaces(&self.dem)?;
        }
        if let Some(phase) = &mut self.fluid {
            if row {
                phase.take_means(self.case, &self.dem, &self.transport)?;
            }
            if fluid {
                self.files.fluid_snapshot(phase, &self.dem, &self.transport)?;
            }
        }
        let mut finished = false;
        if row {
            finished = self.row(is_last)?;
        }
        self.dem.clock.charge(Phase::Output);
        Ok(finished)
    }

    fn row(&mut self, is_last: bool) -> Result<bool, RunError> {
        let of_fluid =
            self.fluid.as_ref().map_or(Vec::new(), |f| f.row(self.case, &self.dem, &self.transport));
        let values = self.files.row(&mut self.dem, &of_fluid, &self.transport)?;
        let stop = &self.case.stop;
        let all_in = self.population.is_complete();
        let passed =
            stop.all_passed.is_some_and(|k| values.crossings[k].0 >= self.population.moving() as i64);
        let settled = stop.kinetic_energy_below.is_some_and(|limit| values.kinetic_energy < limit);
        let finished = all_in && self.dem.time() >= stop.after && (passed || settled);
        // In a log file one line every ten seconds is enough; the CSV has them all.
        if self.last_progress.elapsed().as_secs_f64() > 10.0
            || is_last
            || finished
            || self.dem.step == self.first_step
        {
            self.last_progress = Instant::now();
            let done = self.dem.step - self.first_step;
            let elapsed = self.begun.elapsed().as_secs_f64();
            let left = if done > 0 {
                duration(elapsed / done as f64 * (self.schedule.end - self.dem.step) as f64)
            } else {
                "-".into()
            };
            let (step, time, rate) = (self.dem.step, self.dem.time(), done as f64 / elapsed);
            let of_particles = format!(
                "  particles {:>8}  contacts {:>8}  overlap {:>6.3} %  kinetic {:.3e} J  max speed {:.2} m/s  {rate:>7.1} steps/s",
                values.particles,
                values.contacts,
                100.0 * values.largest_overlap,
                values.kinetic_energy,
                values.largest_speed
            );
            let is_alone = self.fluid.as_ref().is_some_and(FluidPhase::is_alone);
            let (count, of_particles) = match &self.fluid {
                Some(fluid) if is_alone => (fluid.flow.state.step, String::new()),
                _ => (step, of_particles),
            };
            let of_fluid = if self.fluid.is_some() { fluid::progress(&of_fluid) } else { String::new() };
            self.say(&format!("step {count:>9}  t {time:>10.5} s{of_particles}{of_fluid}  left {left}"));
        }
        Ok(finished)
    }

    fn summary(&mut self) {
        let elapsed = self.begun.elapsed().as_secs_f64();
        let steps = self.dem.step - self.first_step;
        let mut parts: Vec<(String, f64)> = Phase::ALL
            .iter()
            .zip(self.dem.clock.seconds())
            .map(|((_, name), &s)| (name.to_string(), s))
            .collect();
        parts.extend(self.fluid.iter().flat_map(FluidPhase::times));
        let seconds: Vec<f64> = parts.iter().map(|&(_, s)| s).collect();
        let mut sums = seconds.clone();
        self.transport.sum(&mut sums);
        // Largest of each and, as largest of the negative, least.
        let mut spans: Vec<f64> = seconds.iter().flat_map(|&s| [s, -s]).collect();
        self.transport.max(&mut spans);
        let mut counts = [
            self.dem.particles.owned as u64,
            self.dem.ledger.inserted,
            self.dem.ledger.left,
            self.dem.report.cores_met,
            self.dem.report.collisions,
            self.dem.report.resting_collisions,
            self.dem.work(),
        ];
        let (own, own_work) = (counts[0], counts[6]);
        self.transport.sum_counts(&mut counts);
        let ranks = self.transport.size();
        let mut extremes = [own as f64, -(own as f64), self.dem.report.worst_overlap, own_work as f64];
        self.transport.max(&mut extremes);
        let peak = crate::cost::peak_memory().unwrap_or(f64::NAN);
        let (mut memory, mut largest) = ([peak], [peak]);
        self.transport.sum(&mut memory);
        self.transport.max(&mut largest);
        if self.transport.rank() != 0 {
            return;
        }
        say!("\ntime by phase (s)          min       mean        max      share");
        for (k, (name, _)) in parts.iter().enumerate() {
            let (mean, most, least) = (sums[k] / ranks as f64, spans[2 * k], -spans[2 * k + 1]);
            say!("  {name:<20} {least:>10.3} {mean:>10.3} {most:>10.3} {:>9.1} %", 100.0 * mean / elapsed);
        }
        say!("memory: {:.0} MB in all, {:.0} MB on the largest rank", memory[0] / 1e6, largest[0] / 1e6);
        let [inside, inserted, left, cores_met, collisions, resting, work] = counts;
        if let Some(fluid) = &self.fluid {
            say!(
                "fluid: {} steps, {:.1} iterations for the pressure each, {:.0} nanoseconds per cell and step",
                fluid.steps,
                fluid.iterations as f64 / fluid.steps.max(1) as f64,
                1e9 * fluid.seconds[0] * ranks as f64
                    / fluid.steps.max(1) as f64
                    / fluid.flow.setup.grid.cells().iter().product::<usize>() as f64
            );
            if fluid.is_alone() {
                say!(
                    "{} on {ranks} rank(s)\nresults in {}",
                    duration(elapsed),
                    self.case.output.directory.display()
                );
                return;
            }
        }
        say!("particles: {inserted} inserted = {inside} inside + {left} left through outlets");
        let [most, least, overlap, most_work] = extremes;
        let of_mean = most_work * ranks as f64 / (work as f64).max(1.0);
        say!(
            "particles per rank: {} to {most}; the busiest rank worked {of_mean:.2} times the mean; borders moved {} times",
            -least,
            self.dem.report.moves
        );
        for (name, lacking) in self.population.missing() {
            say!(
                "warning: {lacking} particles of insert `{name}` were not inserted: not yet due, or no room"
            );
        }
        say!("lists rebuilt {} times in {steps} steps", self.dem.report.rebuilds);
        let limit = self.case.limits.overlap;
        let is_hard = self.case.collisions.is_hard();
        if is_hard {
            say!(
                "{collisions} collisions, {resting} of them at rest, in {:.1} rounds per step",
                self.dem.report.rounds as f64 / steps.max(1) as f64
            );
        }
        let judgement = match (overlap > 0.5 * limit, is_hard) {
            (true, false) => ", near the limit: a stiffer contact would be safer",
            (true, true) => ", near the limit: a smaller time step would be safer",
            _ => "",
        };
        say!(
            "largest overlap {:.2} % of the radius; limits.overlap is {:.1} %{judgement}",
            100.0 * overlap,
            100.0 * limit
        );
        if cores_met > 0 {
            say!(
                "warning: shrunken cores met {cores_met} times and were resolved by the penetration routine: a thicker crust (shape.crust) or a smaller step would be faster"
            );
        }
        if inside > 0 && steps > 0 {
            say!(
                "{} on {ranks} rank(s): {:.4} microseconds per particle and step",
                duration(elapsed),
                1e6 * elapsed / steps as f64 / inside as f64
            );
        }
        say!("results in {}", self.case.output.directory.display());
    }
}

#[cfg(test)]
mod tests {
    use super::{Events, Schedule};
    use grains_dem::Origin;

    #[test]
    fn events_of_commensurate_intervals_coincide_and_keep_to_their_times() {
        for dt in [7e-6, 2.5e-6, 1e-4, 3.3e-4, 9.1e-6] {
            let every = |seconds| Events::new(seconds, dt, &Origin::default());
            let end = every(10.0).at(1.0);
            let [series, particles, checkpoint] = [0.002, 0.1, 1.0].map(every);
            let (surfaces, fluid) = (every(0.0), every(0.3));
            let schedule = Schedule { particles, series, checkpoint, surfaces, fluid, end };
            let (mut step, mut rows) = (0, 0);
            while step < end {
                let next = schedule.next(step);
                rows += 1;
                assert!(
                    (next as f64 * dt - 0.002 * f64::from(rows)).abs() <= 0.501 * dt,
                    "{dt} row {rows}: {next}"
                );
                assert!(series.is_due(next));
                assert_eq!(particles.is_due(next), rows % 50 == 0, "{dt} row {rows}");
                assert_eq!(checkpoint.is_due(next), rows % 500 == 0, "{dt} row {rows}");
                assert_eq!(fluid.is_due(next), rows % 150 == 0, "{dt} row {rows}");
                assert!(!surfaces.is_due(next));
                step = next;
            }
            assert_eq!(rows, 5000, "{dt}");
        }
    }

    #[test]
    fn events_keep_to_their_times_when_the_time_step_changes() {
        let origin = Origin { step: 1000, time: 0.1 };
        for dt in [3e-5, 2.5e-4, 1e-4 / 7.0] {
            let events = Events::new(0.004, dt, &origin);
            let mut step = origin.step;
            for number in 26..100 {
                step = events.next(step);
                assert!(
                    (origin.time_of(step, dt) - 0.004 * f64::from(number)).abs() <= 0.501 * dt,
                    "{dt} {number}"
                );
                assert!(events.is_due(step) && !events.is_due(step + 1));
            }
        }
    }

    #[test]
    fn intervals_below_a_step_come_at_every_step() {
        let events = Events::new(1e-9, 1e-6, &Origin::default());
        assert_eq!([0, 1, 2].map(|step| events.next(step)), [1, 2, 3]);
        assert!(events.is_due(0) && events.is_due(7));
    }
}
