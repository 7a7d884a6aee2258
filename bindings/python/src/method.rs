//! The method of strips and its options, from keyword arguments with the names of the command's flags.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use tristrip::StripifyOptions;

use crate::arguments::Arguments;
use crate::errors::Failure;

/// Joins the options that have arguments of their own with the others.
pub(crate) fn flags<'py>(
    py: Python<'py>,
    others: Option<&Bound<'py, PyDict>>,
    effort: impl IntoPyObject<'py>,
    cost: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let flags = others.map_or_else(|| Ok(PyDict::new(py)), PyDictMethods::copy)?;
    flags.set_item("effort", effort)?;
    flags.set_item("cost", cost)?;
    Ok(flags)
}

/// Reads a method and its options; those that are `None` have the default of the method.
pub(crate) fn options(
    method: &str,
    weld: bool,
    flags: Option<&Bound<'_, PyDict>>,
) -> Result<StripifyOptions, Failure> {
    let mut pairs = vec![("--method".to_owned(), method.to_owned())];
    for (name, value) in flags.into_iter().flat_map(PyDictMethods::iter) {
        let name: String = name.extract()?;
        if !value.is_none() {
            pairs.push((format!("--{}", name.replace('_', "-")), value.str()?.to_string()));
        }
    }
    let pairs: Vec<(&str, &str)> = pairs.iter().map(|(name, value)| (&**name, &**value)).collect();
    Ok(tristrip_pipeline::method_of_flags(&pairs)?.with_weld(weld))
}

/// Takes a method and its options from keyword arguments, all of which that are left belong to the method.
pub(crate) fn taken(arguments: &Arguments<'_>, usual: &str) -> PyResult<StripifyOptions> {
    let name: Option<String> = arguments.extract("method")?;
    let weld = arguments.flag("weld")?;
    Ok(options(name.as_deref().unwrap_or(usual), weld, Some(&arguments.rest()?))?)
}
