//! The rows of tables of levels; the keys are those of the JSON report of `tristrip-lab levels`.

use serde::{Serialize, Serializer};
use tristrip_pipeline::levels::DisplayFilter;

/// The name of the mesh drawn as single triangles, beside the names of the filters.
pub const SINGLE_TRIANGLES: &str = "triangles";

/// A level, and the vertices that each filter sends for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelRow {
    /// The level, from 0 for the base mesh.
    pub level: usize,
    /// Undone collapses, in percent of all collapses.
    pub percent: f64,
    /// Triangles of the level.
    pub triangles: usize,
    /// Vertices sent by filter.
    pub vertices_sent: VerticesSent,
    /// The refinement from the previous row to this one.
    pub refinement: Refinement,
}

/// The vertex splits from one level to another, and what they write.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Refinement {
    /// Vertex splits.
    pub splits: usize,
    /// Index-map slots written per split if collapses write the kept vertex.
    pub updates_naive: f64,
    /// Index-map slots written per split if collapses write symbols that refer to a nearby slot.
    pub updates_encoded: f64,
    /// Bytes of the refinement of the mesh as single triangles.
    pub bytes_triangles: usize,
    /// Bytes of the refinement of the naive index map.
    pub bytes_naive: usize,
    /// Bytes of the refinement of the encoded index map.
    pub bytes_encoded: usize,
}

/// Vertices sent as single triangles, and by each filter, in the order of [`DisplayFilter::ALL`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VerticesSent {
    /// As single triangles.
    pub triangles: usize,
    /// By each filter.
    pub by_filter: Vec<usize>,
}

impl VerticesSent {
    /// Iterates over the names of the filters and the vertices that they send.
    pub fn filters(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let names = DisplayFilter::ALL.iter().map(|filter| filter.name());
        names.zip(self.by_filter.iter().copied())
    }
}

/// Serializes as an object of names and counts.
impl Serialize for VerticesSent {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let single = std::iter::once((SINGLE_TRIANGLES, self.triangles));
        serializer.collect_map(single.chain(self.filters()))
    }
}

/// The vertices that a filter sends for all levels of a model together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilterTotal {
    /// The name of the filter, or [`SINGLE_TRIANGLES`].
    pub filter: String,
    /// Vertices sent for all levels.
    pub vertices_sent: u64,
    /// The same per triangle.
    pub vertices_per_triangle: f64,
    /// In percent of the vertices sent as single triangles.
    pub percent: f64,
}
