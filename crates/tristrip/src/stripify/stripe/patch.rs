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
//! The paper walks over the faces once for each patch. Here a round takes many. After a fixed amount of work for
//! each quadrilateral a round takes patches of half the largest's size, too, so that the time stays linear whatever comes.
//!
//! # References
//! See [`super`], section 3.2 of the paper.
//!
//! # Complexity
//! O(n) for each round; at most `EXACT_ROUNDS` + 2 log n rounds. At most 40 bytes a quadrilateral.

use crate::dual::{DualGraph, FaceId, HalfEdge};

const NONE: u32 = u32::MAX;
/// Quadrilaterals looked at, for each of the model, before a round may take patches that are not the largest.
const EXACT_ROUNDS: usize = 64;

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

/// Finds patches.
#[derive(Debug)]
pub(super) struct Patches<'a> {
    graph: &'a DualGraph,
    /// Whether a face is a quadrilateral that is in no patch.
    free: Vec<bool>,
    quads: Vec<u32>,
    /// By heading.
    rung: Vec<u32>,
}

impl<'a> Patches<'a> {
    pub(super) fn new(graph: &'a DualGraph) -> Self {
        let is_quad = |face: &u32| graph.half_edges(FaceId(*face)).count() == 4;
        let quads: Vec<u32> = (0..graph.face_count() as u32).filter(is_quad).collect();
        let mut free = vec![false; graph.face_count()];
        quads.iter().for_each(|&face| free[face as usize] = true);
        Self { graph, free, quads, rung: vec![0; graph.half_edge_count()] }
    }

    /// Finds all patches of at least `cutoff` quadrilaterals, in the order in which they are found. Each is given as its rows,
    /// and these as the headings of their quadrilaterals from west to east.
    pub(super) fn find(mut self, cutoff: u32) -> Vec<Vec<Vec<u32>>> {
        let mut found = Vec::new();
        let mut work = 0;
        let budget = EXACT_ROUNDS * self.quads.len();
        loop {
            self.quads.retain(|&face| self.free[face as usize]);
            work += self.quads.len();
            self.measure();
            let share = if work <= budget { 1 } else { 2 };
            let mut candidates = self.candidates(u64::from(cutoff.max(1)), share);
            candidates.sort_by_key(|patch| std::cmp::Reverse(patch.area()));
            let before = found.len();
            for (i, patch) in candidates.into_iter().enumerate() {
                found.extend(self.claim(patch, cutoff.max(1), i > 0));
            }
            if found.len() == before {
                return found;
            }
        }
    }

    /// The half-edge of the same quadrilateral, `turns` corners on.
    #[inline]
    fn around(&self, half_edge: u32, turns: u32) -> u32 {
        around(self.graph, half_edge, turns)
    }

    /// The edge by which a heading enters the next quadrilateral, if there is one.
    #[inline]
    fn enters(&self, heading: u32) -> Option<u32> {
        let twin = self.graph.twin(HalfEdge(heading))?;
        self.free[self.graph.face_of(twin).0 as usize].then_some(twin.0)
    }

    /// The same heading one quadrilateral on.
    #[inline]
    fn ahead(&self, heading: u32) -> Option<u32> {
        self.enters(heading).map(|h| self.around(h, 2))
    }

    /// The eastward heading of the quadrilateral to the north.
    #[inline]
    fn north(&self, heading: u32) -> Option<u32> {
        self.enters(self.around(heading, 1)).map(|h| self.around(h, 1))
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
        let headings = || self.quads.iter().flat_map(|&face| self.graph.half_edges(FaceId(face)));
        headings().for_each(|h| rung[h.0 as usize] = 0);
        let mut column = Vec::new();
        for h in headings().filter(|h| self.enters(h.0).is_some()) {
            // Northward to the end or to what is known; where it comes around, all are on the same ring.
            column.clear();
            let mut at = Some(h.0);
            while let Some(h) = at.filter(|&h| rung[h as usize] == 0) {
                rung[h as usize] = NONE;
                column.push(h);
                at = self.rung_above(h);
            }
            let around = at.is_some_and(|h| rung[h as usize] == NONE);
            let mut height = at.filter(|_| !around).map_or(0, |h| rung[h as usize]);
            for &h in column.iter().rev() {
                height += 1;
                rung[h as usize] = if around { column.len() as u32 } else { height };
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
            if area < cutoff || area < largest / share {
                return;
            }
            if area > largest && share == 1 {
                found.clear();
            }
            largest = largest.max(area);
            found.push(patch);
        };
        let mut seen = vec![false; self.rung.len()];
        let mut line = Vec::new();
        let mut stack: Vec<(usize, u32)> = Vec::new();
        // Lines that have a beginning first; closed ones begin anywhere.
        for closed in [false, true] {
            for &face in &self.quads {
                for h in self.graph.half_edges(FaceId(face)).map(|h| h.0) {
                    let begins = self.enters(self.around(h, 2)).is_none();
                    if seen[h as usize] || !(closed || begins) {
                        continue;
                    }
                    line.clear();
                    let mut next = Some(h);
                    while let Some(heading) = next.filter(|&heading| !seen[heading as usize]) {
                        seen[heading as usize] = true;
                        line.push(heading);
                        next = self.ahead(heading);
                    }
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
            }
        }
        found.retain(|patch| patch.area() >= largest / share);
        found
    }

    /// Step 3: takes a patch; `None` where it meets another one. What is left of the patch where its lines cross themselves
    /// will do if there is no `other`.
    fn claim(&mut self, patch: Patch, cutoff: u32, other: bool) -> Option<Vec<Vec<u32>>> {
        let mut rows: Vec<Vec<u32>> = Vec::new();
        let (mut first, mut width) = (Some(patch.corner), patch.width as usize);
        while let Some(start) = first.filter(|_| rows.len() < patch.height as usize) {
            let mut row = Vec::with_capacity(width);
            let mut heading = Some(start);
            while let Some(h) = heading.filter(|_| row.len() < width) {
                let face = self.graph.face_of(HalfEdge(h)).0 as usize;
                if !std::mem::take(&mut self.free[face]) {
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
        if area < u64::from(cutoff) || (other && area < patch.area()) {
            rows.iter().for_each(|row| self.release(row));
            return None;
        }
        if rows.len() > width {
            // Columns are longer: the patch is turned around its north-west corner.
            let column = |i: usize| rows.iter().map(|row| self.around(row[i], 1)).collect();
            rows = (0..width).rev().map(column).collect();
        }
        Some(rows)
    }

    fn release(&mut self, row: &[u32]) {
        row.iter().for_each(|&h| self.free[self.graph.face_of(HalfEdge(h)).0 as usize] = true);
    }
}

/// The headings of a path through all rows of a patch, every other row from east to west.
pub(super) fn winding(graph: &DualGraph, rows: &[Vec<u32>]) -> Vec<u32> {
    let mut way = Vec::with_capacity(rows.iter().map(Vec::len).sum());
    for (i, row) in rows.iter().enumerate() {
        let northward = if i % 2 == 0 { 1 } else { 3 };
        if i % 2 == 0 {
            way.extend_from_slice(row);
        } else {
            way.extend(row.iter().rev().map(|&h| around(graph, h, 2)));
        }
        if let Some(last) = way.last_mut() {
            *last = around(graph, *last, northward);
        }
    }
    way
}

/// The half-edge of the same quadrilateral, `turns` corners on.
#[inline]
fn around(graph: &DualGraph, half_edge: u32, turns: u32) -> u32 {
    let first = graph.half_edges(graph.face_of(HalfEdge(half_edge))).next().map_or(0, |h| h.0);
    first + ((half_edge - first + turns) & 3)
}
