//! Reports on re-ordered vertices: the new order, and the number of moved vertices.

use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use tristrip_io::VertexGroup;
use tristrip_pipeline::text::{count, counted};

/// The vertices of parts that share them; the keys are those of the JSON report.
#[derive(Debug, Serialize)]
pub(crate) struct GroupOrder {
    parts: Vec<usize>,
    vertices: usize,
    moved: usize,
    /// The source vertex of each new vertex, on one line of the JSON output.
    new_to_old: Option<Box<RawValue>>,
    /// Why the vertices kept their order; `None` if they did not.
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

/// Returns a line on how many vertices have a new number.
pub(crate) fn line(groups: &[VertexGroup]) -> String {
    let moved: usize = groups.iter().map(|group| group.order.moved_count()).sum();
    let all = groups.iter().map(|group| group.order.vertex_count()).sum();
    format!("{} of {} renumbered in the order of first use", count(moved), counted(all, "vertex"))
}
