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
//! The module `baseline` is the operator as it was first described, `eta` the search that makes it fast, and `ids` tells both whether a
//! loop arises.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001 (the operator);
//! Porcu, Scateni: *An Iterative Stripification Algorithm Based on Dual Graph Operations*, 2003 (identifiers);
//! Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*, 2006.

mod baseline;
mod eta;
mod ids;
mod star;
#[cfg(test)]
mod tests;

use super::watch::{Progress, Watch};
use super::{EtaOptions, Start, StripPlan, input, sequential, sgi};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::prepare::PreparedFaces;

/// Plans strips by tunnels of at most `length` edges, from isolated triangles.
pub(super) fn plan_tunnel<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    length: u32,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let mut plan = isolated(surface, graph);
    baseline::join(plan.triangulation.graph(), &mut plan.cover, length, &mut Tally::new(watch));
    plan
}

/// Plans strips by the enhanced tunnelling algorithm. The triangulation is that of the strips that it starts from.
pub(super) fn plan_eta<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: EtaOptions,
    seed: u64,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let mut plan = match options.start() {
        Start::Isolated => isolated(surface, graph),
        Start::Input => input::plan(surface, graph),
        Start::Sgi => sgi::plan(surface, graph),
        Start::Sequential => sequential::plan(surface, graph),
    };
    eta::join(plan.triangulation.graph(), &mut plan.cover, options, seed, &mut Tally::new(watch));
    plan
}

/// Joins the paths of a cover by the enhanced tunnelling algorithm; the watch may stop it.
pub(super) fn join(
    graph: &DualGraph,
    cover: &mut PathCover,
    options: EtaOptions,
    seed: u64,
    watch: &dyn Watch,
) {
    eta::join(graph, cover, options, seed, &mut Tally::new(watch));
}

/// Every triangle by itself.
fn isolated<'a>(surface: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> StripPlan<'a> {
    let triangulation = Triangulation::fan(surface, graph);
    let cover = PathCover::isolated(triangulation.triangle_count());
    StripPlan::new(triangulation, cover)
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
    /// Accesses at which the watch is asked next.
    ask_at: u64,
    watch: &'a dyn Watch,
}

impl<'a> Tally<'a> {
    fn new(watch: &'a dyn Watch) -> Self {
        Self { accesses: 0, ask_at: WATCH_EVERY, watch }
    }

    /// Counts one access, and tells whether the search shall go on.
    #[inline]
    fn count(&mut self, cover: &PathCover) -> bool {
        self.accesses += 1;
        self.go_on(cover)
    }

    /// Tells whether the search shall go on.
    #[inline]
    fn go_on(&mut self, cover: &PathCover) -> bool {
        if self.accesses < self.ask_at {
            return true;
        }
        self.ask_at = self.accesses + WATCH_EVERY;
        let strips = cover.path_count();
        self.watch.go_on(Progress { steps: self.accesses, strips, cost: strips, ..Progress::default() })
    }
}
