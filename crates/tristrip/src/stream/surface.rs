//! The triangles that a stream has built so far, with their neighbours: a corner table whose vertices are fans.
//!
//! A *fan* is a run of triangles around a point in which each shares an edge with the next: closed around an inner point, open on a border. A point where a
//! surface touches itself, or at which attributes differ, has several fans. Edges are shared within fans only, so that any set of triangles has a table.
//!
//! ```text
//!        a₂ ───── a₁              The corners around k, counterclockwise: (k a₀ a₁), (k a₁ a₂), …
//!       ╱  ╲     ╱  ╲
//!      ╱    ╲   ╱    ╲            A split moves the triangles of some successive corners to a new fan v, and adds the triangles
//!    a₃ ───── k ───── a₀          S = (k aₛ v) before them and E = (k v aₑ) after them.
//! ```
//! A triangle has four places in the table: three corners, and what its user keeps with it.
//!
//! # Complexity
//! A split takes time in proportion to the corners that move; 32 bytes per triangle and 4 per fan.

/// No corner: an edge of one triangle.
pub(super) const NONE: u32 = u32::MAX;

/// A fan of more corners is not split, so that the time of a split has a bound.
pub(super) const MOST_CORNERS: usize = 1024;

/// Returns the next corner of the same triangle. Which one it is cannot be predicted, so that a branch would be expensive.
#[inline]
pub(super) fn next(corner: u32) -> u32 {
    corner + 1 - 3 * (corner >> 1 & 1)
}

/// Returns the corner before in the same triangle.
#[inline]
pub(super) fn previous(corner: u32) -> u32 {
    corner + 2 - 3 * ((corner | corner >> 1) & 1)
}

/// Returns the triangle of a corner.
#[inline]
pub(super) fn triangle_of(corner: u32) -> u32 {
    corner >> 3
}

/// Returns the corners of a triangle.
#[inline]
pub(super) fn corners_of(triangle: u32) -> std::ops::Range<u32> {
    triangle << 3..(triangle << 3) + 3
}

/// Triangles with neighbours.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    /// Eight cells for each triangle: the fans of its three corners, a mark, what is opposite to its corners, and one that is not used. A corner is the
    /// place of its fan.
    cells: Vec<u32>,
    /// A corner of each fan, the first one counterclockwise if the fan is open; none of a fan without triangles.
    pub(super) first: Vec<u32>,
}

/// From the cell of a corner's fan to that of what is opposite.
const OPPOSITE: u32 = 4;

impl Surface {
    /// Builds the table of triangles from what is opposite to each corner, where corners are counted three to a triangle. The fans get numbers in the order
    /// of their lowest corners.
    pub(super) fn new(opposite: &[u32]) -> Self {
        let corner = |i: u32| if i == NONE { NONE } else { 8 * (i / 3) + i % 3 };
        let mut surface = Self::default();
        for triangle in opposite.chunks_exact(3) {
            surface.push([NONE; 3]);
            let first = surface.cells.len() - 4;
            (0..3).for_each(|i| surface.cells[first + i] = corner(triangle[i]));
        }
        surface.number_fans();
        surface
    }

    /// Returns whether the corners of each triangle are in three fans. Splits keep it so.
    pub(super) fn has_distinct_fans(&self) -> bool {
        let fans = |triangle: &[u32]| [triangle[0], triangle[1], triangle[2]];
        self.cells.chunks_exact(8).map(fans).all(|[a, b, c]| a != b && b != c && a != c)
    }

    /// Returns the number of triangles.
    pub(super) fn triangle_count(&self) -> usize {
        self.cells.len() >> 3
    }

    /// Returns the memory in bytes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.cells[..]) + size_of_val(&self.first[..])
    }

    /// Returns all corners.
    pub(super) fn corners(&self) -> impl Iterator<Item = u32> + use<> {
        (0..self.triangle_count() as u32).flat_map(corners_of)
    }

    /// Returns the fan of a corner.
    #[inline]
    pub(super) fn fan(&self, corner: u32) -> u32 {
        self.cells[corner as usize]
    }

    #[inline]
    pub(super) fn set_fan(&mut self, corner: u32, fan: u32) {
        self.cells[corner as usize] = fan;
    }

    /// Returns the corner on the other side of the edge opposite to a corner, or none.
    #[inline]
    pub(super) fn opposite(&self, corner: u32) -> u32 {
        self.cells[(corner + OPPOSITE) as usize]
    }

    /// Returns the mark of the triangle of a corner: 0 unless it was set.
    #[inline]
    pub(super) fn mark(&self, corner: u32) -> u32 {
        self.cells[(corner | 3) as usize]
    }

    #[inline]
    pub(super) fn set_mark(&mut self, corner: u32, mark: u32) {
        self.cells[(corner | 3) as usize] = mark;
    }

    /// Returns the next corner counterclockwise around the fan of a corner.
    #[inline]
    pub(super) fn after(&self, corner: u32) -> Option<u32> {
        let opposite = self.opposite(next(corner));
        (opposite != NONE).then(|| next(opposite))
    }

    /// Returns the next corner clockwise around the fan of a corner.
    #[inline]
    pub(super) fn before(&self, corner: u32) -> Option<u32> {
        let opposite = self.opposite(previous(corner));
        (opposite != NONE).then(|| previous(opposite))
    }

    /// Collects the corners of a fan counterclockwise, at most [`MOST_CORNERS`] and one more; returns whether the fan is open, if it has not more.
    #[inline]
    pub(super) fn ring(&self, fan: u32, ring: &mut Vec<u32>) -> bool {
        ring.clear();
        let first = self.first[fan as usize];
        let mut at = (first != NONE).then_some(first);
        while let Some(corner) = at {
            ring.push(corner);
            at = self.after(corner);
            if at == Some(first) || ring.len() > MOST_CORNERS {
                return false;
            }
        }
        true
    }

    /// Returns whether a fan is open; of one without triangles false.
    pub(super) fn is_open(&self, fan: u32) -> bool {
        let first = self.first[fan as usize];
        first != NONE && self.before(first).is_none()
    }

    /// Makes two corners opposite to each other; one of them may be none.
    pub(super) fn join(&mut self, a: u32, b: u32) {
        if a != NONE {
            self.cells[(a + OPPOSITE) as usize] = b;
        }
        if b != NONE {
            self.cells[(b + OPPOSITE) as usize] = a;
        }
    }

    /// Returns the corner with which the fan of a corner starts: this one if the fan is closed.
    pub(super) fn first_around(&self, corner: u32) -> u32 {
        let mut first = corner;
        while let Some(before) = self.before(first) {
            first = before;
            if first == corner {
                break;
            }
        }
        first
    }

    /// Numbers the fans of all corners in the order of their lowest corners.
    fn number_fans(&mut self) {
        for corner in self.corners() {
            if self.fan(corner) != NONE {
                continue;
            }
            let fan = self.first.len() as u32;
            let first = self.first_around(corner);
            self.first.push(first);
            let mut at = Some(first);
            while let Some(corner) = at.filter(|&corner| self.fan(corner) == NONE) {
                self.set_fan(corner, fan);
                at = self.after(corner);
            }
        }
    }

    /// Appends a triangle without neighbours; returns its first corner.
    pub(super) fn push(&mut self, fans: [u32; 3]) -> u32 {
        let corner = self.cells.len() as u32;
        let [a, b, c] = fans;
        self.cells.extend([a, b, c, 0, NONE, NONE, NONE, NONE]);
        corner
    }

    /// Moves the successive `corners` of a fan to a new fan, and adds the triangles before and after them. `ring` are all corners of the fan, from `start` on
    /// `count` of which move. Returns the first corners of the new triangles, which are corners of `fan`.
    pub(super) fn split(&mut self, fan: u32, ring: &[u32], split: Split) -> [u32; 2] {
        let Split { start, count, is_open, adds: [adds_start, adds_end] } = split;
        let new = self.first.len() as u32;
        let n = ring.len();
        let at = |i: usize| if i >= n { ring[i - n] } else { ring[i] };
        // 1. The edges on both sides of the corners that move. Each is named by the corner opposite to it.
        let before = match (start, is_open) {
            (0, true) => NONE,
            (0, false) => next(ring[n - 1]),
            _ => next(ring[start - 1]),
        };
        let after = match (start + count, is_open) {
            (end, true) if end == n => NONE,
            (end, _) => previous(at(end)),
        };
        let [first, last] =
            if count == 0 { [NONE; 2] } else { [previous(at(start)), next(at(start + count - 1))] };
        let start_fan = match (count, before) {
            (0, NONE) => NONE,
            (0, _) => self.fan(next(before)),
            _ => self.fan(next(at(start))),
        };
        let end_fan = match (count, after) {
            (0, NONE) => NONE,
            (0, _) => self.fan(previous(after)),
            _ => self.fan(previous(at(start + count - 1))),
        };
        // 2. Move.
        for i in start..start + count {
            self.set_fan(at(i), new);
        }
        // 3. Add. In S = (k aₛ v), the edge to v is opposite to corner 0, that from v to k to corner 1, that from k to corner 2.
        let mut added = [NONE; 2];
        if adds_start {
            let corner = self.push([fan, start_fan, new]);
            self.join(corner + 2, before);
            self.join(corner, first);
            added[0] = corner;
        }
        // In E = (k v aₑ), the edge from v to aₑ is opposite to corner 0, that from aₑ to k to corner 1, that from k to v to corner 2.
        if adds_end {
            let corner = self.push([fan, new, end_fan]);
            self.join(corner + 1, after);
            self.join(corner, last);
            added[1] = corner;
        }
        match added {
            [start, end] if start != NONE && end != NONE => self.join(start + 1, end + 2),
            _ => (),
        }
        // 4. The first corners. An open fan starts where there is nothing clockwise.
        if adds_end && after == NONE {
            self.first[end_fan as usize] = added[1] + 2;
        }
        if adds_start && count == 0 {
            self.first[start_fan as usize] = added[0] + 1;
        }
        let new_first = if adds_start {
            added[0] + 2
        } else if count > 0 {
            at(start)
        } else {
            added[1] + 1
        };
        self.first.push(new_first);
        let kept_first = match () {
            () if !is_open && adds_end => added[1],
            () if start > 0 => ring[0],
            () if adds_start => added[0],
            () if adds_end => added[1],
            () => at(count),
        };
        self.first[fan as usize] = kept_first;
        added
    }
}

/// What a split of a fan does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Split {
    /// The first of the corners that move.
    pub(super) start: usize,
    /// How many corners move.
    pub(super) count: usize,
    pub(super) is_open: bool,
    /// Whether a triangle is added before and after these corners.
    pub(super) adds: [bool; 2],
}

#[cfg(test)]
mod tests;
