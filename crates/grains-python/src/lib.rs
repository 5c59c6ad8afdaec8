//! The compiled part of the Python package `grains`: cases, simulations and analyses. `python/grains` gives them their Python form.

mod analyses;
mod arrays;
mod case;
mod job;
mod messages;
mod simulation;

use grains_simulation::{ErrorKind, RunError};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

pyo3::create_exception!(
    grains,
    CaseError,
    PyValueError,
    "A case that is wrong: the key, its value and the remedy."
);
pyo3::create_exception!(grains, UnphysicalError, PyRuntimeError, "A state that can no longer be trusted.");
pyo3::create_exception!(grains, FilesError, PyOSError, "A file that cannot be read or written.");

/// An error of a run as one of Python.
fn raised(error: RunError) -> PyErr {
    let RunError { kind, message } = error;
    let message = match message.is_empty() {
        true => "another rank has met an error; its message is there".to_string(),
        false => message,
    };
    match kind {
        ErrorKind::Case => CaseError::new_err(message),
        ErrorKind::Unphysical => UnphysicalError::new_err(message),
        ErrorKind::Files => FilesError::new_err(message),
    }
}

#[pymodule]
fn _grains(module: &Bound<'_, PyModule>) -> PyResult<()> {
    messages::install();
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("CaseError", py.get_type::<CaseError>())?;
    module.add("UnphysicalError", py.get_type::<UnphysicalError>())?;
    module.add("FilesError", py.get_type::<FilesError>())?;
    module.add_class::<case::Case>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_function(wrap_pyfunction!(job::join, module)?)?;
    module.add_function(wrap_pyfunction!(job::finish, module)?)?;
    module.add_function(wrap_pyfunction!(case::toml_of_json, module)?)?;
    module.add_function(wrap_pyfunction!(case::json_of_toml, module)?)?;
    module.add_function(wrap_pyfunction!(case::schema, module)?)?;
    module.add_function(wrap_pyfunction!(analyses::analyse, module)?)
}
