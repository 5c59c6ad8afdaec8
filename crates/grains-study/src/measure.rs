//! Numbers taken from a run.

use crate::csv_table::CsvTable;
use crate::error::StudyError;
use crate::folder::{Folder, write};
use crate::launch::Launch;
use crate::member::RUN;
use crate::study_check::no_such;
use crate::study_file::{Measure, Study, Take};
use std::fs;
use std::process::Command;

/// A number with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// The number; NaN if the run does not have it.
    pub number: f64,
    /// Its unit; `-` of a pure number, empty if unknown.
    pub unit: String,
}

/// What an analysis or command of a measure is kept as, in the folder of a member.
fn name_of(study: &Study, name: &str) -> String {
    let measure = &study.measure[name];
    let same = |other: &&String| {
        let other = &study.measure[*other];
        (&other.analyse, &other.command) == (&measure.analyse, &measure.command)
    };
    format!("measure-{}", study.measure.keys().find(same).map_or(name, |first| first))
}

/// The words that make the analysis or command what it is.
fn words_of(measure: &Measure) -> String {
    measure.analyse.clone().unwrap_or_else(|| measure.command.join(" "))
}

/// Measures that need an analysis or a command, with what that is kept as and its words.
fn made_measures(study: &Study) -> impl Iterator<Item = (&String, &Measure, String, String)> {
    let made = study.measure.iter().filter(|(_, m)| m.analyse.is_some() || !m.command.is_empty());
    made.map(|(name, measure)| (name, measure, name_of(study, name), words_of(measure)))
}

fn is_made(folder: &Folder, kept: &str, words: &str) -> bool {
    fs::read_to_string(folder.file(&format!("{kept}.txt"))).is_ok_and(|text| text == words)
}

/// Whether all analyses and commands of the measures have been made.
pub(crate) fn is_prepared(study: &Study, folder: &Folder) -> bool {
    made_measures(study).all(|(_, _, kept, words)| is_made(folder, &kept, &words))
}

/// Makes what the measures of a study need of a run at its end: analyses and commands that have not been made.
///
/// # Errors
/// An analysis that fails.
pub(crate) fn prepare(study: &Study, folder: &Folder, launch: &Launch) -> Result<(), StudyError> {
    for (name, measure, kept, words) in made_measures(study) {
        if is_made(folder, &kept, &words) {
            continue;
        }
        let log = folder.file(&format!("{kept}.log"));
        let _ = fs::remove_file(&log);
        let status = if measure.analyse.is_some() {
            launch.analyse(folder, &words.split_whitespace().collect::<Vec<_>>(), &kept)?
        } else {
            let mut command = Command::new(&measure.command[0]);
            command.args(&measure.command[1..]);
            launch.wait(command, folder, &format!("{kept}.log"))?
        };
        if !status.success() {
            let said = fs::read_to_string(&log).unwrap_or_default();
            let last = said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("it says nothing");
            return Err(StudyError::Runs(format!(
                "measure {name}: {words}: {}",
                last.trim_start_matches("error: ")
            )));
        }
        write(&folder.file(&format!("{kept}.txt")), &words)?;
    }
    Ok(())
}

/// Takes a measure from the files of a run.
///
/// # Errors
/// A file or column that is not there.
pub(crate) fn take(study: &Study, name: &str, folder: &Folder) -> Result<Value, StudyError> {
    let measure = &study.measure[name];
    let kept = name_of(study, name);
    if !measure.command.is_empty() {
        let path = folder.file(&format!("{kept}.log"));
        let text = fs::read_to_string(&path).map_err(|error| StudyError::of_file(&path, error))?;
        let number = text.split_whitespace().rev().find_map(|word| word.parse::<f64>().ok());
        let number = number.ok_or_else(|| StudyError::of_file(&path, "no number was printed"))?;
        return Ok(Value { number, unit: measure.unit.clone().unwrap_or_default() });
    }
    let path = match &measure.analyse {
        Some(words) => {
            folder.file(&kept).join(format!("{}.csv", words.split_whitespace().next().unwrap_or_default()))
        }
        None => folder.file(RUN).join("series.csv"),
    };
    let table = CsvTable::read(&path)?;
    let column = measure.column.as_deref().unwrap_or_default();
    let known: Vec<&str> = table.columns.iter().map(String::as_str).collect();
    let Some(position) = table.position(column) else {
        return Err(study.error(
            &format!("measure.{name}.column"),
            format!("{}: {}", path.display(), no_such("column", column, &known)),
        ));
    };
    let values = table.numbers(position);
    let needs_time =
        matches!(measure.take, Take::Rate | Take::TimeTo) || measure.from.is_some() || measure.to.is_some();
    let times = match table.position("time") {
        Some(time) => table.numbers(time),
        None if needs_time => {
            return Err(study.error(
                &format!("measure.{name}"),
                format!(
                    "{} has no column `time`; leave out `from` and `to`, and take no rate or time",
                    path.display()
                ),
            ));
        }
        None => vec![0.0; values.len()],
    };
    let number = number(measure, &times, &values);
    let own = table.units.get(position).cloned().unwrap_or_default();
    let unit = match measure.take {
        Take::TimeTo => "s".into(),
        Take::Rate if own == "-" => "1/s".into(),
        Take::Rate if !own.is_empty() => format!("{own}/s"),
        _ => own,
    };
    Ok(Value { number, unit: measure.unit.clone().unwrap_or(unit) })
}

/// The number that a measure takes of a column; NaN where there is none.
fn number(measure: &Measure, times: &[f64], values: &[f64]) -> f64 {
    let (from, to) = (measure.from.unwrap_or(f64::NEG_INFINITY), measure.to.unwrap_or(f64::INFINITY));
    let rows: Vec<(f64, f64)> = times
        .iter()
        .copied()
        .zip(values.iter().copied())
        .filter(|(t, v)| (from..=to).contains(t) && v.is_finite())
        .collect();
    let count = rows.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| rows.iter().map(of).sum::<f64>() / count;
    match measure.take {
        Take::First => rows.first().map_or(f64::NAN, |row| row.1),
        Take::Last => rows.last().map_or(f64::NAN, |row| row.1),
        Take::Mean => mean(&|row| row.1),
        Take::Max => rows.iter().map(|row| row.1).fold(f64::NAN, f64::max),
        Take::Min => rows.iter().map(|row| row.1).fold(f64::NAN, f64::min),
        Take::Rate => {
            let (t, v) = (mean(&|row| row.0), mean(&|row| row.1));
            mean(&|row| (row.0 - t) * (row.1 - v)) / mean(&|row| (row.0 - t).powi(2))
        }
        Take::TimeTo => time_to(&rows, measure.level.unwrap_or(f64::NAN)) - measure.from.unwrap_or(0.0),
    }
}

/// Time at which a level is passed for the first time, upwards or downwards.
fn time_to(rows: &[(f64, f64)], level: f64) -> f64 {
    if let Some(&(time, value)) = rows.first()
        && value == level
    {
        return time;
    }
    let passed =
        rows.windows(2).find(|pair| (pair[0].1 < level) != (pair[1].1 < level) || pair[1].1 == level);
    passed.map_or(f64::NAN, |pair| {
        let ((t0, v0), (t1, v1)) = (pair[0], pair[1]);
        t0 + (t1 - t0) * (level - v0) / (v1 - v0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const VARY: &str = "case = \"a.toml\"\n[vary]\na = { key = \"seed\", values = [1] }\n";

    fn taken(keys: &str) -> f64 {
        let study = Study::parse(&format!("{VARY}[measure.m]\ncolumn = \"x\"\n{keys}\n"), "s.toml").unwrap();
        let times = [0.0, 1.0, 2.0, 3.0, 4.0];
        number(&study.measure["m"], &times, &[1.0, 3.0, 5.0, f64::NAN, 4.0])
    }

    #[test]
    fn every_way_to_take_a_number() {
        assert_eq!([taken("take = \"first\""), taken("")], [1.0, 4.0]);
        assert_eq!([taken("take = \"min\""), taken("take = \"max\"")], [1.0, 5.0]);
        assert_eq!(taken("take = \"mean\"\nfrom = 1\nto = 2"), 4.0);
        assert_eq!(taken("take = \"rate\"\nto = 2"), 2.0);
        assert_eq!(taken("take = \"time-to\"\nlevel = 4"), 1.5);
        assert_eq!(taken("take = \"time-to\"\nlevel = 4.5\nfrom = 2"), 1.0);
        assert!(taken("take = \"time-to\"\nlevel = 9").is_nan() && taken("from = 7").is_nan());
    }

    #[test]
    fn analyses_with_the_same_words_are_made_once() {
        let text = "[measure.angle]\nanalyse = \"drum --time 2:4\"\ncolumn = \"angle\"\n[measure.speed]\nanalyse = \"drum --time 2:4\"\ncolumn = \"speed\"\n[measure.x]\ncolumn = \"y\"\n";
        let study = Study::parse(&format!("{VARY}{text}"), "s.toml").unwrap();
        assert_eq!([name_of(&study, "angle"), name_of(&study, "speed")], ["measure-angle", "measure-angle"]);
    }
}
