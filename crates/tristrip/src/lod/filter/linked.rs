//! Ours: the valid triangles of a simplified strip in their order, at the least cost that strips in this order have.
//!
//! # Algorithm
//! The next valid triangle is linked to the one sent last where the two share an edge, in opposite senses, that is not the one by which
//! that one was entered. A swap is sent when a link needs it, never ahead. The triangle sent last is z x y, entered across z x:
//!
//! ```text
//!     y           across x y   w follows                      z x y w
//!    ╱ ╲          across z y   the edge is turned by a swap   z x z y w
//!   ╱   ╲         across z x   only if it is the first of its strip, which is rotated: so its links are all free
//!  z─────x        else         a new strip, whose first triangle begins at an even place by a rotation, not a repeat
//! ```
//! A strip whose second triangle took a swap is read from its other end without it, where its length allows: the parities
//! of all its triangles then change with the direction.
//!
//! Strips are not joined by degenerate triangles, which would draw two of them in a row: that is a matter of the
//! [layout](crate::strip::layout).
//!
//! So a run of linked triangles costs what [`emit`](crate::strip::emit()) would send for its path. A link is always worth its while: one
//! vertex and at most two swaps more, where a new strip takes three vertices and a restart. So on a surface where at most two
//! triangles meet at an edge the result is never worse than that of [`dtfs`](super::dtfs), which splits wherever the shared edge is
//! not the last one.
//!
//! # References
//! Kim et al. 2005, section 4, which it follows but for rotations, links across other edges, and late swaps.
//!
//! # Complexity
//! O(n); at most three vertices a triangle.

use super::scanner::{Scanner, Sink};
use super::valid::{FIRST_KEY, Gatherer};

/// A scan that has come to the end of a block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Linked {
    key: u32,
    /// The strip of the triangle sent last.
    strip: u32,
    run: Run,
}

impl Default for Linked {
    fn default() -> Self {
        let run = Run { last: [0; 3], is_even: true, count: Count::None, is_swapped_at_start: false };
        Self { key: FIRST_KEY, strip: 0, run }
    }
}

impl Scanner for Linked {
    fn scan(&mut self, rest: &[u32], gatherer: &mut Gatherer, sink: &mut impl Sink) {
        for triangle in gatherer.gather(rest, &mut self.key) {
            let Some(&[a, b, c]) = rest[triangle.place as usize..].first_chunk() else { break };
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

/// The display strip that is being sent.
#[derive(Debug, Clone, PartialEq)]
struct Run {
    /// The vertices sent last, a triangle; entered across the first two unless it is the only one.
    last: [u32; 3],
    /// Whether an even number of vertices was sent.
    is_even: bool,
    count: Count,
    is_swapped_at_start: bool,
}

/// How many triangles were sent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Count {
    None,
    One,
    Two,
    More,
}

impl Run {
    fn begin(&mut self, triangle: [u32; 3], sink: &mut impl Sink) {
        triangle.into_iter().for_each(|vertex| sink.send(vertex));
        *self = Self { last: triangle, is_even: false, count: Count::One, is_swapped_at_start: false };
    }

    /// Sends a triangle after the last one, if they share an edge by which it can be left.
    fn link(&mut self, triangle: [u32; 3], sink: &mut impl Sink) -> bool {
        let [z, x, y] = self.last;
        if self.count == Count::One {
            // It stands at an even place, wound as it is sent.
            for [z, x, y] in [[z, x, y], [x, y, z], [y, z, x]] {
                if let Some(w) = across(triangle, y, x) {
                    sink.replace_last([z, x, y]);
                    self.send([x, y, w], sink);
                    return true;
                }
            }
            return false;
        }
        // The triangle sent last stands at an odd place after an even number of vertices.
        let turned =
            |from, to| if self.is_even { across(triangle, to, from) } else { across(triangle, from, to) };
        if let Some(w) = turned(y, x) {
            self.send([x, y, w], sink);
            true
        } else if let Some(w) = turned(z, y) {
            sink.send_before_last(z);
            self.is_even = !self.is_even;
            self.is_swapped_at_start |= self.count == Count::Two;
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
        self.count = if self.count == Count::One { Count::Two } else { Count::More };
    }

    fn end(&self, sink: &mut impl Sink) {
        if self.count == Count::None {
            return;
        }
        if self.is_swapped_at_start && self.is_even {
            sink.turn_round();
        }
        sink.end();
    }
}

/// Gives the third vertex of a triangle that has this edge, in this sense.
fn across(triangle: [u32; 3], from: u32, to: u32) -> Option<u32> {
    match triangle {
        [a, b, w] | [w, a, b] | [b, w, a] if a == from && b == to => Some(w),
        _ => None,
    }
}
