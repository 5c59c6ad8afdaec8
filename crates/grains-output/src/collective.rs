//! Transfer of rows of a dataset: the parts of HDF5 that the safe binding leaves out.

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

/// Ranks up to which each writes for itself.
const FEW: i32 = 64;

impl Participants {
    /// How rows of all ranks are written best.
    ///
    /// Collective transfers of Open MPI 4.1 hang on a full disk (the aggregating rank leaves, the others wait
    /// for it), and gain nothing on few ranks; on many they save the file system from small pieces.
    /// Compressed datasets know no other way.
    pub fn writing(ranks: i32, is_compressed: bool) -> Self {
        if is_compressed || ranks > FEW { Self::All } else { Self::ThisRank }
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
    let kind = Datatype::from_type::<T>()?;
    let rows = data.len() / width.max(1);
    transfer(dataset, [first, rows, width], who, |memory, file, list| {
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
    let kind = Datatype::from_type::<T>()?;
    let rows = data.len() / width.max(1);
    transfer(dataset, [first, rows, width], Participants::ThisRank, |memory, file, list| {
        // SAFETY: the memory space describes exactly `data`, borrowed mutably for the call.
        unsafe { H5Dread(dataset.id(), kind.id(), memory, file, list, data.as_mut_ptr().cast()) }
    })
}

/// Selects rows in file and memory and makes the call; `call` gets memory space, file space and list.
fn transfer(
    dataset: &Dataset,
    [first, rows, width]: [usize; 3],
    who: Participants,
    call: impl FnOnce(hid_t, hid_t, hid_t) -> i32,
) -> hdf5::Result<()> {
    let rank = dataset.ndim();
    if rank != 1 && rank != 2 {
        return Err("the dataset has neither one nor two dimensions".into());
    }
    let (start, count) = ([first as u64, 0], [rows as u64, width as u64]);
    hdf5::sync::sync(|| {
        // SAFETY: every handle is created here and closed below; the selections have the dataset's rank,
        // one or two, the length of `start` and `count`. A handle that could not be made is negative,
        // which the later calls refuse.
        unsafe {
            let list = H5Pcreate(*hdf5::globals::H5P_DATASET_XFER);
            let listed = match who {
                Participants::All => H5Pset_dxpl_mpio(list, H5FD_MPIO_COLLECTIVE),
                Participants::ThisRank => 0,
            };
            let file = H5Dget_space(dataset.id());
            let memory = H5Screate_simple(rank as i32, count.as_ptr(), ptr::null());
            let selected = if rows == 0 {
                H5Sselect_none(file).min(H5Sselect_none(memory))
            } else {
                let set = H5S_seloper_t::H5S_SELECT_SET;
                H5Sselect_hyperslab(file, set, start.as_ptr(), ptr::null(), count.as_ptr(), ptr::null())
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
                None if listed.min(selected) < 0 => Err("the rows cannot be selected".into()),
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
