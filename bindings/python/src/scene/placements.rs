//! Where the nodes of a scene place its parts.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyRange;
use tristrip_io::gltf::Placement;

use super::data::SceneData;
use crate::errors::Failure;

/// The transform of what is not moved.
const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// The numbers of parts, and a matrix.
type Placed<'py> = (Bound<'py, PyRange>, Bound<'py, PyArray2<f64>>);

/// Returns the numbers of the parts in each place, and the transform of the place.
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
<<<<<<< HEAD
        Ok((PyRange::new(py, isize::try_from(parts.start)?, isize::try_from(parts.end)?)?, matrix))
=======
        // There are fewer parts than bytes in memory.
        let [start, end] = [parts.start, parts.end].map(|part| isize::try_from(part).unwrap_or(isize::MAX));
        Ok((PyRange::new(py, start, end)?, matrix))
>>>>>>> py-scene
    });
    arrays.collect()
}
