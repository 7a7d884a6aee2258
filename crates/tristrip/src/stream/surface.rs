//! The triangles decoded so far, with adjacency: a corner table whose vertices are fans.
//!
//! A *fan* is a run of triangles around a point. Each triangle shares an edge with the next one. A
//! fan is closed around an inner point and open at a border. A point where a surface touches
//! itself, or where attributes differ, has several fans. Edges are shared only within fans, so a
//! corner table exists for any set of triangles.
//!
//! ```text
//!        a₂ ───── a₁
//!       ╱  ╲     ╱  ╲
//!      ╱    ╲   ╱    ╲
//!    a₃ ───── k ───── a₀
//! ```
//! The corners around k are counterclockwise: (k a₀ a₁), (k a₁ a₂), … A split moves the triangles
//! of some consecutive corners to a new fan v, and adds the triangles S = (k aₛ v) before them and
//! E = (k v aₑ) after them.
//!
//! # Complexity
//! A split takes time proportional to the number of corners that move; 32 bytes per triangle and 4
//! per fan.

/// No corner: the edge has a single triangle.
pub(super) const NONE: u32 = u32::MAX;

/// Fans with more corners are not split, which bounds the time of a split.
pub(super) const MAX_CORNERS: usize = 1024;

/// Returns the next corner of the same triangle. The index is unpredictable, so a branch would be
/// expensive.
#[inline]
pub(super) fn next(corner: u32) -> u32 {
    corner + 1 - 3 * (corner >> 1 & 1)
}

/// Returns the previous corner of the same triangle.
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

/// Triangles with adjacency.
#[derive(Debug, Clone, Default)]
pub(super) struct StreamSurface {
    /// Eight cells per triangle: the fans of its three corners, a mark, the corners opposite to its
    /// corners, and an unused cell. A corner is the index of the cell of its fan.
    cells: Vec<u32>,
    /// A corner of each fan; the first one counterclockwise if the fan is open. [`NONE`] for a fan
    /// without triangles.
    pub(super) first: Vec<u32>,
}

/// The offset from the cell of a corner's fan to that of its opposite corner.
const OPPOSITE: u32 = 4;

impl StreamSurface {
    /// Builds the table of triangles from the opposite corner of each corner, with three corners
    /// per triangle. Fans are numbered in the order of their lowest corners.
    pub(super) fn new(opposite: &[u32]) -> Self {
        let corner = |i: u32| if i == NONE { NONE } else { 8 * (i / 3) + i % 3 };
        let mut surface = Self::default();
        for triangle in opposite.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| corner(triangle[i]));
            surface.cells.extend([NONE, NONE, NONE, 0, a, b, c, NONE]);
        }
        surface.number_fans();
        surface
    }

    /// Returns whether the corners of each triangle are in three different fans. Splits preserve
    /// this.
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

    /// Returns the number of triangles that fit into the reserved memory.
    pub(super) fn capacity(&self) -> usize {
        self.cells.capacity() / 8
    }

    /// Reserves memory for additional triangles and fans.
    pub(super) fn reserve(&mut self, triangles: usize, fans: usize) {
        self.cells.reserve_exact(8 * triangles);
        self.first.reserve_exact(fans);
    }

    /// Returns the eight cells of each triangle: its fans, a mark, the corners opposite to its
    /// corners, and an unused cell.
    pub(super) fn triangles(&self) -> impl Iterator<Item = &[u32; 8]> {
        self.cells.as_chunks::<8>().0.iter()
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

    /// Returns the corner on the other side of the edge opposite to a corner, or [`NONE`].
    #[inline]
    pub(super) fn opposite(&self, corner: u32) -> u32 {
        self.cells[(corner + OPPOSITE) as usize]
    }

    /// Returns the mark of the triangle of a corner; 0 unless it was set.
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

    /// Collects the corners of a fan counterclockwise, at most [`MAX_CORNERS`] + 1. `used` is the
    /// mark of triangles that are not free.
    #[inline]
    pub(super) fn ring(&self, fan: u32, used: u32, ring: &mut Ring) {
        ring.clear();
        let first = self.first[fan as usize];
        if first == NONE {
            return;
        }
        let (mut corner, mut n) = (first, 0);
        let last = loop {
            let at = (corner >> 3 << 3) as usize;
            let Some(cells) = self.cells[at..].first_chunk::<8>() else { return };
            let after = (next(corner) & 3) as usize;
            ring.free |= u32::from(cells[3] != used) << (n & 31);
            (ring.corners[n], ring.around[n]) = (corner, cells[after]);
            n += 1;
            let opposite = cells[after + OPPOSITE as usize];
            if opposite == NONE {
                break self.fan(previous(corner));
            }
            corner = next(opposite);
            if corner == first || n > MAX_CORNERS {
                ring.is_open = false;
                break ring.around[0];
            }
        };
        ring.around[n] = last;
        ring.length = n;
    }

    /// Returns whether a fan is open; `false` if it has no triangles.
    pub(super) fn is_open(&self, fan: u32) -> bool {
        let first = self.first[fan as usize];
        first != NONE && self.before(first).is_none()
    }

    /// Makes two corners opposite to each other. Either can be [`NONE`].
    pub(super) fn join(&mut self, a: u32, b: u32) {
        self.set_opposite(a, b);
        self.set_opposite(b, a);
    }

    /// Sets the opposite corner of a corner. Has no effect if the corner is [`NONE`].
    #[inline]
    fn set_opposite(&mut self, corner: u32, opposite: u32) {
        if corner != NONE {
            self.cells[(corner + OPPOSITE) as usize] = opposite;
        }
    }

    /// Returns the first corner of a corner's fan, or the corner itself if the fan is closed.
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

    /// Moves consecutive corners of a fan to a new fan, and adds the triangles before and after
    /// them, with a mark. `ring` is the ring of the fan, [repeated](Ring::repeat). Returns the
    /// first corners of the new triangles, which are corners of `fan`, or [`NONE`].
    pub(super) fn split(&mut self, fan: u32, ring: &Ring, split: Split, mark: u32) -> [u32; 2] {
        let Split { start, count, is_open, adds: [adds_start, adds_end] } = split;
        let new = self.first.len() as u32;
        let ([moved, around], all) = (ring.run(split), ring.corners());
        // 1. The edges on both sides of the corners that move. Each is identified by the opposite
        //    corner.
        let before = match start.checked_sub(1) {
            Some(before) => next(all[before]),
            None if is_open => NONE,
            None => next(all[all.len() - 1]),
        };
        let after = match all.get(start + count) {
            Some(&after) => previous(after),
            None if is_open => NONE,
            None => previous(all[start + count - all.len()]),
        };
        let (first, last) =
            (moved.first().map_or(NONE, |&c| previous(c)), moved.last().map_or(NONE, |&c| next(c)));
        let (start_fan, end_fan) = (around[0], around[around.len() - 1]);
        // 2. Move.
        moved.iter().for_each(|&corner| self.set_fan(corner, new));
        // 3. Add triangles. In S = (k aₛ v), the edge from aₛ to v is opposite to corner 0, that
        //    from v to k to corner 1, that from k to aₛ to corner 2. In E = (k v aₑ), the edge from
        //    v to aₑ is opposite to corner 0, that from aₑ to k to corner 1, that from k to v to
        //    corner 2.
        let corner = self.cells.len() as u32;
        let added = match [adds_start, adds_end] {
            [true, true] => [corner, corner + 8],
            [true, false] => [corner, NONE],
            [false, true] => [NONE, corner],
            [false, false] => [NONE, NONE],
        };
        let [of_start, of_end] = added;
        let [inner_start, inner_end] =
            if adds_start && adds_end { [of_start + 1, of_end + 2] } else { [NONE; 2] };
        if adds_start {
            self.cells.extend([fan, start_fan, new, mark, first, inner_end, before, NONE]);
            self.set_opposite(first, of_start);
            self.set_opposite(before, of_start + 2);
        }
        if adds_end {
            self.cells.extend([fan, new, end_fan, mark, last, after, inner_start, NONE]);
            self.set_opposite(last, of_end);
            self.set_opposite(after, of_end + 1);
        }
        // 4. The first corners. An open fan starts at the corner with nothing clockwise of it.
        if adds_end && after == NONE {
            self.first[end_fan as usize] = added[1] + 2;
        }
        if adds_start && count == 0 {
            self.first[start_fan as usize] = added[0] + 1;
        }
        let new_first =
            if adds_start { added[0] + 2 } else { moved.first().map_or(added[1] + 1, |&corner| corner) };
        self.first.push(new_first);
        let kept_first = match () {
            () if !is_open && adds_end => added[1],
            () if start > 0 => all[0],
            () if adds_start => added[0],
            () if adds_end => added[1],
            () => all[count % all.len()],
        };
        self.first[fan as usize] = kept_first;
        added
    }
}

/// A fan: its corners, and the fans at the other ends of its edges. An open fan has one edge more
/// than corners; for a closed one, the first fan is repeated at the end.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    length: usize,
    corners: Vec<u32>,
    around: Vec<u32>,
    pub(super) is_open: bool,
    /// A bit for each of the first 32 corners: whether it is free. Valid only if there are no more.
    pub(super) free: u32,
}

impl Ring {
    pub(super) fn new() -> Self {
        // Twice the size, so that runs can wrap around the last corner.
        let cells = vec![NONE; 2 * MAX_CORNERS + 2];
        Self { length: 0, corners: cells.clone(), around: cells, is_open: true, free: 0 }
    }

    fn clear(&mut self) {
        (self.length, self.is_open, self.free) = (0, true, 0);
    }

    #[inline]
    pub(super) fn corners(&self) -> &[u32] {
        &self.corners[..self.length]
    }

    #[inline]
    pub(super) fn around(&self) -> &[u32] {
        &self.around[..=self.length]
    }

    /// Repeats the first corners and fans after the last ones, as far as a split moves them.
    #[inline]
    pub(super) fn repeat(&mut self, split: Split) {
        for i in self.length..split.start + split.count {
            self.corners[i] = self.corners[i - self.length];
            self.around[i + 1] = self.around[i + 1 - self.length];
        }
    }

    /// Returns the corners that a split moves, which must be [repeated](Self::repeat), and the fans
    /// around them: one more than corners.
    #[inline]
    pub(super) fn run(&self, split: Split) -> [&[u32]; 2] {
        let (start, end) = (split.start, split.start + split.count);
        [&self.corners[start..end], &self.around[start..=end]]
    }
}

/// A split of a fan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Split {
    /// The index of the first corner that moves.
    pub(super) start: usize,
    /// The number of corners that move.
    pub(super) count: usize,
    pub(super) is_open: bool,
    /// Whether a triangle is added before and after these corners.
    pub(super) adds: [bool; 2],
}

#[cfg(test)]
mod tests;
