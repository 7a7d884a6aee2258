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

    /// Takes how a computation is watched: `progress`, `budget` and `on_interrupt`.
    pub(crate) fn watching(&self) -> PyResult<Watching> {
        let on_interrupt: Option<String> = self.extract("on_interrupt")?;
        let (progress, budget) = (self.take("progress")?, self.extract("budget")?);
        let on_interrupt = on_interrupt.as_deref().unwrap_or("raise");
        Ok(Watching::new(self.given.py(), progress, budget, on_interrupt)?)
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
