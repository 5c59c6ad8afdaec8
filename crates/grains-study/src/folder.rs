//! The folder of a member: its case, its log, its results, and what became of it.

use crate::error::StudyError;
use crate::member::RUN;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use toml::Table;

/// What became of a member.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Not begun.
    #[default]
    Waiting,
    /// Begun; if nothing runs, it was killed.
    Begun,
    /// Left with a checkpoint, to go on.
    Stopped,
    /// At its end.
    Done,
    /// Ended with an error.
    Failed,
}

impl State {
    /// The word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Begun => "begun",
            Self::Stopped => "stopped",
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }
}

/// What is kept of a member beside its results, in `member.json`.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Record {
    /// What became of it.
    pub state: State,
    /// Wall-clock time of all its runs (s).
    pub seconds: f64,
    /// Version of the program that ran it last.
    pub version: String,
    /// Its error, if it failed.
    pub message: Option<String>,
    /// Exit code, if it failed.
    pub code: Option<i32>,
    /// Step at which it was last.
    pub step: u64,
    /// How often it was begun since it last came farther.
    pub tries: u32,
}

/// Times that a member may be begun without coming farther before nobody begins it again unasked.
const MOST_TRIES: u32 = 3;

/// The part of `status.json` of a run that decides how it goes on.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Status {
    pub state: String,
    pub step: u64,
}

/// The folder of a member.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Folder(PathBuf);

impl Folder {
    /// That of a member of a study.
    pub fn of(directory: &Path, number: usize) -> Self {
        Self(directory.join(format!("{number:04}")))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Directory of its results.
    pub fn run(&self) -> PathBuf {
        self.0.join(RUN)
    }

    /// Creates it with its case, if it is not there.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn create(&self, text: &str) -> Result<(), StudyError> {
        fs::create_dir_all(&self.0).map_err(|error| StudyError::of_file(&self.0, error))?;
        let path = self.file("case.toml");
        if path.exists() {
            return Ok(());
        }
        write(&path, text)
    }

    /// What was kept of it; nothing of a member that was not begun.
    pub fn record(&self) -> Record {
        let text = fs::read_to_string(self.file("member.json")).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// Keeps what became of it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, record: &Record) -> Result<(), StudyError> {
        let text = serde_json::to_string_pretty(record).unwrap_or_default();
        write(&self.file("member.json"), &(text + "\n"))
    }

    /// How far its run says it is.
    pub fn status(&self) -> Status {
        let text = fs::read_to_string(self.run().join("status.json")).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// Whether a run writes to it at present, of this call or of another.
    pub fn is_written_to(&self) -> bool {
        fs::File::open(self.run().join(".lock")).is_ok_and(|file| file.try_lock_shared().is_err())
    }

    /// Whether it has a checkpoint.
    pub fn has_checkpoint(&self) -> bool {
        let entries = fs::read_dir(self.run()).into_iter().flatten().flatten();
        entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .any(|name| name.starts_with("checkpoint-") && name.ends_with(".h5"))
    }

    /// The last error in its log.
    pub fn error(&self) -> Option<String> {
        let log = fs::read_to_string(self.file("log")).unwrap_or_default();
        let after = &log[log.rfind("error: ")? + "error: ".len()..];
        let lines = after.lines().take_while(|line| !line.starts_with("-----") && !line.trim().is_empty());
        Some(lines.collect::<Vec<_>>().join("\n"))
    }
}

impl Record {
    /// Whether the member is at its end or has failed in a way that it would fail again.
    pub fn is_settled(&self) -> bool {
        match self.state {
            State::Done => true,
            State::Failed => self.code.is_some_and(|code| code == 2 || code == 3),
            _ => false,
        }
    }

    /// Whether a job without anybody to look after it should begin or continue the member.
    pub fn is_left(&self) -> bool {
        !matches!(self.state, State::Done | State::Failed) && self.tries < MOST_TRIES
    }
}

/// Writes a file under another name and renames it, so that nobody reads half of it.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), StudyError> {
    let part = path.with_extension("part");
    fs::write(&part, text)
        .and_then(|()| fs::rename(&part, path))
        .map_err(|error| StudyError::of_file(path, format!("cannot be written: {error}")))
}

/// Numbers of the folders of a study, by what their cases say. Comments and layout do not count.
pub(crate) struct Numbers {
    of_case: BTreeMap<String, usize>,
    next: usize,
}

impl Numbers {
    /// Those of the folders that are there.
    pub fn read(directory: &Path) -> Self {
        let entries = fs::read_dir(directory).into_iter().flatten().flatten();
        let numbers = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<usize>().ok());
        let case = |number: usize| fs::read_to_string(Folder::of(directory, number).file("case.toml")).ok();
        let mut numbers: Vec<usize> = numbers.collect();
        // Of folders with the same case the first is meant.
        numbers.sort_unstable_by(|a, b| b.cmp(a));
        let of_case = numbers.iter().filter_map(|&n| Some((meaning(&case(n)?), n))).collect();
        Self { of_case, next: numbers.first().map_or(1, |last| last + 1) }
    }

    /// The number of a case: that of its folder, or the next.
    pub fn of(&mut self, text: &str) -> usize {
        *self.of_case.entry(meaning(text)).or_insert_with(|| {
            self.next += 1;
            self.next - 1
        })
    }
}

/// What a case says, without comments and layout.
fn meaning(text: &str) -> String {
    text.parse::<Table>().map_or_else(|_| text.to_owned(), |table| table.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directory(name: &str) -> PathBuf {
        let directory = std::env::temp_dir().join(format!("grains-study-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&directory);
        fs::create_dir_all(&directory).unwrap();
        directory
    }

    #[test]
    fn a_case_keeps_its_folder_whatever_else_the_study_has() {
        let directory = directory("numbers");
        let mut numbers = Numbers::read(&directory);
        for (text, number) in [("a = 1\n", 1), ("a = 2\n", 2), ("a = 1\n", 1)] {
            assert_eq!(numbers.of(text), number);
            Folder::of(&directory, number).create(text).unwrap();
        }
        let mut numbers = Numbers::read(&directory);
        assert_eq!([numbers.of("a = 3\n"), numbers.of("# better\na  = 2"), numbers.of("a = 1\n")], [3, 2, 1]);
    }

    #[test]
    fn what_is_done_or_would_fail_again_is_not_run_again() {
        let failed = |code| Record { state: State::Failed, code, ..Record::default() };
        assert!(!Record::default().is_settled() && Record::default().is_left());
        assert!(Record { state: State::Done, ..Record::default() }.is_settled());
        assert!(failed(Some(3)).is_settled() && !failed(Some(4)).is_settled() && !failed(None).is_settled());
        assert!(!Record { state: State::Begun, tries: MOST_TRIES, ..Record::default() }.is_left());
    }

    #[test]
    fn the_error_of_a_log_is_its_last_without_the_words_of_mpirun() {
        let folder = Folder::of(&directory("log"), 1);
        folder.create("").unwrap();
        fs::write(
            folder.file("log"),
            "error: old\nstep 1\nerror: a.toml:1: lost\nparticle 3\n-----\nmpirun\n",
        )
        .unwrap();
        assert_eq!(folder.error().as_deref(), Some("a.toml:1: lost\nparticle 3"));
    }
}
