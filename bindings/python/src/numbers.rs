//! Integer arguments with errors that report what was found and what was expected.

use pyo3::prelude::*;

use crate::errors::Failure;

/// A count: an integer of at least 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Count(pub(crate) usize);

impl<'py> FromPyObject<'_, 'py> for Count {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        // Accepts NumPy integers; rejects floats and strings.
        let index = given.call_method0("__index__");
        match index.and_then(|index| index.extract::<usize>()) {
            Ok(count) => Ok(Self(count)),
            Err(_) => {
                Err(Failure::Parameter(format!("found {}, expected a count of 0 or more", given.repr()?))
                    .into())
            }
        }
    }
}
