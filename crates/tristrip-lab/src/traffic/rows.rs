//! The rows of tables of levels; the keys are those of the JSON report of `tristrip-lab levels`.

use serde::{Serialize, Serializer};
use tristrip_pipeline::levels::DisplayFilter;

/// The name of the mesh drawn as single triangles, used like the name of a filter.
pub const SINGLE_TRIANGLES: &str = "triangles";

/// A level, and the vertices that each filter sends for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelRow {
    /// The level, from 0 for the base mesh.
    pub level: usize,
    /// The undone collapses, in percent of all collapses.
    pub percent: f64,
    /// The number of triangles of the level.
    pub triangles: usize,
    /// The number of vertices sent, by filter.
    pub vertices_sent: VerticesSent,
    /// The refinement from the previous row to this one.
    pub refinement: Refinement,
}

/// The vertex splits from one level to another, and their writes.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Refinement {
    /// The number of vertex splits.
    pub splits: usize,
    /// The index-map slots written per split if collapses write the kept vertex.
    pub updates_naive: f64,
    /// The index-map slots written per split if collapses write symbols that refer to a nearby
    /// slot.
    pub updates_encoded: f64,
    /// The size of the refinement of the mesh as single triangles, in bytes.
    pub bytes_triangles: usize,
    /// The size of the refinement of the naive index map, in bytes.
    pub bytes_naive: usize,
    /// The size of the refinement of the encoded index map, in bytes.
    pub bytes_encoded: usize,
}

/// The number of vertices sent as single triangles, and by each filter, in the order of
/// [`DisplayFilter::ALL`].
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

/// The number of vertices that a filter sends over all levels of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilterTotal {
    /// The name of the filter, or [`SINGLE_TRIANGLES`].
    pub filter: String,
    /// The number of vertices sent over all levels.
    pub vertices_sent: u64,
    /// The number of vertices sent per triangle.
    pub vertices_per_triangle: f64,
    /// The number of vertices in percent of single triangles.
    pub percent: f64,
}
