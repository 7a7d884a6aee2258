//! Reports as dictionaries with the keys of the command's JSON reports.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

/// A report as a Python dictionary.
pub(crate) type Report<'py> = PyResult<Bound<'py, PyDict>>;

/// Converts a report to a dictionary.
pub(crate) fn report<'py, T: Serialize>(py: Python<'py>, report: &T) -> PyResult<Bound<'py, PyAny>> {
    Ok(pythonize::pythonize(py, report)?)
}
