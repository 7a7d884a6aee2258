//! What a packed model is reported as.

use serde::Serialize;

use super::Packed;
use crate::metrics::rounded;

/// The counts of a packed model; the keys are those of the JSON report of `tristrip pack`. All are `None` before it is packed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct PackedReport {
    /// The meshes of the stream.
    pub meshes: Option<usize>,
    /// The chunks of the stream; `None` for the format of paper 001.
    pub chunks: Option<usize>,
    /// The vertices that the full meshes use.
    pub vertices: Option<usize>,
    /// The triangles of all full meshes.
    pub triangles: Option<usize>,
    /// The triangles that are drawn before the first chunk or record.
    pub base_triangles: Option<usize>,
    /// The size of the file.
    pub bytes: Option<usize>,
    /// The bytes before the first chunk or record.
    pub base_bytes: Option<usize>,
    /// The bits of the file per vertex; `None` where there are no vertices.
    pub bits_per_vertex: Option<f64>,
    /// How far a position may be from that of the input; `None` for the format of paper 001.
    pub position_error: Option<f64>,
}

impl Packed {
    /// Returns the counts for a report.
    pub fn report(&self) -> PackedReport {
        PackedReport {
            meshes: Some(self.meshes),
            chunks: Some(self.chunks),
            vertices: Some(self.vertices),
            triangles: Some(self.triangles),
            base_triangles: Some(self.base_triangles),
            bytes: Some(self.bytes.len()),
            base_bytes: Some(self.chunk_start),
            bits_per_vertex: bits_per_vertex(self.bytes.len(), self.vertices),
            position_error: Some(self.position_error),
        }
    }
}

/// Returns the bits per vertex of a file; `None` where there are no vertices.
fn bits_per_vertex(bytes: usize, vertices: usize) -> Option<f64> {
    (vertices > 0).then(|| rounded(8.0 * bytes as f64 / vertices as f64))
}
