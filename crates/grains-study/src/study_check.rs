//! What the schema of a study cannot say.

use crate::error::StudyError;
use crate::study_file::{Study, Take, Vary};
use grains_case::closest;

/// Checks names, ranges and what belongs together.
///
/// # Errors
/// The first thing that is wrong.
pub(crate) fn check(study: &Study) -> Result<(), StudyError> {
    if study.vary.is_empty() {
        return Err(study.error("vary", "names nothing; write [vary.NAME] with a key and values"));
    }
    for name in study.vary.keys().chain(study.measure.keys()) {
        let section = if study.vary.contains_key(name) { "vary" } else { "measure" };
        if name.is_empty() || name.contains(|c: char| !(c.is_alphanumeric() || "_-".contains(c))) {
            return Err(study.error(
                &format!("{section}.{name}"),
                "names head columns of tables: use letters, digits, `_` and `-`",
            ));
        }
        if RESERVED.contains(&name.as_str())
            || study.vary.contains_key(name) == study.measure.contains_key(name)
        {
            return Err(study.error(
                &format!("{section}.{name}"),
                "already the name of a column of the table; choose another",
            ));
        }
    }
    study.vary.keys().try_for_each(|name| check_vary(study, name))?;
    study.vary.keys().try_for_each(|name| check_doubles(study, name))?;
    study.measure.keys().try_for_each(|name| check_measure(study, name))?;
    check_design(study)?;
    check_fit(study)
}

/// Columns that every table has.
const RESERVED: [&str; 6] = ["member", "round", "seed", "state", "seconds", "version"];

/// Refuses a case in the place of a study.
///
/// # Errors
/// What the file is.
pub(crate) fn check_kind(text: &str, file: &str) -> Result<(), StudyError> {
    let Ok(table) = text.parse::<toml::Table>() else { return Ok(()) };
    if !table.contains_key("domain") || table.contains_key("vary") {
        return Ok(());
    }
    let message = format!(
        "a case, not a study: `grains-mpi {file}` runs it; a study names it by `case`, and what is varied in [vary]"
    );
    Err(grains_case::remark(text, file, "domain", message).into())
}

/// Refuses a value that a list has twice, unless it goes together with others.
fn check_doubles(study: &Study, name: &str) -> Result<(), StudyError> {
    let values = &study.vary[name].values;
    let is_alone = !study.design.together.iter().flatten().any(|other| other == name);
    let double = (1..values.len()).find(|&k| values[..k].contains(&values[k]));
    match double.filter(|_| is_alone) {
        Some(k) => Err(study.error(
            &format!("vary.{name}.values[{k}]"),
            "comes twice, and equal members are run once; decimals have a point, as in 0.5: remove it, or run every member several times by design.repeats",
        )),
        None => Ok(()),
    }
}

fn check_vary(study: &Study, name: &str) -> Result<(), StudyError> {
    let vary = &study.vary[name];
    let path = format!("vary.{name}");
    let refuse = |key: &str, message: &str| Err(study.error(&format!("{path}{key}"), message));
    if vary.key.is_some() != vary.keys.is_empty() {
        return refuse(
            "",
            "needs the key of the case that it varies: `key`, or `keys` if several get the same value",
        );
    }
    let is_range = vary.min.is_some() || vary.max.is_some();
    if is_range && !vary.values.is_empty() {
        return refuse(".values", "has a range as well; leave out the one or the other");
    }
    if vary.log && !is_range {
        return refuse(".log", "is of ranges; leave it out, or give `min` and `max` in place of `values`");
    }
    if !is_range {
        return Ok(());
    }
    match (vary.min, vary.max) {
        (Some(min), Some(max)) if min >= max => refuse(".max", &format!("must be above min = {min}")),
        (Some(min), _) if vary.log && min <= 0.0 => refuse(".min", "must be above 0 where log = true"),
        (Some(_), Some(_)) => Ok(()),
        (Some(_), None) => refuse(".max", "missing key. Upper end of the range"),
        _ => refuse(".min", "missing key. Lower end of the range"),
    }
}

fn check_measure(study: &Study, name: &str) -> Result<(), StudyError> {
    let measure = &study.measure[name];
    let path = format!("measure.{name}");
    let refuse = |key: &str, message: String| Err(study.error(&format!("{path}{key}"), message));
    if !measure.command.is_empty() {
        let others = measure.column.is_some() || measure.analyse.is_some() || measure.level.is_some();
        return if others || measure.take != Take::Last || measure.from.is_some() || measure.to.is_some() {
            refuse(".command", "is the whole measure; leave out the other keys".into())
        } else {
            Ok(())
        };
    }
    if measure.column.is_none() {
        return refuse(
            ".column",
            "missing key. Column of series.csv, or of the table of the analysis".into(),
        );
    }
    match (measure.take == Take::TimeTo, measure.level) {
        (true, None) => return refuse(".level", "missing key. Value that `time-to` waits for".into()),
        (false, Some(_)) => return refuse(".level", "is of take = \"time-to\"; leave it out".into()),
        _ => {}
    }
    match (measure.from, measure.to) {
        (Some(from), Some(to)) if from >= to => refuse(".to", format!("must be after from = {from} s")),
        _ => Ok(()),
    }
}

fn check_design(study: &Study) -> Result<(), StudyError> {
    let design = &study.design;
    let lists: Vec<&str> = study
        .vary
        .iter()
        .filter(|(_, vary)| !vary.values.is_empty())
        .map(|(name, _)| name.as_str())
        .collect();
    let mut seen: Vec<&str> = Vec::new();
    for (i, group) in design.together.iter().enumerate() {
        let mut length = None;
        for (j, name) in group.iter().enumerate() {
            let path = format!("design.together[{i}][{j}]");
            if !lists.contains(&name.as_str()) {
                return Err(study.error(&path, no_such("list of values in [vary]", name, &lists)));
            }
            if seen.contains(&name.as_str()) {
                return Err(study.error(&path, "goes together with others already; name it once"));
            }
            seen.push(name);
            let count = study.vary[name].values.len();
            if length.is_some_and(|length| length != count) {
                let message = format!(
                    "has {count} values, `{}` has {}; lists that go together are of one length",
                    group[0],
                    study.vary[&group[0]].values.len()
                );
                return Err(study.error(&path, message));
            }
            length = Some(count);
        }
    }
    let has_ranges = !study.ranges().is_empty();
    if study.fit.is_none() && has_ranges && design.samples.is_none() {
        return Err(study.error(
            "design.samples",
            "missing key. Points of the Latin hypercube over the ranges of [vary]",
        ));
    }
    if !has_ranges && design.samples.is_some() {
        return Err(study.error(
            "design.samples",
            "is of ranges, and [vary] has none: give `min` and `max`, or leave it out",
        ));
    }
    if design.points.is_none()
        && let Some((name, _)) = study.vary.iter().find(|(_, v)| v.values.is_empty() && v.range().is_none())
    {
        return Err(study.error(
            &format!("vary.{name}"),
            "has no values; give `values`, or `min` and `max`, or a column of `design.points`",
        ));
    }
    Ok(())
}

fn check_fit(study: &Study) -> Result<(), StudyError> {
    let Some(fit) = &study.fit else { return Ok(()) };
    let is_wrong = |vary: &&Vary| vary.range().is_none() && vary.values.len() != 1;
    if let Some((name, _)) = study.vary.iter().find(|(_, vary)| is_wrong(vary)) {
        let message = "needs a range to be fitted, `min` and `max`, or one value that stays";
        return Err(study.error(&format!("vary.{name}"), message));
    }
    let fitted = study.ranges().len();
    if fitted == 0 {
        return Err(study.error("vary", "has no range; what is to be fitted needs `min` and `max`"));
    }
    if fit.target.is_empty() {
        return Err(
            study.error("fit.target", "names no measure; write [fit.target.NAME] with value and uncertainty")
        );
    }
    let measures: Vec<&str> = study.measure.keys().map(String::as_str).collect();
    if let Some(name) = fit.target.keys().find(|name| !measures.contains(&name.as_str())) {
        return Err(study.error(&format!("fit.target.{name}"), no_such("measure", name, &measures)));
    }
    if fitted > MOST_FITTED {
        let message = format!(
            "{fitted} quantities are to be fitted, {MOST_FITTED} at most; leave out those that matter least"
        );
        return Err(study.error("vary", message));
    }
    let (initial, repeats) = (crate::fit::initial_points(study), study.design.repeats);
    if fit.max_runs < initial * repeats {
        return Err(study.error(
            "fit.max_runs",
            format!(
                "the search begins with {initial} points of {repeats} run(s) each: must be at least {}",
                initial * repeats
            ),
        ));
    }
    let coefficients = crate::surface::coefficients(fitted);
    if initial < coefficients + 2 {
        return Err(study.error(
            "design.samples",
            format!(
                "a surface of {coefficients} coefficients is fitted to the points: must be at least {}",
                coefficients + 2
            ),
        ));
    }
    Ok(())
}

/// Quantities that a surface of second order can be fitted to with a sensible number of runs.
const MOST_FITTED: usize = 8;

/// The message about an unknown name.
pub(crate) fn no_such(what: &str, name: &str, known: &[&str]) -> String {
    let meant = closest(name, known.iter().copied())
        .map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    let list = if known.is_empty() { "none".into() } else { known.join(", ") };
    format!("no such {what}{meant} (there: {list})")
}
