//! What a study and its case ask of each other, checked before anything runs.

use crate::address::Address;
use crate::error::StudyError;
use crate::study_file::{Measure, Study};
use grains_case::Case;
use std::path::Path;
use toml_edit::{DocumentMut, Value};

/// Checks a study against its case and the addresses of what it varies.
///
/// # Errors
/// The first thing that is wrong.
pub(crate) fn check(
    study: &Study,
    case: &Case,
    document: &DocumentMut,
    addresses: &[(&str, Address)],
) -> Result<(), StudyError> {
    check_directory(study)?;
    check_seed(study)?;
    check_overlaps(study, document, addresses)?;
    check_ranks(study, case)?;
    study.measure.iter().try_for_each(|(name, measure)| check_measure(study, case, name, measure))
}

/// Whether a study varies a key.
fn varies(study: &Study, key: &str) -> bool {
    study.vary.values().flat_map(|vary| vary.addresses()).any(|address| address.trim() == key)
}

/// The name of what varies a key.
fn varied<'s>(study: &'s Study, key: &str) -> Option<&'s str> {
    let mut names = study.vary.iter();
    let found = names.find(|(_, vary)| vary.addresses().any(|address| address.trim() == key));
    found.map(|(name, _)| name.as_str())
}

fn check_directory(study: &Study) -> Result<(), StudyError> {
    match varied(study, "output.directory") {
        Some(name) => Err(study.error(
            &format!("vary.{name}"),
            "each member has a folder of its own, so that this makes equal runs; leave it out, and set `directory` of the study for all of them",
        )),
        None => Ok(()),
    }
}

fn check_seed(study: &Study) -> Result<(), StudyError> {
    match varied(study, "seed").filter(|_| study.design.repeats > 1) {
        Some(name) => Err(study.error(
            "design.repeats",
            format!("repeats differ by their seed, which vary.{name} sets as well: they would be equal; leave out the one or the other"),
        )),
        None => Ok(()),
    }
}

/// Refuses keys that two quantities vary, of which the later alone would count.
fn check_overlaps(
    study: &Study,
    document: &DocumentMut,
    addresses: &[(&str, Address)],
) -> Result<(), StudyError> {
    // Words that no case has.
    const MARKS: [&str; 2] = ["grains-study-first", "grains-study-second"];
    let marked = |document: &DocumentMut| document.to_string().matches(MARKS[0]).count();
    for (k, (name, address)) in addresses.iter().enumerate() {
        for (other, before) in addresses[..k].iter().filter(|(other, _)| other != name) {
            let mut tried = document.clone();
            let first = before.set(&mut tried, &Value::from(MARKS[0]));
            let places = marked(&tried);
            let second = address.set(&mut tried, &Value::from(MARKS[1]));
            if first.is_ok() && second.is_ok() && marked(&tried) < places {
                let message = format!(
                    "sets a key that vary.{other} sets as well, and the later of the two wins; vary each key once"
                );
                return Err(study.error(&format!("vary.{name}"), message));
            }
        }
    }
    Ok(())
}

fn check_ranks(study: &Study, case: &Case) -> Result<(), StudyError> {
    let Some(ranks) = case.domain.ranks.filter(|_| !varies(study, "domain.ranks")) else { return Ok(()) };
    let product: usize = ranks.iter().map(|&n| n as usize).product();
    if product == study.run.ranks {
        return Ok(());
    }
    Err(study.error(
        "run.ranks",
        format!(
            "{} rank(s), but domain.ranks = {ranks:?} of the case makes {product} subdomains: every run would end at once; take run.ranks = {product}, or remove domain.ranks",
            study.run.ranks
        ),
    ))
}

fn check_measure(study: &Study, case: &Case, name: &str, measure: &Measure) -> Result<(), StudyError> {
    let refuse = |key: &str, message: String| Err(study.error(&format!("measure.{name}.{key}"), message));
    if let Some(program) = measure.command.first() {
        return match is_found(program) {
            true => Ok(()),
            false => refuse(
                "command",
                format!("no program `{program}` is found; install it, or give its full path"),
            ),
        };
    }
    let end = case.time.end;
    if let Some(from) = measure.from.filter(|from| *from >= end && !varies(study, "time.end")) {
        return refuse(
            "from",
            format!(
                "no row is so late, as the runs end at {end} s (time.end); it must be below, not {from} s"
            ),
        );
    }
    let words = measure.analyse.as_deref().map(str::trim);
    let takes_series =
        words.is_none_or(|words| ["flow-rate", "friction"].iter().any(|own| words.starts_with(own)));
    let output = &case.output;
    if takes_series && output.series == 0.0 && !varies(study, "output.series") {
        return refuse(
            "column",
            "is taken of series.csv, which is not written: output.series of the case is 0; give it a time (s)".into(),
        );
    }
    let is_dry = case.fluid.is_none();
    if !takes_series && is_dry && output.particles == 0.0 && !varies(study, "output.particles") {
        return refuse(
            "analyse",
            "needs snapshots, which are not written: output.particles of the case is 0; give it a time (s)"
                .into(),
        );
    }
    Ok(())
}

/// Whether a program can be started; a path is relative to the folder of a run, which is not there yet.
fn is_found(program: &str) -> bool {
    if program.contains('/') {
        return !Path::new(program).is_absolute() || Path::new(program).exists();
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
}
