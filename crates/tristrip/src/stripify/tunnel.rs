//! `tunnel` and `eta`: fewer strips by tunnels, alternating paths between the ends of strips.
//!
//! The edges of the dual graph within strips are black, all others red. A *tunnel* leads from a terminal, that is the end of a strip
//! or an isolated triangle, over a red edge, a black one, and so on, and over a red one to another terminal. Complementing it,
//! red to black and black to red, makes one strip fewer.
//!
//! ```text
//!   w ┄┄ v ━━ b ┄┄ x         w ━━ v    b ━━ x
//!        ┃    ┃        ─▶         ┃    ┃          three strips become two
//!        c    d                   c    d
//! ```
//! [`baseline`] is the operator as it was first described, [`eta`] the search that makes it fast, [`ids`] how both know that no
//! loop arises.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001 (the operator);
//! Porcu, Scateni: *An Iterative Stripification Algorithm Based on Dual Graph Operations*, 2003 (identifiers);
//! Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*, 2006.

mod baseline;
mod ids;
#[cfg(test)]
mod tests;

use super::Plan;
use super::watch::{Progress, Watch};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::mesh::{Surface, Triangulation};

/// Plans strips by tunnels of at most `length` edges, from isolated triangles.
pub(super) fn plan_tunnel<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    length: u32,
    watch: &dyn Watch,
) -> Plan<'a> {
    let triangulation = Triangulation::fan(surface, graph);
    let mut cover = PathCover::isolated(triangulation.triangle_count());
    baseline::join(triangulation.graph(), &mut cover, length, &mut Tally::new(watch));
    Plan { triangulation, cover }
}

/// How a search from a terminal ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Searched {
    Found,
    Nothing,
    Stopped,
}

/// Accesses to nodes after which the watch is asked.
const WATCH_EVERY: u64 = 1 << 13;

/// Counts accesses to nodes, the unit in which these searches are measured, and asks the watch now and then.
struct Tally<'a> {
    accesses: u64,
    watch: &'a dyn Watch,
}

impl<'a> Tally<'a> {
    fn new(watch: &'a dyn Watch) -> Self {
        Self { accesses: 0, watch }
    }

    /// Counts one access, and tells whether the search shall go on.
    #[inline]
    fn count(&mut self, cover: &PathCover) -> bool {
        self.accesses += 1;
        if !self.accesses.is_multiple_of(WATCH_EVERY) {
            return true;
        }
        let strips = cover.path_count();
        self.watch.go_on(Progress { steps: self.accesses, strips, cost: strips, ..Progress::default() })
    }
}
