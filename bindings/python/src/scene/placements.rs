//! Placements of parts by the nodes of a scene.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyRange;
use tristrip_io::gltf::Placement;

use super::data::SceneData;
use crate::errors::Failure;

/// The identity transform.
const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A range of part indices, and a matrix.
type Placed<'py> = (Bound<'py, PyRange>, Bound<'py, PyArray2<f64>>);

/// Returns the part indices and the transform of each placement.
pub(crate) fn placements<'py>(py: Python<'py>, scene: &SceneData) -> PyResult<Vec<Placed<'py>>> {
    let model = scene.model();
    let placed = match &model.scene {
        Some(scene) => scene.placements().map_err(Failure::from)?,
        None if model.parts.is_empty() => Vec::new(),
        None => vec![Placement { parts: 0..model.parts.len(), transform: IDENTITY, node: None }],
    };
    let arrays = placed.into_iter().map(|Placement { parts, transform, .. }| {
        let rows = transform.as_flattened().iter().copied().chain([0.0, 0.0, 0.0, 1.0]);
        let matrix = PyArray1::from_iter(py, rows).reshape([4, 4])?;
        Ok((PyRange::new(py, isize::try_from(parts.start)?, isize::try_from(parts.end)?)?, matrix))
    });
    arrays.collect()
}
