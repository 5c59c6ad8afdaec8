//! Tables: CSV files that a restart continues, and such that are written anew each time.

use crate::error::{FileError, Identity};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A CSV file with `#` comments, a header, and a row or a block of rows per output; the first column is the
/// step.
///
/// One rank writes it. `pandas.read_csv(path, comment="#")` reads it.
pub struct Series {
    path: PathBuf,
    identity: Option<Identity>,
    file: File,
    columns: usize,
    /// Length of the file (bytes), and the last output's step and where its rows begin.
    length: u64,
    last: Option<(u64, u64)>,
}

impl Series {
    /// Creates the file; one of that name is lost. Comments become lines `# name: value`.
    ///
    /// # Errors
    /// A file that cannot be written, or a column whose name holds a comma, quote or line end.
    pub fn create(path: &Path, columns: &[String], comments: &[(String, String)]) -> Result<Self, FileError> {
        let text = header(path, columns, comments)?;
        // All is written at the end, wherever that is after rows were cut off.
        let emptied = File::create(path).and_then(|_| OpenOptions::new().append(true).open(path));
        let mut file = emptied.map_err(|e| FileError::new(path, format!("cannot be created: {e}")))?;
        file.write_all(text.as_bytes())
            .map_err(|e| FileError::new(path, format!("cannot be written: {e}")))?;
        let length = text.len() as u64;
        let identity = Identity::of(path);
        Ok(Self { path: path.to_path_buf(), identity, file, columns: columns.len(), length, last: None })
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
                    if last.is_none_or(|(step, _)| step != row) {
                        last = Some((row, kept as u64));
                    }
                } else {
                    header = Some(line.trim_end().to_string());
                }
            }
            kept += line.len();
        }
        let found: Vec<&str> = header.as_deref().unwrap_or_default().split(',').collect();
        if found != columns {
            return Err(FileError::new(path, other_columns(&found, columns)));
        }
        let aside = path.with_extension("csv.tmp");
        let opened = std::fs::write(&aside, &text[..kept])
            .and_then(|()| std::fs::rename(&aside, path))
            .and_then(|()| OpenOptions::new().append(true).open(path));
        let file = opened.map_err(|e| FileError::new(path, format!("cannot be written: {e}")))?;
        let (path, identity) = (path.to_path_buf(), Identity::of(path));
        Ok(Self { path, identity, file, columns: columns.len(), length: kept as u64, last })
    }

    /// Whether the file ends with rows of a step, as one that was continued from there.
    pub fn holds(&self, step: u64) -> bool {
        self.last.is_some_and(|(last, _)| last == step)
    }

    /// Appends comments after the last row, in lines `# name: value`; they go with it if it is replaced.
    ///
    /// # Errors
    /// A full disk.
    pub fn note(&mut self, comments: &[(String, String)]) -> Result<(), FileError> {
        let text = commented(comments);
        self.file
            .write_all(text.as_bytes())
            .map_err(|e| FileError::new(&self.path, format!("cannot be written: {e}")))?;
        self.length += text.len() as u64;
        Ok(())
    }

    /// Appends a row: the step, then a value per further column. Rows of the same step, which a restart
    /// left, are replaced.
    ///
    /// # Errors
    /// A full disk, or another number of values than columns.
    pub fn append(&mut self, step: u64, values: &[f64]) -> Result<(), FileError> {
        if values.len() + 1 != self.columns {
            let problem = format!("{} values for {} columns after the step", values.len(), self.columns - 1);
            return Err(FileError::new(&self.path, problem));
        }
        self.append_block(step, values)
    }

    /// Appends rows of one step, such as a profile: `values` are `[rows][columns after the step]`. Rows of
    /// the same step, which a restart left, are replaced.
    ///
    /// # Errors
    /// A full disk, a file that was removed or replaced meanwhile, or values that make up no whole rows.
    pub fn append_block(&mut self, step: u64, values: &[f64]) -> Result<(), FileError> {
        let rows = rows(&self.path, &format!("{step},"), self.columns - 1, values)?;
        Identity::require(self.identity, &self.path)?;
        self.write(step, &rows).map_err(|e| {
            // Half a row must not stay: the next one would be glued to it.
            let _ = self.file.set_len(self.length);
            FileError::new(&self.path, format!("cannot be written: {e}; free space, then --restart latest"))
        })
    }

    fn write(&mut self, step: u64, rows: &str) -> std::io::Result<()> {
        if let Some((_, start)) = self.last.filter(|&(last, _)| last == step) {
            self.file.set_len(start)?;
            self.length = start;
        }
        // One write per output: a reader never sees half of one.
        self.file.write_all(rows.as_bytes())?;
        self.last = Some((step, self.length));
        self.length += rows.len() as u64;
        Ok(())
    }
}

/// Writes a whole CSV file aside and renames it; `values` are `[rows][columns]`. One rank does.
///
/// # Errors
/// A file that cannot be written, a column whose name holds a comma, quote or line end, or values that make
/// up no whole rows.
pub fn write_table(
    path: &Path,
    columns: &[String],
    comments: &[(String, String)],
    values: &[f64],
) -> Result<(), FileError> {
    let text = header(path, columns, comments)? + &rows(path, "", columns.len(), values)?;
    let aside = path.with_extension("csv.tmp");
    std::fs::write(&aside, text)
        .and_then(|()| std::fs::rename(&aside, path))
        .map_err(|e| FileError::new(path, format!("cannot be written: {e}")))
}

/// Comments and the names of the columns.
fn header(path: &Path, columns: &[String], comments: &[(String, String)]) -> Result<String, FileError> {
    if let Some(column) = columns.iter().find(|c| c.contains([',', '"', '\n', '#'])) {
        let problem = format!("the column `{column}` has one of , \" # or a line end in its name: rename it");
        return Err(FileError::new(path, problem));
    }
    Ok(commented(comments) + &columns.join(",") + "\n")
}

fn commented(comments: &[(String, String)]) -> String {
    let lines = comments.iter().flat_map(|(name, value)| value.lines().map(move |line| (name, line)));
    lines.map(|(name, line)| format!("# {name}: {line}\n")).collect()
}

/// Lines of `width` values, each after the same beginning.
fn rows(path: &Path, beginning: &str, width: usize, values: &[f64]) -> Result<String, FileError> {
    if width == 0 || !values.len().is_multiple_of(width) {
        let problem = format!("{} values do not make up rows of {width}", values.len());
        return Err(FileError::new(path, problem));
    }
    let mut text = String::new();
    for row in values.chunks(width) {
        let row: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
        text += &format!("{beginning}{}\n", row.join(","));
    }
    Ok(text)
}

/// Why a series with the columns `found` cannot go on with others.
fn other_columns(found: &[&str], wanted: &[String]) -> String {
    let list =
        |names: Vec<&str>| if names.is_empty() { "none".into() } else { format!("`{}`", names.join("`, `")) };
    let old = list(found.iter().copied().filter(|name| !wanted.iter().any(|w| w == name)).collect());
    let new = list(wanted.iter().map(String::as_str).filter(|name| !found.contains(name)).collect());
    format!(
        "has columns of another case or of an earlier version (only there: {old}; only in this run: {new}): continue with the case it was begun with, or in another output.directory"
    )
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
        assert!(series.holds(50) && !series.holds(30));
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            "# case: two\n# case: lines\nstep,time [s]\n0,0.0\n10,0.1\n20,0.2\n30,7.0\n50,8.0\n"
        );
        let other = ["step".to_string(), "time".to_string()];
        assert!(
            Series::resume(&path, &other, 30)
                .is_err_and(|e| e.to_string().contains("has columns of another case"))
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_row_written_twice_is_there_once_in_a_new_file_and_in_a_continued_one() {
        let folder = std::env::temp_dir().join(format!("grains-twice-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("series.csv");
        let columns = ["step".to_string(), "time".to_string()];
        let twice = |mut series: Series| {
            for value in [1.0, 2.5] {
                series.append(10, &[value]).unwrap();
            }
            series.append(20, &[3.0]).unwrap();
            std::fs::read_to_string(&path).unwrap()
        };
        let created = twice(Series::create(&path, &columns, &[]).unwrap());
        assert_eq!(created, "step,time\n10,2.5\n20,3.0\n");
        assert_eq!(twice(Series::resume(&path, &columns, 10).unwrap()), created);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn blocks_of_rows_are_cut_and_replaced_whole() {
        let folder = std::env::temp_dir().join(format!("grains-profile-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("profile-axis.csv");
        let columns = ["step", "z [m]", "p [Pa]"].map(String::from);
        let block = |p: f64| [0.0, p, 0.5, p + 0.25, 1.0, -p];
        let lines =
            |step: u64, p: f64| format!("{step},0.0,{p:?}\n{step},0.5,{:?}\n{step},1.0,{:?}\n", p + 0.25, -p);
        let mut series = Series::create(&path, &columns, &[]).unwrap();
        (0..4).for_each(|k| series.append_block(10 * k, &block(k as f64)).unwrap());
        assert!(
            series.append_block(40, &[1.0, 2.0, 3.0]).is_err_and(|e| e.to_string().contains("rows of 2"))
        );
        series.append_block(40, &[]).unwrap();
        drop(series);
        let mut series = Series::resume(&path, &columns, 20).unwrap();
        let header = "step,z [m],p [Pa]\n".to_string();
        let kept = header + &lines(0, 0.0) + &lines(10, 1.0);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), kept.clone() + &lines(20, 2.0));
        // The block of the restart replaces all rows of its step, and so does the same step again.
        for p in [7.0, 8.0] {
            series.append_block(20, &block(p)).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), kept.clone() + &lines(20, p));
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_table_is_written_whole_each_time() {
        let folder = std::env::temp_dir().join(format!("grains-table-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("profile-axis-mean.csv");
        let columns = ["z [m]", "p [Pa]"].map(String::from);
        write_table(&path, &columns, &[], &[0.0, 1.0, 0.5, 2.0]).unwrap();
        write_table(&path, &columns, &[("from".into(), "5 s".into())], &[0.0, f64::NAN]).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "# from: 5 s\nz [m],p [Pa]\n0.0,NaN\n");
        assert!(write_table(&path, &columns, &[], &[1.0]).is_err());
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
