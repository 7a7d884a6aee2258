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
mod order;
mod repair;
mod star;
#[cfg(test)]
mod tests;

use super::watch::{Progress, Watch};
use super::{Plan, input, sequential, sgi};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::mesh::{Surface, Triangulation};
pub use repair::{Repaired, Repairer};

/// Plans strips by tunnels of at most `length` edges, from isolated triangles.
pub(super) fn plan_tunnel<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    length: u32,
    watch: &dyn Watch,
) -> Plan<'a> {
    let mut plan = isolated(surface, graph);
    baseline::join(plan.triangulation.graph(), &mut plan.cover, length, &mut Tally::new(watch));
    plan
}

/// What a caller of `eta` may choose.
///
/// ```
/// use tristrip::{Faces, Mesh, Method, Options, stripify};
/// use tristrip::stripify::{EtaOptions, Start};
/// // A closed fan of six triangles.
/// let corners = (0..6).flat_map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
/// let mesh = Mesh::new(vec![[0.0; 3]; 7], Faces::from_triangles(corners)?)?;
/// let eta = EtaOptions::default().with_length(9).with_start(Start::Isolated);
/// let strips = stripify(&mesh, &Options::default().with_method(Method::Eta(eta)))?;
/// assert_eq!(strips.len(), 1);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct EtaOptions {
    length: u32,
    threshold: u32,
    start: Start,
}

/// The strips that `eta` starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Start {
    /// Every triangle by itself.
    Isolated,
    /// Those of [`Method::Input`](super::Method::Input). The paper shows strips of a first phase and does not say which; from these the
    /// misses per triangle are within 0.02 of its own on all six models of its tables that are at hand.
    Input,
    /// Those of [`Method::Sgi`](super::Method::Sgi).
    Sgi,
    /// Those of [`Method::Sequential`](super::Method::Sequential), which leave the fewest strips, soonest, and the fewest swaps: dragon
    /// comes to 446, from isolated triangles to 461.
    #[default]
    Sequential,
}

/// Tunnels of up to 1000 edges, 512 accesses to nodes a search, from the strips of `sequential`.
impl Default for EtaOptions {
    fn default() -> Self {
        Self { length: 1000, threshold: 512, start: Start::default() }
    }
}

impl EtaOptions {
    /// Sets the greatest length of a tunnel, in edges.
    #[must_use]
    pub fn with_length(mut self, length: u32) -> Self {
        self.length = length;
        self
    }

    /// Sets the accesses to nodes after which the search from a terminal is given up.
    #[must_use]
    pub fn with_threshold(mut self, threshold: u32) -> Self {
        self.threshold = threshold;
        self
    }

    /// Sets the strips that it starts from.
    #[must_use]
    pub fn with_start(mut self, start: Start) -> Self {
        self.start = start;
        self
    }

    /// Gives the greatest length of a tunnel, in edges.
    pub fn length(&self) -> u32 {
        self.length
    }

    /// Gives the accesses to nodes after which the search from a terminal is given up.
    pub fn threshold(&self) -> u32 {
        self.threshold
    }

    /// Gives the strips that it starts from.
    pub fn start(&self) -> Start {
        self.start
    }
}

/// Plans strips by the enhanced tunnelling algorithm. The triangulation is that of the strips that it starts from.
pub(super) fn plan_eta<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    options: EtaOptions,
    seed: u64,
    watch: &dyn Watch,
) -> Plan<'a> {
    let mut plan = match options.start {
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
fn isolated<'a>(surface: &'a Surface<'_>, graph: &'a DualGraph) -> Plan<'a> {
    let triangulation = Triangulation::fan(surface, graph);
    let cover = PathCover::isolated(triangulation.triangle_count());
    Plan::new(triangulation, cover)
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
