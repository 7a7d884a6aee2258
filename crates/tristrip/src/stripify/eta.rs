//! `eta`, the enhanced tunnelling algorithm as published: tunnels within a star, identifiers rewritten node by node.
//!
//! # Algorithm
//! The numbers are those of section 4.1 of the paper; see [`tunnel`](super::tunnel) for the terms.
//!
//! 1. *The length k*: fixed, and every tunnel up to it is accepted (depth first). Where strips are left, the search is repeated with a longer
//!    one (section 6.1): 49, 99, 199 …. Or it is 1, 3, 5 …, where the next begins when no terminal has a tunnel of the last (breadth first,
//!    section 5).
//! 2. *A terminal*, in random order.
//! 3. *Its k-star*: the triangles at most k steps away.
//! 4. *Temporary edges* for the strips that leave the star and come back.
//! 5. *Tunnelling*: alternating paths, depth first. A step cuts a black edge, which splits a strip, and links the part at its near end with
//!    the tip; the part gets the identifier of the tip, node by node, and its own again when the path is given up. No step closes a loop:
//!    both must not be the same part of one strip. A search ends after a given number of accesses to nodes, the forecast of section 4.2.
//! 6. *Complement*, if a tunnel was found: the temporary edges vanish, and the strips get their identifiers everywhere.
//! 7. *The next terminal.*
//!
//! Without localization, steps 3, 4 and 6 fall away: identifiers are written to the end of each strip. It finds the same tunnels. On demand, a
//! search begins without localization, and begins again within a star when it has become long: the same tunnels, too.
//!
//! # Departures
//! - A strip's consecutive crossings of the star's boundary are found by the position of a triangle on its strip, kept beside the
//!   identifier; the paper does not say how it finds them.
//! - Where the cut divides a strip that is the tip's own, one part is followed to find out whether the tip is on it, in place of an
//!   identifier that would be written on it and taken back. As many nodes are accessed.
//! - The threshold counts the triangles that paths step on, not the identifiers written, so that it cuts the same searches with and
//!   without localization.
//! - The paper leaves open the order of terminals and paths: both are random, but an end of the tunnel is taken first. It does not say when
//!   to end: here, when some passes over all terminals have found nothing.
//!
//! [`guided_tunnels`](super::guided_tunnels) is what we made of it.
//!
//! # References
//! Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*, 2006.
//!
//! # Complexity
//! A search takes O(star + threshold · star) time. At most 48 bytes per triangle, beside the cover and the dual graph.

mod search;
mod star;
mod tagged_strips;
#[cfg(test)]
mod tests;

use super::options::{Acceptance, EtaOptions, Localization};
use super::tunnel::accesses::{AccessCounter, SearchOutcome};
use super::tunnel::path_tags::{PathTags, complement_links};
use super::watch::Watch;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;
use crate::random::Random;
use search::{EtaSearch, SearchLimits};
use star::Star;
use tagged_strips::TaggedStrips;

/// How many passes over all terminals, and how many strips in them, find nothing before the search ends.
#[derive(Debug, Clone, Copy)]
struct Patience {
    passes: u32,
    searches: usize,
}

/// The patience with the last maximum length. With 20 passes alone, fandisk keeps a second strip for some seeds.
const LAST_PATIENCE: Patience = Patience { passes: 20, searches: 1000 };

/// The patience while longer tunnels are to come.
const SHORT_PATIENCE: Patience = Patience { passes: 3, searches: 0 };

/// The first maximum length, if lengths are repeated.
const FIRST_LENGTH: u32 = 49;

/// Accesses to nodes after which a search is repeated within a star, if stars are found on demand. On bunny it saves two thirds of the time.
const SHORT_SEARCH: u64 = 256;

/// Joins paths of a cover until no more tunnels are found or the watch stops it.
pub(super) fn join(
    graph: &DualGraph,
    cover: &mut PathCover,
    options: EtaOptions,
    seed: u64,
    watch: &dyn Watch,
) {
    let tags = PathTags::new(graph, cover);
    let strips = TaggedStrips::new(cover, &tags);
    let is_local = options.localization() != Localization::None;
    let state = Eta {
        graph,
        options,
        min_path_count: graph.components().1,
        cover,
        strips,
        tags: is_local.then_some(tags),
        star: Star::default(),
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
    /// With localization: the strips before a search, and the order of their triangles.
    tags: Option<PathTags>,
    star: Star,
    search: EtaSearch,
    random: Random,
}

impl Eta<'_> {
    fn run(mut self, counter: &mut AccessCounter<'_>) {
        let max_length = self.options.length();
        let mut length = match self.options.acceptance() {
            Acceptance::DepthFirst => max_length,
            Acceptance::Repeated => max_length.min(FIRST_LENGTH),
            Acceptance::BreadthFirst => 1,
        };
        while length <= max_length && self.cover.path_count() > self.min_path_count {
            let patience = match self.options.acceptance() {
                Acceptance::BreadthFirst => Patience { passes: 1, searches: 0 },
                _ if length < max_length => SHORT_PATIENCE,
                _ => LAST_PATIENCE,
            };
            self.search.was_cut_short = false;
            // If no path reached this length, a longer one finds nothing else.
            if !self.passes(length, patience, counter) || length == max_length || !self.search.was_cut_short {
                return;
            }
            length = match self.options.acceptance() {
                Acceptance::BreadthFirst => length.saturating_add(2),
                _ => length.saturating_mul(2).saturating_add(1).min(max_length),
            };
        }
    }

    /// Does passes over all terminals until some have found nothing. Returns whether to continue.
    fn passes(&mut self, length: u32, patience: Patience, counter: &mut AccessCounter<'_>) -> bool {
        let mut fruitless = Patience { passes: 0, searches: 0 };
        while self.cover.path_count() > self.min_path_count
            && (fruitless.passes < patience.passes || fruitless.searches < patience.searches)
        {
            let before = self.cover.path_count();
            if !self.pass(length, counter) {
                return false;
            }
            if self.cover.path_count() < before {
                fruitless = Patience { passes: 0, searches: 0 };
            } else {
                fruitless.passes += 1;
                fruitless.searches += before;
            }
        }
        true
    }

    /// Searches once from every terminal. Returns whether to continue.
    fn pass(&mut self, length: u32, counter: &mut AccessCounter<'_>) -> bool {
        let mut terminals: Vec<u32> =
            (0..self.cover.len() as u32).filter(|&t| self.cover.degree(FaceId(t)) < 2).collect();
        for i in (1..terminals.len()).rev() {
            terminals.swap(i, self.random.below(i + 1));
        }
        for terminal in terminals {
            if self.cover.degree(FaceId(terminal)) == 2 {
                continue;
            }
            let before = counter.accesses();
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

    /// Searches from a terminal, and complements the tunnel if one was found.
    fn search_from(&mut self, terminal: u32, length: u32, counter: &mut AccessCounter<'_>) -> SearchOutcome {
        let outcome = match self.options.localization() {
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
        // No search has more accesses than `u64::MAX`.
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
        let limits = SearchLimits { length, threshold: self.options.threshold(), accesses };
        let context = (self.graph, &*self.cover);
        self.search.find(context, &mut self.strips, terminal, limits, &mut self.random, counter)
    }
}
