//! A filter developed for this library: sends the valid triangles of a simplified strip in their
//! order, at the minimum cost for strips in this order.
//!
//! # Algorithm
//! The next valid triangle is linked to the last one if they share an edge with opposite
//! directions. The edge must not be the entry edge of the last triangle. A swap is sent only when a
//! link needs it. The last triangle is z x y, entered across z x:
//!
//! ```text
//!     y           across x y   w follows                            z x y w
//!    ╱ ╲          across z y   a swap changes the exit edge         z x z y w
//!   ╱   ╲         across z x   only if it is the first triangle: rotate it; all its links are free
//!  z─────x        otherwise    a new strip; rotate its first triangle to begin at an even position
//! ```
//! If the second triangle of a strip took a swap, the strip is reversed and the swap is omitted,
//! provided that reversing a strip of this length changes the parities of all its triangles.
//!
//! Strips are not joined by degenerate triangles: a join would send two degenerate triangles in a
//! row. Joining is part of the [layout](crate::strip::layout).
//!
//! A sequence of linked triangles therefore costs as much as the strip that
//! [`emit`](crate::strip::emit()) would send for its path. A link is always worthwhile: it costs
//! one vertex and at most two swaps, while a new strip costs three vertices and a restart. On a
//! surface with at most two triangles per edge, the result is never worse than that of
//! [`dtfs`](super::dtfs), which splits wherever the shared edge is not the last one.
//!
//! # References
//! Kim et al. 2005, section 4. Departures: rotations, links across other edges, and late swaps.
//!
//! # Complexity
//! O(n) time; at most three vertices per triangle.

use super::scanner::{Scanner, Sink};
use super::valid::{FIRST_KEY, Gatherer};

/// The state of the scan after a block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Linked {
    key: u32,
    /// The index of the simplified strip that contains the last triangle.
    strip: u32,
    run: DisplayStrip,
}

impl Default for Linked {
    fn default() -> Self {
        let run = DisplayStrip {
            last: [0; 3],
            is_even: true,
            count: SentTriangles::None,
            is_swapped_at_start: false,
        };
        Self { key: FIRST_KEY, strip: 0, run }
    }
}

impl Scanner for Linked {
    fn scan(&mut self, rest: &[u32], gatherer: &mut Gatherer, sink: &mut impl Sink) {
        for triangle in gatherer.gather(rest, &mut self.key) {
            let Some(&[a, b, c]) = rest[triangle.position as usize..].first_chunk() else { break };
            let oriented = if triangle.key % 2 == 0 { [a, b, c] } else { [b, a, c] };
            let strip = triangle.key / 2;
            if strip != self.strip || !self.run.link(oriented, sink) {
                self.run.end(sink);
                self.run.begin(oriented, sink);
            }
            self.strip = strip;
        }
    }

    fn end(&self, sink: &mut impl Sink) {
        self.run.end(sink);
    }
}

/// The open display strip.
#[derive(Debug, Clone, PartialEq)]
struct DisplayStrip {
    /// The last triangle sent, entered across its first two vertices unless it is the only one.
    last: [u32; 3],
    /// Whether an even number of vertices was sent.
    is_even: bool,
    count: SentTriangles,
    is_swapped_at_start: bool,
}

/// The number of triangles sent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum SentTriangles {
    None,
    One,
    Two,
    More,
}

impl DisplayStrip {
    fn begin(&mut self, triangle: [u32; 3], sink: &mut impl Sink) {
        triangle.into_iter().for_each(|vertex| sink.send(vertex));
        *self =
            Self { last: triangle, is_even: false, count: SentTriangles::One, is_swapped_at_start: false };
    }

    /// Sends a triangle if the last one can exit across an edge shared with it. Returns whether it
    /// did.
    fn link(&mut self, triangle: [u32; 3], sink: &mut impl Sink) -> bool {
        let [z, x, y] = self.last;
        if self.count == SentTriangles::One {
            // The last triangle is at an even position, so its vertices are in its winding order.
            for [z, x, y] in [[z, x, y], [x, y, z], [y, z, x]] {
                if let Some(w) = across(triangle, y, x) {
                    sink.replace_last([z, x, y]);
                    self.send([x, y, w], sink);
                    return true;
                }
            }
            return false;
        }
        // The last triangle is at an odd position if the number of vertices is even.
        let turned =
            |from, to| if self.is_even { across(triangle, to, from) } else { across(triangle, from, to) };
        if let Some(w) = turned(y, x) {
            self.send([x, y, w], sink);
            true
        } else if let Some(w) = turned(z, y) {
            sink.send_before_last(z);
            self.is_even = !self.is_even;
            self.is_swapped_at_start |= self.count == SentTriangles::Two;
            self.send([z, y, w], sink);
            true
        } else {
            false
        }
    }

    fn send(&mut self, triangle: [u32; 3], sink: &mut impl Sink) {
        sink.send(triangle[2]);
        self.last = triangle;
        self.is_even = !self.is_even;
        self.count = if self.count == SentTriangles::One { SentTriangles::Two } else { SentTriangles::More };
    }

    fn end(&self, sink: &mut impl Sink) {
        if self.count == SentTriangles::None {
            return;
        }
        if self.is_swapped_at_start && self.is_even {
            sink.reverse_open_strip();
        }
        sink.end();
    }
}

/// Returns the third vertex of a triangle that has the directed edge.
fn across(triangle: [u32; 3], from: u32, to: u32) -> Option<u32> {
    match triangle {
        [a, b, w] | [w, a, b] | [b, w, a] if a == from && b == to => Some(w),
        _ => None,
    }
}
