//! Compares the files of two runs.

use super::results::{Series, series, snapshots};
use std::fs;
use std::path::Path;

/// Columns that a fluid's iterations or rounding make, which are others on other ranks.
const ROUNDING: [&str; 4] = ["iterations", "divergence", "imbalance", "deep_penetrations"];

/// Asserts that the files of two runs hold the same steps, and values that are the same but for the sums over ranks and the
/// tolerance of the fluid's solvers, `share` of the largest of a column.
pub fn assert_same_files(wanted: &Path, found: &Path, share: f64) {
    for file in ["particles.vtkhdf", "walls.vtkhdf", "surfaces.vtkhdf"] {
        if wanted.join(file).exists() {
            assert_eq!(snapshots(&wanted.join(file)), snapshots(&found.join(file)), "{file}");
        }
    }
    for file in ["fluid.vtkhdf", "fluid-mean.vtkhdf"] {
        if wanted.join(file).exists() {
            assert_eq!(times(&wanted.join(file)), times(&found.join(file)), "{file}");
        }
    }
    assert_same_rows(&series(wanted), &series(found), share);
    for entry in fs::read_dir(wanted).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.starts_with("profile-") && name.ends_with(".csv") {
            let [a, b] = [wanted, found].map(|folder| table(&folder.join(&name)));
            assert_same_rows(&a, &b, share);
        }
    }
}

pub fn times(file: &Path) -> Vec<f64> {
    let steps = hdf5::File::open(file).unwrap().group("VTKHDF/Steps").unwrap();
    let count = steps.attr("NSteps").unwrap().read_scalar::<i64>().unwrap() as usize;
    let mut times = steps.dataset("Values").unwrap().read_raw::<f64>().unwrap();
    times.truncate(count);
    times
}

fn table(path: &Path) -> Series {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns = lines.next().unwrap().split(',').map(String::from).collect();
    let rows = lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    Series { columns, rows }
}

pub fn assert_same_rows(wanted: &Series, found: &Series, share: f64) {
    assert_eq!(wanted.columns, found.columns);
    let first = &wanted.columns[0];
    assert_eq!(wanted.column(first), found.column(first), "column {first}");
    // Components of a vector are measured by the largest of them.
    let vector = |name: &str| name.trim_end_matches(['x', 'y', 'z']).to_string();
    for name in wanted.columns.iter().filter(|name| !ROUNDING.iter().any(|r| name.contains(r))) {
        let alike = wanted.columns.iter().filter(|other| vector(other) == vector(name));
        let largest = alike.flat_map(|n| wanted.column(n)).filter(|x| x.is_finite()).map(f64::abs);
        let tolerance = share * largest.fold(0.0, f64::max);
        for (row, (a, b)) in wanted.column(name).into_iter().zip(found.column(name)).enumerate() {
            let same = (a - b).abs() <= tolerance || a.is_nan() && b.is_nan();
            assert!(same, "column {name}, row {row}: {b:e} for {a:e}, within {tolerance:e}");
        }
    }
}
