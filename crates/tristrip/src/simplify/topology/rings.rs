//! The corners around each point, some of which are removed and others move to another point.
//!
//! # Complexity
//! Constant time to remove a corner; time proportional to the corners moved, and sometimes to those already there, to move them.

use std::ops::Range;

use super::corner::CornerId;
use crate::csr::Csr;
use crate::mesh::{is_degenerate, triangle_at};

/// The corners around each point, all in one array. A ring that outgrows its range moves to the end.
#[derive(Debug)]
pub(super) struct CornerRings {
    corners: Vec<CornerId>,
    rings: Vec<RingRange>,
    /// The position of each corner in its ring.
    positions: Vec<u32>,
}

/// The range of a ring in the array, and its capacity.
#[derive(Debug, Clone, Copy, Default)]
struct RingRange {
    start: u32,
    length: u32,
    capacity: u32,
}

impl RingRange {
    fn range(self) -> Range<usize> {
        self.start as usize..(self.start + self.length) as usize
    }
}

impl CornerRings {
    /// Groups the corners of triangles by point, in ascending order, without those of triangles that have a vertex twice.
    pub(super) fn new(triangles: &[[u32; 3]], vertices: &[u32], point_count: usize) -> Self {
        // Corners that are left out are grouped behind those of all points.
        let left_out = [point_count as u32; 3];
        let is_drawn = |t: usize| !is_degenerate(triangle_at(vertices, t));
        let points = (0..triangles.len()).flat_map(|t| if is_drawn(t) { triangles[t] } else { left_out });
        let by_point = Csr::group(points, point_count + 1);
        let mut corners = Vec::with_capacity(by_point.range(point_count as u32).start);
        let mut rings = Vec::with_capacity(point_count);
        let mut positions = vec![0; 3 * triangles.len()];
        for row in by_point.rows().take(point_count) {
            let (start, length) = (corners.len() as u32, row.len() as u32);
            rings.push(RingRange { start, length, capacity: length });
            for (position, &corner) in (0..).zip(row) {
                corners.push(CornerId::new(corner as usize / 3, corner as usize % 3));
                positions[corner as usize] = position;
            }
        }
        Self { corners, rings, positions }
    }

    /// Returns the corners around a point.
    pub(super) fn of(&self, point: u32) -> &[CornerId] {
        &self.corners[self.rings[point as usize].range()]
    }

    /// Removes a corner from the ring of a point; the last corner takes its position.
    pub(super) fn remove(&mut self, point: u32, corner: CornerId) {
        let ring = &mut self.rings[point as usize];
        let corners = &mut self.corners[ring.range()];
        let position = self.positions[corner.index()];
        let last = corners[corners.len() - 1];
        corners[position as usize] = last;
        self.positions[last.index()] = position;
        ring.length -= 1;
    }

    /// Moves all corners of one point behind those of another.
    pub(super) fn append(&mut self, from: u32, to: u32) {
        let source = std::mem::take(&mut self.rings[from as usize]);
        let ring = &mut self.rings[to as usize];
        let length = ring.length + source.length;
        for (position, corner) in (ring.length..).zip(&self.corners[source.range()]) {
            self.positions[corner.index()] = position;
        }
        if length <= ring.capacity {
            self.corners.copy_within(source.range(), ring.range().end);
        } else {
            let start = self.corners.len() as u32;
            self.corners.extend_from_within(ring.range());
            self.corners.extend_from_within(source.range());
            let spare = length / 4 + 1;
            self.corners.resize(self.corners.len() + spare as usize, CornerId::default());
            (ring.start, ring.capacity) = (start, length + spare);
        }
        ring.length = length;
    }
}
