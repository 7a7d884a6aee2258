//! The parts of a model, with their prepared faces and dual graphs. They are processed in parallel
//! and returned in order.

use rayon::prelude::*;
use tristrip::{DualGraph, Mesh, PreparedFaces, Strips};
use tristrip_io::Model;

use crate::error::Error;

/// Calls `work` for each item in parallel. Results are in the order of the items.
pub(crate) fn map<'a, T: Sync, R: Send>(items: &'a [T], work: impl Fn(&'a T) -> R + Sync + Send) -> Vec<R> {
    items.par_iter().map(work).collect()
}

/// Returns the meshes of a model's parts, in order.
///
/// ```
/// let model = tristrip_io::read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", tristrip_io::Format::Obj)?;
/// assert_eq!(tristrip_pipeline::meshes(&model).len(), 1);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn meshes(model: &Model) -> Vec<&Mesh> {
    model.parts.iter().map(|part| &part.mesh).collect()
}

/// A part with its prepared faces and its dual graph.
#[derive(Debug)]
#[non_exhaustive]
pub struct PreparedPart<'a> {
    /// The mesh as it was read.
    pub mesh: &'a Mesh,
    /// The prepared faces. Degenerate faces are removed, concave polygons are triangulated, and
    /// vertices are welded if requested.
    pub surface: PreparedFaces<'a>,
    /// The dual graph of the prepared faces.
    pub graph: DualGraph,
}

/// Checks that strips refer only to vertices of their parts. Each item has the strips of a part and
/// its number of vertices.
pub(crate) fn check_vertices(parts: &[(&Strips, usize)]) -> Result<(), Error> {
    for (number, (strips, vertex_count)) in parts.iter().enumerate() {
        if let Some(found) = strips.vertices().iter().find(|&&vertex| vertex as usize >= *vertex_count) {
            let expected = format!("less than {vertex_count}");
            return Err(Error::unproven(format!("part {number}: found vertex {found}, expected {expected}")));
        }
    }
    Ok(())
}
