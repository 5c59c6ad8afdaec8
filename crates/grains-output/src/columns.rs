//! Tables kept in HDF5.

use crate::error::FileError;
use hdf5::Dataset;
use hdf5::types::{TypeDescriptor, VarLenAscii, VarLenUnicode};
use std::ops::Range;
use std::path::Path;

/// The one-dimensional datasets at the root of an HDF5 file as lines of CSV, a column each: the names, and share `k` of
/// `n` of the rows.
///
/// # Errors
/// A file that cannot be read, or datasets of different lengths.
pub fn read_columns_as_csv(path: &Path, (k, n): (usize, usize)) -> Result<(String, String), FileError> {
    let unreadable = |e: hdf5::Error| {
        FileError::new(
            path,
            format!(
                "cannot be read as columns: {e}; it is damaged, or no HDF5 file: write datasets x, y, z and so on, or take a .csv"
            ),
        )
    };
    let file = hdf5::File::open(path).map_err(unreadable)?;
    let names = file.member_names().map_err(unreadable)?;
    let datasets: hdf5::Result<Vec<Dataset>> = names.iter().map(|name| file.dataset(name)).collect();
    let datasets = datasets.map_err(unreadable)?;
    let rows = datasets.first().map_or(0, |dataset| dataset.size());
    if let Some((name, _)) = names.iter().zip(&datasets).find(|(_, dataset)| dataset.size() != rows) {
        return Err(FileError::new(path, format!("`{name}` has another length than `{}`", names[0])));
    }
    let own = rows * k / n..rows * (k + 1) / n;
    let columns = datasets.iter().map(|dataset| column(dataset, own.clone()));
    let columns = columns.collect::<hdf5::Result<Vec<Vec<String>>>>().map_err(unreadable)?;
    let mut text = String::new();
    for row in 0..own.len() {
        let values: Vec<&str> = columns.iter().map(|column| &*column[row]).collect();
        text += &(values.join(",") + "\n");
    }
    Ok((names.join(","), text))
}

/// The numbers or names in some rows of a dataset as texts.
fn column(dataset: &Dataset, rows: Range<usize>) -> hdf5::Result<Vec<String>> {
    Ok(match dataset.dtype()?.to_descriptor()? {
        TypeDescriptor::VarLenUnicode => {
            let names = dataset.read_slice_1d::<VarLenUnicode, _>(rows)?;
            names.iter().map(ToString::to_string).collect()
        }
        TypeDescriptor::VarLenAscii => {
            let names = dataset.read_slice_1d::<VarLenAscii, _>(rows)?;
            names.iter().map(ToString::to_string).collect()
        }
        _ => dataset.read_slice_1d::<f64, _>(rows)?.iter().map(|x| format!("{x:?}")).collect(),
    })
}
