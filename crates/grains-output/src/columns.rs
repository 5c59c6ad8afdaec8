//! Tables kept in HDF5.

use crate::error::FileError;
use hdf5::Dataset;
use hdf5::types::{TypeDescriptor, VarLenAscii, VarLenUnicode};
use std::path::Path;

/// The one-dimensional datasets at the root of an HDF5 file as a CSV text, a column each.
///
/// # Errors
/// A file that cannot be read, or datasets of different lengths.
pub fn read_columns_as_csv(path: &Path) -> Result<String, FileError> {
    let columns = (|| -> hdf5::Result<Vec<(String, Vec<String>)>> {
        let file = hdf5::File::open(path)?;
        file.member_names()?
            .into_iter()
            .map(|name| Ok((name.clone(), column(&file.dataset(&name)?)?)))
            .collect()
    })();
    let columns = columns.map_err(|e| FileError::new(path, format!("cannot be read as columns: {e}")))?;
    let rows = columns.first().map_or(0, |c| c.1.len());
    if let Some((name, _)) = columns.iter().find(|c| c.1.len() != rows) {
        return Err(FileError::new(path, format!("`{name}` has another length than `{}`", columns[0].0)));
    }
    let names: Vec<&str> = columns.iter().map(|c| c.0.as_str()).collect();
    let mut text = names.join(",") + "\n";
    for row in 0..rows {
        let values: Vec<&str> = columns.iter().map(|c| &*c.1[row]).collect();
        text += &(values.join(",") + "\n");
    }
    Ok(text)
}

/// The numbers or names of a dataset as texts.
fn column(dataset: &Dataset) -> hdf5::Result<Vec<String>> {
    Ok(match dataset.dtype()?.to_descriptor()? {
        TypeDescriptor::VarLenUnicode => {
            dataset.read_raw::<VarLenUnicode>()?.iter().map(ToString::to_string).collect()
        }
        TypeDescriptor::VarLenAscii => {
            dataset.read_raw::<VarLenAscii>()?.iter().map(ToString::to_string).collect()
        }
        _ => dataset.read_raw::<f64>()?.iter().map(|x| format!("{x:?}")).collect(),
    })
}
