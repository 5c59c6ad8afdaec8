//! What an analysis found: tables as CSV files, pictures, and lines for the terminal.

use super::picture::{Picture, draw};
use grains_output::FileError;
use grains_simulation::RunError;
use std::path::Path;

/// A table, written as CSV with comments that begin with `#`.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Name of the file, without its ending.
    pub name: String,
    /// What the rows are, in one sentence.
    pub what: String,
    /// Names and units of the columns.
    pub columns: Vec<(String, &'static str)>,
    /// Rows, as long as the columns; NaN stands for what is not defined.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// A table without rows.
    pub fn new(name: &str, what: &str, columns: &[(&str, &'static str)]) -> Self {
        let columns = columns.iter().map(|&(name, unit)| (name.to_string(), unit)).collect();
        Self { name: name.into(), what: what.into(), columns, rows: Vec::new() }
    }

    /// Appends a row.
    pub fn push(&mut self, row: Vec<f64>) {
        debug_assert_eq!(row.len(), self.columns.len(), "{}", self.name);
        self.rows.push(row);
    }

    /// Values of two columns, by number.
    pub fn points(&self, x: usize, y: usize) -> Vec<[f64; 2]> {
        self.rows.iter().map(|row| [row[x], row[y]]).collect()
    }

    /// The file: comments, names of the columns, rows; numbers as short as they can be read back exactly.
    fn csv(&self, origin: &[(String, String)]) -> String {
        let units: Vec<&str> = self.columns.iter().map(|c| c.1).collect();
        let mut text = String::new();
        let own = [("what".to_string(), self.what.clone()), ("units".to_string(), units.join(","))];
        for (name, value) in origin.iter().chain(&own) {
            value.lines().for_each(|line| text += &format!("# {name}: {line}\n"));
        }
        let names: Vec<&str> = self.columns.iter().map(|c| c.0.as_str()).collect();
        text += &(names.join(",") + "\n");
        for row in &self.rows {
            let values: Vec<String> = row.iter().map(|&x| number(x)).collect();
            text += &(values.join(",") + "\n");
        }
        text
    }
}

/// A number that reads back exactly; whole ones without a point.
fn number(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e15 { format!("{}", x as i64) } else { format!("{x:?}") }
}

/// A time (s) with the digits a reader wants.
pub fn seconds(time: f64) -> String {
    let short = format!("{time:.5e}").parse::<f64>().unwrap_or(time);
    format!("{short} s")
}

/// What an analysis found, on all ranks or at least on the first.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Main numbers, a line each.
    pub lines: Vec<String>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Pictures.
    pub pictures: Vec<Picture>,
}

impl Report {
    /// Writes tables and pictures into a folder, which is created.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn write(&self, folder: &Path, program: &str, run: &Path, times: &str) -> Result<(), RunError> {
        let refuse = |path: &Path, error: std::io::Error| {
            let problem = format!("cannot be written: {error}; choose another folder with --output");
            RunError::from(FileError::new(path, problem))
        };
        std::fs::create_dir_all(folder).map_err(|e| refuse(folder, e))?;
        let origin = [
            ("program".to_string(), program.to_string()),
            ("run".to_string(), run.display().to_string()),
            ("time".to_string(), times.to_string()),
        ];
        let save = |name: String, text: String| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(|e| refuse(&path, e))
        };
        for table in &self.tables {
            save(format!("{}.csv", table.name), table.csv(&origin))?;
        }
        for picture in &self.pictures {
            save(format!("{}.svg", picture.name), draw(picture).map_err(RunError::files)?)?;
        }
        Ok(())
    }

    /// Names of the files.
    pub fn files(&self) -> Vec<String> {
        let tables = self.tables.iter().map(|t| format!("{}.csv", t.name));
        let pictures = self.pictures.iter().map(|p| format!("{}.svg", p.name));
        tables.chain(pictures).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_say_where_they_come_from_and_numbers_read_back() {
        let mut table = Table::new("a", "Test.", &[("n", "-"), ("x", "m")]);
        table.push(vec![3.0, 0.1]);
        table.push(vec![-2.0, f64::NAN]);
        let text = table.csv(&[("run".into(), "results".into())]);
        assert_eq!(text, "# run: results\n# what: Test.\n# units: -,m\nn,x\n3,0.1\n-2,NaN\n");
        assert_eq!(number(1e-20).parse::<f64>(), Ok(1e-20));
        assert_eq!(number(1e300).parse::<f64>(), Ok(1e300));
    }
}
