//! Meshes and one-part models built from arrays.

use pyo3::prelude::*;
use tristrip::Mesh;
use tristrip_io::{Model, Part};

use crate::arrays::{GivenFaces, positions};
use crate::errors::Failure;

/// Reads a mesh without attributes.
pub(crate) fn mesh_of(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> Result<Mesh, Failure> {
    let points = positions("vertices", vertices)?;
    let points = points.as_slice().map_err(PyErr::from)?.as_chunks().0.to_vec();
    Ok(Mesh::new(points, GivenFaces::of("faces", faces)?.to_faces()?)?)
}

/// Returns a model of one mesh.
pub(crate) fn one_part(mesh: Mesh) -> Model {
    Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() }
}
