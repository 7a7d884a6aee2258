//! Reports as dictionaries whose keys are those of the command's JSON.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

/// A report as a dictionary.
pub(crate) type Report<'py> = PyResult<Bound<'py, PyDict>>;

/// Converts a report.
pub(crate) fn report<'py, T: Serialize>(py: Python<'py>, report: &T) -> PyResult<Bound<'py, PyAny>> {
    Ok(pythonize::pythonize(py, report)?)
}
