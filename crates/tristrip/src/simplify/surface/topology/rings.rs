//! Maintains the corners around each point while corners are removed or moved to other points.
//!
//! # Complexity
//! Constant time to remove a corner. Moving corners takes time proportional to their number, and
//! sometimes also to the number already at the target.

use std::ops::Range;

use super::corner::CornerId;
use crate::csr::Csr;
use crate::mesh::{is_degenerate, triangle_at};

/// The corners around each point, all in one array. A ring that outgrows its range is moved to the
/// end of the array.
#[derive(Debug)]
pub(super) struct CornerRings {
    corners: Vec<CornerId>,
    /// The opposite edge of each of these corners: the points of the two others of its triangle, in
    /// winding order.
    opposite: Vec<[u32; 2]>,
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
    /// Groups the corners of triangles by point, in ascending order. Corners of triangles with a
    /// repeated vertex are left out.
    pub(super) fn new(triangles: &[[u32; 3]], vertices: &[u32], point_count: usize) -> Self {
        // Corners that are left out are grouped after those of all points.
        let left_out = [point_count as u32; 3];
        let is_drawn = |t: usize| !is_degenerate(triangle_at(vertices, t));
        let points = (0..triangles.len()).flat_map(|t| if is_drawn(t) { triangles[t] } else { left_out });
        let by_point = Csr::group(points, point_count + 1);
        let count = by_point.range(point_count as u32).start;
        let (mut corners, mut opposite) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut rings = Vec::with_capacity(point_count);
        let mut positions = vec![0; 3 * triangles.len()];
        for row in by_point.rows().take(point_count) {
            let (start, length) = (corners.len() as u32, row.len() as u32);
            rings.push(RingRange { start, length, capacity: length });
            for (position, &corner) in (0..).zip(row) {
                let id = CornerId::new(corner as usize / 3, corner as usize % 3);
                corners.push(id);
                opposite.push(id.others(triangles));
                positions[corner as usize] = position;
            }
        }
        Self { corners, opposite, rings, positions }
    }

    /// Returns the corners around a point.
    pub(super) fn of(&self, point: u32) -> &[CornerId] {
        &self.corners[self.rings[point as usize].range()]
    }

    /// Returns the opposite edge of each corner around a point.
    pub(super) fn opposite(&self, point: u32) -> &[[u32; 2]] {
        &self.opposite[self.rings[point as usize].range()]
    }

    /// Sets one end of the opposite edge of a corner in the ring of a point.
    pub(super) fn set_opposite(&mut self, point: u32, corner: CornerId, end: usize, to: u32) {
        let position = self.rings[point as usize].start + self.positions[corner.index()];
        self.opposite[position as usize][end] = to;
    }

    /// Removes a corner from the ring of a point; the last corner takes its position.
    pub(super) fn remove(&mut self, point: u32, corner: CornerId) {
        let ring = &mut self.rings[point as usize];
        let position = self.positions[corner.index()];
        let (at, end) = ((ring.start + position) as usize, ring.range().end - 1);
        let last = self.corners[end];
        self.corners[at] = last;
        self.opposite[at] = self.opposite[end];
        self.positions[last.index()] = position;
        ring.length -= 1;
    }

    /// Moves all corners of one point to the end of another point's ring.
    pub(super) fn append(&mut self, from: u32, to: u32) {
        let source = std::mem::take(&mut self.rings[from as usize]);
        let ring = &mut self.rings[to as usize];
        let length = ring.length + source.length;
        for (position, corner) in (ring.length..).zip(&self.corners[source.range()]) {
            self.positions[corner.index()] = position;
        }
        if length <= ring.capacity {
            self.corners.copy_within(source.range(), ring.range().end);
            self.opposite.copy_within(source.range(), ring.range().end);
        } else {
            let start = self.corners.len() as u32;
            let spare = length / 4 + 1;
            let end = self.corners.len() + (length + spare) as usize;
            for range in [ring.range(), source.range()] {
                self.corners.extend_from_within(range.clone());
                self.opposite.extend_from_within(range);
            }
            self.corners.resize(end, CornerId::default());
            self.opposite.resize(end, [0; 2]);
            (ring.start, ring.capacity) = (start, length + spare);
        }
        ring.length = length;
    }
}
