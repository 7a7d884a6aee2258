//! Patches: rectangular regions of quadrilaterals, the largest first.
//!
//! # Algorithm
//! Going straight through a quadrilateral means to leave it across the edge opposite to the one of entry; so every edge of a
//! quadrilateral is a heading, and headings form lines, open or closed.
//!
//! ```text
//!        north                   ┌───┬───┐
//!      ┌───────┐                 │   │   │      the rung of h: in how many rows, from this one northward, the
//! west │   q   │ h: east     ┌───┼───┼───┤      columns of the two quadrilaterals that h joins are neighbours; here 2
//!      └───────┘             │   │ h─┼─▶ │
//!        south               └───┴───┴───┘
//! ```
//! 1. Every heading learns its rung, from the rung above it.
//! 2. The rungs along a line are a histogram: a patch with its south row on the line is as high as the lowest rung between its
//!    columns. The largest patches are found with a stack.
//! 3. All patches as large as the largest are taken, except those that meet one already taken. Steps 1 to 3 are done again
//!    until the largest is below the cutoff.
//!
//! The paper walks over the faces once for each patch. Here a round takes many. When the work exceeds a fixed amount, a round
//! takes patches of at least half the largest's size, so that the time stays near linear whatever comes; on a grid of a
//! million quadrilaterals with holes that changed the cost by less than 0.1 %.
//!
//! # References
//! Section 3.2 of the paper; see [`super`].
//!
//! # Complexity
//! O(n) for each round, and a few rounds for each halving of the largest patch. 45 bytes a quadrilateral.

use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};

const NONE: u32 = u32::MAX;
/// Quadrilaterals looked at before a round may take patches that are not the largest.
const EXACT_WORK: usize = 500_000;

/// A rectangular patch: where it starts, and how far it goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Patch {
    /// The eastward heading of its south-west quadrilateral.
    corner: u32,
    width: u32,
    height: u32,
}

impl Patch {
    fn area(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// Finds patches. Quadrilateral q has the headings 4q to 4q + 3, in its winding.
#[derive(Debug)]
pub(super) struct Patches {
    /// The heading on the other side of each one's edge; `NONE` where there is no quadrilateral.
    twins: Vec<u32>,
    /// The face's first corner.
    corners: Vec<u32>,
    /// Whether a quadrilateral is in no patch, and those that are in none.
    free: Vec<bool>,
    left: Vec<u32>,
    /// By heading.
    rung: Vec<u32>,
}

impl Patches {
    pub(super) fn new(graph: &DualGraph) -> Self {
        let corners: Vec<u32> = (0..graph.face_count() as u32)
            .filter_map(|face| {
                let mut corners = graph.half_edges(FaceId(face));
                let first = corners.next()?.0;
                (corners.next_back()?.0 - first == 3).then_some(first)
            })
            .collect();
        let heading = |h: HalfEdge| {
            let first = graph.half_edges(graph.face_of(h)).next()?.0;
            corners.binary_search(&first).ok().map(|quad| 4 * quad as u32 + h.0 - first)
        };
        let mut twins = Vec::with_capacity(4 * corners.len());
        for h in corners.iter().flat_map(|&first| first..first + 4) {
            twins.push(graph.twin(HalfEdge(h)).and_then(heading).unwrap_or(NONE));
        }
        let free = vec![true; corners.len()];
        let left = (0..corners.len() as u32).collect();
        let rung = vec![0; twins.len()];
        Self { twins, corners, free, left, rung }
    }

    /// Finds all patches of at least `cutoff` quadrilaterals, in the order in which they are found. Each is given as its rows,
    /// and these as the half-edges across which their quadrilaterals are left from west to east; rows are not shorter than
    /// columns.
    pub(super) fn find(mut self, cutoff: u32) -> Vec<Vec<Vec<u32>>> {
        let cutoff = u64::from(cutoff.max(1));
        let mut found = Vec::new();
        let mut work = 0;
        loop {
            self.left.retain(|&quad| self.free[quad as usize]);
            work += self.left.len();
            self.measure();
            let share = if work <= EXACT_WORK { 1 } else { 2 };
            let before = found.len();
            for (i, patch) in self.candidates(cutoff, share).into_iter().enumerate() {
                found.extend(self.claim(patch, cutoff, i > 0));
            }
            if found.len() == before {
                let half_edge = |h: &mut u32| *h = self.corners[*h as usize / 4] + *h % 4;
                found.iter_mut().flatten().flatten().for_each(half_edge);
                return found;
            }
        }
    }

    /// The heading by which another one enters the next quadrilateral backward, if there is one.
    #[inline]
    fn enters(&self, heading: u32) -> Option<u32> {
        let twin = self.twins[heading as usize];
        (twin != NONE && self.free[twin as usize / 4]).then_some(twin)
    }

    /// The same heading one quadrilateral on.
    #[inline]
    fn ahead(&self, heading: u32) -> Option<u32> {
        self.enters(heading).map(|h| turn(h, 2))
    }

    /// The eastward heading of the quadrilateral to the north.
    #[inline]
    fn north(&self, heading: u32) -> Option<u32> {
        self.enters(turn(heading, 1)).map(|h| turn(h, 1))
    }

    /// The eastward heading one row to the north, where both quadrilaterals that this one joins have neighbours there that it
    /// joins in turn.
    #[inline]
    fn rung_above(&self, heading: u32) -> Option<u32> {
        let above = self.north(heading)?;
        let east = self.ahead(heading)?;
        (self.ahead(above)? == self.north(east)?).then_some(above)
    }

    /// Step 1.
    fn measure(&mut self) {
        let mut rung = std::mem::take(&mut self.rung);
        let headings = || self.left.iter().flat_map(|&quad| 4 * quad..4 * quad + 4);
        headings().for_each(|h| rung[h as usize] = 0);
        let mut column = Vec::new();
        for h in headings().filter(|&h| self.enters(h).is_some()) {
            // Northward to the end or to what is known; where it comes around, all are on the same ring.
            column.clear();
            let mut at = Some(h);
            while let Some(h) = at.filter(|&h| rung[h as usize] == 0) {
                rung[h as usize] = NONE;
                column.push(h);
                at = self.rung_above(h);
            }
            let around = at.is_some_and(|h| rung[h as usize] == NONE);
            let known = at.filter(|_| !around).map_or(0, |h| rung[h as usize]);
            for (above, &h) in column.iter().rev().enumerate() {
                let height = if around { column.len() } else { above + 1 };
                rung[h as usize] = known + height as u32;
            }
        }
        self.rung = rung;
    }

    /// Step 2: the largest patches, those of an area of at least a `share` of the largest, and at least the cutoff.
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
        let mut seen = vec![false; self.rung.len()];
        let (mut line, mut stack) = (Vec::new(), Vec::new());
        // Lines that have a beginning first; closed ones begin anywhere.
        for closed in [false, true] {
            for h in self.left.iter().flat_map(|&quad| 4 * quad..4 * quad + 4) {
                if seen[h as usize] || !(closed || self.enters(turn(h, 2)).is_none()) {
                    continue;
                }
                line.clear();
                let mut next = Some(h);
                while let Some(heading) = next.filter(|&heading| !seen[heading as usize]) {
                    seen[heading as usize] = true;
                    line.push(heading);
                    next = self.ahead(heading);
                }
                self.search_line(&line, &mut stack, &mut add);
            }
        }
        found.retain(|patch| patch.area() * share >= largest);
        found.sort_by_key(|patch| std::cmp::Reverse(patch.area()));
        found
    }

    /// Gives every patch that is as high and wide as it can be, with its south row on a line.
    fn search_line(&self, line: &[u32], stack: &mut Vec<(usize, u32)>, add: &mut impl FnMut(Patch)) {
        // A column by itself is a row of another line, unless it is a single quadrilateral.
        if let [only] = *line {
            add(Patch { corner: only, width: 1, height: 1 });
        }
        stack.clear();
        for i in 0..line.len() {
            let rung = if i + 1 < line.len() { self.rung[line[i] as usize] } else { 0 };
            let mut start = i;
            while let Some(&(from, height)) = stack.last()
                && height >= rung
            {
                stack.pop();
                start = from;
                if height > rung {
                    add(Patch { corner: line[from], width: (i - from + 1) as u32, height });
                }
            }
            stack.push((start, rung));
        }
    }

    /// Step 3: takes a patch; `None` where it meets another one. What is left of the patch where its lines cross themselves
    /// will do if there is no `other`.
    fn claim(&mut self, patch: Patch, cutoff: u64, other: bool) -> Option<Vec<Vec<u32>>> {
        let mut rows: Vec<Vec<u32>> = Vec::new();
        let (mut first, mut width) = (Some(patch.corner), patch.width as usize);
        while let Some(start) = first.filter(|_| rows.len() < patch.height as usize) {
            let mut row = Vec::with_capacity(width);
            let mut heading = Some(start);
            while let Some(h) = heading.filter(|_| row.len() < width) {
                if !std::mem::take(&mut self.free[h as usize / 4]) {
                    break;
                }
                row.push(h);
                heading = self.ahead(h);
            }
            let whole = row.len() == width;
            if rows.is_empty() && !other {
                width = row.len();
            } else if !whole {
                self.release(&row);
                break;
            }
            rows.push(row);
            first = self.north(start);
        }
        let area = (rows.len() * width) as u64;
        if area < cutoff || (other && area < patch.area()) {
            rows.iter().for_each(|row| self.release(row));
            return None;
        }
        if rows.len() > width {
            // Columns are longer: the patch is turned around its north-west corner.
            let column = |i: usize| rows.iter().map(|row| turn(row[i], 1)).collect();
            rows = (0..width).rev().map(column).collect();
        }
        Some(rows)
    }

    fn release(&mut self, row: &[u32]) {
        row.iter().for_each(|&h| self.free[h as usize / 4] = true);
    }
}

/// Gives the heading of the same quadrilateral, some corners on.
#[inline]
fn turn(heading: u32, corners: u32) -> u32 {
    heading & !3 | (heading + corners) & 3
}

/// Gives the half-edges of one way through all rows of a patch, every other row from east to west.
pub(super) fn winding(graph: &DualGraph, rows: &[Vec<u32>]) -> Vec<u32> {
    let turn = |h: u32, corners: u32| {
        let first = graph.half_edges(graph.face_of(HalfEdge(h))).next().map_or(0, |h| h.0);
        first + ((h - first + corners) & 3)
    };
    let mut way = Vec::with_capacity(rows.iter().map(Vec::len).sum());
    for (i, row) in rows.iter().enumerate() {
        let eastward = i % 2 == 0;
        if eastward {
            way.extend_from_slice(row);
        } else {
            way.extend(row.iter().rev().map(|&h| turn(h, 2)));
        }
        if let Some(last) = way.last_mut() {
            *last = turn(*last, if eastward { 1 } else { 3 });
        }
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;
    use proptest::prelude::*;

    /// A grid whose quadrilaterals start at any of their corners, without those that are not `kept`.
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

    fn sizes(graph: &DualGraph, cutoff: u32) -> Vec<(usize, usize)> {
        let found = Patches::new(graph).find(cutoff);
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
            // The way through the whole patch leaves each quadrilateral toward the next.
            for w in winding(graph, rows).windows(2) {
                assert_eq!(graph.twin(HalfEdge(w[0])).map(|t| graph.face_of(t)), Some(face(&w[1])));
            }
        }
        found.iter().map(|rows| (rows.len(), rows[0].len())).collect()
    }

    #[test]
    fn finds_the_largest_first_and_stops_at_the_cutoff() {
        assert_eq!(sizes(&grid(7, 3, false, |_, _| true), 5), [(3, 7)]);
        assert_eq!(sizes(&grid(2, 6, false, |_, _| true), 5), [(2, 6)], "rows run along the longer side");
        let corner_gone = grid(6, 4, false, |x, y| x < 3 || y < 2);
        assert_eq!(sizes(&corner_gone, 5), [(3, 4), (2, 3)]);
        assert_eq!(sizes(&corner_gone, 7), [(3, 4)]);
        assert_eq!(sizes(&grid(2, 2, false, |_, _| true), 5), []);
        assert_eq!(sizes(&grid(9, 2, true, |_, _| true), 5), [(2, 9)], "around a cylinder");
    }

    /// The area of the largest rectangle, by trying all.
    fn largest(width: u32, height: u32, kept: impl Fn(u32, u32) -> bool) -> usize {
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
        fn is_as_large_as_the_largest_found_by_trying_all(
            width in 1..8_u32, height in 1..8_u32, holes in any::<u64>(), cutoff in 1..12_u32,
        ) {
            let kept = |x: u32, y: u32| holes.wrapping_mul(0x9e37_79b9) >> ((y * 8 + x) % 61) & 3 != 0;
            let found = sizes(&grid(width, height, false, kept), cutoff);
            let area = largest(width, height, kept);
            let expected = (area >= cutoff as usize).then_some(area);
            prop_assert_eq!(found.first().map(|&(rows, columns)| rows * columns), expected);
            prop_assert!(found.iter().all(|&(rows, columns)| rows * columns >= cutoff as usize));
            prop_assert!(found.windows(2).all(|w| w[0].0 * w[0].1 >= w[1].0 * w[1].1), "largest first");
        }
    }
}
