//! `eta`: the enhanced tunnelling algorithm as published, with tunnels within a star and
//! identifiers rewritten node by node.
//!
//! # Algorithm
//! The steps are numbered as in section 4.1 of the paper. See [`tunnel`](super::tunnel) for the
//! terms.
//!
//! 1. *The length k* is fixed, and every tunnel up to this length is accepted (depth first). The
//!    search may be repeated with longer tunnels for the strips that remain (section 6.1): 49, 99,
//!    199 …. Alternatively k is 1, 3, 5 …, and increases when no terminal has a tunnel of the
//!    current length (breadth first, section 5).
//! 2. *A terminal* is selected, in random order.
//! 3. *The k-star* of the terminal is collected: the triangles at most k steps away.
//! 4. *Temporary edges* replace the parts of strips that leave the star and come back.
//! 5. *Tunnelling* follows alternating paths, depth first. A step cuts a black edge, which splits a
//!    strip, and links the part at its near end with the tip. The part gets the identifier of the
//!    tip, node by node. When the path is abandoned, the part gets its old identifier back. No step
//!    closes a loop: after the cut, the linked triangle and the tip must not be on the same part of
//!    a strip. A search ends after its paths have visited a given number of triangles (the forecast
//!    of section 4.2).
//! 6. *Complement*, if a tunnel was found: the temporary edges are removed, and the identifiers are
//!    written to the complete strips.
//! 7. The search continues with *the next terminal*.
//!
//! Without localization, steps 3, 4 and 6 are omitted, and identifiers are written to the end of
//! each strip. With localization on demand, a search starts without localization, and is restarted
//! within a star when it has become long. All three variants find the same tunnels.
//!
//! # Departures
//! - Consecutive crossings of the star's boundary by a strip are found by the position of each
//!   triangle on its strip, which is stored with the identifier. The paper does not say how these
//!   crossings are found.
//! - Where the cut divides the tip's own strip, one part is followed to find out whether the tip is
//!   on it, instead of writing and removing a temporary identifier. This accesses the same number
//!   of nodes.
//! - The threshold counts the triangles that paths visit, not the identifiers written. It therefore
//!   ends the same searches with and without localization.
//! - The paper does not specify the order of terminals and paths. Here both are random, but an end
//!   of the tunnel is tried first. The paper does not specify when to stop either. Here the search
//!   stops after some passes over all terminals without a tunnel.
//! - The paper does not specify the lengths of repeated searches. Section 6.1 only says that longer
//!   tunnels can be searched for.
//!
//! [`guided_tunnels`](super::guided_tunnels) is this library's variant.
//!
//! # References
//! Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*,
//! 2006.
//!
//! # Complexity
//! A search takes O(star + threshold · star) time. At most 60 bytes per triangle in addition to the
//! cover and the dual graph.

mod search;
mod star;
mod tagged_strips;
#[cfg(test)]
mod tests;

use super::options::{Acceptance, Localization, TunnelOptions};
use super::tunnel::accesses::{AccessCounter, SearchOutcome};
use super::tunnel::path_tags::{PathTags, complement_links};
use super::watch::Watch;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;
use crate::random::Random;
use search::{EtaSearch, SearchLimits};
use star::EtaStar;
use tagged_strips::TaggedStrips;

/// The parameters of [`Method::Eta`](super::Method::Eta).
#[derive(Debug, Clone, Copy)]
pub(super) struct EtaOptions {
    pub(super) tunnels: TunnelOptions,
    pub(super) acceptance: Acceptance,
    pub(super) localization: Localization,
}

/// The number of consecutive passes over all terminals without a tunnel, and the total number of
/// strips in these passes, after which the search ends.
#[derive(Debug, Clone, Copy)]
struct EmptyPasses {
    passes: u32,
    strips: usize,
}

/// The limit at the last maximum length. With 20 passes alone, fandisk keeps a second strip for
/// some seeds.
const AT_LAST_LENGTH: EmptyPasses = EmptyPasses { passes: 20, strips: 1000 };

/// The limits while longer tunnels will follow, depth first and breadth first.
const DEPTH_FIRST: EmptyPasses = EmptyPasses { passes: 3, strips: 0 };
const BREADTH_FIRST: EmptyPasses = EmptyPasses { passes: 1, strips: 0 };

/// The first maximum length of repeated searches.
const FIRST_LENGTH: u32 = 49;

/// Node accesses after which a search is repeated within a star, with localization on demand. Saves
/// two thirds of the time on bunny.
const SHORT_SEARCH: u64 = 256;

/// Joins paths of a cover until no more tunnels are found or the watcher stops the search.
pub(super) fn join(
    graph: &DualGraph,
    cover: &mut PathCover,
    options: EtaOptions,
    seed: u64,
    watch: &dyn Watch,
) {
    let tags = PathTags::new(graph, cover);
    let strips = TaggedStrips::new(cover, &tags);
    let is_local = options.localization != Localization::None;
    let terminals = (0..cover.len() as u32).filter(|&t| cover.degree(FaceId(t)) < 2).collect();
    let state = Eta {
        graph,
        terminals,
        options,
        min_path_count: graph.components().1,
        cover,
        strips,
        tags: is_local.then_some(tags),
        star: EtaStar::default(),
        search: EtaSearch::default(),
        random: Random::new(seed),
    };
    state.run(&mut AccessCounter::new(watch));
}

/// The state of the method.
struct Eta<'a> {
    graph: &'a DualGraph,
    options: EtaOptions,
    min_path_count: usize,
    cover: &'a mut PathCover,
    strips: TaggedStrips,
    /// The ends of strips at the last pass. No search makes another triangle the end of a strip.
    terminals: Vec<u32>,
    /// With localization: the strips before a search, and the order of their triangles.
    tags: Option<PathTags>,
    star: EtaStar,
    search: EtaSearch,
    random: Random,
}

impl Eta<'_> {
    fn run(mut self, counter: &mut AccessCounter<'_>) {
        // A path visits a triangle for every second edge, and the threshold ends the search.
        let max_length = self
            .options
            .tunnels
            .length
            .min(self.options.tunnels.threshold.saturating_mul(2).saturating_add(1));
        let mut length = match self.options.acceptance {
            Acceptance::DepthFirst => max_length,
            Acceptance::Repeated => max_length.min(FIRST_LENGTH),
            Acceptance::BreadthFirst => 1,
        };
        while length <= max_length && self.cover.path_count() > self.min_path_count {
            let most_empty = match self.options.acceptance {
                Acceptance::BreadthFirst if length.saturating_add(2) <= max_length => BREADTH_FIRST,
                Acceptance::Repeated if length < max_length => DEPTH_FIRST,
                _ => AT_LAST_LENGTH,
            };
            self.search.was_cut_short = false;
            // If no path was cut short, longer paths find nothing else.
            if !self.passes(length, most_empty, counter) || length == max_length || !self.search.was_cut_short
            {
                return;
            }
            length = match self.options.acceptance {
                Acceptance::BreadthFirst => length.saturating_add(2),
                _ => length.saturating_mul(2).saturating_add(1).min(max_length),
            };
        }
    }

    /// Makes passes over all terminals until enough consecutive passes have found nothing. Returns
    /// whether to continue.
    fn passes(&mut self, length: u32, most_empty: EmptyPasses, counter: &mut AccessCounter<'_>) -> bool {
        let mut empty = EmptyPasses { passes: 0, strips: 0 };
        while self.cover.path_count() > self.min_path_count
            && (empty.passes < most_empty.passes || empty.strips < most_empty.strips)
        {
            let before = self.cover.path_count();
            if !self.pass(length, counter) {
                return false;
            }
            if self.cover.path_count() < before {
                empty = EmptyPasses { passes: 0, strips: 0 };
            } else {
                empty.passes += 1;
                empty.strips += before;
            }
        }
        true
    }

    /// Searches once from every terminal. Returns whether to continue.
    fn pass(&mut self, length: u32, counter: &mut AccessCounter<'_>) -> bool {
        let cover = &*self.cover;
        self.terminals.retain(|&t| cover.degree(FaceId(t)) < 2);
        let mut terminals = self.terminals.clone();
        for i in (1..terminals.len()).rev() {
            terminals.swap(i, self.random.below(i + 1));
        }
        for terminal in terminals {
            if self.cover.degree(FaceId(terminal)) == 2 {
                continue;
            }
            let before = counter.accesses();
            counter.add(1);
            let outcome = self.search_from(terminal, length, counter);
            if outcome == SearchOutcome::Stopped {
                return false;
            }
            counter.end_search(before, outcome == SearchOutcome::Found);
            if self.cover.path_count() == self.min_path_count {
                return true;
            }
            if !counter.may_continue(self.cover) {
                return false;
            }
        }
        true
    }

    /// Searches from a terminal, and complements the tunnel if one is found.
    fn search_from(&mut self, terminal: u32, length: u32, counter: &mut AccessCounter<'_>) -> SearchOutcome {
        let outcome = match self.options.localization {
            Localization::None => self.find(terminal, length, u64::MAX, counter),
            Localization::Star => self.find_in_star(terminal, length, counter),
            Localization::OnDemand => {
                let random = self.random.clone();
                self.find(terminal, length, SHORT_SEARCH, counter).or_else(|| {
                    self.random = random;
                    self.find_in_star(terminal, length, counter)
                })
            }
        };
        // No search takes `u64::MAX` accesses.
        let outcome = outcome.unwrap_or(SearchOutcome::NotFound);
        if outcome == SearchOutcome::Found {
            let tunnel = self.search.tunnel();
            if let Some(tags) = &mut self.tags {
                tags.complement(self.graph, self.cover, tunnel);
                self.strips.write_changed(self.graph, tags, tunnel);
                counter.add(self.strips.take_accesses());
            } else {
                complement_links(self.graph, self.cover, tunnel);
            }
        }
        outcome
    }

    fn find_in_star(
        &mut self,
        terminal: u32,
        length: u32,
        counter: &mut AccessCounter<'_>,
    ) -> Option<SearchOutcome> {
        if let Some(tags) = &self.tags {
            let context = (self.graph, &*self.cover, tags);
            counter.add(self.star.build(context, terminal, length, &mut self.strips));
        }
        let outcome = self.find(terminal, length, u64::MAX, counter);
        self.star.remove(&mut self.strips);
        outcome
    }

    fn find(
        &mut self,
        terminal: u32,
        length: u32,
        accesses: u64,
        counter: &mut AccessCounter<'_>,
    ) -> Option<SearchOutcome> {
        let limits = SearchLimits { length, threshold: self.options.tunnels.threshold, accesses };
        let context = (self.graph, &*self.cover);
        self.search.find(context, &mut self.strips, terminal, limits, &mut self.random, counter)
    }
}
