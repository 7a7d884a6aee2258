//! `tunnel`: reduces the number of strips by tunnels. A tunnel is an alternating path between the
//! ends of two strips.
//!
//! The edges of the dual graph within strips are black, all others red. A *terminal* is the end of
//! a strip or an isolated triangle. A *tunnel* leads from a terminal to another terminal and
//! alternates between red and black edges, starting and ending with red ones. Complementing it (red
//! to black and black to red) leaves one strip fewer.
//!
//! ```text
//!   w ┄┄ v ━━ b ┄┄ x         w ━━ v    b ━━ x
//!        ┃    ┃        ─▶         ┃    ┃          three strips become two
//!        c    d                   c    d
//! ```
//! `baseline` is the original operator. [`eta`](super::eta) is the published search that applies it
//! locally, and [`guided_tunnels`](super::guided_tunnels) is this library's variant. `tunnel` and
//! `guided_tunnels` detect loops with the modules `path_tags` and `path_intervals`.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001 (the
//! operator); Porcu, Scateni: *An Iterative Stripification Algorithm Based on Dual Graph
//! Operations*, 2003 (identifiers).

pub(super) mod accesses;
mod baseline;
pub(super) mod context;
pub(super) mod partial_tunnel;
mod path_intervals;
pub(super) mod path_tags;
#[cfg(test)]
pub(super) mod tests;

use super::options::{LastTie, Start};
use super::watch::Watch;
use super::{StripPlan, input, sequential, sgi};
use crate::cover::PathCover;
use crate::dual::{DualGraph, Triangulation};
use crate::prepare::PreparedFaces;
use accesses::AccessCounter;

/// Plans strips by tunnels of at most `length` edges, from isolated triangles.
pub(super) fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    length: u32,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let mut plan = isolated_triangles(prepared, graph);
    baseline::join(plan.triangulation.graph(), &mut plan.cover, length, &mut AccessCounter::new(watch));
    plan
}

/// Plans strips by joining initial strips. The triangulation is that of the initial strips.
pub(super) fn plan_joined<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    start: Start,
    join: impl FnOnce(&DualGraph, &mut PathCover),
) -> StripPlan<'a> {
    let mut plan = initial_strips(prepared, graph, start);
    join(plan.triangulation.graph(), &mut plan.cover);
    plan
}

fn initial_strips<'a>(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph, start: Start) -> StripPlan<'a> {
    match start {
        Start::Isolated => isolated_triangles(prepared, graph),
        Start::Input => input::plan(prepared, graph),
        Start::Sgi => sgi::plan(prepared, graph, LastTie::Last),
        Start::Sequential => sequential::plan(prepared, graph),
    }
}

/// Plans one strip per triangle.
fn isolated_triangles<'a>(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> StripPlan<'a> {
    let triangulation = Triangulation::fan(prepared, graph);
    let cover = PathCover::isolated(triangulation.triangle_count());
    StripPlan::new(triangulation, cover)
}
