//! Index maps: the vertices of all strips one after the other, with [`RESTART`] between strips, as a restart index buffer has them.

use crate::error::{Error, MeshProblem};
use crate::strip::Strips;

/// Separates strips in an index map; no vertex has this number.
pub const RESTART: u32 = u32::MAX;

/// Checks that all vertices of strips are below a number.
pub fn check_strips(strips: &Strips, vertex_count: usize) -> Result<(), Error> {
    for (face, strip) in strips.iter().enumerate() {
        if let Some(corner) = strip.iter().position(|&v| v as usize >= vertex_count) {
            let (found, vertex_count) = (strip[corner], vertex_count as u32);
            let (face, corner) = (face as u32, corner as u32);
            return Err(MeshProblem::VertexIndex { face, corner, found, vertex_count }.into());
        }
    }
    Ok(())
}
