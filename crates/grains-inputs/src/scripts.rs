//! Command lines, studies, and what comes from other codes.

use crate::{Folders, text};
use grains_import::Options;
use grains_study::{Launch, Study, Task, carry_out};
use std::ffi::OsString;
use std::fs;
use std::os::unix::ffi::OsStringExt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Members of studies whose cases are all checked: each takes a millisecond.
const FEW: usize = 8;

/// A study file, up to the cases of all its members.
pub fn study(bytes: &[u8], folders: &Folders) -> bool {
    let file = folders.given.join("study.toml");
    let Some(Ok(study)) = text(bytes).map(|text| Study::parse(text, &file.display().to_string())) else {
        return false;
    };
    if study.members().is_ok_and(|members| members > FEW) {
        return true;
    }
    let options = grains_study::Options { task: Task::DryRun, jobs: 1, retry: false };
    let launch = Launch {
        program: "grains-mpi".into(),
        version: String::new(),
        launcher: Vec::new(),
        ranks: study.run.ranks,
        walltime: None,
        interrupted: Arc::new(AtomicBool::new(false)),
    };
    carry_out(&study, &options, &launch, &|_| ()).is_ok()
}

/// A script, data file or dump of LAMMPS or LIGGGHTS, up to the case that is written.
pub fn import(bytes: &[u8], folders: &Folders) -> bool {
    // Files of the system may be endless.
    let is_outside = |word: &[u8]| bytes.windows(word.len()).any(|part| part == word);
    if is_outside(b"/dev") || is_outside(b"/proc") || is_outside(b"/sys") {
        return false;
    }
    let file = folders.own.join("in.script");
    if fs::write(&file, bytes).is_err() {
        return false;
    }
    grains_import::import(&[file], &folders.own.join("imported"), &Options::default()).is_ok()
}

/// A command line, its words one a line.
pub fn command(bytes: &[u8], _: &Folders) -> bool {
    let words = bytes.split(|byte| *byte == b'\n').map(|word| OsString::from_vec(word.to_vec()));
    grains_program::understands([OsString::from("grains-mpi")].into_iter().chain(words))
}
