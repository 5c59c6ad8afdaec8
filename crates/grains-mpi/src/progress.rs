//! What the terminal shows of a run: lines of progress, and a summary.

use crate::bar::{self, Bar};
use crate::control::Control;
use crate::messages;
use crate::record::{Beginning, Machine, Record};
use grains_analysis::Findings;
use grains_case::Case;
use grains_domain::Transport;
use grains_simulation::{FluidProgress, Progress, RunError, Simulation, Status, Summary, duration};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Seconds between lines: in a log file one every ten is enough; the CSV has them all.
const INTERVAL: f64 = 10.0;

/// What may stop a run before its end.
pub struct Limits {
    /// Set by a signal.
    pub interrupted: Arc<AtomicBool>,
    /// Wall-clock time (s).
    pub walltime: f64,
}

/// Runs a simulation to its end, or until a signal or the walltime stops it; rank 0 keeps a record from the first step on.
///
/// # Errors
/// A state that can no longer be trusted, or a file that cannot be written.
pub fn run(
    mut simulation: Simulation,
    beginning: &Beginning<'_>,
    Limits { interrupted, walltime }: &Limits,
    record: &mut Option<Record>,
) -> Result<(), RunError> {
    let is_first = simulation.transport().rank() == 0;
    let case = simulation.case().clone();
    let (mut told, mut last, mut is_new) = (None, Instant::now(), true);
    let mut control = is_first.then(|| Control::new(&simulation));
    let mut bar = is_first.then(Bar::on_terminal).flatten();
    let mut stopped_by = None;
    let machine = Machine::of(simulation.transport());
    let status = loop {
        let is_looking = control.as_mut().is_some_and(Control::is_due);
        let is_asked = is_looking && control.as_ref().is_some_and(Control::is_stop_asked);
        let reasons = [
            (is_asked, "request"),
            (interrupted.load(Ordering::Relaxed), "signal"),
            (simulation.seconds() > *walltime, "walltime"),
        ];
        if let Some((_, reason)) = reasons.into_iter().find(|(holds, _)| *holds) {
            simulation.stop();
            stopped_by = stopped_by.or(Some(reason));
        }
        let status = simulation.step()?;
        if is_new {
            // Bonds are there from the first step on.
            let prediction = simulation.prediction();
            *record = is_first.then(|| Record::new(beginning, &simulation, &machine, &prediction));
            is_new = false;
        }
        if let Some(bar) = bar.as_mut().filter(|bar| bar.is_due()) {
            bar.draw(&simulation);
        }
        let is_due = bar.is_none() && told.is_none()
            || status != Status::Running
            || bar.is_none() && last.elapsed().as_secs_f64() > INTERVAL;
        if let Some(progress) = simulation.progress().filter(|p| is_first && is_due && told != Some(p.step)) {
            bar::clear();
            say!("{}", line(progress, &simulation));
            (told, last) = (Some(progress.step), Instant::now());
        }
        if let Some(control) = control.as_mut().filter(|_| is_looking || status != Status::Running) {
            // Another rank may have got the signal.
            let reason = (status == Status::Stopped).then_some(stopped_by.unwrap_or("signal"));
            control.tell(&simulation, status, reason);
            record.iter_mut().for_each(Record::renew);
        }
        if status != Status::Running {
            break status;
        }
    };
    bar::clear();
    if is_first && status == Status::Stopped {
        let (step, time) = (simulation.steps(), simulation.time());
        say!("stopped at step {step}, t = {time:.6} s: continue with --restart latest");
    }
    let at = (simulation.steps(), simulation.time());
    let summary = simulation.close()?;
    if let Some(record) = record {
        summarise(&summary, &case);
        let reason = (status == Status::Stopped).then_some(stopped_by.unwrap_or("signal"));
        record.end((&summary, &case), (status, reason), at);
    }
    Ok(())
}

/// A line of progress.
fn line(progress: &Progress, simulation: &Simulation) -> String {
    let Progress { step, time, end, totals, fluid } = progress;
    let done = step.saturating_sub(simulation.steps() - simulation.steps_done());
    let rate = done as f64 / simulation.seconds();
    let left = if done > 0 { duration((end - step) as f64 / rate) } else { "-".into() };
    let (count, of_particles) = match fluid {
        Some(FluidProgress { step, is_alone: true, .. }) => (step, String::new()),
        _ => {
            let text = format!(
                "  particles {:>8}  contacts {:>8}  overlap {:>6.3} %  kinetic {:.3e} J  max speed {:.2} m/s  {rate:>7.1} steps/s",
                totals.particles,
                totals.contacts,
                100.0 * totals.max_overlap,
                totals.kinetic_energy,
                totals.max_speed
            );
            (step, text)
        }
    };
    let of_fluid = fluid.map_or(String::new(), |fluid| {
        format!(
            "  fluid dt {:.2e} s  CFL {:.2}  kinetic {:.3e} J  drop {:.4e} Pa  iterations {:.0}",
            fluid.dt, fluid.cfl, fluid.kinetic_energy, fluid.pressure_drop, fluid.iterations
        )
    });
    format!("step {count:>9}  t {time:>10.5} s{of_particles}{of_fluid}  left {left}")
}

/// Prints what a run has done.
fn summarise(summary: &Summary, case: &Case) {
    say!("\ntime by phase (s)          min       mean        max      share");
    for phase in &summary.phases {
        let share = 100.0 * phase.mean / summary.seconds;
        say!(
            "  {:<20} {:>10.3} {:>10.3} {:>10.3} {share:>9.1} %",
            phase.name,
            phase.min,
            phase.mean,
            phase.max
        );
    }
    let [memory, largest] = summary.memory.map(|bytes| bytes / 1e6);
    say!("memory: {memory:.0} MB in all, {largest:.0} MB on the largest rank");
    if let Some(fluid) = &summary.fluid {
        let steps = fluid.steps.max(1) as f64;
        say!(
            "fluid: {} steps, {:.1} iterations for the pressure each, {:.0} nanoseconds per cell and step",
            fluid.steps,
            fluid.iterations as f64 / steps,
            fluid.nanoseconds_per_cell_step(summary.ranks)
        );
    }
    if summary.fluid.is_some_and(|fluid| fluid.is_alone) {
        say!("{} on {} rank(s)", duration(summary.seconds), summary.ranks);
    } else {
        particles(summary, case);
    }
    say!("results in {}", case.output.directory.display());
}

/// Prints what became of the particles.
fn particles(summary: &Summary, case: &Case) {
    let Summary { inserted, inside, left, steps, .. } = *summary;
    say!("particles: {inserted} inserted = {inside} inside + {left} left through outlets");
    let [min, max] = summary.per_rank;
    say!(
        "particles per rank: {min} to {max}; the busiest rank worked {:.2} times the mean; borders moved {} times",
        summary.imbalance,
        summary.moves
    );
    for (name, lacking) in &summary.missing {
        warn(format!("{lacking} particles of insert `{name}` were not inserted: not yet due, or no room"));
    }
    let [min, max] = summary.rebuilds;
    let times = if min == max { max.to_string() } else { format!("{min} to {max}") };
    say!("lists rebuilt {times} times in {steps} steps");
    let is_hard = case.collisions.is_hard();
    if is_hard {
        let [collisions, resting, rounds] = summary.collisions;
        let rounds = rounds as f64 / steps.max(1) as f64;
        say!("{collisions} collisions, {resting} of them at rest, in {rounds:.1} rounds per step at most");
    }
    let (overlap, limit) = (summary.worst_overlap, case.limits.overlap);
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
    if summary.deep_penetrations > 0 {
        warn(format!(
            "{} deep penetrations, overlaps beyond the crust, took the slower penetration routine: a thicker crust (shape.crust) or a smaller step would be faster",
            summary.deep_penetrations
        ));
    }
    let (time, ranks) = (duration(summary.seconds), summary.ranks);
    if let Some(each) = summary.microseconds_per_particle_step() {
        say!("{time} on {ranks} rank(s): {each:.4} microseconds per particle and step");
    }
}

/// Prints a warning among the results, and keeps it.
fn warn(text: String) {
    say!("warning: {text}");
    messages::keep(text);
}

/// Prints what an analysis found.
pub fn tell(findings: &Findings) {
    /// Lines up to which all are shown.
    const ALL: usize = 6;
    let last = findings.lines.len().saturating_sub(1);
    for (k, line) in findings.lines.iter().enumerate() {
        // Of many states the first and the last; the tables hold all.
        if last < ALL || k == 0 || k == last {
            say!("{line}");
        } else if k == 1 {
            say!("…");
        }
    }
    say!("{}: {}", findings.folder.display(), findings.files.join(", "));
}
