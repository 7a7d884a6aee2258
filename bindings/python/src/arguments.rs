//! Keyword arguments of functions that have many. Each is taken once; any left over is unknown.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyDictMethods};

use crate::work::Watching;

/// The keyword arguments of a call, as PyO3 passes them.
pub(crate) type Keywords<'a, 'py> = &'a Bound<'py, PyDict>;

/// The keyword arguments that have not been taken yet.
pub(crate) struct Arguments<'py> {
    given: Bound<'py, PyDict>,
}

impl<'py> Arguments<'py> {
    /// Copies the arguments of a call.
    pub(crate) fn of(py: Python<'py>, given: Option<Keywords<'_, 'py>>) -> PyResult<Self> {
        let given = given.map_or_else(|| Ok(PyDict::new(py)), PyDictMethods::copy)?;
        Ok(Self { given })
    }

    pub(crate) fn py(&self) -> Python<'py> {
        self.given.py()
    }

    /// Takes an argument; `None` counts as missing.
    pub(crate) fn take(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(found) = self.given.get_item(name)? else { return Ok(None) };
        self.given.del_item(name)?;
        Ok((!found.is_none()).then_some(found))
    }

    /// Takes an argument and converts it to `T`.
    pub(crate) fn extract<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str) -> PyResult<Option<T>> {
        let Some(found) = self.take(name)? else { return Ok(None) };
        match found.extract::<T>() {
            Ok(value) => Ok(Some(value)),
            Err(error) => {
                let error: PyErr = error.into();
                Err(PyErr::from_type(
                    error.get_type(self.given.py()),
                    format!("argument '{name}': {}", error.value(self.given.py())),
                ))
            }
        }
    }

    /// Takes a flag that defaults to false.
    pub(crate) fn flag(&self, name: &str) -> PyResult<bool> {
        Ok(self.extract(name)?.unwrap_or(false))
    }

    /// Takes `progress`, for a computation without an intermediate result.
    pub(crate) fn watching(&self) -> PyResult<Watching> {
        self.watched(None, None)
    }

    /// Takes `progress` and `budget`, for a computation that contains searches.
    pub(crate) fn watching_searches(&self) -> PyResult<Watching> {
        self.watched(self.extract("budget")?, None)
    }

    /// Takes `progress` and `on_interrupt`, for a computation with an intermediate result.
    pub(crate) fn interruptible(&self) -> PyResult<Watching> {
        Ok(self.watched(None, self.extract("on_interrupt")?)?.keeping_best())
    }

    /// Takes `progress`, `on_interrupt` and `budget`, for a search.
    pub(crate) fn interruptible_search(&self) -> PyResult<Watching> {
        Ok(self.watched(self.extract("budget")?, self.extract("on_interrupt")?)?.keeping_best())
    }

    fn watched(&self, budget: Option<f64>, on_interrupt: Option<String>) -> PyResult<Watching> {
        let on_interrupt = on_interrupt.as_deref().unwrap_or("raise");
        Ok(Watching::new(self.py(), self.take("progress")?, budget, on_interrupt)?)
    }

    /// Returns the arguments that have not been taken.
    pub(crate) fn rest(&self) -> PyResult<Bound<'py, PyDict>> {
        self.given.copy()
    }

    /// Checks that every argument was taken.
    pub(crate) fn finish(&self, function: &str) -> PyResult<()> {
        match self.given.keys().get_item(0) {
            Err(_) => Ok(()),
            Ok(name) => {
                let name = name.repr()?;
                Err(PyTypeError::new_err(format!("{function}() got an unexpected keyword argument {name}")))
            }
        }
    }
}
