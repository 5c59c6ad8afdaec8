//! Tables of a run: the time series and profiles.

use crate::block::{Array, Block};
use serde::Serialize;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Numbers of a table at most.
const NUMBERS: usize = 160_000;
/// Rows of a table at most: a chart has fewer pixels.
const ROWS: usize = 2_000;

/// A table as the page reads it.
#[derive(Debug, Serialize)]
pub struct Table {
    /// Its name.
    pub name: String,
    /// Rows in the file.
    pub stored: usize,
    /// Rows here.
    pub rows: usize,
    /// Columns with a number that is not 0.
    pub columns: Vec<Column>,
    /// Names of columns without.
    pub zeros: Vec<String>,
}

/// A column of a table.
#[derive(Debug, Serialize)]
pub struct Column {
    name: String,
    unit: String,
    values: Array,
}

/// Columns and rows of a file.
#[derive(Debug, Default, PartialEq)]
struct Rows {
    names: Vec<String>,
    units: Vec<String>,
    rows: Vec<Vec<f64>>,
    stored: usize,
}

/// Reads a time series, thinned if it is long; none if there is no row.
///
/// # Errors
/// A file that cannot be read.
pub fn series(path: &Path, block: &mut Block) -> std::io::Result<Option<Table>> {
    let rows = Rows::read(path)?;
    Ok((!rows.rows.is_empty()).then(|| rows.table("series", block)))
}

/// Reads the profiles of a directory: means, and the last output of the others.
///
/// # Errors
/// A file that cannot be read.
pub fn profiles(directory: &Path, block: &mut Block) -> std::io::Result<Vec<Table>> {
    /// More would fill pages.
    const MAX: usize = 16;
    let mut names: Vec<String> = std::fs::read_dir(directory)?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with("profile-") && name.ends_with(".csv"))
        .collect();
    names.sort();
    let mut tables = Vec::new();
    for file in names.into_iter().take(MAX) {
        let mut rows = Rows::read(&directory.join(&file))?;
        rows.keep_last_block();
        if rows.rows.len() > 1 {
            let name = file.trim_start_matches("profile-").trim_end_matches(".csv");
            tables.push(rows.table(name, block));
        }
    }
    Ok(tables)
}

impl Rows {
    fn read(path: &Path) -> std::io::Result<Self> {
        let mut found = Self::default();
        let (mut every, mut peaks): (usize, Vec<f64>) = (1, Vec::new());
        let mut last = None;
        for line in BufReader::new(File::open(path)?).lines() {
            let line = line?;
            if let Some(comment) = line.strip_prefix('#') {
                if let Some(units) = comment.trim_start().strip_prefix("units: ") {
                    found.units = units.split(',').map(String::from).collect();
                }
                continue;
            }
            if found.names.is_empty() {
                found.names = line.split(',').map(String::from).collect();
                continue;
            }
            let row: Vec<f64> = line.split(',').map(|x| x.trim().parse().unwrap_or(f64::NAN)).collect();
            // A row that is being written.
            if row.len() != found.names.len() {
                continue;
            }
            found.stored += 1;
            peaks.resize(row.len(), f64::NEG_INFINITY);
            peaks.iter_mut().zip(&row).for_each(|(peak, &x)| *peak = peak.max(x));
            if !(found.stored - 1).is_multiple_of(every) {
                last = Some(row);
                continue;
            }
            last = None;
            found.rows.push(found.with_peaks(row, &peaks));
            peaks.fill(f64::NEG_INFINITY);
            if found.rows.len() > 2 * found.longest() {
                every *= 2;
                found.rows = std::mem::take(&mut found.rows).into_iter().step_by(2).collect();
            }
        }
        if let Some(row) = last {
            found.rows.push(found.with_peaks(row, &peaks));
        }
        Ok(found)
    }

    /// Rows that a page holds.
    fn longest(&self) -> usize {
        (NUMBERS / self.names.len().max(1)).clamp(100, ROWS) / 2
    }

    /// A row whose maxima are those of all rows since the one before.
    fn with_peaks(&self, row: Vec<f64>, peaks: &[f64]) -> Vec<f64> {
        let of = |((name, x), &peak): ((&String, f64), &f64)| {
            if name.starts_with("max_") { x.max(peak) } else { x }
        };
        self.names.iter().zip(row).zip(peaks).map(of).collect()
    }

    /// Keeps the rows of the last output, and drops the columns that number and date it.
    fn keep_last_block(&mut self) {
        if self.names.first().is_some_and(|name| name == "step") {
            let step = self.rows.last().map(|row| row[0]);
            self.rows.retain(|row| Some(row[0]) == step);
        }
        let dropped = |name: &String| name == "step" || name == "time";
        let kept: Vec<usize> = (0..self.names.len()).filter(|&k| !dropped(&self.names[k])).collect();
        self.units.resize(self.names.len(), String::new());
        self.names = kept.iter().map(|&k| self.names[k].clone()).collect();
        self.units = kept.iter().map(|&k| self.units[k].clone()).collect();
        self.rows.iter_mut().for_each(|row| *row = kept.iter().map(|&k| row[k]).collect());
    }

    fn table(self, name: &str, block: &mut Block) -> Table {
        let (mut columns, mut zeros) = (Vec::new(), Vec::new());
        for (k, column) in self.names.iter().enumerate() {
            if k > 0 && self.rows.iter().all(|row| row[k] == 0.0 || !row[k].is_finite()) {
                zeros.push(column.clone());
                continue;
            }
            // Profiles have their units in the names of the columns.
            let (name, unit) = match column.split_once(" [") {
                Some((name, unit)) => (name, unit.trim_end_matches(']')),
                None => (column.as_str(), self.units.get(k).map_or("", String::as_str)),
            };
            let values = block.reals(self.rows.iter().map(|row| row[k]));
            columns.push(Column { name: name.into(), unit: unit.into(), values });
        }
        Table { name: name.into(), stored: self.stored, rows: self.rows.len(), columns, zeros }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn read(name: &str, text: &str) -> Rows {
        let path = std::env::temp_dir().join(format!("grains-curves-{name}-{}", std::process::id()));
        std::fs::write(&path, text).unwrap();
        let rows = Rows::read(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        rows
    }

    #[test]
    fn a_long_series_keeps_its_ends_and_its_peaks() {
        let mut text = "# units: -,s,m/s\nstep,time,max_speed\n".to_string();
        (0..100_001)
            .for_each(|k| text += &format!("{k},{},{}\n", k as f64 * 0.5, if k == 77_777 { 9 } else { 1 }));
        text += "100001,5000";
        let found = read("long", &text);
        assert_eq!(found.stored, 100_001);
        assert!((500..=ROWS + 1).contains(&found.rows.len()), "{}", found.rows.len());
        assert_eq!((found.rows[0][0], found.rows.last().unwrap()[1]), (0.0, 50_000.0));
        assert_eq!(found.rows.iter().map(|row| row[2]).fold(0.0, f64::max), 9.0);
        assert!(found.rows.windows(2).all(|rows| rows[0][0] < rows[1][0]));
    }

    #[test]
    fn of_a_profile_the_last_output_is_shown() {
        let mut found =
            read("profile", "step,time,z,p\n0,0.0,0.1,5.0\n0,0.0,0.2,6.0\n7,1.0,0.1,8.0\n7,1.0,0.2,9.0\n");
        found.keep_last_block();
        assert_eq!(found.names, ["z", "p"]);
        assert_eq!(found.rows, [[0.1, 8.0], [0.2, 9.0]]);
    }
}
