//! The tunnelling operator in its simplest form: it tries every alternating path, shortest first.
//! The faster searches are compared with it.
//!
//! # Algorithm
//! 1. Set the length to 1.
//! 2. From each terminal in turn, follow every alternating path of at most that length: over a red
//!    edge to a triangle `v`, then over one of the black edges of `v`, and so on. No edge is used
//!    twice.
//! 3. If a red edge leads to a terminal and no loop would remain, complement the path, and continue
//!    from that terminal.
//! 4. When no terminal has a tunnel of that length, try the next odd length, up to the limit, as
//!    long as a path of that length exists.
//!
//! At the end, no tunnel up to the limit remains. This includes tunnels whose path closes a loop
//! and opens it again later. The rules of Stewart and of Porcu and Scateni forbid such paths,
//! because these rules apply to every step. The rule here examines the paths only after the last
//! step.
//!
//! # Complexity
//! The number of paths grows exponentially with the length: it doubles with each black edge.

use super::accesses::{AccessCounter, SearchOutcome};
use super::context::SearchContext;
use super::partial_tunnel::PartialTunnel;
use super::path_tags::PathTags;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;

/// Joins paths of a cover by tunnels, until none of at most this length remains or the watcher
/// stops the search.
pub(super) fn join(
    graph: &DualGraph,
    cover: &mut PathCover,
    max_length: u32,
    counter: &mut AccessCounter<'_>,
) {
    let mut tags = PathTags::new(graph, cover);
    let mut search = TunnelSearch::default();
    let mut length = 1_u32;
    while length <= max_length {
        let (mut found, mut was_cut_short) = (false, false);
        for t in 0..cover.len() as u32 {
            while cover.degree(FaceId(t)) < 2 {
                let context = SearchContext { graph, cover, tags: &tags };
                let outcome = search.find(&context, t, length, counter);
                was_cut_short |= search.was_cut_short;
                match outcome {
                    SearchOutcome::Stopped => return,
                    SearchOutcome::NotFound => break,
                    SearchOutcome::Found => {
                        counter.add(tags.complement(graph, cover, search.tunnel.steps()));
                    }
                }
                found = true;
            }
        }
        // A complement may have opened a shorter tunnel, which the next round at this length finds.
        // If no path reached this length, longer paths find nothing else.
        if !found {
            if !was_cut_short {
                return;
            }
            length = length.saturating_add(2);
        }
    }
}

/// A search from one terminal.
#[derive(Debug, Default)]
pub(super) struct TunnelSearch {
    pub(super) tunnel: PartialTunnel,
    /// Whether a path was not followed because of its length.
    was_cut_short: bool,
}

impl TunnelSearch {
    /// Searches for a tunnel of at most `length` edges from a terminal.
    pub(super) fn find(
        &mut self,
        context: &SearchContext<'_>,
        terminal: u32,
        length: u32,
        counter: &mut AccessCounter<'_>,
    ) -> SearchOutcome {
        self.was_cut_short = false;
        self.tunnel.begin(context, terminal);
        self.tunnel.add_all_candidates(context, terminal);
        self.tunnel.search(context, counter, u64::MAX, |tunnel, step, [v, b]| {
            // A path of n steps has 2 n edges, and one more at its end.
            if 2 * tunnel.steps().len() as u64 + 3 > u64::from(length) {
                self.was_cut_short = true;
            } else if tunnel.try_step(context, step, [v, b], u32::MAX) {
                tunnel.add_all_candidates(context, b);
            }
        })
    }
}
