//! Patches: rectangular regions of quadrilaterals, largest first.
//!
//! # Algorithm
//! A straight path leaves a quadrilateral across the edge opposite to its entry. Every half-edge of
//! a quadrilateral therefore represents a direction through the quadrilateral. These directions
//! form open or closed lines.
//!
//! ```text
//!        north                   ┌───┬───┐
//!      ┌───────┐                 │   │   │    the grid height of h: the number of rows, from this
//! west │   q   │ h: east     ┌───┼───┼───┤    one northward, in which the two columns that h joins
//!      └───────┘             │   │ h─┼─▶ │    are neighbours; here 2
//!        south               └───┴───┴───┘
//! ```
//! 1. The grid height of every quad half-edge is computed from the grid height of the half-edge
//!    above it.
//! 2. The grid heights along a line form a histogram. A patch with its south row on the line is as
//!    high as the lowest grid height in its columns. A stack finds the largest patches.
//! 3. All patches of the largest size are taken, except patches that overlap one already taken.
//!    Steps 1 to 3 are repeated until the largest patch is below the cutoff.
//!
//! The paper traverses the faces once per patch. Here a round takes many patches. When the work
//! exceeds a fixed amount, a round takes all patches of at least half the largest size. This keeps
//! the time nearly linear for any input. On a grid of a million quadrilaterals with holes it
//! changed the cost by less than 0.1 %.
//!
//! # References
//! Section 3.2 of the paper; see [`super`].
//!
//! # Complexity
//! O(n) per round, with a few rounds each time the size of the largest patch halves. 45 bytes per
//! quadrilateral.

use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge, OptionalId};

/// Marks the grid heights of half-edges on the column being followed.
const ON_COLUMN: u32 = u32::MAX;
/// Number of examined quadrilaterals after which a round may take patches that are not the largest.
const EXACT_WORK: usize = 500_000;

/// A rectangular patch: where it starts and how far it extends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Patch {
    /// The eastward half-edge of the south-west quadrilateral.
    corner: u32,
    width: u32,
    height: u32,
}

impl Patch {
    fn area(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// Finds patches. Quadrilateral q has the quad half-edges 4q to 4q + 3, in winding order.
#[derive(Debug)]
pub(super) struct PatchFinder {
    /// The quad half-edge on the other side of each one, if there is a quadrilateral.
    twins: Vec<OptionalId>,
    /// The first corner of each quadrilateral's face.
    corners: Vec<u32>,
    /// Whether each quadrilateral is in no patch, and the list of those.
    free: Vec<bool>,
    free_quads: Vec<u32>,
    /// By quad half-edge.
    grid_heights: Vec<u32>,
}

impl PatchFinder {
    pub(super) fn new(graph: &DualGraph) -> Self {
        let corners: Vec<u32> = (0..graph.face_count() as u32)
            .filter_map(|face| {
                let mut corners = graph.half_edges(FaceId(face));
                let first = corners.next()?.0;
                (corners.next_back()?.0 - first == 3).then_some(first)
            })
            .collect();
        let quad_half_edge = |h: HalfEdge| {
            let first = graph.half_edges(graph.face_of(h)).next()?.0;
            corners.binary_search(&first).ok().map(|quad| 4 * quad as u32 + h.0 - first)
        };
        let mut twins = Vec::with_capacity(4 * corners.len());
        for h in corners.iter().flat_map(|&first| first..first + 4) {
            twins.push(OptionalId::from(graph.twin(HalfEdge(h)).and_then(quad_half_edge)));
        }
        let free = vec![true; corners.len()];
        let free_quads = (0..corners.len() as u32).collect();
        let grid_heights = vec![0; twins.len()];
        Self { twins, corners, free, free_quads, grid_heights }
    }

    /// Finds all patches of at least `cutoff` quadrilaterals, in the order in which they are found.
    /// A patch is returned as a list of rows. A row is a list of the half-edges across which its
    /// quadrilaterals are left from west to east. Rows are at least as long as columns.
    pub(super) fn find(mut self, cutoff: u32) -> Vec<Vec<Vec<u32>>> {
        let cutoff = u64::from(cutoff.max(1));
        let mut found = Vec::new();
        let mut work = 0;
        loop {
            self.free_quads.retain(|&quad| self.free[quad as usize]);
            work += self.free_quads.len();
            self.measure_heights();
            let share = if work <= EXACT_WORK { 1 } else { 2 };
            let before = found.len();
            for (i, patch) in self.candidates(cutoff, share).into_iter().enumerate() {
                found.extend(self.claim(patch, cutoff, i == 0));
            }
            if found.len() == before {
                let to_half_edge = |h: &mut u32| *h = self.corners[*h as usize / 4] + *h % 4;
                found.iter_mut().flatten().flatten().for_each(to_half_edge);
                return found;
            }
        }
    }

    /// Returns the quad half-edge on the other side, if its quadrilateral is free.
    #[inline]
    fn free_twin(&self, h: u32) -> Option<u32> {
        self.twins[h as usize].get().filter(|&twin| self.free[twin as usize / 4])
    }

    /// Returns the half-edge in the same direction, one quadrilateral further.
    #[inline]
    fn ahead(&self, h: u32) -> Option<u32> {
        self.free_twin(h).map(|twin| rotate(twin, 2))
    }

    /// Returns the eastward half-edge of the quadrilateral to the north.
    #[inline]
    fn north(&self, h: u32) -> Option<u32> {
        self.free_twin(rotate(h, 1)).map(|twin| rotate(twin, 1))
    }

    /// Returns the eastward half-edge one row to the north. Returns `None` unless both
    /// quadrilaterals at this half-edge have northern neighbours and the returned half-edge
    /// connects these neighbours.
    #[inline]
    fn next_of_column(&self, h: u32) -> Option<u32> {
        let above = self.north(h)?;
        let east = self.ahead(h)?;
        (self.ahead(above)? == self.north(east)?).then_some(above)
    }

    /// Computes the grid heights: step 1.
    fn measure_heights(&mut self) {
        let mut heights = std::mem::take(&mut self.grid_heights);
        let half_edges = || self.free_quads.iter().flat_map(|&quad| 4 * quad..4 * quad + 4);
        half_edges().for_each(|h| heights[h as usize] = 0);
        let mut column = Vec::new();
        for h in half_edges().filter(|&h| self.free_twin(h).is_some()) {
            // Go north to the end or to a known height. A closed column has one height everywhere.
            column.clear();
            let mut next = Some(h);
            while let Some(h) = next.filter(|&h| heights[h as usize] == 0) {
                heights[h as usize] = ON_COLUMN;
                column.push(h);
                next = self.next_of_column(h);
            }
            let is_ring = next.is_some_and(|h| heights[h as usize] == ON_COLUMN);
            let known = next.filter(|_| !is_ring).map_or(0, |h| heights[h as usize]);
            for (above, &h) in column.iter().rev().enumerate() {
                let height = if is_ring { column.len() } else { above + 1 };
                heights[h as usize] = known + height as u32;
            }
        }
        self.grid_heights = heights;
    }

    /// Finds the largest patches, with an area of at least `1 / share` of the largest and at least
    /// the cutoff: step 2.
    fn candidates(&self, cutoff: u64, share: u64) -> Vec<Patch> {
        let mut found: Vec<Patch> = Vec::new();
        let mut largest = 0;
        let mut add = |patch: Patch| {
            let area = patch.area();
            if area < cutoff || area * share < largest {
                return;
            }
            if area > largest && share == 1 {
                found.clear();
            }
            largest = largest.max(area);
            found.push(patch);
        };
        let mut seen = vec![false; self.grid_heights.len()];
        let (mut line, mut stack) = (Vec::new(), Vec::new());
        // Lines with a start come first. Closed ones start anywhere.
        for is_closed in [false, true] {
            for h in self.free_quads.iter().flat_map(|&quad| 4 * quad..4 * quad + 4) {
                if seen[h as usize] || !(is_closed || self.free_twin(rotate(h, 2)).is_none()) {
                    continue;
                }
                line.clear();
                let mut next = Some(h);
                while let Some(h) = next.filter(|&h| !seen[h as usize]) {
                    seen[h as usize] = true;
                    line.push(h);
                    next = self.ahead(h);
                }
                self.search_line(&line, &mut stack, &mut add);
            }
        }
        found.retain(|patch| patch.area() * share >= largest);
        found.sort_by_key(|patch| std::cmp::Reverse(patch.area()));
        found
    }

    /// Calls `add` for every maximal patch with its south row on a line.
    fn search_line(&self, line: &[u32], stack: &mut Vec<(usize, u32)>, add: &mut impl FnMut(Patch)) {
        // A column by itself is a row of another line, unless it is a single quadrilateral.
        if let [only] = *line {
            add(Patch { corner: only, width: 1, height: 1 });
        }
        stack.clear();
        for i in 0..line.len() {
            let grid_height = if i + 1 < line.len() { self.grid_heights[line[i] as usize] } else { 0 };
            let mut start = i;
            while let Some(&(from, height)) = stack.last()
                && height >= grid_height
            {
                stack.pop();
                start = from;
                if height > grid_height {
                    add(Patch { corner: line[from], width: (i - from + 1) as u32, height });
                }
            }
            stack.push((start, grid_height));
        }
    }

    /// Takes a patch and returns its rows, or `None` if it meets another patch: step 3. The lines
    /// of the first patch of a round may cross themselves; the free part of it is enough.
    fn claim(&mut self, patch: Patch, cutoff: u64, is_first: bool) -> Option<Vec<Vec<u32>>> {
        let mut rows: Vec<Vec<u32>> = Vec::new();
        let (mut first, mut width) = (Some(patch.corner), patch.width as usize);
        while let Some(start) = first.filter(|_| rows.len() < patch.height as usize) {
            let mut row = Vec::with_capacity(width);
            let mut next = Some(start);
            while let Some(h) = next.filter(|_| row.len() < width) {
                if !std::mem::take(&mut self.free[h as usize / 4]) {
                    break;
                }
                row.push(h);
                next = self.ahead(h);
            }
            let is_whole = row.len() == width;
            if rows.is_empty() && is_first {
                width = row.len();
            } else if !is_whole {
                self.release(&row);
                break;
            }
            rows.push(row);
            first = self.north(start);
        }
        let area = (rows.len() * width) as u64;
        if area < cutoff || (!is_first && area < patch.area()) {
            rows.iter().for_each(|row| self.release(row));
            return None;
        }
        if rows.len() > width {
            // The columns are longer: rotate the patch about its north-west corner.
            let column = |i: usize| rows.iter().map(|row| rotate(row[i], 1)).collect();
            rows = (0..width).rev().map(column).collect();
        }
        Some(rows)
    }

    fn release(&mut self, row: &[u32]) {
        row.iter().for_each(|&h| self.free[h as usize / 4] = true);
    }
}

/// Returns the half-edge of the same quadrilateral `corners` corners later.
#[inline]
fn rotate(h: u32, corners: u32) -> u32 {
    h & !3 | (h + corners) & 3
}

/// Returns the half-edges of one path through all rows of a patch, with every other row from east
/// to west.
pub(super) fn serpentine(graph: &DualGraph, rows: &[Vec<u32>]) -> Vec<u32> {
    let rotate = |h: u32, corners: u32| {
        let first = graph.half_edges(graph.face_of(HalfEdge(h))).next().map_or(0, |h| h.0);
        first + ((h - first + corners) & 3)
    };
    let mut path = Vec::with_capacity(rows.iter().map(Vec::len).sum());
    for (i, row) in rows.iter().enumerate() {
        let is_eastward = i % 2 == 0;
        if is_eastward {
            path.extend_from_slice(row);
        } else {
            path.extend(row.iter().rev().map(|&h| rotate(h, 2)));
        }
        if let Some(last) = path.last_mut() {
            *last = rotate(*last, if is_eastward { 1 } else { 3 });
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;
    use proptest::prelude::*;

    /// Builds a grid of the `kept` quadrilaterals, which start at any of their corners.
    fn grid(width: u32, height: u32, around: bool, kept: impl Fn(u32, u32) -> bool) -> DualGraph {
        let v = |x: u32, y: u32| y * (width + 1) + if around { x % width } else { x };
        let mut polygons = Vec::new();
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|&(x, y)| kept(x, y)) {
            let mut polygon = vec![v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
            polygon.rotate_left((x * 7 + y * 3) as usize % 4);
            polygons.push(polygon);
        }
        DualGraph::new(&Faces::from_polygons(polygons).unwrap())
    }

    /// Finds patches, checks them, and returns their numbers of rows and columns.
    fn checked_sizes(graph: &DualGraph, cutoff: u32) -> Vec<(usize, usize)> {
        let found = PatchFinder::new(graph).find(cutoff);
        let mut seen = vec![false; graph.face_count()];
        for rows in &found {
            let face = |&h: &u32| graph.face_of(HalfEdge(h));
            for row in rows {
                assert_eq!(row.len(), rows[0].len());
                for h in row {
                    assert!(!std::mem::replace(&mut seen[face(h).0 as usize], true), "in two patches");
                }
                for w in row.windows(2) {
                    assert_eq!(graph.twin(HalfEdge(w[0])).map(|t| graph.face_of(t)), Some(face(&w[1])));
                }
            }
            // The path through the whole patch leaves each quadrilateral toward the next.
            for w in serpentine(graph, rows).windows(2) {
                assert_eq!(graph.twin(HalfEdge(w[0])).map(|t| graph.face_of(t)), Some(face(&w[1])));
            }
        }
        found.iter().map(|rows| (rows.len(), rows[0].len())).collect()
    }

    #[test]
    fn finds_the_largest_first_and_stops_at_the_cutoff() {
        assert_eq!(checked_sizes(&grid(7, 3, false, |_, _| true), 5), [(3, 7)]);
        assert_eq!(
            checked_sizes(&grid(2, 6, false, |_, _| true), 5),
            [(2, 6)],
            "rows run along the longer side"
        );
        let corner_gone = grid(6, 4, false, |x, y| x < 3 || y < 2);
        assert_eq!(checked_sizes(&corner_gone, 5), [(3, 4), (2, 3)]);
        assert_eq!(checked_sizes(&corner_gone, 7), [(3, 4)]);
        assert_eq!(checked_sizes(&grid(2, 2, false, |_, _| true), 5), []);
        assert_eq!(checked_sizes(&grid(9, 2, true, |_, _| true), 5), [(2, 9)], "around a cylinder");
    }

    /// Returns the area of the largest rectangle by brute force.
    fn largest_area(width: u32, height: u32, kept: impl Fn(u32, u32) -> bool) -> usize {
        let mut best = 0;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            for (x1, y1) in (y..height).flat_map(|y1| (x..width).map(move |x1| (x1, y1))) {
                if (y..=y1).all(|y| (x..=x1).all(|x| kept(x, y))) {
                    best = best.max((x1 - x + 1) * (y1 - y + 1));
                }
            }
        }
        best as usize
    }

    proptest! {
        #[test]
        fn the_first_patch_is_the_largest_rectangle(
            width in 1..8_u32, height in 1..8_u32, holes in any::<u64>(), cutoff in 1..12_u32,
        ) {
            let kept = |x: u32, y: u32| holes.wrapping_mul(0x9e37_79b9) >> ((y * 8 + x) % 61) & 3 != 0;
            let found = checked_sizes(&grid(width, height, false, kept), cutoff);
            let area = largest_area(width, height, kept);
            let expected = (area >= cutoff as usize).then_some(area);
            prop_assert_eq!(found.first().map(|&(rows, columns)| rows * columns), expected);
            prop_assert!(found.iter().all(|&(rows, columns)| rows * columns >= cutoff as usize));
            prop_assert!(found.windows(2).all(|w| w[0].0 * w[0].1 >= w[1].0 * w[1].1), "largest first");
        }
    }
}
