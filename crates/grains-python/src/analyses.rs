//! Analyses of stored runs.

use crate::{CaseError, job, raised};
use clap::{CommandFactory, FromArgMatches, Parser};
use grains_analysis::{Analysis, Findings};
use pyo3::prelude::*;

/// The words of an analysis, as on the command line.
#[derive(Parser)]
#[command(name = "analyse")]
struct Words {
    #[command(subcommand)]
    what: Analysis,
}

/// Does the analysis of some words, as after `grains-mpi analyse`; returns its main lines, its folder and the names of its files.
#[pyfunction]
pub fn analyse(words: Vec<String>, communicator: usize) -> PyResult<(Vec<String>, String, Vec<String>)> {
    let all = std::iter::once("analyse".to_string()).chain(words);
    let told = |e: clap::Error| CaseError::new_err(e.render().to_string());
    let matches = Words::command().try_get_matches_from(all).map_err(told)?;
    let Words { what } = Words::from_arg_matches(&matches).map_err(told)?;
    let program = concat!("grains (Python) ", env!("CARGO_PKG_VERSION"));
    let Findings { lines, folder, files } =
        grains_analysis::analyse(&what, program, &*job::job(communicator)?).map_err(raised)?;
    Ok((lines, folder.display().to_string(), files))
}
