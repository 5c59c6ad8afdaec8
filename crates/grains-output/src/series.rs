//! The time series: a CSV that a restart continues.

use crate::error::FileError;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A CSV file with `#` comments, a header, and a row per interval; the first column is the step.
///
/// One rank writes it. `pandas.read_csv(path, comment="#")` reads it.
pub struct Series {
    path: PathBuf,
    file: File,
    columns: usize,
    /// Length of the file (bytes), and the last row's step and where the row begins.
    length: u64,
    last: Option<(u64, u64)>,
}

impl Series {
    /// Creates the file; one of that name is lost. Comments become lines `# name: value`.
    ///
    /// # Errors
    /// A file that cannot be written, or a column whose name holds a comma, quote or line end.
    pub fn create(path: &Path, columns: &[String], comments: &[(String, String)]) -> Result<Self, FileError> {
        if let Some(column) = columns.iter().find(|c| c.contains([',', '"', '\n', '#'])) {
            let problem =
                format!("the column `{column}` has one of , \" # or a line end in its name: rename it");
            return Err(FileError::new(path, problem));
        }
        let mut text = String::new();
        for (name, value) in comments {
            value.lines().for_each(|line| text += &format!("# {name}: {line}\n"));
        }
        text += &(columns.join(",") + "\n");
        let opened = OpenOptions::new().write(true).create(true).truncate(true).open(path);
        let mut file = opened.map_err(|e| FileError::new(path, format!("cannot be created: {e}")))?;
        file.write_all(text.as_bytes())
            .map_err(|e| FileError::new(path, format!("cannot be written: {e}")))?;
        let length = text.len() as u64;
        Ok(Self { path: path.to_path_buf(), file, columns: columns.len(), length, last: None })
    }

    /// Continues the file, forgetting every row after `step` and a row that a crash cut short.
    ///
    /// The row of `step` itself stays until it is appended again.
    ///
    /// # Errors
    /// A file that cannot be read or that has other columns.
    pub fn resume(path: &Path, columns: &[String], step: u64) -> Result<Self, FileError> {
        let text = std::fs::read_to_string(path).map_err(|e| {
            FileError::new(
                path,
                format!("cannot be continued: {e}; restore it, or start in another directory"),
            )
        })?;
        let mut header = None;
        let (mut kept, mut last) = (0, None);
        for line in text.split_inclusive('\n').take_while(|line| line.ends_with('\n')) {
            if !line.starts_with('#') {
                if header.is_some() {
                    let row = line.split(',').next().and_then(|s| s.parse::<u64>().ok());
                    let Some(row) = row.filter(|&row| row <= step) else { break };
                    last = Some((row, kept as u64));
                } else {
                    header = Some(line.trim_end().to_string());
                }
            }
            kept += line.len();
        }
        if header.as_deref() != Some(&columns.join(",")) {
            let (found, wanted) = (header.unwrap_or_default(), columns.join(","));
            let problem = format!(
                "has the columns `{found}`, this run `{wanted}`: continue with the case it was begun with, or in another directory"
            );
            return Err(FileError::new(path, problem));
        }
        let aside = path.with_extension("csv.tmp");
        let opened = std::fs::write(&aside, &text[..kept])
            .and_then(|()| std::fs::rename(&aside, path))
            .and_then(|()| OpenOptions::new().append(true).open(path));
        let file = opened.map_err(|e| FileError::new(path, format!("cannot be written: {e}")))?;
        Ok(Self { path: path.to_path_buf(), file, columns: columns.len(), length: kept as u64, last })
    }

    /// Appends a row: the step, then a value per further column. A row of the same step, which a restart
    /// left, is replaced.
    ///
    /// # Errors
    /// A full disk, or another number of values than columns.
    pub fn append(&mut self, step: u64, values: &[f64]) -> Result<(), FileError> {
        if values.len() + 1 != self.columns {
            let problem = format!("{} values for {} columns after the step", values.len(), self.columns - 1);
            return Err(FileError::new(&self.path, problem));
        }
        let mut row = step.to_string();
        for value in values {
            row += &format!(",{value:?}");
        }
        row.push('\n');
        self.write(step, &row).map_err(|e| {
            // Half a row must not stay: the next one would be glued to it.
            let _ = self.file.set_len(self.length);
            FileError::new(&self.path, format!("cannot be written: {e}; free space, then --restart latest"))
        })
    }

    fn write(&mut self, step: u64, row: &str) -> std::io::Result<()> {
        if let Some((_, start)) = self.last.filter(|&(last, _)| last == step) {
            self.file.set_len(start)?;
            self.length = start;
        }
        // One write per row: a reader never sees half of one.
        self.file.write_all(row.as_bytes())?;
        self.last = Some((step, self.length));
        self.length += row.len() as u64;
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_restart_continues_the_series_and_refuses_other_columns() {
        let folder = std::env::temp_dir().join(format!("grains-series-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("series.csv");
        let columns = ["step".to_string(), "time [s]".to_string()];
        let mut series = Series::create(&path, &columns, &[("case".into(), "two\nlines".into())]).unwrap();
        (0..5).for_each(|k| series.append(10 * k, &[0.1 * k as f64]).unwrap());
        drop(series);
        // half a row, as a crash leaves it
        OpenOptions::new().append(true).open(&path).unwrap().write_all(b"50,0.").unwrap();
        let mut series = Series::resume(&path, &columns, 30).unwrap();
        series.append(30, &[7.0]).unwrap();
        series.append(50, &[8.0]).unwrap();
        assert!(series.append(60, &[8.0, 9.0]).is_err());
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            "# case: two\n# case: lines\nstep,time [s]\n0,0.0\n10,0.1\n20,0.2\n30,7.0\n50,8.0\n"
        );
        let other = ["step".to_string(), "time".to_string()];
        assert!(Series::resume(&path, &other, 30).is_err_and(|e| e.to_string().contains("has the columns")));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
