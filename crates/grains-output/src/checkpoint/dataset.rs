//! Datasets of a checkpoint.

use hdf5::dataset::FillTime;
use hdf5::{Dataset, Group, H5Type};

/// What failed where a checkpoint could not be written.
pub(super) const FAILED: &str = "the checkpoint cannot be written (earlier ones are intact)";

/// Creates a dataset.
pub(super) fn create<T: H5Type>(group: &Group, name: &str, shape: &[usize]) -> hdf5::Result<Dataset> {
    group.new_dataset::<T>().fill_time(FillTime::Never).shape(shape).create(name)
}

/// Creates a dataset with the checksum of its values.
pub(super) fn create_checked<T: H5Type>(
    group: &Group,
    name: &str,
    shape: &[usize],
    checksum: u64,
) -> hdf5::Result<Dataset> {
    let dataset = create::<T>(group, name, shape)?;
    dataset.new_attr::<u64>().create("checksum")?.write_scalar(&checksum)?;
    Ok(dataset)
}
