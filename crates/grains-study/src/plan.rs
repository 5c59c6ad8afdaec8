//! What is asked of a study: its members, those that are left, and what came of them.

use crate::design::{self, Values};
use crate::error::StudyError;
use crate::estimate::Observation;
use crate::fit::{Search, Verdict};
use crate::fit_report::FitReport;
use crate::folder::{Folder, Numbers, State, write};
use crate::launch::Launch;
use crate::measure;
use crate::member::{Member, Pattern, told_varied};
use crate::picture;
use crate::slurm;
use crate::study_file::Study;
use crate::sweep::{Say, Sweep};
use crate::table::Table;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// What is asked of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// To run what is left and to gather all.
    Run,
    /// To run one member.
    Only(usize),
    /// To gather what there is.
    Gather,
    /// To print the numbers of the members that a batch system is to run.
    Left,
    /// To check and list all members.
    DryRun,
}

/// How a study is carried out.
#[derive(Clone, Debug)]
pub struct Options {
    /// What is asked.
    pub task: Task,
    /// Runs side by side (-).
    pub jobs: usize,
    /// Whether members are run again that failed for a reason of their own.
    pub retry: bool,
}

/// A member of a search as it is kept from call to call.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
struct Asked {
    round: usize,
    /// What is added to the seed of the case.
    shift: u64,
    values: Values,
}

/// A study that is carried out.
struct Plan<'a> {
    study: &'a Study,
    options: &'a Options,
    launch: &'a Launch,
    say: Say<'a>,
    directory: PathBuf,
    pattern: Pattern<'a>,
    numbers: Numbers,
    members: Vec<Member>,
}

/// Carries out what is asked of a study, and says on the terminal what comes of it.
///
/// # Errors
/// A study or member that is wrong, files that cannot be written, and runs that failed.
pub fn carry_out(study: &Study, options: &Options, launch: &Launch, say: Say<'_>) -> Result<(), StudyError> {
    let directory = study.directory();
    let mut plan = Plan {
        pattern: Pattern::read(study)?,
        numbers: Numbers::read(&directory),
        members: Vec::new(),
        study,
        options,
        launch,
        say,
        directory,
    };
    let mut search = study.fit.is_some().then(|| Search::new(study));
    plan.begin(search.as_ref())?;
    match options.task {
        Task::DryRun => {
            plan.list();
            return Ok(());
        }
        Task::Only(number) => return plan.run_only(number),
        _ => {}
    }
    let _lock = plan.lock()?;
    let verdict = plan.advance(search.as_mut())?;
    if options.task == Task::Left {
        say(&slurm::array(plan.left().iter().map(|member| member.number).collect()));
        return Ok(());
    }
    plan.gather(search.as_ref().map(|search| (search, verdict)))
}

impl Plan<'_> {
    /// Makes the members that are known from the beginning, all of which are checked.
    fn begin(&mut self, search: Option<&Search>) -> Result<(), StudyError> {
        let repeats = self.study.design.repeats;
        let Some(search) = search else {
            for values in design::points(self.study)? {
                for repeat in 0..repeats {
                    self.add(0, &values, (repeats > 1).then_some(repeat as u64))?;
                }
            }
            return Ok(());
        };
        // What was asked for once stays, though the targets may have changed meanwhile.
        let text = fs::read_to_string(self.asked_file()).unwrap_or_default();
        let asked: Vec<Asked> = serde_json::from_str(&text).unwrap_or_default();
        let is_inside = |asked: &&Asked| {
            let names: BTreeSet<&String> = asked.values.keys().collect();
            names == self.study.vary.keys().collect()
                && search.coordinates(&asked.values).iter().all(|x| x.abs() < 1.0 + 1e-9)
        };
        let asked: Vec<Asked> = asked.iter().filter(is_inside).cloned().collect();
        if asked.is_empty() {
            return self.ask(0, &search.first());
        }
        // Every run of a search has a seed of its own, so that what runs have in common is no bias.
        asked.iter().try_for_each(|asked| self.add(asked.round, &asked.values, Some(asked.shift)))
    }

    fn asked_file(&self) -> PathBuf {
        self.directory.join("search.json")
    }

    /// Adds the points of a round of a search, with repeats.
    fn ask(&mut self, round: usize, points: &[Values]) -> Result<(), StudyError> {
        let mut shift = self.members.iter().map(|member| member.shift + 1).max().unwrap_or(0);
        for values in points {
            for _ in 0..self.study.design.repeats {
                self.add(round, values, Some(shift))?;
                shift += 1;
            }
        }
        Ok(())
    }

    /// Adds a member after a check of its case; one that is there already is not added again.
    fn add(&mut self, round: usize, values: &Values, shift: Option<u64>) -> Result<(), StudyError> {
        let (text, seed) = self.pattern.text(values, shift)?;
        let number = self.numbers.of(&text);
        if self.members.iter().all(|member| member.number != number) {
            let shift = shift.unwrap_or(0);
            self.members.push(Member { number, round, seed, shift, values: values.clone(), text });
        }
        Ok(())
    }

    /// Refuses a second call at the same time.
    fn lock(&self) -> Result<fs::File, StudyError> {
        let path = self.directory.join(".lock");
        let refuse = |error: &dyn std::fmt::Display| StudyError::of_file(&path, error);
        let unwritten = |error: std::io::Error| {
            StudyError::of_file(
                &self.directory,
                format!("cannot be written: {error}; choose another `directory` of the study"),
            )
        };
        fs::create_dir_all(&self.directory).map_err(unwritten)?;
        let file = fs::File::create(&path).map_err(unwritten)?;
        match file.try_lock() {
            Err(fs::TryLockError::WouldBlock) => Err(refuse(
                &"another `grains-mpi sweep` of this study is at work; wait until it has ended, or stop it with Ctrl-C",
            )),
            _ => Ok(file),
        }
    }

    /// Writes the cases of all members, and what a search has asked for.
    fn write_cases(&self) -> Result<(), StudyError> {
        for member in &self.members {
            Folder::of(&self.directory, member.number).create(&member.text)?;
        }
        if self.study.fit.is_none() {
            return Ok(());
        }
        let of = |m: &Member| Asked { round: m.round, shift: m.shift, values: m.values.clone() };
        let asked: Vec<Asked> = self.members.iter().map(of).collect();
        write(&self.asked_file(), &(serde_json::to_string_pretty(&asked).unwrap_or_default() + "\n"))
    }

    /// Runs what is open, and lets a search ask for more until it ends or something stays open.
    fn advance(&mut self, search: Option<&mut Search>) -> Result<Verdict, StudyError> {
        let Some(search) = search else {
            self.write_cases()?;
            self.run_open()?;
            return Ok(Verdict::GoesOn);
        };
        let mut learned = 0;
        loop {
            self.write_cases()?;
            self.run_open()?;
            if self.launch.is_interrupted() || !self.left().is_empty() {
                return Ok(Verdict::GoesOn);
            }
            let last = self.members.iter().map(|member| member.round).max().unwrap_or(0);
            let mut verdict = Verdict::GoesOn;
            // Round by round, so that a search that has ended is known as such when it is asked again.
            for round in std::mem::replace(&mut learned, last + 1)..=last {
                verdict = match search.learn(&self.observations(search, round)) {
                    Ok(verdict) => verdict,
                    Err(_) if round < last => continue,
                    Err(problem) => return Err(self.no_fit(&problem)),
                };
            }
            if verdict != Verdict::GoesOn {
                return Ok(verdict);
            }
            let points = search.next();
            if self.options.task == Task::Run {
                (self.say)(&format!(
                    "round {}: runs around {}",
                    last + 1,
                    told_varied(self.study, &points[0])
                ));
            }
            self.ask(last + 1, &points)?;
        }
    }

    fn no_fit(&self, problem: &str) -> StudyError {
        let (study, directory) = (&self.study.written.0, self.directory.display());
        StudyError::Runs(format!("{study}: no fit: {problem}; see the logs in {directory}"))
    }

    /// Runs the members that are not settled, unless only what there is is asked for.
    fn run_open(&self) -> Result<(), StudyError> {
        let open = self.open();
        if self.options.task != Task::Run || open.is_empty() {
            return Ok(());
        }
        let settled = self.members.len() - open.len();
        let jobs = self.options.jobs.min(open.len());
        (self.say)(&format!(
            "{} of {} members to run, {jobs} side by side",
            open.len(),
            settled + open.len()
        ));
        self.sweep(&open)
    }

    fn sweep(&self, members: &[&Member]) -> Result<(), StudyError> {
        let Self { study, directory, launch, options, say, .. } = self;
        Sweep { study, directory, launch, jobs: options.jobs, say }.run(members)
    }

    /// Members that are not settled, or whose measures want another analysis.
    fn open(&self) -> Vec<&Member> {
        let is_open = |member: &&Member| {
            let folder = Folder::of(&self.directory, member.number);
            let record = folder.record();
            match record.state {
                State::Done => !measure::is_prepared(self.study, &folder),
                State::Failed => self.options.retry || !record.is_settled(),
                _ => true,
            }
        };
        self.members.iter().filter(is_open).collect()
    }

    /// Members that a job without anybody to look after it should begin or continue.
    fn left(&self) -> Vec<&Member> {
        self.members.iter().filter(|m| Folder::of(&self.directory, m.number).record().is_left()).collect()
    }

    fn run_only(&self, number: usize) -> Result<(), StudyError> {
        let Some(member) = self.members.iter().find(|member| member.number == number) else {
            let numbers: Vec<String> = self.members.iter().map(|member| member.number.to_string()).collect();
            return Err(StudyError::Study(format!(
                "--only {number}: no such member; there are {}",
                numbers.join(", ")
            )));
        };
        self.sweep(&[member])?;
        match Folder::of(&self.directory, number).record() {
            record if record.state == State::Failed => {
                Err(StudyError::Runs(format!("{number:04}: {}", record.message.unwrap_or_default())))
            }
            _ => Ok(()),
        }
    }

    fn list(&self) {
        for member in &self.members {
            let state = Folder::of(&self.directory, member.number).record().state;
            (self.say)(&format!(
                "{:04}  {}  {}",
                member.number,
                told_varied(self.study, &member.values),
                state.word()
            ));
        }
        let more = self
            .study
            .fit
            .as_ref()
            .map_or(String::new(), |fit| format!(", up to {} as the search goes on", fit.max_runs));
        (self.say)(&format!("{} members{more}; their cases are right", self.members.len()));
    }

    /// What the runs up to a round say of the measures with targets.
    fn observations(&self, search: &Search, round: usize) -> Vec<Observation> {
        let members: Vec<Member> =
            self.members.iter().filter(|member| member.round <= round).cloned().collect();
        let table = Table::of(self.study, &members, &self.directory);
        let position = |name: &String| table.measures.iter().position(|(other, _)| other == name);
        let wanted: Vec<usize> = search.targets.iter().filter_map(|(name, _)| position(name)).collect();
        let observation = |row: &crate::table::Row| Observation {
            x: search.coordinates(&row.member.values),
            measures: wanted.iter().map(|&i| row.measures[i]).collect(),
        };
        table.rows.iter().map(observation).collect()
    }

    /// Writes table, pictures and the fit, and says what came of the members.
    fn gather(&self, search: Option<(&Search, Verdict)>) -> Result<(), StudyError> {
        let table = Table::of(self.study, &self.members, &self.directory);
        table.problems.iter().for_each(|problem| (self.say)(&format!("no measure of {problem}")));
        table.write(&self.directory.join("table.csv"), self.study, &self.launch.version)?;
        let mut files = vec!["table.csv"];
        let fitted = search.filter(|(search, _)| !search.estimates.is_empty());
        if let Some((search, verdict)) = fitted {
            let report = FitReport::of(self.study, search, verdict, &table);
            report.lines().iter().for_each(|line| (self.say)(line));
            write(&self.directory.join("fit.toml"), &report.toml(&self.launch.version))?;
            write(&self.directory.join("fit.csv"), &report.csv())?;
            let own = Path::new("results").join(format!("{}-fitted", self.study.name()));
            write(&self.directory.join("fitted.toml"), &self.pattern.fitted(&report.values(), &own)?)?;
            files.extend(["fit.toml", "fit.csv", "fitted.toml"]);
        }
        let drawn = picture::draw(self.study, &table, fitted.map(|(search, _)| search));
        if let Some(drawn) =
            drawn.map_err(|problem| StudyError::Files(format!("study.svg: cannot be drawn: {problem}")))?
        {
            write(&self.directory.join("study.svg"), &drawn)?;
            files.push("study.svg");
        }
        let states = [State::Done, State::Failed, State::Stopped, State::Begun, State::Waiting];
        let counts: Vec<String> = states
            .iter()
            .map(|&state| (table.count(state), state.word()))
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}"))
            .collect();
        (self.say)(&format!("{} members: {}", table.rows.len(), counts.join(", ")));
        (self.say)(&format!("{}: {}", self.directory.display(), files.join(", ")));
        match table.count(State::Failed) {
            0 => Ok(()),
            failed => Err(StudyError::Runs(format!(
                "{failed} of {} members failed; each folder has a `log`, and --retry runs them again",
                table.rows.len()
            ))),
        }
    }
}
