//! Keyword arguments of functions that have many: each is taken once, and those that are left are unknown.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyDictMethods};

use crate::work::Watching;

/// The keyword arguments of a call.
pub(crate) type Keywords<'a, 'py> = &'a Bound<'py, PyDict>;

/// Keyword arguments.
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

    /// Takes an argument; one that is `None` counts as missing.
    pub(crate) fn take(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(found) = self.given.get_item(name)? else { return Ok(None) };
        self.given.del_item(name)?;
        Ok((!found.is_none()).then_some(found))
    }

    /// Takes an argument of a type.
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

    /// Takes a flag that is false unless it is set.
    pub(crate) fn flag(&self, name: &str) -> PyResult<bool> {
        Ok(self.extract(name)?.unwrap_or(false))
    }

    /// Takes how a computation is watched that has no result before its end: `progress`.
    pub(crate) fn watching(&self) -> PyResult<Watching> {
        self.watched(None, None)
    }

    /// Likewise where searches are a part of it: also their `budget`.
    pub(crate) fn watching_searches(&self) -> PyResult<Watching> {
        self.watched(self.extract("budget")?, None)
    }

    /// Takes how a computation is watched whose result so far is kept: `progress`, and what Ctrl-C does, `on_interrupt`.
    pub(crate) fn interruptible(&self) -> PyResult<Watching> {
        Ok(self.watched(None, self.extract("on_interrupt")?)?.keeping_best())
    }

    /// Likewise for a search: also its `budget`.
    pub(crate) fn interruptible_search(&self) -> PyResult<Watching> {
        Ok(self.watched(self.extract("budget")?, self.extract("on_interrupt")?)?.keeping_best())
    }

    fn watched(&self, budget: Option<f64>, on_interrupt: Option<String>) -> PyResult<Watching> {
        let on_interrupt = on_interrupt.as_deref().unwrap_or("raise");
        Ok(Watching::new(self.py(), self.take("progress")?, budget, on_interrupt)?)
    }

    /// Returns the arguments that are left.
    pub(crate) fn rest(&self) -> PyResult<Bound<'py, PyDict>> {
        self.given.copy()
    }

    /// Checks that no argument is left.
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
