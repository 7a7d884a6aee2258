//! Merges vertices as collapses rename them, and finds the triangles that become degenerate.
//!
//! # Algorithm
//! Each drawn vertex has a *slot*, a list of corners. When one vertex is renamed to another, the
//! shorter of their two lists is appended to the longer one. The kept vertex takes the slot of the
//! longer list. A triangle that becomes degenerate has a corner in both lists, so checking the
//! triangles of the moved corners finds all of them.
//!
//! # Complexity
//! O(n log n) time for all collapses of a mesh: whenever a corner moves, its list at least doubles.
//! About 40 bytes per used vertex and 8 per corner.

use crate::ids::OptionalId;
use crate::mesh::{SPARSE, VertexSubset, is_degenerate, triangle_at, triangles_of};

/// The corners of each vertex that is still drawn.
pub(super) struct MergedVertices {
    /// The used vertices, if they are few.
    used: Option<VertexSubset>,
    /// The slot of each vertex, or of each used vertex; none if it is no longer drawn.
    slots: Vec<OptionalId>,
    /// The corners of each slot.
    corners: Vec<Vec<u32>>,
    /// The slot of each corner.
    slot_at: Vec<u32>,
    is_drawn: Vec<bool>,
}

impl MergedVertices {
    /// Collects the corners of each vertex. Every corner must be less than `vertex_count`.
    pub(super) fn new(vertex_count: usize, triangles: &[u32]) -> Self {
        let used = (vertex_count / SPARSE > triangles.len()).then(|| VertexSubset::of(triangles));
        let slot_at = used.as_ref().map_or_else(|| triangles.to_vec(), |used| used.numbers(triangles));
        let mut corners = vec![Vec::new(); used.as_ref().map_or(vertex_count, VertexSubset::len)];
        for (corner, &slot) in (0..).zip(&slot_at) {
            corners[slot as usize].push(corner);
        }
        let slot = |(slot, corners): (u32, &Vec<u32>)| (!corners.is_empty()).then_some(slot).into();
        Self {
            used,
            slots: (0..).zip(&corners).map(slot).collect(),
            is_drawn: triangles_of(&slot_at).map(|t| !is_degenerate(t)).collect(),
            corners,
            slot_at,
        }
    }

    /// Renames vertex `removed` to `kept`, and appends the triangles that become degenerate to
    /// `dropped`. Returns `None` if one of the vertices is not drawn or both are the same.
    pub(super) fn rename(&mut self, removed: u32, kept: u32, dropped: &mut Vec<u32>) -> Option<()> {
        let [removed, kept] = [self.number(removed)?, self.number(kept)?];
        let [from, to] = [self.slots[removed].get()?, self.slots[kept].get()?];
        if removed == kept {
            return None;
        }
        let lengths = [from, to].map(|slot| self.corners[slot as usize].len());
        let [shorter, longer] = if lengths[0] <= lengths[1] { [from, to] } else { [to, from] };
        let moved = std::mem::take(&mut self.corners[shorter as usize]);
        moved.iter().for_each(|&corner| self.slot_at[corner as usize] = longer);
        for triangle in moved.iter().map(|&corner| corner / 3) {
            let is_drawn = &mut self.is_drawn[triangle as usize];
            if *is_drawn && is_degenerate(triangle_at(&self.slot_at, triangle as usize)) {
                *is_drawn = false;
                dropped.push(triangle);
            }
        }
        self.corners[longer as usize].extend(moved);
        self.slots[removed] = OptionalId::NONE;
        self.slots[kept] = OptionalId::some(longer);
        Some(())
    }

    /// Returns the index of a vertex in `slots`.
    fn number(&self, vertex: u32) -> Option<usize> {
        let number = self.used.as_ref().map_or(Some(vertex), |used| used.find(vertex))? as usize;
        (number < self.slots.len()).then_some(number)
    }
}
