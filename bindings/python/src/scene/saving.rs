//! Scenes as files and bytes without new strips, as the command `convert` writes them.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use tristrip_pipeline::{ConvertOptions, Encoded, Observer, strips_as_stored};

use super::data::SceneData;
use super::output::{Destination, Noting, file_report};
use crate::errors::Failure;
use crate::work::Watching;

/// Writes a file, and reports on it.
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
        let noting = Noting::new(watcher);
        let converted = converted(scene, &destination, verify, &noting);
        let converted = converted.map_err(|failure| destination.unproven(failure))?;
        let written = destination.write(&converted.encoded)?;
        let notes = scene.image_notes(&destination.target).into_iter();
        let notes = notes.chain(noting.into_notes(converted.encoded.losses.iter().cloned())).collect();
        Ok((converted, written, notes))
    });
    let (converted, written, notes) = saved?.result()?;
    let found = file_report(py, &destination, &converted.encoded, &written, notes)?;
    let meshes = tristrip_pipeline::meshes(scene.as_read());
    let faces: usize = meshes.iter().map(|mesh| mesh.faces().face_count()).sum();
    let triangles: usize = meshes.iter().map(|mesh| mesh.faces().triangle_count()).sum();
    found.set_item("faces", faces)?;
    found.set_item("triangles", triangles)?;
    found.set_item("strips", converted.strips)?;
    found.set_item("parts", meshes.len())?;
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

/// A converted scene.
struct Converted {
    encoded: Encoded,
    /// The number of strips, if any part is drawn as strips.
    strips: Option<usize>,
}

/// Converts a scene for a destination.
fn converted(
    scene: &SceneData,
    destination: &Destination<'_>,
    verify: bool,
    observer: &dyn Observer,
) -> Result<Converted, Failure> {
    let mut options = ConvertOptions::new(destination.target.format).with_verify(verify);
    if destination.is_chosen {
        options = options.with_layout(destination.layout);
    }
    let model = scene.model_for(&destination.target);
    let strips = strips_as_stored(&model, &options, observer)?;
    let encoded = options.encode(&model, &strips, observer)?;
    let count = strips.iter().flatten().map(tristrip::Strips::len).sum();
    Ok(Converted { encoded, strips: strips.iter().any(Option::is_some).then_some(count) })
}
