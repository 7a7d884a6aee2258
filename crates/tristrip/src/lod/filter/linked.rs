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

use super::Sink;
use super::valid::{Gatherer, blocks};

/// Scans the strips of an index map.
pub(super) fn scan(map: &[u32], sink: &mut impl Sink) {
    let mut run = Run { last: [0; 3], length: 0, triangles: 0, is_swapped_at_start: false };
    let (mut gatherer, mut strip) = (Gatherer::new(), 0);
    for block in blocks(map) {
        for triangle in gatherer.gather(block) {
            let Some(&[a, b, c]) = block[triangle.place as usize..].first_chunk() else { break };
            let oriented = if triangle.key % 2 == 0 { [a, b, c] } else { [b, a, c] };
            let is_new = std::mem::replace(&mut strip, triangle.key / 2) != strip;
            if is_new || !run.link(oriented, sink) {
                run.end(sink);
                run.begin(oriented, sink);
            }
        }
    }
    run.end(sink);
}

/// The display strip that is being sent.
struct Run {
    /// The vertices sent last, a triangle; entered across the first two unless it is the only one.
    last: [u32; 3],
    /// Vertices sent.
    length: usize,
    triangles: usize,
    is_swapped_at_start: bool,
}

impl Run {
    fn begin(&mut self, triangle: [u32; 3], sink: &mut impl Sink) {
        triangle.into_iter().for_each(|vertex| sink.send(vertex));
        *self = Self { last: triangle, length: 3, triangles: 1, is_swapped_at_start: false };
    }

    /// Sends a triangle after the last one, if they share an edge by which it can be left.
    fn link(&mut self, triangle: [u32; 3], sink: &mut impl Sink) -> bool {
        let [z, x, y] = self.last;
        if self.triangles == 1 {
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
        let is_odd = self.length.is_multiple_of(2);
        let turned = |from, to| if is_odd { across(triangle, to, from) } else { across(triangle, from, to) };
        if let Some(w) = turned(y, x) {
            self.send([x, y, w], sink);
            true
        } else if let Some(w) = turned(z, y) {
            sink.send_before_last(z);
            self.length += 1;
            self.is_swapped_at_start |= self.triangles == 2;
            self.send([z, y, w], sink);
            true
        } else {
            false
        }
    }

    fn send(&mut self, triangle: [u32; 3], sink: &mut impl Sink) {
        sink.send(triangle[2]);
        self.last = triangle;
        self.length += 1;
        self.triangles += 1;
    }

    fn end(&mut self, sink: &mut impl Sink) {
        if self.triangles == 0 {
            return;
        }
        if self.is_swapped_at_start && self.length.is_multiple_of(2) {
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
