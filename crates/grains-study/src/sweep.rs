//! Runs members side by side, each to its end.

use crate::error::StudyError;
use crate::folder::{Folder, Record, State};
use crate::launch::Launch;
use crate::measure;
use crate::member::{Member, told_varied};
use crate::study_file::{Keep, Study};
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Says a line on the terminal.
pub type Say<'a> = &'a (dyn Fn(&str) + Sync);

/// Members that are run together.
pub(crate) struct Sweep<'a> {
    pub study: &'a Study,
    pub directory: &'a Path,
    pub launch: &'a Launch,
    pub jobs: usize,
    pub say: Say<'a>,
}

impl Sweep<'_> {
    /// Runs members, as many side by side as there are jobs; what becomes of each is kept in its folder.
    ///
    /// # Errors
    /// A file that cannot be written, or a program that cannot be started.
    pub fn run(&self, members: &[&Member]) -> Result<(), StudyError> {
        let (next, ended) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let problem = Mutex::new(None);
        let begun = Instant::now();
        let has_problem = || problem.lock().map_or(true, |found| found.is_some());
        let work = || {
            while !self.launch.is_interrupted() && !has_problem() {
                let Some(member) = members.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                match self.run_one(member) {
                    Ok(record) => {
                        let ended = ended.fetch_add(1, Ordering::Relaxed) + 1;
                        let each = begun.elapsed().as_secs_f64() / ended as f64;
                        self.tell(member, &record, each * (members.len() - ended) as f64);
                    }
                    Err(error) => {
                        if let Ok(mut problem) = problem.lock() {
                            *problem = Some(error);
                        }
                    }
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..self.jobs.min(members.len()) {
                scope.spawn(work);
            }
        });
        problem.into_inner().ok().flatten().map_or(Ok(()), Err)
    }

    /// Runs a member to its end, or until it leaves or fails.
    fn run_one(&self, member: &Member) -> Result<Record, StudyError> {
        let folder = Folder::of(self.directory, member.number);
        folder.create(&member.text)?;
        if self.launch.wait_for_others(&folder) {
            (self.say)(&format!("{:04}: ran already, started elsewhere; goes on from there", member.number));
        }
        let before = folder.record();
        // A run that ended while nobody looked is at its end all the same.
        let is_finished = folder.status().state == "finished";
        let mut record = Record {
            state: State::Begun,
            version: self.launch.version.clone(),
            tries: before.tries + 1,
            message: None,
            code: None,
            ..before
        };
        folder.keep(&record)?;
        let begun = Instant::now();
        let ended = if is_finished {
            None
        } else {
            // What failed begins anew: its state may be what is wrong.
            let goes_on = before.state != State::Failed && folder.has_checkpoint();
            Some(self.launch.run(&folder, goes_on)?)
        };
        let status = folder.status();
        if status.step > record.step {
            (record.step, record.tries) = (status.step, 0);
        }
        match ended {
            Some(status) if !status.success() => self.note_failure(&folder, status, &mut record),
            _ if status.state == "finished" => self.finish(&folder, &mut record)?,
            _ => record.state = State::Stopped,
        }
        record.seconds += begun.elapsed().as_secs_f64();
        folder.keep(&record)?;
        Ok(record)
    }

    fn note_failure(&self, folder: &Folder, status: std::process::ExitStatus, record: &mut Record) {
        if self.launch.is_interrupted() && (status.signal().is_some() || !folder.has_checkpoint()) {
            // It was stopped before it could write anything.
            record.state = State::Stopped;
            return;
        }
        record.state = State::Failed;
        record.code = status.code();
        let log = folder.file("log");
        record.message = Some(
            folder.error().unwrap_or_else(|| format!("{status}, without a word; see {}", log.display())),
        );
    }

    /// Takes the measures of a run at its end, and removes what shall not stay.
    fn finish(&self, folder: &Folder, record: &mut Record) -> Result<(), StudyError> {
        if let Err(error) = measure::prepare(self.study, folder, self.launch) {
            if self.launch.is_interrupted() {
                record.state = State::Stopped;
                return Ok(());
            }
            (record.state, record.message) = (State::Failed, Some(error.to_string()));
            return Ok(());
        }
        record.state = State::Done;
        if self.study.run.keep == Keep::Series {
            remove_states(&folder.run())?;
        }
        Ok(())
    }

    /// A line about a member, and the time (s) that is left.
    fn tell(&self, member: &Member, record: &Record, left: f64) {
        let taken = || {
            let folder = Folder::of(self.directory, member.number);
            let one = |name: &String| match measure::take(self.study, name, &folder) {
                Ok(value) => format!("{name} = {}{}", rounded(value.number), in_unit(&value.unit)),
                Err(error) => format!("{name}: {error}"),
            };
            self.study.measure.keys().map(one).collect::<Vec<_>>().join(", ")
        };
        let what = match (record.state, &record.message) {
            (State::Done, _) => taken(),
            (State::Failed, Some(message)) => format!("failed: {message}"),
            (State::Stopped, _) => "stopped; the same command goes on".into(),
            (state, _) => state.word().into(),
        };
        let left = if left > 0.0 { format!(", left {}", duration(left)) } else { String::new() };
        (self.say)(&format!(
            "{:04}  {}  {what}  ({}{left})",
            member.number,
            told_varied(self.study, &member.values),
            duration(record.seconds)
        ));
    }
}

/// Removes snapshots and checkpoints.
fn remove_states(run: &Path) -> Result<(), StudyError> {
    for entry in fs::read_dir(run).into_iter().flatten().flatten() {
        let path = entry.path();
        let is_state =
            path.extension().is_some_and(|e| ["vtkhdf", "xdmf", "h5", "vtp"].iter().any(|word| e == *word));
        let removed = match path.is_dir() {
            true if entry.file_name() == "shapes" => fs::remove_dir_all(&path),
            false if is_state => fs::remove_file(&path),
            _ => Ok(()),
        };
        removed.map_err(|error| StudyError::of_file(&path, format!("cannot be removed: {error}")))?;
    }
    Ok(())
}

/// A number with four digits.
pub(crate) fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// A unit behind a number; none of a pure number.
pub(crate) fn in_unit(unit: &str) -> String {
    if unit.is_empty() || unit == "-" { String::new() } else { format!(" {unit}") }
}

/// A time for the terminal: `12 s`, `3 min`, `2.5 h`.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 119.5 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
