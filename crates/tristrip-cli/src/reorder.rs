//! Reports on re-ordered vertices: the new order, the number of moved vertices, and the vertices that kept their order.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use tristrip_io::VertexGroup;

use crate::text::{count, counted};

/// The vertices of parts that share them; the keys are those of the JSON report.
#[derive(Debug, Serialize)]
pub(crate) struct GroupReport {
    parts: Vec<usize>,
    vertices: usize,
    moved: usize,
    /// The source vertex of each new vertex, on one line of the JSON output.
    new_to_old: Option<Box<RawValue>>,
    /// Why the vertices kept their order; `None` if they did not.
    kept: Option<String>,
}

impl GroupReport {
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

/// Returns a note per reason for which parts kept their vertex order.
pub(crate) fn kept(groups: &[VertexGroup]) -> Vec<String> {
    let mut by_reason: BTreeMap<&str, usize> = BTreeMap::new();
    for group in groups {
        if let Some(why) = &group.kept {
            *by_reason.entry(why).or_default() += group.parts.len();
        }
    }
    let note = |(why, parts)| format!("vertices not re-ordered in {}: {why}", counted(parts, "part"));
    by_reason.into_iter().map(note).collect()
}
