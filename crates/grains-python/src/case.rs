//! Cases, their schema and what they will cost.

use crate::{CaseError, raised};
use grains_simulation::check;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::Path;

/// A case that was read and is right.
#[pyclass(frozen, module = "grains._grains")]
pub struct Case {
    pub case: grains_case::Case,
}

#[pymethods]
impl Case {
    /// The case of a text in TOML; `name` is what messages call it, files are relative to `folder`.
    #[staticmethod]
    fn parse(text: &str, name: &str, folder: &str) -> PyResult<Self> {
        let case = grains_case::Case::parse(text, name, Path::new(folder));
        case.map(|case| Self { case }).map_err(|e| CaseError::new_err(e.to_string()))
    }

    /// The case with every default spelt out, as TOML.
    fn to_toml(&self) -> String {
        self.case.to_toml()
    }

    /// Values that are allowed but unlikely.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.case.warnings.iter().map(ToString::to_string).collect()
    }

    /// What it will be and cost on a number of ranks.
    fn check<'py>(&self, py: Python<'py>, ranks: usize) -> PyResult<Bound<'py, PyDict>> {
        let report = check::report(&self.case, ranks).map_err(raised)?;
        let found = PyDict::new(py);
        found.set_item("ranks", report.ranks)?;
        found.set_item("subdomains", report.subdomains)?;
        found.set_item("memory", report.cost.memory)?;
        found.set_item("disk", report.cost.disk)?;
        let warnings = self.case.warnings.iter().map(ToString::to_string).chain(report.warnings);
        found.set_item("warnings", warnings.collect::<Vec<_>>())?;
        if let Some(particles) = &report.particles {
            found.set_item("particles", particles.count)?;
            found.set_item("mass", particles.mass)?;
            found.set_item("time_step", particles.step.dt)?;
            found.set_item("recommended_time_step", particles.step.recommended)?;
            found.set_item("time_step_reason", particles.step.reason.to_string())?;
            found.set_item("steps", particles.steps)?;
            found.set_item("seconds", particles.seconds)?;
            found.set_item("max_overlap", particles.max_overlap)?;
        }
        Ok(found)
    }
}

/// JSON, as Python writes it, as TOML.
#[pyfunction]
pub fn toml_of_json(json: &str) -> PyResult<String> {
    let value: toml::Value = serde_json::from_str(json).map_err(|e| CaseError::new_err(e.to_string()))?;
    toml::to_string(&value).map_err(|e| CaseError::new_err(e.to_string()))
}

/// TOML as JSON, which Python reads.
#[pyfunction]
pub fn json_of_toml(text: &str) -> PyResult<String> {
    let value: toml::Value = toml::from_str(text).map_err(|e| CaseError::new_err(e.to_string()))?;
    serde_json::to_string(&value).map_err(|e| CaseError::new_err(e.to_string()))
}

/// The JSON schema of case files.
#[pyfunction]
pub fn schema() -> String {
    format!("{:#}", grains_case::schema())
}
