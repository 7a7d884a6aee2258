//! Maintains the paths of a mesh by repairing them next to each change.

use super::nearby::NearbyTriangles;
use crate::cover::PathCover;
use crate::cover::local_search::LocalSearch;
use crate::cover::priced::{PricedPaths, StripPrices};
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::strip::{Strips, emit};

/// The maximum number of steps of the walks to path ends for the searches next to a change, and for
/// each triangle that a search starts from. The test models take less than 20,000 next to a change.
const WALK_STEPS: u64 = 1 << 14;
const WALK_STEPS_PER_SEARCH: u64 = 128;

/// Paths, a local search that improves them, and the triangles where it starts.
#[derive(Debug, Clone)]
pub(crate) struct RepairedPaths {
    pub(crate) paths: PricedPaths,
    pub(crate) search: LocalSearch,
    near: NearbyTriangles,
}

impl RepairedPaths {
    /// Allocates empty slots for triangles.
    pub(crate) fn empty(triangle_count: usize, prices: StripPrices, seed: u64) -> Self {
        Self {
            paths: PricedPaths::empty(triangle_count, prices),
            search: LocalSearch::new(seed),
            near: NearbyTriangles::among(triangle_count),
        }
    }

    /// Allocates empty slots up to this many triangles.
    pub(crate) fn grow(&mut self, triangle_count: usize) {
        self.paths.grow(triangle_count);
        self.near.grow(triangle_count);
    }

    /// Returns the memory in bytes.
    pub(crate) fn memory(&self) -> usize {
        self.paths.memory() + self.near.memory()
    }

    /// Returns the number of vertices of all strips, including swaps and winding repeats, in O(1)
    /// time.
    pub(crate) fn vertices_sent(&self, triangle_count: usize) -> usize {
        // Derived from the cost, in which strips can have another price.
        let strips = self.paths.strip_count().cast_signed() as i64;
        let beyond = self.paths.cost() - strips * i64::from(self.paths.prices().strip - 2);
        triangle_count + usize::try_from(beyond).unwrap_or(0)
    }

    /// Finds up to `most` triangles nearest to the start triangles, including these. The next
    /// searches start from them.
    pub(crate) fn find_near(&mut self, start: impl Iterator<Item = u32>, most: usize) {
        self.near.find(&self.paths, start, most);
    }

    /// Searches `rounds` times from each of the triangles near a change that `selects` accepts.
    pub(crate) fn search_near(&mut self, rounds: u32, selects: impl Fn(&PricedPaths, u32) -> bool) {
        for _ in 0..rounds {
            for &t in &self.near.triangles {
                if selects(&self.paths, t) {
                    self.search.improve_at(&mut self.paths, t);
                }
            }
        }
    }

    /// Builds the strips, in O(n) time. `triangle` returns the vertices of a drawn triangle, and
    /// `None` for others.
    pub(crate) fn emit(&self, triangle: impl Fn(u32) -> Option<[u32; 3]>) -> Strips {
        // Renumber the triangles without those that are not drawn.
        let mut number = vec![0; self.paths.len()];
        let (mut corners, mut drawn) = (Vec::new(), Vec::new());
        for t in 0..number.len() as u32 {
            if let Some(vertices) = triangle(t) {
                number[t as usize] = drawn.len() as u32;
                drawn.push(t);
                corners.extend(vertices);
            }
        }
        let mut twins = Vec::with_capacity(corners.len());
        let mut cover = PathCover::isolated(drawn.len());
        for (&t, i) in drawn.iter().zip(0..) {
            for e in 0..3 {
                let twin = self.paths.twin(4 * t + e);
                let there = twin.map(|twin| 3 * number[twin as usize / 4] + twin % 4);
                twins.push(there);
                if let (Some(twin), Some(there)) = (twin, there)
                    && self.paths.mask(t) >> e & 1 == 1
                    && 4 * t + e < twin
                {
                    cover.link_unchecked(3 * i + e, there);
                }
            }
        }
        emit(&Triangulation::from_parts(corners, DualGraph::of_triangle_twins(twins)), &cover)
    }
}

/// Returns the maximum number of walk steps of searches from this many triangles.
pub(crate) fn walk_steps(rounds: u32, triangle_count: usize) -> u64 {
    WALK_STEPS + WALK_STEPS_PER_SEARCH * u64::from(rounds) * triangle_count as u64
}
