//! Writes scenes without building strips, as the command `convert` does.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use tristrip_pipeline::{Observer, convert};

use super::data::SceneData;
use super::output::{Destination, file_report};
use crate::errors::Failure;
use crate::work::Watching;

/// Writes a file and returns its report.
pub(crate) fn save<'py>(
    py: Python<'py>,
    scene: &SceneData,
    path: &Path,
    format: Option<&str>,
    layout: Option<&str>,
    verify: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let destination = Destination::file(path, format, layout)?;
    let saved = Watching::default().run(py, |watcher| {
        let converted = converted(scene, &destination, verify, watcher);
        let converted = converted.map_err(|failure| destination.unproven(failure))?;
        let written = destination.write(&converted.encoded)?;
        Ok((converted, written, scene.image_notes(&destination.target)))
    });
    let (converted, written, notes) = saved?.result()?;
    let found = file_report(py, &destination, &converted.encoded, &written, notes)?;
    found.set_item("faces", converted.faces)?;
    found.set_item("triangles", converted.triangles)?;
    found.set_item("strips", converted.strips)?;
    found.set_item("parts", converted.parts)?;
    if converted.strips.is_none() {
        found.set_item("layout", py.None())?;
    }
    Ok(found)
}

/// Returns the bytes of a file.
pub(crate) fn to_bytes<'py>(
    py: Python<'py>,
    scene: &SceneData,
    format: &str,
    layout: Option<&str>,
    verify: bool,
) -> PyResult<Bound<'py, PyBytes>> {
    let destination = Destination::memory(format, layout)?;
    let converted = Watching::default().run(py, |watcher| converted(scene, &destination, verify, watcher));
    Ok(PyBytes::new(py, &converted?.result()?.encoded.bytes))
}

/// Converts a scene for a destination.
fn converted(
    scene: &SceneData,
    destination: &Destination<'_>,
    verify: bool,
    observer: &dyn Observer,
) -> Result<convert::Outcome, Failure> {
    let mut options = convert::Options::new(destination.target.format).with_verify(verify);
    if destination.is_chosen {
        options = options.with_layout(destination.layout);
    }
    let model = scene.model_for(&destination.target);
    Ok(convert::run(&model, &options, observer)?)
}
