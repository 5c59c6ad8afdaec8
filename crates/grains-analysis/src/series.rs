//! The time series of a run, read back.

use super::snapshots::StoredRun;
use grains_simulation::RunError;
use std::path::PathBuf;

/// The columns of a `series.csv` by name.
#[derive(Clone, Debug)]
pub struct TimeSeries {
    path: PathBuf,
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl TimeSeries {
    /// Reads the series beside the stored states of a run; one rank does.
    ///
    /// # Errors
    /// None there, or one that is damaged.
    pub fn read(run: &StoredRun) -> Result<Self, RunError> {
        let path = run.path.with_file_name("series.csv");
        match std::fs::read_to_string(&path) {
            Ok(text) => Self::parse(path, &text),
            Err(error) => Err(RunError::files(format!(
                "{}: cannot be read: {error}; give the directory of a run with output.series > 0",
                path.display()
            ))),
        }
    }

    fn parse(path: PathBuf, text: &str) -> Result<Self, RunError> {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let columns: Vec<String> = lines.next().unwrap_or_default().split(',').map(String::from).collect();
        let row = |line: &str| line.split(',').map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>();
        // The last row may be one that a run in progress is writing.
        let rows: Vec<Vec<f64>> = lines.map_while(row).take_while(|row| row.len() == columns.len()).collect();
        if rows.is_empty() {
            return Err(RunError::files(format!(
                "{}: holds no rows; give a run with output.series > 0",
                path.display()
            )));
        }
        Ok(Self { path, columns, rows })
    }

    /// The values of a column.
    ///
    /// # Errors
    /// No column of that name.
    pub fn column(&self, name: &str) -> Result<Vec<f64>, RunError> {
        match self.columns.iter().position(|column| column == name) {
            Some(at) => Ok(self.rows.iter().map(|row| row[at]).collect()),
            None => Err(RunError::files(format!(
                "{}: lacks the column `{name}`: it is of a case without what the column tells of, or of an older version; run the case again",
                self.path.display()
            ))),
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// The series of a text.
    pub fn series(text: &str) -> Result<TimeSeries, RunError> {
        TimeSeries::parse("series.csv".into(), text)
    }

    #[test]
    fn columns_are_found_by_name_and_half_a_row_is_left_out() {
        let read = series("# case: a,b\nstep,time,x\n0,0.0,NaN\n1,0.5,2e-3\n2,1.0,").unwrap();
        assert_eq!(read.column("time").unwrap(), [0.0, 0.5]);
        assert_eq!(read.column("x").unwrap()[1], 2e-3);
        assert!(read.column("y").unwrap_err().message.contains("`y`"));
        assert!(series("step,time\n").unwrap_err().message.contains("output.series"));
    }
}
