//! Studies with a shell script in place of the program: what runs, what does not, and what a fit makes of it.

#![allow(clippy::unwrap_used)]

use grains_study::{Launch, Options, Study, StudyError, Task, carry_out};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, atomic::AtomicBool};

/// A real case, as every member is checked.
const CASE: &str = include_str!("../../../mpi-tests/cases/base.toml");

/// The mass is 2 + 3 f + f² with the friction f, and scatters with the seed. Friction above 0.9 fails. With a file `slow`
/// beside the study the run leaves half way, with a checkpoint.
const PROGRAM: &str = r##"#!/bin/sh
echo "$@" >>calls
mkdir -p run
f=$(sed -n 's/^friction = //p' case.toml | head -n 1)
seed=$(sed -n 's/^seed = //p' case.toml)
awk -v f="$f" -v seed="${seed:-1}" 'BEGIN {
    if (f > 0.9) exit 1
    srand(seed); u = rand(); noise = 0.02 * sqrt(-2 * log(1 - u)) * cos(6.2831853 * rand())
    printf "# units: s,kg\ntime,mass\n0,0\n1,%.9f\n", 2 + 3 * f + f * f + noise }' >run/series.csv || {
    echo "error: particle 7 is lost at friction $f"
    exit 3
}
if [ -e ../../../slow ]; then
    touch run/checkpoint-5.h5
    echo '{"state": "stopped", "step": 5}' >run/status.json
else
    echo '{"state": "finished", "step": 10}' >run/status.json
fi
"##;

struct Played {
    home: PathBuf,
    said: Mutex<Vec<String>>,
}

impl Played {
    fn new(name: &str, study: &str) -> Self {
        let home = std::env::temp_dir().join(format!("grains-study-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&home);
        fs::create_dir_all(&home).unwrap();
        fs::write(home.join("base.toml"), CASE).unwrap();
        fs::write(home.join("program"), PROGRAM).unwrap();
        fs::set_permissions(home.join("program"), fs::Permissions::from_mode(0o755)).unwrap();
        let played = Self { home, said: Mutex::default() };
        played.write(study);
        played
    }

    fn write(&self, study: &str) {
        let directory = self.directory();
        fs::write(
            self.home.join("s.toml"),
            format!("case = \"base.toml\"\ndirectory = {directory:?}\n{study}"),
        )
        .unwrap();
    }

    fn directory(&self) -> PathBuf {
        self.home.join("results/s")
    }

    fn ask(&self, task: Task, retry: bool) -> Result<(), StudyError> {
        let study = Study::load(&self.home.join("s.toml"))?;
        let launch = Launch {
            program: self.home.join("program"),
            version: "played".into(),
            launcher: Vec::new(),
            ranks: 1,
            walltime: None,
            interrupted: Arc::new(AtomicBool::new(false)),
        };
        self.said.lock().unwrap().clear();
        carry_out(&study, &Options { task, jobs: 3, retry }, &launch, &|line| {
            self.said.lock().unwrap().push(line.into())
        })
    }

    fn said(&self) -> String {
        self.said.lock().unwrap().join("\n")
    }

    /// Words with which the program was called for a member.
    fn calls(&self, member: usize) -> Vec<String> {
        let text =
            fs::read_to_string(self.directory().join(format!("{member:04}/calls"))).unwrap_or_default();
        text.lines().map(String::from).collect()
    }

    /// A column of the table.
    fn column(&self, name: &str) -> Vec<String> {
        let text = fs::read_to_string(self.directory().join("table.csv")).unwrap();
        let mut rows = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').collect::<Vec<_>>());
        let position = rows.next().unwrap().iter().position(|column| *column == name).unwrap();
        rows.map(|row| row[position].to_string()).collect()
    }
}

impl Drop for Played {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.home);
    }
}

const MEASURE: &str = "[measure]\nmass = { column = \"mass\" }\n";

#[test]
fn a_member_that_fails_is_told_and_stops_no_other() {
    let vary = "[vary]\nf = { key = \"contact[*].friction\", values = [0.1, 0.95, 0.5] }\n";
    let played = Played::new("fails", &format!("{vary}{MEASURE}"));
    let error = played.ask(Task::Run, false).unwrap_err();
    assert!(
        matches!(&error, StudyError::Runs(message) if message.starts_with("1 of 3 members failed")),
        "{error}"
    );
    assert!(
        played.said().contains("0002  f = 0.95  failed: particle 7 is lost at friction 0.95"),
        "{}",
        played.said()
    );
    assert_eq!(played.column("state"), ["done", "failed", "done"]);
    assert_eq!(played.column("mass")[1], "NaN");
    // It would fail again.
    assert!(played.ask(Task::Run, false).is_err() && played.calls(2).len() == 1);
    assert!(played.ask(Task::Run, true).is_err() && played.calls(2).len() == 2 && played.calls(1).len() == 1);
}

#[test]
fn a_study_that_grows_keeps_its_runs_and_stopped_ones_go_on() {
    let vary = |values: &str| {
        format!("[vary]\nf = {{ key = \"contact[*].friction\", values = {values} }}\n{MEASURE}")
    };
    let played = Played::new("grows", &vary("[0.2, 0.4]"));
    fs::write(played.home.join("slow"), "").unwrap();
    played.ask(Task::Run, false).unwrap();
    assert_eq!(played.column("state"), ["stopped"; 2]);
    played.ask(Task::Left, false).unwrap();
    assert_eq!(played.said(), "1-2");
    fs::remove_file(played.home.join("slow")).unwrap();
    played.write(&vary("[0.1, 0.2, 0.4]"));
    played.ask(Task::Only(2), false).unwrap();
    assert_eq!(played.calls(2), ["run case.toml", "run case.toml --restart latest"]);
    played.ask(Task::Run, false).unwrap();
    assert_eq!(played.column("member"), ["3", "1", "2"]);
    assert_eq!(played.column("state"), ["done"; 3]);
    assert_eq!([1, 2, 3].map(|member| played.calls(member).len()), [2, 2, 1]);
    // What comes no farther is left alone by jobs.
    fs::write(played.home.join("slow"), "").unwrap();
    played.write(&vary("[0.3]"));
    (0..4).for_each(|_| drop(played.ask(Task::Only(4), false)));
    played.ask(Task::Left, false).unwrap();
    assert_eq!(played.said(), "", "{:?}", played.calls(4));
}

#[test]
fn repeats_have_seeds_of_their_own() {
    let vary = "[vary]\nf = { key = \"contact[*].friction\", values = [0.2] }\n[design]\nrepeats = 3\n";
    let played = Played::new("repeats", &format!("{vary}{MEASURE}"));
    played.ask(Task::Run, false).unwrap();
    assert_eq!(played.column("seed"), ["1", "2", "3"]);
    let masses = played.column("mass");
    assert!(masses[0] != masses[1] && masses[1] != masses[2], "{masses:?}");
}

/// The fit finds the friction of the played program, goes on from its runs when the target changes, and is the same by jobs.
#[test]
fn a_fit_finds_what_is_known() {
    let study = |value: f64| {
        format!(
            "[vary]\nf = {{ key = \"contact[*].friction\", min = 0.05, max = 0.8 }}\n{MEASURE}[fit]\nmax_runs = 30\ntarget.mass = {{ value = {value}, uncertainty = 0.03 }}\n"
        )
    };
    let mass = |f: f64| 2.0 + 3.0 * f + f * f;
    let found = |played: &Played| {
        let fit: toml::Table =
            fs::read_to_string(played.directory().join("fit.toml")).unwrap().parse().unwrap();
        let f = &fit["quantity"]["f"];
        let runs = fit["runs"].as_integer().unwrap();
        (f["value"].as_float().unwrap(), f["uncertainty"].as_float().unwrap(), runs)
    };
    let played = Played::new("fit", &study(mass(0.35)));
    played.ask(Task::Run, false).unwrap();
    let (value, uncertainty, runs) = found(&played);
    // A measured number known to 0.03 at a slope of 3.7, and surfaces from runs that scatter by 0.02.
    assert!(
        (0.008..0.012).contains(&uncertainty) && (value - 0.35).abs() < 3.0 * uncertainty,
        "{value} ± {uncertainty}"
    );
    assert!(runs < 30 && played.said().contains("stay where they are"), "{}", played.said());
    let fitted = fs::read_to_string(played.directory().join("fitted.toml")).unwrap();
    assert!(
        fitted.contains(&format!("friction = {:?}\n", format!("{value:.3e}").parse::<f64>().unwrap())),
        "{fitted}"
    );
    let calls =
        |played: &Played, runs| (1..=runs as usize).map(|member| played.calls(member).len()).sum::<usize>();
    played.ask(Task::Run, false).unwrap();
    assert_eq!((found(&played).2, calls(&played, runs)), (runs, runs as usize));

    played.write(&study(mass(0.6)));
    played.ask(Task::Run, false).unwrap();
    let (value, uncertainty, more) = found(&played);
    assert!((value - 0.6).abs() < 3.0 * uncertainty && more < 2 * runs, "{value} ± {uncertainty} of {more}");
    assert_eq!(calls(&played, more), more as usize);

    let jobs = Played::new("fit_jobs", &study(mass(0.35)));
    loop {
        jobs.ask(Task::Left, false).unwrap();
        let left = jobs.said();
        if left.is_empty() {
            break;
        }
        for part in left.split(',') {
            let ends: Vec<usize> = part.split('-').map(|end| end.parse().unwrap()).collect();
            (ends[0]..=*ends.last().unwrap()).for_each(|member| jobs.ask(Task::Only(member), false).unwrap());
        }
    }
    jobs.ask(Task::Gather, false).unwrap();
    assert_eq!(found(&jobs).2, runs);
}

#[test]
fn studies_that_are_wrong_are_refused_with_a_remedy() {
    let refused = |study: &str, wanted: &str| {
        let played = Played::new("refused", study);
        let error = played.ask(Task::DryRun, false).unwrap_err().to_string();
        assert!(error.contains(wanted), "{error}");
    };
    let f = "f = { key = \"contact[*].friction\"";
    refused(&format!("[vary]\n{f}, values = [0.1], min = 0 }}\n"), "has a range as well");
    refused(&format!("[vary]\n{f}, min = 0.3, max = 0.1 }}\n"), "vary.f.max = 0.1: must be above min = 0.3");
    refused(
        &format!("[vary]\n{f}, values = [\"much\"] }}\n"),
        "contact[0].friction = \"much\": must be a number",
    );
    refused("[vary]\nseed = { key = \"seed\", values = [1] }\n", "already the name of a column");
    refused("[vary]\nf = { values = [1] }\n", "needs the key of the case");
    refused(
        &format!("[vary]\n{f}, values = [0.1] }}\n[measure]\nm = {{ column = \"x\", take = \"time-to\" }}\n"),
        "measure.m.level: missing key",
    );
    refused(
        &format!("[vary]\n{f}, values = [0.1] }}\n[measure]\nm = {{ column = \"x\", take = \"average\" }}\n"),
        "unknown value",
    );
    refused(
        &format!(
            "[vary]\n{f}, min = 0.1, max = 0.5 }}\n{MEASURE}[fit]\nmax_runs = 30\ntarget.mas = {{ value = 1, uncertainty = 1 }}\n"
        ),
        "no such measure; did you mean `mass`?",
    );
    refused(
        &format!(
            "[vary]\n{f}, min = 0.1, max = 0.5 }}\n{MEASURE}[fit]\nmax_runs = 3\ntarget.mass = {{ value = 1, uncertainty = 1 }}\n"
        ),
        "must be at least 7",
    );
}

#[test]
fn files_that_a_case_names_are_found_from_the_folder_of_a_member() {
    let played = Played::new(
        "files",
        &format!("[vary]\nf = {{ key = \"contact[*].friction\", values = [0.2] }}\n{MEASURE}"),
    );
    fs::write(played.home.join("places.csv"), "x,y,z\n0.03,0.03,0.03\n").unwrap();
    let begin = CASE.find("count = 16").unwrap();
    let end = begin + CASE[begin..].find("\n\n").unwrap();
    let text =
        format!("{}place = {{ kind = \"file\", path = \"places.csv\" }}{}", &CASE[..begin], &CASE[end..]);
    fs::write(played.home.join("base.toml"), text).unwrap();
    played.ask(Task::Run, false).unwrap();
    let member = fs::read_to_string(played.directory().join("0001/case.toml")).unwrap();
    let path = fs::canonicalize(played.home.join("places.csv")).unwrap();
    assert!(member.contains(&format!("path = {path:?}")), "{member}");
    assert!(Path::new(&played.directory().join("0001/run")).is_dir());
}
