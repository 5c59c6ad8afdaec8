//! Collective transfer of rows of a dataset: the part of HDF5 that the safe binding leaves out.

#![allow(unsafe_code)] // raw calls, each group under the library's lock

use hdf5::{Dataset, Datatype, H5Type};
use hdf5_sys::h5d::{H5Dget_space, H5Dread, H5Dwrite};
use hdf5_sys::h5i::hid_t;
use hdf5_sys::h5p::H5FD_mpio_xfer_t::H5FD_MPIO_COLLECTIVE;
use hdf5_sys::h5p::{H5Pclose, H5Pcreate, H5Pset_dxpl_mpio};
use hdf5_sys::h5s::{H5S_seloper_t, H5Sclose, H5Screate_simple, H5Sselect_hyperslab, H5Sselect_none};
use std::ptr;

/// Writes rows `first..first + rows` of a dataset of `width` values per row; all ranks take part.
///
/// # Errors
/// What HDF5 says.
pub fn write_rows<T: H5Type>(dataset: &Dataset, first: usize, width: usize, data: &[T]) -> hdf5::Result<()> {
    let kind = Datatype::from_type::<T>()?;
    transfer(dataset, first, width, data.len() / width.max(1), |memory, file, list| {
        // SAFETY: the memory space describes exactly `data`, which outlives the call.
        unsafe { H5Dwrite(dataset.id(), kind.id(), memory, file, list, data.as_ptr().cast()) }
    })
}

/// Reads rows `first..` of a dataset into `data`; all ranks take part.
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
    transfer(dataset, first, width, rows, |memory, file, list| {
        // SAFETY: the memory space describes exactly `data`, borrowed mutably for the call.
        unsafe { H5Dread(dataset.id(), kind.id(), memory, file, list, data.as_mut_ptr().cast()) }
    })
}

fn transfer(
    dataset: &Dataset,
    first: usize,
    width: usize,
    rows: usize,
    call: impl FnOnce(hid_t, hid_t, hid_t) -> i32,
) -> hdf5::Result<()> {
    let rank = dataset.ndim();
    let (start, count) = ([first as u64, 0], [rows as u64, width as u64]);
    let status = hdf5::sync::sync(|| {
        // SAFETY: every handle is created here and closed below; selections have the dataset's rank,
        // which is one or two.
        unsafe {
            let list = H5Pcreate(*hdf5::globals::H5P_DATASET_XFER);
            H5Pset_dxpl_mpio(list, H5FD_MPIO_COLLECTIVE);
            let file = H5Dget_space(dataset.id());
            let memory = H5Screate_simple(rank as i32, count.as_ptr(), ptr::null());
            if rows == 0 {
                H5Sselect_none(file);
                H5Sselect_none(memory);
            } else {
                let set = H5S_seloper_t::H5S_SELECT_SET;
                H5Sselect_hyperslab(file, set, start.as_ptr(), ptr::null(), count.as_ptr(), ptr::null());
            }
            let status = call(memory, file, list);
            H5Sclose(memory);
            H5Sclose(file);
            H5Pclose(list);
            status
        }
    });
    if status < 0 {
        return Err(hdf5::Error::query().unwrap_or_else(|_| "a transfer failed".into()));
    }
    Ok(())
}
