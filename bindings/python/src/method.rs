//! Parses a strip method and its options, from a method text as in the command and from keyword
//! arguments.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use tristrip::StripifyOptions;
use tristrip_pipeline::{parse_method, with_method_parameter};

use crate::arguments::Arguments;
use crate::errors::Failure;

/// Combines the parameters that have their own arguments with the others.
pub(crate) fn parameters<'py>(
    py: Python<'py>,
    others: Option<&Bound<'py, PyDict>>,
    effort: impl IntoPyObject<'py>,
    cost: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let parameters = others.map_or_else(|| Ok(PyDict::new(py)), PyDictMethods::copy)?;
    parameters.set_item("effort", effort)?;
    parameters.set_item("cost", cost)?;
    Ok(parameters)
}

/// Parses a method such as `best` or `stripe-global:patches=full`, and its parameters. Parameters
/// that are `None` have the default of the method.
pub(crate) fn options(
    method: &str,
    weld: bool,
    parameters: Option<&Bound<'_, PyDict>>,
) -> Result<StripifyOptions, Failure> {
    let mut options = parse_method(method)?.with_weld(weld);
    for (name, value) in parameters.into_iter().flat_map(PyDictMethods::iter) {
        if !value.is_none() {
            options = with_method_parameter(options, &name.extract::<String>()?, value.str()?.to_str()?)?;
        }
    }
    Ok(options)
}

/// Takes a method and its options from keyword arguments. All remaining arguments belong to the
/// method.
pub(crate) fn taken(arguments: &Arguments<'_>, usual: &str) -> PyResult<StripifyOptions> {
    let name: Option<String> = arguments.extract("method")?;
    let weld = arguments.flag("weld")?;
    Ok(options(name.as_deref().unwrap_or(usual), weld, Some(&arguments.rest()?))?)
}
