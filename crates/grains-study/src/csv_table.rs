//! Tables of the program: CSV with comments that begin with `#`, among them the units of the columns.

use crate::error::StudyError;
use grains_case::read_text;
use std::path::Path;

/// A table of numbers and words.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CsvTable {
    pub columns: Vec<String>,
    pub units: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl CsvTable {
    /// Reads a table.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        let text = read_text(path).map_err(|error| StudyError::of_file(path, error))?;
        Self::parse(&text).map_err(|problem| StudyError::of_file(path, problem))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let split = |line: &str| line.split(',').map(|word| word.trim().to_owned()).collect::<Vec<_>>();
        let mut table = Self::default();
        for line in text.lines() {
            match line.strip_prefix('#') {
                Some(comment) => {
                    if let Some(units) = comment.trim().strip_prefix("units:") {
                        table.units = split(units);
                    }
                }
                None if line.trim().is_empty() => {}
                None if table.columns.is_empty() => table.columns = split(line),
                None => table.rows.push(split(line)),
            }
        }
        if table.columns.is_empty() {
            return Err("has no line with the names of columns".into());
        }
        let width = table.columns.len();
        match table.rows.iter().position(|row| row.len() != width) {
            Some(row) => Err(format!(
                "row {} has {} values, not {width}; commas part the columns, and decimals have a point",
                row + 1,
                table.rows[row].len()
            )),
            None => Ok(table),
        }
    }

    /// Number of a column.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// Numbers of a column; what is none is NaN.
    pub fn numbers(&self, column: usize) -> Vec<f64> {
        self.rows.iter().map(|row| row[column].parse().unwrap_or(f64::NAN)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_units_and_rows_are_told_apart() {
        let table = CsvTable::parse("# program: x\n# units: s,kg\ntime,mass\n0,1.5\n1,2").unwrap();
        assert_eq!(table.units, ["s", "kg"]);
        assert_eq!(table.numbers(table.position("mass").unwrap()), [1.5, 2.0]);
        assert!(CsvTable::parse("a,b\n1\n2,3\n").unwrap_err().contains("row 1 has 1 values"));
        assert!(CsvTable::parse("# nothing\n").is_err());
    }
}
