//! Members of a study: the case with some values, as a text that is checked before anything runs.

use crate::address::Address;
use crate::design::Values;
use crate::error::StudyError;
use crate::study_file::Study;
use grains_case::Case;
use std::path::{Path, PathBuf};
use toml::{Table, Value};
use toml_edit::DocumentMut;

/// Directory of the results of a member, within its folder.
pub(crate) const RUN: &str = "run";

/// One run of a study.
#[derive(Clone, Debug)]
pub struct Member {
    /// Number of its folder.
    pub number: usize,
    /// Round of the search for the best values in which it was asked for; 0 of its beginning, and without a search.
    pub round: usize,
    /// Seed of its case (-).
    pub seed: u64,
    /// What that is more than the seed of the study's case (-).
    pub shift: u64,
    /// Values of the varied quantities.
    pub values: Values,
    /// Its case.
    pub text: String,
}

/// The case of a study, from which its members are made.
pub(crate) struct Pattern<'s> {
    study: &'s Study,
    path: PathBuf,
    document: DocumentMut,
    seed: u64,
    addresses: Vec<(&'s str, Address)>,
}

impl<'s> Pattern<'s> {
    /// Reads the case of a study.
    ///
    /// # Errors
    /// A case that is wrong by itself, and keys that are none.
    pub fn read(study: &'s Study) -> Result<Self, StudyError> {
        let path = study.base().join(&study.case);
        if !path.is_file() {
            return Err(study.error(
                "case",
                format!("no such file; looked for {}, as paths are relative to the study", path.display()),
            ));
        }
        let case = Case::load(&path)?;
        let text = std::fs::read_to_string(&path).map_err(|error| StudyError::of_file(&path, error))?;
        let document = text.parse::<DocumentMut>().map_err(|error| StudyError::of_file(&path, error))?;
        let mut addresses = Vec::new();
        for (name, vary) in &study.vary {
            for (i, text) in vary.addresses().enumerate() {
                let place = if vary.key.is_some() {
                    format!("vary.{name}.key")
                } else {
                    format!("vary.{name}.keys[{i}]")
                };
                let address = Address::parse(text).map_err(|problem| study.error(&place, problem))?;
                let value = vary.values.first().and_then(|value| value.to_string().parse().ok());
                address
                    .set(&mut document.clone(), &value.unwrap_or_else(|| 0.into()))
                    .map_err(|problem| study.error(&place, problem))?;
                addresses.push((name.as_str(), address));
            }
        }
        crate::case_check::check(study, &case, &document, &addresses)?;
        Ok(Self { study, path, document, seed: case.seed, addresses })
    }

    /// The case with some values and the seed of a repetition; `shift` is added to the seed of the case, if it is not varied.
    ///
    /// # Errors
    /// What the check of cases finds wrong, with the values.
    pub fn text(&self, values: &Values, shift: Option<u64>) -> Result<(String, u64), StudyError> {
        let mut document = self.document.clone();
        let seed = self.seed + shift.unwrap_or(0);
        if shift.is_some() {
            document["seed"] = toml_edit::value(seed as i64);
        }
        let told = told(values);
        for (name, address) in &self.addresses {
            let Some(value) = values.get(*name).and_then(|value| value.to_string().parse().ok()) else {
                continue;
            };
            address.set(&mut document, &value).map_err(|problem| {
                self.study.error(&format!("vary.{name}"), format!("{problem} ({told})"))
            })?;
        }
        let base = self.path.parent().unwrap_or(Path::new(""));
        let case =
            Case::parse(&document.to_string(), &self.path.display().to_string(), base).map_err(|errors| {
                let is_of_range = errors.0.iter().any(|error| {
                    let value = error.value.as_ref().and_then(|value| value.parse::<f64>().ok());
                    error.message.contains("whole number")
                        && self.study.ranges().iter().any(|(name, _)| values[*name].as_float() == value)
                });
                let remedy = match is_of_range {
                    true => "\na range gives no whole numbers: give `values` in place of `min` and `max`",
                    false => "",
                };
                StudyError::Study(format!(
                    "{}: not a case with {told}:\n{errors}{remedy}",
                    self.study.written.0
                ))
            })?;
        with_full_paths(&mut document, &case);
        document["output"].or_insert(toml_edit::table())["directory"] = toml_edit::value(RUN);
        Ok((document.to_string(), case.seed))
    }

    /// The case with some values, for its own folder and directory of results.
    ///
    /// # Errors
    /// What the check of cases finds wrong.
    pub fn fitted(&self, values: &Values, directory: &Path) -> Result<String, StudyError> {
        let (text, _) = self.text(values, None)?;
        let mut document =
            text.parse::<DocumentMut>().map_err(|error| StudyError::of_file(&self.path, error))?;
        document["output"]["directory"] = toml_edit::value(directory.display().to_string());
        Ok(document.to_string())
    }
}

/// Values for a message: `friction = 0.3, rolling = 0.1`.
pub(crate) fn told(values: &Values) -> String {
    values.iter().map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
}

/// The same without those that have one value in all members.
pub(crate) fn told_varied(study: &Study, values: &Values) -> String {
    let is_varied = |name: &String| study.vary[name].values.len() != 1;
    let varied: Values =
        values.iter().filter(|(name, _)| is_varied(name)).map(|(n, v)| (n.clone(), v.clone())).collect();
    told(if varied.is_empty() { values } else { &varied })
}

/// Gives files their full paths, as the folder of a member is not that of the case.
fn with_full_paths(document: &mut DocumentMut, case: &Case) {
    let Ok(resolved) = case.to_toml().parse::<Table>() else { return };
    let Ok(written) = document.to_string().parse::<Table>() else { return };
    let mut found = Vec::new();
    compare(&Value::Table(written), &Value::Table(resolved), String::new(), &mut found);
    for (place, path) in found {
        if let Ok(address) = Address::parse(&place) {
            // It stands where it was found.
            let _ = address.set(document, &path.as_str().into());
        }
    }
}

/// Finds texts of a case that stand for files: those that its check has replaced by full paths.
fn compare(written: &Value, resolved: &Value, place: String, found: &mut Vec<(String, String)>) {
    match (written, resolved) {
        (Value::Table(written), Value::Table(resolved)) => {
            for (key, value) in written {
                if let Some(other) = resolved.get(key) {
                    let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
                    compare(value, other, place, found);
                }
            }
        }
        (Value::Array(written), Value::Array(resolved)) => {
            for (i, (value, other)) in written.iter().zip(resolved).enumerate() {
                compare(value, other, format!("{place}[{i}]"), found);
            }
        }
        (Value::String(written), Value::String(path)) if written != path && Path::new(path).is_absolute() => {
            found.push((place, path.clone()));
        }
        _ => {}
    }
}
