//! The degenerate triangle-free scanner: only valid triangles are sent, and a new strip starts
//! where two of them are not consecutive.
//!
//! # Algorithm
//! Read three vertices at a time; skip them unless all are different. The cases for a valid
//! triangle (d e f) after a valid triangle (a b c) are:
//!
//! ```text
//! regular   b = d and c = e, at a position of the other parity  sends f        a b c f
//! swap      b = e and c = d, at a position of the same parity   sends b f      a b c b f
//! split     otherwise, at an even position                      a new strip    a b c │ d e f
//! split     otherwise, at an odd position                       a new strip    a b c │ d d e f
//! ```
//! The paper has no conditions on the parities, because on an oriented surface they follow from the
//! vertices. Where more than two triangles share an edge, the parities may not match; the scanner
//! then starts a new strip. A strip that begins at an odd position repeats its first vertex. The
//! paper says that this vertex is overridden for a consistent orientation. The paper counts it in
//! its results but not in its figure 8 (`502 615 206 620 │ 620 580 66 761`, where the second strip
//! begins at an odd position). [`DrawCost`](super::DrawCost) contains both counts.
//!
//! A straightforward scanner spends most of its time on mispredicted branches. Here, valid
//! triangles are gathered without branches. Each of them sends a suffix of the word d d e f. Only
//! the length of the suffix depends on the case:
//!
//! ```text
//! d d e f     new strip at an odd position
//!   d e f     new strip at an even position
//!     e f     swap, where e is b
//!       f     regular
//! ```
//! A block is written from its end to its beginning. The unsent part of a word is overwritten by
//! the word of the previous triangle.
//!
//! # References
//! Kim et al. 2005, section 4.
//!
//! # Complexity
//! O(n) time; at most four vertices per triangle.

#![allow(clippy::needless_bitwise_bool, reason = "a lazy operator would be a branch")]

use super::scanner::{Scanner, Sink};
use super::valid::{BLOCK, FIRST_KEY, Gatherer, Valid};

/// The state of the scan after a block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Dtfs {
    key: u32,
    before: Triangle,
    is_begun: bool,
}

impl Default for Dtfs {
    fn default() -> Self {
        Self { key: FIRST_KEY, before: Triangle::NONE, is_begun: false }
    }
}

impl Scanner for Dtfs {
    fn scan(&mut self, rest: &[u32], gatherer: &mut Gatherer, sink: &mut impl Sink) {
        let valid = gatherer.gather(rest, &mut self.key);
        let Some(last) = valid.last() else { return };
        let mut words = [0; 4 * BLOCK];
        // The starts of display strips in `words`, last one first.
        let mut starts = [0; BLOCK];
        let (mut at, mut begun, mut repeats) = (words.len(), 0, 0);
        let last = Triangle::of(rest, *last);
        let mut now = last;
        for i in (0..valid.len()).rev() {
            let previous = if i == 0 { self.before } else { Triangle::of(rest, valid[i - 1]) };
            let (is_regular, is_new) = now.follows(&previous);
            let is_repeat = is_new & (now.key % 2 == 1);
            let [d, e, f] = now.vertices;
            if let Some(word) = words[..at].last_chunk_mut() {
                *word = [d, d, e, f];
            }
            at -= 1 + usize::from(!is_regular) + usize::from(is_new) + usize::from(is_repeat);
            starts[begun % BLOCK] = at as u32;
            begun += usize::from(is_new);
            repeats += usize::from(is_repeat);
            now = previous;
        }
        let starts = starts[..begun].iter().rev().map(|start| start - at as u32);
        sink.send_block(&words[at..], starts, repeats, self.is_begun);
        self.before = last;
        self.is_begun = true;
    }

    fn end(&self, sink: &mut impl Sink) {
        if self.is_begun {
            sink.end();
        }
    }
}

/// A valid triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Triangle {
    vertices: [u32; 3],
    key: u32,
}

impl Triangle {
    /// A triangle that no other can follow, because no strip has its key.
    const NONE: Self = Self { vertices: [0; 3], key: 0 };

    fn of(rest: &[u32], valid: Valid) -> Self {
        let w = &rest[valid.position as usize..][..3];
        Self { vertices: [w[0], w[1], w[2]], key: valid.key }
    }

    /// Returns whether this triangle is the regular case after another one, and whether it is a
    /// split.
    fn follows(&self, previous: &Self) -> (bool, bool) {
        let ([_, b, c], [d, e, _]) = (previous.vertices, self.vertices);
        let is_regular = (b == d) & (c == e) & (self.key == previous.key ^ 1);
        let is_swap = (b == e) & (c == d) & (self.key == previous.key);
        (is_regular, !(is_regular | is_swap))
    }
}
