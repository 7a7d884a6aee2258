//! Filters: turn a strip whose vertices were renamed by collapses into *display strips*, which draw
//! the same triangles with fewer vertices.
//!
//! A collapse makes two vertices of a strip equal and the triangles between them degenerate. They
//! draw nothing, but their vertices are still sent. Near the base mesh, most of a strip is
//! degenerate. A filter reads a simplified strip once, front to back, and sends only the vertices
//! that are needed. With every filter, display strips draw exactly the oriented triangles of the
//! simplified strip.
//!
//! ```text
//! the strip          0 1 2 3 4 5 6        draws 012 213 234 435 456
//! 3 becomes 2        0 1 2 2 4 5 6        draws 012 425 456; 1 2 2 and 2 2 4 draw nothing
//! None, Stss         0 1 2 2 4 5 6
//! Dtfs               0 1 2 │ 2 2 4 5 6    a strip at an odd position repeats its first vertex
//! Linked             0 1 2 │ 2 5 4 6      rotates the first triangle instead, without a repeat
//! ```
//! # References
//! [`stss`] implements El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing
//! and Updating Triangle Strips for Real-Time Rendering*, 2000, section 5.4. [`dtfs`] implements
//! Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D Meshes*,
//! 2005 (section 4). [`linked`] was developed for this library, as was [`repair`](super::repair).
//! `repair` does not read simplified strips: it follows the collapses and repairs its own strips
//! next to them.
//!
//! # Complexity
//! O(n) time. The only memory is the result, at most four vertices per triangle. On one core, for
//! the strips of the bunny at 21 levels, `Dtfs` reads 360 million entries per second, `Stss` and
//! `Linked` 260 million.

mod costs;
mod dtfs;
mod linked;
mod scanner;
mod stss;
mod valid;

#[cfg(test)]
mod tests;

use crate::lod::level::index_map::RESTART;
use crate::names::names;
use crate::strip::Strips;
pub use costs::FilterCosts;
pub(crate) use dtfs::Dtfs;
pub(crate) use linked::Linked;
pub use scanner::DrawCost;
pub(crate) use scanner::{DrawTally, Scanner, Sink};
pub(crate) use scanner::{replace_last_triangle, replace_last_vertex, reverse_but_for_start};
pub(crate) use stss::Stss;
pub(crate) use valid::{BLOCK, Gatherer};

/// A filter that turns simplified strips into display strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Filter {
    /// Sends strips unchanged, including degenerate triangles.
    None,
    /// The simple triangle strip scanner: sends immediately repeated pairs of vertices once.
    Stss,
    /// The degenerate triangle-free scanner: sends only valid triangles, and starts a new strip
    /// where two of them are not consecutive.
    Dtfs,
    /// Sends only valid triangles, in the same order, at the minimum cost for this order. This
    /// filter was developed for this library.
    #[default]
    Linked,
}

names! {
    "tristrip::lod::Filter", Filter, "filter",
    None => "none", "Draw the renamed strips unchanged, degenerate triangles included";
    Stss => "stss", "Simple triangle strip scanner: send repeated pairs of vertices once (El-Sana et al. 2000)";
    Dtfs => "dtfs", "Degenerate-triangle-free scanner: send valid triangles only (Kim et al. 2005)";
    Linked => "linked", "Send valid triangles only, in the same order, at the minimum cost for this order";
}

impl Filter {
    /// Filters all strips of an index map and appends their display strips. Clear and reuse
    /// `display` at the next level to avoid allocation.
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

    /// Returns the display strips of simplified strips.
    ///
    /// ```
    /// use tristrip::{Strips, lod::Filter};
    /// let simplified = Strips::from_parts(vec![0, 1, 2, 2, 2, 3, 4, 4, 4], vec![6, 9])?;
    /// let lengths = |filter: Filter| filter.strips(&simplified).iter().map(|strip| strip.len()).collect::<Vec<_>>();
    /// assert_eq!((lengths(Filter::None), lengths(Filter::Linked)), (vec![6, 3], vec![3]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn strips(self, strips: &Strips) -> Strips {
        let mut display = Strips::default();
        strips.iter().for_each(|strip| self.scan(strip, &mut display));
        display
    }

    /// Returns the cost of the strips that [`Filter::map_to`] would append, without storing them.
    ///
    /// ```
    /// use tristrip::lod::{Filter, RESTART};
    /// let map = [0, 1, 2, 2, RESTART, 3, 4, 5];
    /// assert_eq!([Filter::None, Filter::Linked].map(|filter| filter.sent_by_map(&map).vertices), [7, 6]);
    /// ```
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
