//! Numbers as arguments, whose errors name what was found and what was expected.

use pyo3::prelude::*;

use crate::errors::Failure;

/// A count: an integer of 0 or more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Count(pub(crate) usize);

impl<'py> FromPyObject<'_, 'py> for Count {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        // Integers of NumPy are accepted, numbers with a fraction and texts are not.
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
