//! The report on reordered vertices: the new order and the number of moved vertices.

use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use tristrip_io::VertexGroup;
use tristrip_pipeline::text::{count, counted};

/// The vertices of a group of parts that share vertices. The field names are the keys of the JSON
/// report.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct GroupOrder {
    /// The indices of the parts, from 0.
    parts: Vec<usize>,
    /// The number of vertices.
    vertices: usize,
    /// The number of vertices with a new index.
    moved: usize,
    /// For each vertex of the file, its index in the input; every index occurs once. The JSON
    /// output has them on one line.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<u32>"))]
    new_to_old: Option<Box<RawValue>>,
    /// Why the vertices kept their order; `null` if they were reordered.
    kept: Option<String>,
}

impl GroupOrder {
    pub(crate) fn of(group: &VertexGroup) -> Self {
        Self {
            parts: group.parts.clone(),
            vertices: group.order.vertex_count(),
            moved: group.order.moved_count(),
            new_to_old: to_raw_value(group.order.new_to_old()).ok(),
            kept: group.kept.clone(),
        }
    }
}

/// Returns a line with the number of vertices whose index changed.
pub(crate) fn line(groups: &[VertexGroup]) -> String {
    let moved: usize = groups.iter().map(|group| group.order.moved_count()).sum();
    let all = groups.iter().map(|group| group.order.vertex_count()).sum();
    format!("moved {} of {} into the order of first use", count(moved), counted(all, "vertex"))
}
