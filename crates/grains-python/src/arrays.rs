//! Arrays of numpy that show the memory of a simulation, without copying it.
//!
//! An array keeps its [`Lease`] alive. A simulation that is about to change its state looks whether anybody still reads it
//! ([`Leases::release`]); if so, it leaves the memory to the readers and goes on in a copy. So an array is what the state was
//! when the array was made, for as long as it lives.

use grains_simulation::{Loan, Simulation};
use numpy::ndarray::{ArrayView1, ArrayView2, ArrayView3, ShapeBuilder};
use numpy::{Element, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// What arrays hold on to: nothing, while the simulation owns the memory they show, and that memory afterwards.
type Lease = Arc<Mutex<Option<Loan>>>;

/// The base of an array, which numpy keeps alive with it.
#[pyclass(frozen)]
struct Holder(#[allow(dead_code)] Lease);

/// The arrays of the present state.
#[derive(Default)]
pub struct Leases {
    present: Lease,
}

impl Leases {
    /// To be called before the state of a simulation changes or ends.
    pub fn release(&mut self, simulation: &mut Simulation) {
        if Arc::strong_count(&self.present) > 1 {
            let lease = std::mem::take(&mut self.present);
            // A lock that a panic has left is as good: the memory must not go while arrays show it.
            *lease.lock().unwrap_or_else(PoisonError::into_inner) = Some(simulation.give_memory_away());
        }
    }

    fn holder<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(Bound::new(py, Holder(self.present.clone()))?.into_any())
    }

    /// `count` vectors of a field of the structures of a slice, `[count][3]`; `of` finds it in one.
    pub fn vectors<'py, T>(
        &self,
        py: Python<'py>,
        all: &[T],
        count: usize,
        of: impl Fn(&T) -> &f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Some(first) = all.first().filter(|_| count > 0 && count <= all.len()) else {
            return Ok(PyArray2::<f64>::zeros(py, [0, 3], false).into_any());
        };
        let stride = const { whole(size_of::<T>(), size_of::<f64>()) };
        // SAFETY: a vector of three numbers begins at what `of` finds in each of the first `count` structures, whose size is a
        // multiple of that of a number; `holder` keeps the memory, which nobody writes to while it does.
        #[allow(unsafe_code)]
        let array = unsafe {
            let view = ArrayView2::from_shape_ptr((count, 3).strides((stride, 1)), of(first));
            PyArray2::borrow_from_array(&view, self.holder(py)?)
        };
        read_only(array.into_any())
    }

    /// `count` numbers of the structures of a slice; `of` finds that of one.
    pub fn numbers<'py, T, N: Element>(
        &self,
        py: Python<'py>,
        all: &[T],
        count: usize,
        of: impl Fn(&T) -> &N,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Some(first) = all.first().filter(|_| count > 0 && count <= all.len()) else {
            return Ok(PyArray1::<N>::zeros(py, [0], false).into_any());
        };
        let stride = const { whole(size_of::<T>(), size_of::<N>()) };
        // SAFETY: as in `vectors`.
        #[allow(unsafe_code)]
        let array = unsafe {
            let view = ArrayView1::from_shape_ptr((count,).strides((stride,)), of(first));
            PyArray1::borrow_from_array(&view, self.holder(py)?)
        };
        read_only(array.into_any())
    }

    /// The own cells of a field of the fluid, `[nz][ny][nx]`.
    pub fn cells<'py>(
        &self,
        py: Python<'py>,
        data: &[f64],
        layout: grains_fluid::Layout,
    ) -> PyResult<Bound<'py, PyAny>> {
        let [nx, ny, nz] = layout.cells;
        if layout.is_empty() {
            return Ok(PyArray3::<f64>::zeros(py, [nz, ny, nx], false).into_any());
        }
        let [sx, sy, sz] = layout.strides();
        let own = &data[layout.index(0, 0, 0)..];
        // SAFETY: the own cells are within the array; else as in `vectors`.
        #[allow(unsafe_code)]
        let array = unsafe {
            let view = ArrayView3::from_shape_ptr((nz, ny, nx).strides((sz, sy, sx)), own.as_ptr());
            PyArray3::borrow_from_array(&view, self.holder(py)?)
        };
        read_only(array.into_any())
    }
}

/// How often one size goes into another, of which it must be a whole part: else the program does not build.
const fn whole(of: usize, part: usize) -> usize {
    assert!(of.is_multiple_of(part));
    of / part
}

/// An array that cannot be written to.
fn read_only(array: Bound<'_, PyAny>) -> PyResult<Bound<'_, PyAny>> {
    let flags = pyo3::types::PyDict::new(array.py());
    flags.set_item("write", false)?;
    array.call_method("setflags", (), Some(&flags))?;
    Ok(array)
}
