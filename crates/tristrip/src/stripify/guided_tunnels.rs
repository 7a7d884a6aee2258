//! `guided-tunnels`: tunnels of up to hundreds of edges. Each search is guided toward the nearest
//! end of another strip, and ends can also move.
//!
//! This variant of the enhanced tunnelling algorithm ([`eta`](super::eta)) is original to this
//! library. It leaves fewer strips than `eta` and takes less time.
//!
//! # Algorithm
//! See [`tunnel`](super::tunnel) for the terms.
//!
//! 1. *The length k* grows: 3, 7, 15 …. A length is repeated while it joins many strips.
//! 2. *A terminal* is selected, in random order.
//! 3. *The star* of the terminal is collected: the triangles that alternating paths of k edges
//!    reach. Each of these triangles has a distance along alternating paths to the terminals of
//!    other strips. The star ends a few steps beyond the nearest terminal. If the star contains no
//!    terminal of another strip, there is no search.
//! 4. *A search* runs depth first. At each step the path with the smallest distance is tried first,
//!    and ties are broken at random. The search ends after a given number of node accesses. The
//!    search writes no identifiers: a part of a strip is an interval of positions, inside or
//!    outside the star.
//! 5. *Complement* the tunnel, if one was found. Identifiers are written only then.
//!
//! When tunnel lengths of a few dozen edges find few tunnels, the maximum length is used, and
//! terminals *move*. If a search fails, the part of its path that came nearest to another terminal
//! is complemented. The number of strips stays the same, and a triangle at the end of that part
//! becomes the new terminal. The search ends when moves have led to no join for a while, or when no
//! star contains a terminal of another strip.
//!
//! ```text
//!   w ┄┄ v ━━ b ┄ … ┄ x        w ━━ v    b ┄ … ┄ x        b is the new terminal, closer to x
//! ```
//! A path may close a loop if it later opens the loop again. Only one loop may be closed at a time.
//! If loops are forbidden, as in `eta`, a long strip leaves only one possible path at each step,
//! and there is nothing to search. With the loop rule of `eta`, the horse model ends with 2 to 7
//! strips. Without this rule, it ends with 1.
//!
//! # References
//! Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*,
//! 2006; Pósa: *Hamiltonian circuits in random graphs*, 1976 (moving an end).
//!
//! # Complexity
//! A search takes O(star + threshold · length) time. At most 36 bytes per triangle in addition to
//! the cover and the dual graph.

mod search;
mod star;
#[cfg(test)]
mod tests;

use super::TunnelOptions;
use super::tunnel::accesses::{AccessCounter, SearchOutcome};
use super::tunnel::context::SearchContext;
use super::tunnel::path_tags::PathTags;
use super::watch::Watch;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;
use crate::random::Random;
use search::{GuidedSearch, TunnelLimits};
use star::GuidedStar;

/// A length is repeated if it joined at least one strip in this many.
const REPEAT_SHARE: usize = 20;
/// The length after which terminals move, and all lengths are tried at once. Tuned on bunny and
/// dragon: a larger value leaves more strips.
const MOVING_LENGTH: u32 = 63;
/// Passes that move terminals without a join, after which the search ends. Tuned on horse: 20
/// leaves 3 strips for one seed in twelve.
const MAX_FRUITLESS_PASSES: u32 = 40;
/// One of this many such passes starts with all terminals. The others start with the terminals that
/// had a terminal of another strip in their star.
const FULL_PASS_INTERVAL: u32 = 5;
/// Maximum number of loops closed at a time while terminals move; before that, none. Tuned on bunny
/// and horse: two lead away from tunnels.
const MAX_LOOPS: u32 = 1;

/// Joins paths of a cover until no more tunnels are found or the watcher stops the search.
pub(super) fn join(
    graph: &DualGraph,
    cover: &mut PathCover,
    options: TunnelOptions,
    seed: u64,
    watch: &dyn Watch,
) {
    let mut counter = AccessCounter::new(watch);
    let min_path_count = graph.components().1;
    let mut state = GuidedTunnels {
        tags: PathTags::new(graph, cover),
        star: GuidedStar::default(),
        search: GuidedSearch::default(),
        random: Random::new(seed),
        graph,
        cover,
    };
    let mut length = options.length.min(3);
    let (mut is_moving, mut fruitless_passes) = (false, 0);
    let mut terminals = Vec::new();
    while state.cover.path_count() > min_path_count && fruitless_passes < MAX_FRUITLESS_PASSES {
        let before = state.cover.path_count();
        let is_full = fruitless_passes % FULL_PASS_INTERVAL == 0;
        if is_full {
            state.find_terminals(&mut terminals);
        }
        let max_loops = if is_moving { MAX_LOOPS } else { 0 };
        let limits = TunnelLimits { length, accesses: options.threshold, loops: max_loops };
        if !state.pass(&mut terminals, limits, is_moving, &mut counter) {
            return;
        }
        let found = before - state.cover.path_count();
        if is_moving {
            fruitless_passes = if found == 0 { fruitless_passes + 1 } else { 1 };
            if is_full && terminals.is_empty() {
                return;
            }
        } else if REPEAT_SHARE * found < before {
            is_moving = length >= options.length.min(MOVING_LENGTH);
            length = if is_moving { options.length } else { (2 * length + 1).min(options.length) };
        }
    }
}

/// The state of the method.
struct GuidedTunnels<'a> {
    graph: &'a DualGraph,
    cover: &'a mut PathCover,
    tags: PathTags,
    star: GuidedStar,
    search: GuidedSearch,
    random: Random,
}

impl GuidedTunnels<'_> {
    /// Finds the terminals.
    fn find_terminals(&self, terminals: &mut Vec<u32>) {
        terminals.clear();
        terminals.extend((0..self.cover.len() as u32).filter(|&t| self.cover.degree(FaceId(t)) < 2));
    }

    /// Searches from every terminal, repeatedly where it finds a tunnel, and keeps the terminals
    /// that might find one in another pass. Returns whether to continue.
    fn pass(
        &mut self,
        terminals: &mut Vec<u32>,
        limits: TunnelLimits,
        is_moving: bool,
        counter: &mut AccessCounter<'_>,
    ) -> bool {
        for i in (1..terminals.len()).rev() {
            terminals.swap(i, self.random.below(i + 1));
        }
        let mut kept = 0;
        for i in 0..terminals.len() {
            let mut terminal = terminals[i];
            while self.cover.degree(FaceId(terminal)) < 2 {
                let context = SearchContext { graph: self.graph, cover: self.cover, tags: &self.tags };
                if !self.star.build(&context, terminal, limits.length, counter) {
                    break;
                }
                match self.search.find(&context, &self.star, terminal, limits, &mut self.random, counter) {
                    SearchOutcome::Stopped => return false,
                    SearchOutcome::Found => {
                        self.tags.complement(self.graph, self.cover, self.search.tunnel());
                    }
                    SearchOutcome::NotFound => {
                        if is_moving {
                            let nearest = self.search.nearest();
                            self.tags.complement(self.graph, self.cover, nearest);
                            let black = nearest.last().and_then(|step| step.black.get());
                            terminal =
                                black.and_then(|h| self.graph.twin_of(h)).map_or(terminal, |twin| twin / 3);
                        }
                        terminals[kept] = terminal;
                        kept += 1;
                        break;
                    }
                }
            }
            if !counter.may_continue(self.cover) {
                return false;
            }
        }
        terminals.truncate(kept);
        true
    }
}
