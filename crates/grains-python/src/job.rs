//! The MPI job of a Python process: one of its own, or that of mpi4py.

use crate::raised;
use grains_simulation::{Job, join as join_mpi, start};
use pyo3::prelude::*;
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

thread_local! {
    /// Jobs by the address of their communicator; that of no address is the one this process has started.
    static JOBS: RefCell<HashMap<usize, Rc<Job>>> = RefCell::default();
}

/// The job of a communicator, or that of this process by itself, begun if need be.
pub fn job(communicator: usize) -> PyResult<Rc<Job>> {
    JOBS.with_borrow_mut(|jobs| {
        if let Some(job) = jobs.get(&communicator) {
            return Ok(job.clone());
        }
        let job = Rc::new(match communicator {
            0 => start().map_err(raised)?,
            // SAFETY: `join` is told so by mpi4py, which keeps communicators until MPI ends.
            #[allow(unsafe_code)]
            address => unsafe { join_mpi(address) },
        });
        jobs.insert(communicator, job.clone());
        Ok(job)
    })
}

/// The rank of this process and their number, in the job of the communicator at an address, or of this process if that is 0.
#[pyfunction]
pub fn join(communicator: usize) -> PyResult<(usize, usize)> {
    use grains_domain::Transport;
    let job = job(communicator)?;
    Ok((job.transport().rank(), job.size()))
}

/// Ends what MPI this process has started; simulations must be gone.
#[pyfunction]
pub fn finish() {
    JOBS.with_borrow_mut(HashMap::clear);
}
