//! Arrays that grow along their first dimension, a step at a time.

use crate::metadata::{text, utf8};
use hdf5::dataset::FillTime;
use hdf5::types::{FixedAscii, VarLenUnicode};
use hdf5::{Dataset, Extent, File, Group, H5Type, SimpleExtents};

/// Rows of a chunk of arrays that grow by one row per step.
pub(crate) const STEPS_PER_CHUNK: usize = 256;

/// Begins a temporal VTKHDF file: the root of the type of data with N letters, and its group of fields.
///
/// # Errors
/// What HDF5 says.
pub(crate) fn create_root<const N: usize>(
    file: &File,
    kind: &str,
    version: [i64; 2],
    fields: &str,
) -> hdf5::Result<Group> {
    let root = file.create_group("VTKHDF")?;
    let kind = FixedAscii::<N>::from_ascii(kind).map_err(|e| e.to_string())?;
    root.new_attr::<FixedAscii<N>>().create("Type")?.write_scalar(&kind)?;
    root.new_attr::<i64>().shape(2).create("Version")?.write_raw(&version)?;
    root.create_group(fields)?;
    let steps = root.create_group("Steps")?;
    steps.new_attr::<i64>().create("NSteps")?.write_scalar(&0_i64)?;
    steps.create_group(&format!("{fields}Offsets"))?;
    Ok(root)
}

/// Refuses fields other than those a file holds.
///
/// # Errors
/// A file with other fields.
pub(crate) fn require_fields<'a>(group: &Group, wanted: impl Iterator<Item = &'a str>) -> hdf5::Result<()> {
    let mut present = group.member_names()?;
    let mut wanted: Vec<&str> = wanted.collect();
    present.sort();
    wanted.sort();
    if present == wanted {
        return Ok(());
    }
    let (present, wanted) = (present.join(", "), wanted.join(", "));
    Err(format!(
        "it holds the arrays {present}, this run writes {wanted}; keep the fields of the case (output.fields, fluid.output.fields), or write into another output.directory"
    )
    .into())
}

/// A dataset without rows that can grow: `[0..][row]`, in chunks of `[rows][row]`.
///
/// # Errors
/// What HDF5 says.
pub(crate) fn grow<T: H5Type>(
    group: &Group,
    name: &str,
    row: &[usize],
    chunk: &[usize],
    compress: bool,
) -> hdf5::Result<Dataset> {
    let builder = group.new_dataset::<T>();
    let builder = if compress {
        builder.shuffle().deflate(4)
    } else {
        // Every row is written by us: filling new chunks first would write them twice.
        builder.fill_time(FillTime::Never)
    };
    let rows = std::iter::once(Extent::from(0..));
    let extents = SimpleExtents::from_vec(rows.chain(row.iter().map(|&n| Extent::from(n))).collect());
    builder.chunk(chunk.to_vec()).shape(extents).create(name)
}

/// Gives a dataset another number of rows; all ranks take part.
///
/// # Errors
/// What HDF5 says.
pub(crate) fn resize(dataset: &Dataset, rows: usize) -> hdf5::Result<()> {
    let mut shape = dataset.shape();
    if shape[0] == rows {
        return Ok(());
    }
    shape[0] = rows;
    dataset.resize(shape)
}

/// Writes the unit of a dataset.
///
/// # Errors
/// What HDF5 says.
pub(crate) fn unit(dataset: &Dataset, unit: &str) -> hdf5::Result<()> {
    dataset.new_attr::<VarLenUnicode>().create("unit")?.write_scalar(&text(unit)?)
}

/// The unit of a dataset of a file, if there is one.
pub(crate) fn unit_of(file: &File, dataset: &str) -> Option<String> {
    let unit = file.dataset(dataset).ok()?.attr("unit").ok()?.read_scalar::<VarLenUnicode>().ok()?;
    utf8(unit.as_bytes()).ok()
}

/// Single precision of values.
pub(crate) fn shortened(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&x| x as f32).collect()
}
