//! Shared code of the filters: scans of an index map, and the sinks that store or count display
//! strips.

use super::valid::{BLOCK, Gatherer};
use crate::strip::Strips;

/// The cost of display strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct DrawCost {
    /// Vertices sent, including swaps and winding repeats.
    pub vertices: usize,
    /// Display strips.
    pub strips: usize,
    /// Vertices that strips repeat at their start to preserve the winding; included in `vertices`.
    pub winding_repeats: usize,
}

/// A scan of an index map, block by block. The value is the state between two blocks: from equal
/// states, scans continue identically.
pub(crate) trait Scanner: Clone + PartialEq + Default {
    /// Scans the first block of `rest`.
    fn scan(&mut self, rest: &[u32], gatherer: &mut Gatherer, sink: &mut impl Sink);

    /// Ends the open strip after the last block.
    fn end(&self, sink: &mut impl Sink);

    /// Scans a whole map.
    fn scan_all(mut self, map: &[u32], sink: &mut impl Sink) {
        let mut gatherer = Gatherer::new();
        (0..map.len()).step_by(BLOCK).for_each(|start| self.scan(&map[start..], &mut gatherer, sink));
        self.end(sink);
    }
}

/// Receives display strips, and stores or only counts them.
pub(crate) trait Sink {
    /// Sends a vertex.
    fn send(&mut self, vertex: u32);
    /// Sends vertices.
    fn send_all(&mut self, vertices: &[u32]);
    /// Sends vertices of display strips that begin at `starts`. Unless a strip `is_begun`, the
    /// first start is the first vertex.
    fn send_block(
        &mut self,
        vertices: &[u32],
        starts: impl ExactSizeIterator<Item = u32>,
        winding_repeats: usize,
        is_begun: bool,
    );
    /// Inserts a vertex before the last one.
    fn send_before_last(&mut self, vertex: u32);
    /// Replaces the last three vertices.
    fn replace_last(&mut self, vertices: [u32; 3]);
    /// Reverses the open strip, without the swap of its second triangle.
    fn reverse_open_strip(&mut self);
    /// Ends a display strip.
    fn end(&mut self);
}

/// The cost of a part of a scan. It can be negative, because a strip can become cheaper when it
/// ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct DrawTally {
    pub(crate) vertices: isize,
    pub(crate) strips: isize,
    pub(crate) winding_repeats: isize,
}

impl From<DrawTally> for DrawCost {
    fn from(tally: DrawTally) -> Self {
        let count = |count: isize| usize::try_from(count).unwrap_or(0);
        Self {
            vertices: count(tally.vertices),
            strips: count(tally.strips),
            winding_repeats: count(tally.winding_repeats),
        }
    }
}

impl Sink for DrawTally {
    fn send(&mut self, _: u32) {
        self.vertices += 1;
    }

    fn send_all(&mut self, vertices: &[u32]) {
        self.vertices += vertices.len().cast_signed();
    }

    fn send_block(
        &mut self,
        vertices: &[u32],
        starts: impl ExactSizeIterator<Item = u32>,
        winding_repeats: usize,
        is_begun: bool,
    ) {
        self.vertices += vertices.len().cast_signed();
        self.strips += starts.len().cast_signed() - isize::from(!is_begun);
        self.winding_repeats += winding_repeats.cast_signed();
    }

    fn send_before_last(&mut self, _: u32) {
        self.vertices += 1;
    }

    fn replace_last(&mut self, _: [u32; 3]) {}

    fn reverse_open_strip(&mut self) {
        self.vertices -= 1;
    }

    fn end(&mut self) {
        self.strips += 1;
    }
}

/// Replaces the last vertex of a strip and returns the old one.
pub(crate) fn replace_last_vertex(strip: &mut [u32], vertex: u32) -> Option<u32> {
    strip.last_mut().map(|last| std::mem::replace(last, vertex))
}

/// Replaces the last three vertices of a strip.
pub(crate) fn replace_last_triangle(strip: &mut [u32], vertices: [u32; 3]) {
    if let Some(last) = strip.last_chunk_mut() {
        *last = vertices;
    }
}

/// Reverses a strip v0 v1 v2 v1 w … to … w v1 v2 v0 v1. The caller drops the last vertex.
pub(crate) fn reverse_but_for_start(strip: &mut [u32]) {
    strip.reverse();
    if let [.., second, first] = strip {
        std::mem::swap(second, first);
    }
}

impl Sink for Strips {
    fn send(&mut self, vertex: u32) {
        self.send_vertex(vertex);
    }

    fn send_all(&mut self, vertices: &[u32]) {
        self.send_block_of(vertices, []);
    }

    fn send_block(
        &mut self,
        vertices: &[u32],
        starts: impl ExactSizeIterator<Item = u32>,
        _: usize,
        is_begun: bool,
    ) {
        self.send_block_of(vertices, starts.skip(usize::from(!is_begun)));
    }

    fn send_before_last(&mut self, vertex: u32) {
        if let Some(last) = replace_last_vertex(self.open_strip(), vertex) {
            self.send_vertex(last);
        }
    }

    fn replace_last(&mut self, vertices: [u32; 3]) {
        replace_last_triangle(self.open_strip(), vertices);
    }

    fn reverse_open_strip(&mut self) {
        reverse_but_for_start(self.open_strip());
        self.drop_last_vertex();
    }

    fn end(&mut self) {
        self.end_strip();
    }
}

impl std::ops::AddAssign for DrawCost {
    fn add_assign(&mut self, other: Self) {
        self.vertices += other.vertices;
        self.strips += other.strips;
        self.winding_repeats += other.winding_repeats;
    }
}

impl std::ops::Add for DrawCost {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl std::iter::Sum for DrawCost {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), |sum, count| sum + count)
    }
}
