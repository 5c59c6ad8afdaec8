//! The rows [size, passing fraction] of a sieve analysis, inline or in a CSV file.

use std::path::PathBuf;

use crate::check::Checker;
use crate::csv_numbers;

/// Classes (lower limit, upper limit, fraction) between the rows of a curve and within cut-offs, empty ones left out.
pub(crate) fn classes(passing: &[[f64; 2]], min: Option<f64>, max: Option<f64>) -> Vec<(f64, f64, f64)> {
    let (min, max) = (min.unwrap_or(0.0), max.unwrap_or(f64::INFINITY));
    let cut = |pair: &[[f64; 2]]| {
        let [[lower, below], [upper, above]] = [pair[0], pair[1]];
        let (from, to) = (lower.max(min), upper.min(max));
        let is_whole = from == lower && to == upper;
        let share = if is_whole { 1.0 } else { (to - from) / (upper - lower) };
        (from, to, share * (above - below))
    };
    passing.windows(2).map(cut).filter(|&(from, to, share)| from < to && share > 0.0).collect()
}

/// Takes the rows of the file, if one is named, and checks rows and cut-offs.
pub(crate) fn check(
    key: &str,
    (passing, file): (&mut Vec<[f64; 2]>, &mut Option<PathBuf>),
    [min, max]: [Option<f64>; 2],
    checker: &mut Checker,
) {
    let errors = checker.error_count();
    let rows_key = format!("{key}.{}", if file.is_some() { "path" } else { "passing" });
    if let Some(file) = file.take() {
        if !passing.is_empty() {
            checker.error(&rows_key, "excludes passing; remove one of them".into());
        }
        let file = checker.file(&rows_key, &file, &["csv"]);
        if checker.error_count() > errors {
            return;
        }
        match read(&file) {
            Ok(rows) => *passing = rows,
            Err(message) => return checker.error(&rows_key, message),
        }
    }
    if let Err(message) = cumulative(passing) {
        return checker.error(&rows_key, message);
    }
    if let (Some(min), Some(max)) = (min, max)
        && min >= max
    {
        checker.error(&format!("{key}.max"), format!("must be above min = {min}"));
    } else if classes(passing, min, max).is_empty() {
        let cut_off = if min.is_some() { "min" } else { "max" };
        let message = "leaves nothing of the curve; move it into the range of its sizes";
        checker.error(&format!("{key}.{cut_off}"), message.into());
    }
}

fn read(file: &std::path::Path) -> Result<Vec<[f64; 2]>, String> {
    let rows = csv_numbers::read(file, &["size", "passing"])?;
    rows.into_iter()
        .map(|row| match row {
            [Some(size), Some(passing)] => Ok([size, passing]),
            _ => Err("the file needs the columns size and passing".into()),
        })
        .collect()
}

/// Whether rows are a cumulative curve from 0 to 1.
fn cumulative(rows: &[[f64; 2]]) -> Result<(), String> {
    let [Some([smallest, first]), Some([largest, last])] = [rows.first(), rows.last()] else {
        return Err("missing key; give rows [size, fraction that passes], or path, a CSV file of them".into());
    };
    if *smallest <= 0.0 {
        return Err(format!("the first size is {smallest}; sizes are above 0"));
    }
    for pair in rows.windows(2) {
        let [[size, fraction], [next_size, next_fraction]] = [pair[0], pair[1]];
        if next_size <= size {
            return Err(format!("sizes must ascend; {next_size} comes after {size}"));
        }
        if next_fraction < fraction {
            return Err(format!(
                "fractions must ascend; {next_fraction} at size {next_size} comes after {fraction}; they are those that pass, not those left on the sieve"
            ));
        }
    }
    if *last == 100.0 {
        return Err("fractions end at 1, not at 100; divide per cent by 100".into());
    }
    if *last != 1.0 {
        return Err(format!(
            "the last fraction is {last} at size {largest}; it must be 1: add the size that all pass"
        ));
    }
    if *first != 0.0 {
        return Err(format!(
            "the first fraction is {first} at size {smallest}; it must be 0: add the smallest size"
        ));
    }
    Ok(())
}
