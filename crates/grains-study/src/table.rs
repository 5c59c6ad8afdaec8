//! What the members of a study have given: one row each.

use crate::error::StudyError;
use crate::folder::{Folder, Record, State, write};
use crate::measure::{self, Value};
use crate::member::Member;
use crate::study_file::Study;
use std::path::Path;

/// A member with what became of it.
#[derive(Clone, Debug)]
pub struct Row {
    /// The member.
    pub member: Member,
    /// What became of it.
    pub record: Record,
    /// Its measures in the order of their names; NaN where there is none.
    pub measures: Vec<f64>,
}

/// The rows of a study.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Names of the varied quantities.
    pub varied: Vec<String>,
    /// Names and units of the measures.
    pub measures: Vec<(String, String)>,
    /// Rows.
    pub rows: Vec<Row>,
    /// Measures that could not be taken, with the reason.
    pub problems: Vec<String>,
}

impl Table {
    /// Takes the measures of members that are done.
    pub fn of(study: &Study, members: &[Member], directory: &Path) -> Self {
        let varied = study.vary.keys().cloned().collect();
        let units = |name: &String| (name.clone(), study.measure[name].unit.clone().unwrap_or_default());
        let mut table =
            Self { varied, measures: study.measure.keys().map(units).collect(), ..Self::default() };
        for member in members {
            let folder = Folder::of(directory, member.number);
            let record = folder.record();
            let mut measures = vec![f64::NAN; table.measures.len()];
            for (i, number) in measures.iter_mut().enumerate().filter(|_| record.state == State::Done) {
                match measure::take(study, &table.measures[i].0, &folder) {
                    Ok(Value { number: taken, unit }) => (*number, table.measures[i].1) = (taken, unit),
                    Err(error) => table.problems.push(format!("{:04}: {error}", member.number)),
                }
            }
            table.rows.push(Row { member: member.clone(), record, measures });
        }
        table
    }

    /// How many members have come to a state.
    pub fn count(&self, state: State) -> usize {
        self.rows.iter().filter(|row| row.record.state == state).count()
    }

    /// Writes the table as CSV.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path, study: &Study, program: &str) -> Result<(), StudyError> {
        write(path, &self.csv(study, program))
    }

    fn csv(&self, study: &Study, program: &str) -> String {
        let has_rounds = study.fit.is_some();
        let own = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let mut columns = own(if has_rounds { &["member", "round", "seed"] } else { &["member", "seed"] });
        let mut units = vec!["-".to_string(); columns.len()];
        columns.extend(self.varied.iter().cloned());
        units.extend(self.varied.iter().map(|_| String::new()));
        columns.extend(self.measures.iter().map(|(name, _)| name.clone()));
        units.extend(self.measures.iter().map(|(_, unit)| unit.clone()));
        columns.extend(own(&["state", "seconds", "version"]));
        units.extend(own(&["", "s", ""]));
        let mut text =
            format!("# program: {program}\n# study: {}\n# units: {}\n", study.written.0, units.join(","));
        for (name, vary) in &study.vary {
            text += &format!("# {name}: {}\n", vary.addresses().collect::<Vec<_>>().join(" and "));
        }
        text += &(columns.join(",") + "\n");
        for Row { member, record, measures } in &self.rows {
            let mut cells = vec![member.number.to_string()];
            cells.extend(has_rounds.then(|| member.round.to_string()));
            cells.push(member.seed.to_string());
            cells.extend(self.varied.iter().map(|name| member.values.get(name).map_or(String::new(), cell)));
            cells.extend(measures.iter().map(|number| format!("{number:?}")));
            cells.extend([
                record.state.word().into(),
                format!("{:.1}", record.seconds),
                record.version.clone(),
            ]);
            text += &(cells.join(",") + "\n");
        }
        text
    }
}

/// A value as a cell of a table, in quotes where it has commas.
fn cell(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) if !text.contains([',', '"', '\n']) => text.clone(),
        toml::Value::Array(_) | toml::Value::Table(_) | toml::Value::String(_) => {
            format!("\"{}\"", value.to_string().replace('"', "\"\""))
        }
        other => other.to_string(),
    }
}
