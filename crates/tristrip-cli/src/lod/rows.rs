//! The rows of the tables of `tristrip lod`, which are also keys of its report.

use clap::ValueEnum;
use serde::{Serialize, Serializer};

use crate::values::FilterName;

/// The name of the mesh drawn as single triangles, beside the names of the filters.
pub(crate) const SINGLE_TRIANGLES: &str = "triangles";

/// A level, and the vertices that each filter sends for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct LevelRow {
    pub(crate) level: usize,
    /// Undone collapses, in percent of all collapses.
    pub(crate) percent: f64,
    pub(crate) triangles: usize,
    pub(crate) vertices_sent: VerticesSent,
    /// The refinement from the previous row to this one.
    pub(crate) refinement: Refinement,
}

/// The vertex splits from one level to another, and what they write.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct Refinement {
    pub(crate) splits: usize,
    /// Index-map slots written per split.
    pub(crate) updates_naive: f64,
    pub(crate) updates_encoded: f64,
    /// Bytes of the refinement: of the mesh as single triangles, and of both index maps.
    pub(crate) bytes_triangles: usize,
    pub(crate) bytes_naive: usize,
    pub(crate) bytes_encoded: usize,
}

/// Vertices sent as single triangles, and by each filter, in the order of [`FilterName`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct VerticesSent {
    pub(crate) triangles: usize,
    pub(crate) by_filter: Vec<usize>,
}

impl VerticesSent {
    /// Iterates over the names of the filters and the vertices that they send.
    pub(crate) fn filters(&self) -> impl Iterator<Item = (String, usize)> {
        let names = FilterName::value_variants().iter().map(|filter| filter.name());
        names.zip(self.by_filter.iter().copied())
    }
}

/// Serializes as an object of names and counts.
impl Serialize for VerticesSent {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let single = std::iter::once((SINGLE_TRIANGLES.to_owned(), self.triangles));
        serializer.collect_map(single.chain(self.filters()))
    }
}

/// The vertices that a filter sends for all levels of a model together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct FilterTotal {
    /// The name of the filter, or [`SINGLE_TRIANGLES`].
    pub(crate) filter: String,
    pub(crate) vertices_sent: u64,
    pub(crate) vertices_per_triangle: f64,
    /// In percent of the vertices sent as single triangles.
    pub(crate) percent: f64,
}
