//! Transfer of parts of a dataset: the parts of HDF5 that the safe binding leaves out.

#![allow(unsafe_code)] // raw calls, each group under the library's lock

use hdf5::{Dataset, Datatype, H5Type};
use hdf5_sys::h5d::{H5Dget_space, H5Dread, H5Dwrite};
use hdf5_sys::h5i::hid_t;
use hdf5_sys::h5p::H5FD_mpio_xfer_t::H5FD_MPIO_COLLECTIVE;
use hdf5_sys::h5p::{H5Pclose, H5Pcreate, H5Pset_dxpl_mpio};
use hdf5_sys::h5s::{H5S_seloper_t, H5Sclose, H5Screate_simple, H5Sselect_hyperslab, H5Sselect_none};
use std::ptr;

/// Who takes part in a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Participants {
    /// All ranks in one collective transfer, also those without rows.
    All,
    /// Each rank for itself.
    ThisRank,
}

/// A part of a dataset: the first place and the number of values along each of its dimensions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// First place.
    pub first: Vec<u64>,
    /// Number of values.
    pub count: Vec<u64>,
}

impl Part {
    /// Rows from `first` of a dataset of one or, with `width` values per row, two dimensions.
    fn rows(dataset: &Dataset, first: usize, rows: usize, width: usize) -> Self {
        let dimensions = dataset.ndim();
        let list = |list: [usize; 2]| list.iter().take(dimensions).map(|&n| n as u64).collect();
        Self { first: list([first, 0]), count: list([rows, width]) }
    }

    fn values(&self) -> u64 {
        self.count.iter().product()
    }
}

/// Writes rows `first..first + rows` of a dataset of `width` values per row.
///
/// # Errors
/// What HDF5 says.
pub fn write_rows<T: H5Type>(
    dataset: &Dataset,
    first: usize,
    width: usize,
    data: &[T],
    who: Participants,
) -> hdf5::Result<()> {
    let part = Part::rows(dataset, first, data.len() / width.max(1), width);
    write_part(dataset, &part, data, who)
}

/// Writes a part of a dataset, its values in the order of the dataset.
///
/// # Errors
/// What HDF5 says.
pub fn write_part<T: H5Type>(
    dataset: &Dataset,
    part: &Part,
    data: &[T],
    who: Participants,
) -> hdf5::Result<()> {
    let kind = Datatype::from_type::<T>()?;
    transfer(dataset, (part, data.len()), who, |memory, file, list| {
        // SAFETY: the memory space describes exactly `data`, which outlives the call.
        unsafe { H5Dwrite(dataset.id(), kind.id(), memory, file, list, data.as_ptr().cast()) }
    })
}

/// Reads rows `first..` of a dataset into `data`; only this rank takes part.
///
/// # Errors
/// What HDF5 says.
pub fn read_rows<T: H5Type>(
    dataset: &Dataset,
    first: usize,
    width: usize,
    data: &mut [T],
) -> hdf5::Result<()> {
    let part = Part::rows(dataset, first, data.len() / width.max(1), width);
    read_part(dataset, &part, data)
}

/// Reads a part of a dataset into `data`, in the order of the dataset; only this rank takes part.
///
/// # Errors
/// What HDF5 says.
pub fn read_part<T: H5Type>(dataset: &Dataset, part: &Part, data: &mut [T]) -> hdf5::Result<()> {
    let kind = Datatype::from_type::<T>()?;
    transfer(dataset, (part, data.len()), Participants::ThisRank, |memory, file, list| {
        // SAFETY: the memory space describes exactly `data`, borrowed mutably for the call.
        unsafe { H5Dread(dataset.id(), kind.id(), memory, file, list, data.as_mut_ptr().cast()) }
    })
}

/// Selects a part in file and memory and makes the call; `call` gets memory space, file space and list.
fn transfer(
    dataset: &Dataset,
    (part, values): (&Part, usize),
    who: Participants,
    call: impl FnOnce(hid_t, hid_t, hid_t) -> i32,
) -> hdf5::Result<()> {
    let rank = dataset.ndim();
    let Part { first, count } = part;
    if rank == 0 || [first.len(), count.len()] != [rank; 2] || part.values() != values as u64 {
        return Err(format!("{values} values are no part of a dataset of {rank} dimensions").into());
    }
    hdf5::sync::sync(|| {
        // SAFETY: every handle is created here and closed below; the selections have the dataset's rank,
        // the length of `first` and `count`. A handle that could not be made is negative, which the later
        // calls refuse.
        unsafe {
            let list = H5Pcreate(*hdf5::globals::H5P_DATASET_XFER);
            let listed = match who {
                Participants::All => H5Pset_dxpl_mpio(list, H5FD_MPIO_COLLECTIVE),
                Participants::ThisRank => 0,
            };
            let file = H5Dget_space(dataset.id());
            let memory = H5Screate_simple(rank as i32, count.as_ptr(), ptr::null());
            let selected = if values == 0 {
                H5Sselect_none(file).min(H5Sselect_none(memory))
            } else {
                let set = H5S_seloper_t::H5S_SELECT_SET;
                H5Sselect_hyperslab(file, set, first.as_ptr(), ptr::null(), count.as_ptr(), ptr::null())
            };
            // Made even after a failure: the other ranks wait in it.
            let moved = call(memory, file, list);
            // Asked for at once: the next call, even one that closes a handle, forgets it.
            let error = if moved < 0 { Some(last_error()) } else { None };
            H5Sclose(memory);
            H5Sclose(file);
            H5Pclose(list);
            match error {
                Some(error) => Err(error),
                None if listed.min(selected) < 0 => Err("the part cannot be selected".into()),
                None => Ok(()),
            }
        }
    })
}

fn last_error() -> hdf5::Error {
    match hdf5::Error::query() {
        Ok(error) => error,
        Err(_) => "a transfer failed".into(),
    }
}
