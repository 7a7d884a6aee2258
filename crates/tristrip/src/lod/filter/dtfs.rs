//! The degenerate triangle-free scanner: only valid triangles are sent, with a new strip where two of them do not follow on each other.
//!
//! # Algorithm
//! Three vertices are read at a time, and passed over unless all are different. A valid triangle (d e f) after a valid one (a b c) is
//!
//! ```text
//! regular   b = d and c = e, at a place of the other parity   sends f        a b c f
//! swap      b = e and c = d, at a place of the same parity    sends b f      a b c b f
//! split     else                                              a new strip    a b c │ d e f, or d d e f at an odd place
//! ```
//! The paper does not ask for the parities: on a surface of one orientation they are as they should be where the vertices are; where
//! they are not, as may be where more than two triangles meet at an edge, the scanner splits. The repeated vertex of a new strip at an
//! odd place is what the paper calls overridden for a consistent orientation, and counts in its results, but not in its figure 8
//! (`502 615 206 620 │ 620 580 66 761`, of which the second begins at an odd place): [`Sent`](super::Sent) has both counts.
//!
//! # References
//! Kim et al. 2005, section 4.
//!
//! # Complexity
//! O(n); at most four vertices a triangle.

use super::Sink;

/// Scans one strip.
pub(super) fn scan(strip: &[u32], sink: &mut impl Sink) {
    // The last two vertices of the triangle sent last, and its parity. No valid triangle follows on two equal ones.
    let (mut b, mut c, mut was_odd) = (0, 0, true);
    let mut is_first = true;
    for (i, triangle) in strip.windows(3).enumerate() {
        let (d, e, f) = (triangle[0], triangle[1], triangle[2]);
        if d == e || e == f || d == f {
            continue;
        }
        let is_odd = i % 2 == 1;
        if b == d && c == e && is_odd != was_odd {
            sink.send(f);
        } else if b == e && c == d && is_odd == was_odd {
            sink.send(b);
            sink.send(f);
        } else {
            if !std::mem::take(&mut is_first) {
                sink.end();
            }
            if is_odd {
                sink.send_repeat(d);
            }
            sink.send(d);
            sink.send(e);
            sink.send(f);
        }
        (b, c, was_odd) = (e, f, is_odd);
    }
    if !is_first {
        sink.end();
    }
}
