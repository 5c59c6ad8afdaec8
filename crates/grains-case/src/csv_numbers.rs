//! Small tables of numbers in CSV files.

use std::path::Path;

use crate::csv_share::CsvShare;
use crate::diagnostic::unknown;
use crate::text_file::read_text;

/// The rows of a file whose header has some of the named columns, in any order; `None` where it lacks one.
///
/// # Errors
/// A file that cannot be read, a column of another name, a line of another length, a field that is no number.
pub(crate) fn read<const N: usize>(file: &Path, names: &[&str; N]) -> Result<Vec<[Option<f64>; N]>, String> {
    let text = read_text(file).map_err(|error| format!("cannot read the file: {error}"))?;
    let share = CsvShare::of_text(&text);
    let header = share.columns();
    if let Some(name) = header.iter().find(|name| !names.contains(name)) {
        return Err(unknown("column", name, names));
    }
    let places = names.map(|name| header.iter().position(|known| *known == name));
    let mut rows = Vec::new();
    for (line, fields) in share.rows(0) {
        if fields.len() != header.len() {
            return Err(format!("line {line} has {} fields, the header {}", fields.len(), header.len()));
        }
        let number = |field: &&str| field.parse::<f64>().ok().filter(|number| number.is_finite());
        let numbers: Option<Vec<f64>> = fields.iter().map(number).collect();
        let numbers = numbers.ok_or_else(|| format!("line {line} holds a field that is no number"))?;
        rows.push(places.map(|place| place.map(|k| numbers[k])));
    }
    Ok(rows)
}
