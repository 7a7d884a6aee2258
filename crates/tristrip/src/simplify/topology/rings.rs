//! The corners around each point, of which some go and others move to another point.
//!
//! # Complexity
//! Constant time to take one corner away; time by the corners moved, and now and then by those that were there, to move them.

use std::ops::Range;

use super::corner::{Corner, corners};
use crate::mesh::{is_degenerate, triangle_at};

/// The corners around each point, all in one array. What grows too large for its place moves to the end.
#[derive(Debug)]
pub(super) struct Rings {
    corners: Vec<Corner>,
    of_points: Vec<Ring>,
    /// Where in its ring each corner stands, so that none is looked for.
    places: Vec<u32>,
}

/// Where the corners of a point stand, how many there are, and for how many there is room.
#[derive(Debug, Clone, Copy, Default)]
struct Ring {
    start: u32,
    length: u32,
    room: u32,
}

impl Ring {
    fn range(self) -> Range<usize> {
        self.start as usize..(self.start + self.length) as usize
    }
}

impl Rings {
    /// Puts the corners of triangles in order; those of triangles with a vertex twice, which draw nothing, are left out.
    pub(super) fn new(triangles: &[[u32; 3]], vertices: &[u32], point_count: usize) -> Self {
        let mut of_points = vec![Ring::default(); point_count];
        let drawn = || {
            let all = corners(triangles.len()).zip(triangles.iter().flatten());
            all.filter(|(corner, _)| !is_degenerate(triangle_at(vertices, corner.triangle())))
        };
        drawn().for_each(|(_, &p)| of_points[p as usize].room += 1);
        let mut end = 0;
        for ring in &mut of_points {
            ring.start = end;
            end += ring.room;
        }
        let mut ordered = vec![Corner::default(); end as usize];
        let mut places = vec![0; 3 * triangles.len()];
        for (corner, &p) in drawn() {
            let ring = &mut of_points[p as usize];
            ordered[ring.range().end] = corner;
            places[corner.index()] = ring.length;
            ring.length += 1;
        }
        Self { corners: ordered, of_points, places }
    }

    pub(super) fn of(&self, point: u32) -> &[Corner] {
        &self.corners[self.of_points[point as usize].range()]
    }

    /// Takes a corner away from those of a point.
    pub(super) fn remove(&mut self, point: u32, corner: Corner) {
        let ring = &mut self.of_points[point as usize];
        let corners = &mut self.corners[ring.range()];
        let place = self.places[corner.index()];
        let last = corners[corners.len() - 1];
        corners[place as usize] = last;
        self.places[last.index()] = place;
        ring.length -= 1;
    }

    /// Adds all corners of one point to those of another.
    pub(super) fn append(&mut self, from: u32, to: u32) {
        let source = std::mem::take(&mut self.of_points[from as usize]);
        let ring = &mut self.of_points[to as usize];
        let length = ring.length + source.length;
        for (place, corner) in (ring.length..).zip(&self.corners[source.range()]) {
            self.places[corner.index()] = place;
        }
        if length <= ring.room {
            self.corners.copy_within(source.range(), ring.range().end);
        } else {
            let start = self.corners.len() as u32;
            self.corners.extend_from_within(ring.range());
            self.corners.extend_from_within(source.range());
            let spare = length / 4 + 1;
            self.corners.resize(self.corners.len() + spare as usize, Corner::default());
            (ring.start, ring.room) = (start, length + spare);
        }
        ring.length = length;
    }
}
