//! PNG images of models and strips.

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use tristrip::Strips;
use tristrip_io::Model;
use tristrip_render::images::{self, MAX_SIZE, Mode, RenderOptions, TexturedModel};

use super::data::SceneData;
use crate::errors::Failure;
use crate::work::Watching;

/// Renders a scene.
pub(crate) fn of_scene<'py>(
    py: Python<'py>,
    scene: &SceneData,
    mode: &str,
    size: (i64, i64),
) -> PyResult<Bound<'py, PyBytes>> {
    let known = Mode::ALL.into_iter().find(|known| known.name() == mode);
    let mode = known
        .ok_or_else(|| Failure::option("mode", format!("{mode:?}"), "textured, normals, uv or shaded"))?;
    let options = RenderOptions::default().with_size(pixels(size.0)?, pixels(size.1)?);
    let drawn = Watching::default().run(py, |_| {
        let model = scene.pictured()?;
        let drawn = TexturedModel::new(&model).and_then(|model| model.picture(mode, &options));
        drawn.map_err(Failure::from)
    });
    Ok(PyBytes::new(py, &drawn?.result()?))
}

/// Renders strips with one colour per strip.
pub(crate) fn of_strips<'py>(
    py: Python<'py>,
    model: &Model,
    strips: &[Strips],
    size: (i64, i64),
) -> PyResult<Bound<'py, PyBytes>> {
    let options = RenderOptions::default().with_size(pixels(size.0)?, pixels(size.1)?);
    let drawn = Watching::default().run(py, |_| {
        let positions = model.parts.iter().map(|part| part.mesh.positions());
        let parts: Vec<_> = positions.zip(strips).collect();
        Ok(images::strips(&parts, &options)?)
    });
    Ok(PyBytes::new(py, &drawn?.result()?))
}

/// Renders two models from eight sides, the first in the upper row.
pub(crate) fn before_and_after<'py>(
    py: Python<'py>,
    scenes: [&SceneData; 2],
    size: i64,
) -> PyResult<Bound<'py, PyBytes>> {
    let size = pixels(size)?;
    let drawn = Watching::default().run(py, |_| {
        let [before, after] = [scenes[0].pictured()?, scenes[1].pictured()?];
        let before = TexturedModel::new(&before)?;
        let after = TexturedModel::new(&after)?;
        Ok(images::rows_of_sides(&[&before, &after], Mode::Textured, size)?)
    });
    Ok(PyBytes::new(py, &drawn?.result()?))
}

/// Checks a size.
fn pixels(size: i64) -> Result<u32, Failure> {
    let known = u32::try_from(size).ok().filter(|size| (1..=MAX_SIZE).contains(size));
    known.ok_or_else(|| Failure::option("size", size, "1 to 8192 pixels"))
}
