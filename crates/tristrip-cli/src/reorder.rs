//! What is said of re-ordered vertices: where each went, how many moved, and which could not.

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
    /// For each place the vertex of the source: one line, however many there are.
    new_to_old: Option<Box<RawValue>>,
    /// Why the vertices stayed where they were.
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

/// Says in one line how many vertices have another number.
pub(crate) fn line(groups: &[VertexGroup]) -> String {
    let moved: usize = groups.iter().map(|group| group.order.moved_count()).sum();
    let all = groups.iter().map(|group| group.order.vertex_count()).sum();
    format!("{} of {} moved to the order of first use", count(moved), counted(all, "vertex"))
}

/// Says which parts kept their vertices as they were, and why; the same reason once.
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
