//! Conversion of errors to Python exceptions. The classes are defined in `tristrip._errors`, which
//! allows several base classes and pickling.

use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An error of this crate or of a crate it uses.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An invalid option.
    Parameter(String),
    /// Arrays that do not form a mesh.
    Mesh(String),
    /// An unsupported type of an array or item.
    Type(String),
    /// An error of the crate `tristrip`.
    Core(tristrip::Error),
    /// A read or write error.
    File(tristrip_io::Error),
    /// The verification of a result failed.
    Unproven(String),
    /// A panic: a bug, or an array was modified while it was in use.
    Panic(String),
    /// An exception of a callback or signal handler.
    Python(PyErr),
}

impl Failure {
    /// Describes an option with an invalid value.
    pub(crate) fn option(name: &str, found: impl std::fmt::Display, expected: &str) -> Self {
        Self::Parameter(format!("{name}: found {found}, expected {expected}"))
    }

    /// Describes an array with invalid values or an invalid shape.
    pub(crate) fn mesh(name: &str, found: impl std::fmt::Display, expected: &str) -> Self {
        Self::Mesh(format!("{name}: found {found}, expected {expected}"))
    }
}

impl From<tristrip::Error> for Failure {
    fn from(error: tristrip::Error) -> Self {
        Self::Core(error)
    }
}

impl From<tristrip_io::Error> for Failure {
    fn from(error: tristrip_io::Error) -> Self {
        match error {
            tristrip_io::Error::Mesh(error) => Self::Core(error),
            error => Self::File(error),
        }
    }
}

impl From<tristrip_pipeline::Error> for Failure {
    fn from(error: tristrip_pipeline::Error) -> Self {
        use tristrip_pipeline::Error;
        match error {
            Error::Input(error) => error.into(),
            Error::Format(error) => error.into(),
            Error::Unproven { why, .. } => Self::Unproven(why),
            other => Self::Parameter(other.to_string()),
        }
    }
}

impl From<tristrip_render::Error> for Failure {
    fn from(error: tristrip_render::Error) -> Self {
        match error {
            tristrip_render::Error::Pipeline(error) => error.into(),
            other => Self::Parameter(other.to_string()),
        }
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| match failure {
            Failure::Python(error) => error,
            Failure::Parameter(text) => raise(py, "ParameterError", &text),
            Failure::Mesh(text) => raise(py, "MeshError", &text),
            Failure::Type(text) => raise(py, "ArrayTypeError", &text),
            Failure::Unproven(text) => raise(py, "NotProvenError", &text),
            Failure::Panic(text) => raise(py, "InternalError", &text),
            Failure::Core(error) => of_core(py, &error),
            Failure::File(error) => of_file(py, error),
        })
    }
}

fn of_core(py: Python<'_>, error: &tristrip::Error) -> PyErr {
    use tristrip::Error;
    match error {
        Error::Parameter { name: "flag", found, .. } => {
            let name = found.trim_start_matches('-').replace('-', "_");
            raise(py, "ParameterError", &format!("{name}: not an option of this method"))
        }
        Error::Parameter { name, found, expected } => {
            let name = name.trim_start_matches('-').replace('-', "_");
            raise(py, "ParameterError", &format!("{name}: found {found}, expected {expected}"))
        }
        Error::Format { .. } => raise(py, "FormatError", &error.to_string()),
        Error::LimitExceeded { .. } => raise(py, "LimitError", &error.to_string()),
        _ => raise(py, "MeshError", &error.to_string()),
    }
}

fn of_file(py: Python<'_>, error: tristrip_io::Error) -> PyErr {
    use tristrip_io::Error;
    match error {
        Error::Io { path, source } => raise_file(py, &path, &source),
        Error::Format { .. } => raise(py, "FormatError", &error.to_string()),
        Error::LimitExceeded { .. } => raise(py, "LimitError", &error.to_string()),
        Error::Mesh(error) => of_core(py, &error),
        other => raise(py, "ParameterError", &other.to_string()),
    }
}

/// Builds an `OSError` with errno, message and file name.
pub(crate) fn raise_file(py: Python<'_>, path: &str, source: &std::io::Error) -> PyErr {
    let Some(number) = system_number(py, source) else {
        return raise(py, "FileError", &format!("{path}: {source}"));
    };
    let has_text = source.get_ref().is_some();
    let text = match py.import("os").and_then(|os| os.call_method1("strerror", (number,))) {
        Ok(text) if !has_text => text.to_string(),
        _ => source.to_string(),
    };
    match class(py, "FileError").and_then(|class| class.call1((number, text, path))) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Returns the errno of a system error, derived from its kind if it has none.
fn system_number(py: Python<'_>, source: &std::io::Error) -> Option<i32> {
    use std::io::ErrorKind;
    let name = match (source.raw_os_error(), source.kind()) {
        (Some(number), _) => return Some(number),
        (None, ErrorKind::NotFound) => "ENOENT",
        (None, ErrorKind::PermissionDenied) => "EACCES",
        (None, ErrorKind::IsADirectory) => "EISDIR",
        (None, ErrorKind::NotADirectory) => "ENOTDIR",
        (None, ErrorKind::ReadOnlyFilesystem) => "EROFS",
        (None, ErrorKind::StorageFull) => "ENOSPC",
        _ => return None,
    };
    py.import("errno").and_then(|errno| errno.getattr(name)?.extract()).ok()
}

/// Builds an exception of `tristrip._errors`.
pub(crate) fn raise(py: Python<'_>, name: &str, text: &str) -> PyErr {
    match class(py, name).and_then(|class| class.call1((text,))) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("tristrip._errors")?.getattr(name)
}

/// Attaches the best result so far. Turns `KeyboardInterrupt` into `tristrip.Interrupted`; other
/// exceptions get the attribute `best`.
pub(crate) fn with_best(py: Python<'_>, error: PyErr, best: Py<PyAny>) -> PyErr {
    if error.get_type(py).is(py.get_type::<pyo3::exceptions::PyKeyboardInterrupt>()) {
        let arguments = PyDict::new(py);
        let built = arguments
            .set_item("best", best)
            .and_then(|()| class(py, "Interrupted"))
            .and_then(|class| class.call((), Some(&arguments)));
        return match built {
            Ok(exception) => PyErr::from_value(exception),
            Err(error) => error,
        };
    }
    // Exceptions without a `__dict__` cannot have the attribute.
    let _ = error.value(py).setattr("best", best);
    error
}
