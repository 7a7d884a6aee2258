//! Filters: a strip in which collapses have renamed vertices becomes *display strips*, which draw the same with fewer vertices.
//!
//! A collapse makes two vertices of a strip one, and the triangles between them degenerate. They draw nothing, but they are sent; toward
//! the base mesh most of a strip is such waste. A filter reads a simplified strip once, from front to back, and sends what
//! is needed. What it sends draws exactly the oriented triangles that the simplified strip draws, whatever the filter.
//!
//! ```text
//! the strip          0 1 2 3 4 5 6        draws 012 213 234 435 456
//! 3 becomes 2        0 1 2 2 4 5 6        draws 012 425 456; 1 2 2 and 2 2 4 draw nothing
//! None, Stss         0 1 2 2 4 5 6
//! Dtfs               0 1 2 │ 2 2 4 5 6    a strip that begins at an odd place repeats its first vertex
//! Linked             0 1 2 │ 2 5 4 6      the same without the repeat: a first triangle may be rotated
//! ```
//! # References
//! [`stss`] is El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and Updating Triangle Strips for Real-Time
//! Rendering*, 2000, section 5.4; [`dtfs`] is Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D
//! Meshes*, 2005, section 4. [`linked`] is ours. So is [`repair`](super::repair), which reads no strips: it follows the collapses, and mends strips beside them.
//!
//! # Complexity
//! O(n) time, and no memory but the result, at most four vertices a triangle. Of the strips of the bunny at 21 levels, `Dtfs` reads 360
//! million entries a second, `Stss` and `Linked` 260 million, on a core of their own.

pub mod dtfs;
pub mod linked;
mod scanner;
pub mod stss;
mod valid;

#[cfg(test)]
mod tests;

use super::index_map::RESTART;
use crate::strip::Strips;
pub(crate) use dtfs::Dtfs;
pub(crate) use linked::Linked;
pub use scanner::DrawCost;
pub(crate) use scanner::{DrawTally, Scanner, Sink};
pub(crate) use stss::Stss;
pub(crate) use valid::{BLOCK, Gatherer};

/// How simplified strips become display strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Filter {
    /// Strips are sent as they are, with all that draws nothing.
    None,
    /// The simple triangle strip scanner: pairs of vertices that repeat at once are sent once.
    Stss,
    /// The degenerate triangle-free scanner: valid triangles only, a new strip where two of them do not follow on each other.
    Dtfs,
    /// Ours: valid triangles only, in the same order, at the least cost that this order has.
    #[default]
    Linked,
}

impl Filter {
    /// All filters, from the least to the most that they take out.
    pub const ALL: [Self; 4] = [Self::None, Self::Stss, Self::Dtfs, Self::Linked];

    /// Filters one simplified strip and adds its display strips to others.
    ///
    /// ```
    /// use tristrip::{Strips, lod::Filter};
    /// let mut strips = Strips::default();
    /// Filter::Dtfs.strip_to(&[0, 1, 2, 2, 4, 5, 6], &mut strips);
    /// assert_eq!(strips.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[2, 2, 4, 5, 6]]);
    /// ```
    pub fn strip_to(self, strip: &[u32], display: &mut Strips) {
        self.scan(strip, display);
    }

    /// Filters all strips between the restarts of an index map, and adds their display strips to others. A buffer that is
    /// [cleared](Strips::clear) and filled again at the next level allocates nothing.
    ///
    /// ```
    /// use tristrip::{Strips, lod::{Filter, RESTART}};
    /// let mut strips = Strips::default();
    /// Filter::Linked.map_to(&[0, 1, 2, 2, 4, 5, 6, RESTART, 7, 7, 7], &mut strips);
    /// assert_eq!(strips.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[2, 5, 4, 6]]);
    /// ```
    pub fn map_to(self, map: &[u32], display: &mut Strips) {
        self.scan(map, display);
    }

    /// Filters simplified strips.
    pub fn strips(self, strips: &Strips) -> Strips {
        let mut display = Strips::default();
        strips.iter().for_each(|strip| self.scan(strip, &mut display));
        display
    }

    /// Counts what [`Filter::strip_to`] would send, and stores nothing.
    ///
    /// ```
    /// use tristrip::lod::{DrawCost, Filter};
    /// let strip = [0, 1, 2, 2, 4, 5, 6];
    /// assert_eq!(Filter::Dtfs.sent(&strip), DrawCost { vertices: 8, strips: 2, winding_repeats: 1 });
    /// assert_eq!(Filter::Linked.sent(&strip), DrawCost { vertices: 7, strips: 2, winding_repeats: 0 });
    /// ```
    pub fn sent(self, strip: &[u32]) -> DrawCost {
        self.sent_by_map(strip)
    }

    /// Counts what [`Filter::map_to`] would send, and stores nothing.
    pub fn sent_by_map(self, map: &[u32]) -> DrawCost {
        let mut tally = DrawTally::default();
        self.scan(map, &mut tally);
        tally.into()
    }

    fn scan(self, map: &[u32], sink: &mut impl Sink) {
        match self {
            Self::None => map.split(|&v| v == RESTART).filter(|strip| !strip.is_empty()).for_each(|strip| {
                sink.send_all(strip);
                sink.end();
            }),
            Self::Stss => Stss::default().scan_all(map, sink),
            Self::Dtfs => Dtfs::default().scan_all(map, sink),
            Self::Linked => Linked::default().scan_all(map, sink),
        }
    }
}
