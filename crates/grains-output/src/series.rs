//! The time series: a CSV that a restart continues.

use crate::error::FileError;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A CSV file with `#` comments, a header, and a row per interval; the first column is the step.
pub struct Series {
    path: PathBuf,
    file: File,
    columns: usize,
}

impl Series {
    /// Creates the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(path: &Path, columns: &[String], comments: &[(String, String)]) -> Result<Self, FileError> {
        let mut text = String::new();
        for (name, value) in comments {
            value.lines().for_each(|line| text += &format!("# {name}: {line}\n"));
        }
        text += &(columns.join(",") + "\n");
        let mut file =
            File::create(path).map_err(|e| FileError::new(path, format!("cannot be created: {e}")))?;
        file.write_all(text.as_bytes())
            .map_err(|e| FileError::new(path, format!("cannot be written: {e}")))?;
        Ok(Self { path: path.to_path_buf(), file, columns: columns.len() })
    }

    /// Continues the file, forgetting every row at or after `step`.
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
        let mut kept = String::new();
        let mut header = None;
        for line in text.split_inclusive('\n') {
            if line.starts_with('#') || header.is_none() {
                if !line.starts_with('#') {
                    header = Some(line.trim_end().to_string());
                }
                kept += line;
                continue;
            }
            // A row that a crash cut short has no end of line: it is dropped as well.
            let row_step = line.split(',').next().and_then(|s| s.parse::<u64>().ok());
            if line.ends_with('\n') && row_step.is_some_and(|s| s < step) {
                kept += line;
            }
        }
        if header.as_deref() != Some(&columns.join(",")) {
            let found = header.unwrap_or_default();
            return Err(FileError::new(
                path,
                format!(
                    "has the columns `{found}`, this run `{}`: continue with the case it was begun with, or in another directory",
                    columns.join(",")
                ),
            ));
        }
        let aside = path.with_extension("csv.tmp");
        std::fs::write(&aside, &kept)
            .and_then(|()| std::fs::rename(&aside, path))
            .map_err(|e| FileError::new(path, format!("cannot be written: {e}")))?;
        let file = OpenOptions::new().append(true).open(path).map_err(|e| FileError::new(path, e))?;
        Ok(Self { path: path.to_path_buf(), file, columns: columns.len() })
    }

    /// Appends a row: the step, then a value per further column.
    ///
    /// # Errors
    /// A full disk.
    pub fn append(&mut self, step: u64, values: &[f64]) -> Result<(), FileError> {
        debug_assert_eq!(values.len() + 1, self.columns, "a value per column");
        let mut row = step.to_string();
        for value in values {
            row += &format!(",{value:?}");
        }
        row.push('\n');
        // One write per row: a reader never sees half of one.
        self.file.write_all(row.as_bytes()).map_err(|e| {
            FileError::new(&self.path, format!("cannot be written: {e}; free space, then --restart latest"))
        })
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
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "# case: two\n# case: lines\nstep,time [s]\n0,0.0\n10,0.1\n20,0.2\n30,7.0\n");
        let other = ["step".to_string(), "time".to_string()];
        assert!(Series::resume(&path, &other, 30).is_err_and(|e| e.to_string().contains("has the columns")));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
