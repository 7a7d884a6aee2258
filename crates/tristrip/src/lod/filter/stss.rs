//! The simple triangle strip scanner: pairs of vertices that repeat at once, (a a)+ and (a b)+, are sent once.
//!
//! # Algorithm
//! Four vertices are read. Where the first two are the last two as well, the scanner goes on at the third without sending
//! the first two; else it sends the first vertex and goes on at the second.
//!
//! Two vertices less change no parity, and only the two degenerate triangles that begin with them are gone: so the windings stand,
//! though neither paper speaks of them. Waste such as (a a b b) or (a b b c) is sent, and also what stands at a strip's ends.
//!
//! # The published example
//! Figure 8 of Kim et al. prints, for a strip of 26 vertices, 11 that the scanner sends:
//! `615 615 502 615 206 620 620 580 66 761 258`. The rules give 14: pairs leave three of five equal vertices, and at the end
//! `761 761 258 761`. A pass that first shortens runs of equal vertices to two would give the printed list up to `66`; nothing gives
//! its end. Nor would it do: two triangles of the printed strip have the wrong winding, since a run of five lost three, and a third,
//! `66 761 258`, is not in the mesh.
//!
//! # References
//! El-Sana et al. 2000, section 5.4; Kim et al. 2005, section 2.3, and 5, where it reads four vertices at a time.
//!
//! # Complexity
//! O(n).

use super::scanner::{Scanner, Sink};
use super::valid::{BLOCK, Gatherer};
use crate::lod::index_map::RESTART;

/// A scan that has come to the end of a block.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Stss {
    /// Places of the next block that are done.
    done: usize,
    /// Whether something of the strip was sent.
    is_begun: bool,
}

impl Scanner for Stss {
    fn scan(&mut self, rest: &[u32], _: &mut Gatherer, sink: &mut impl Sink) {
        let mut place = self.done;
        while place < BLOCK {
            match rest[place..] {
                [RESTART, ..] => {
                    self.end(sink);
                    self.is_begun = false;
                    place += 1;
                }
                [a, b, c, d, ..] if a == c && b == d && b != RESTART => place += 2,
                [a, ..] => {
                    sink.send(a);
                    self.is_begun = true;
                    place += 1;
                }
                [] => return,
            }
        }
        self.done = place - BLOCK;
    }

    fn end(&self, sink: &mut impl Sink) {
        if self.is_begun {
            sink.end();
        }
    }
}
