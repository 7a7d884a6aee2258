//! `sequential`: this library's fast method. A greedy stripper chooses each step by its effect on
//! the cost of the remaining faces. Then a local search joins the remaining ends of strips.
//!
//! # Algorithm
//! A strip costs one index per triangle, one more per swap, and three more for its start. Swaps are
//! cheap and ends of strips are expensive. A triangle with a single free neighbour becomes an end
//! of a strip. Each end of a strip accounts for half of these three indices.
//!
//! ```text
//!          ╱╲  s   leaving over s takes a swap, over f none
//!         ╱ t╲     continue to f, unless this leaves s with one free neighbour and f with two;
//!   enter ────── f then the swap (1) is cheaper than the end (1.5) at s
//! ```
//! 1. *Seed*: a triangle with the fewest free neighbours. Ties go to the last one added. The free
//!    region is thereby stripped from its boundary, next to the previous strip. While no triangle
//!    has lost a neighbour, the first triangle in input order is used.
//! 2. *Run*: the winding fixes the first turn of a strip, so there is one run per exit of the seed.
//!    Each run is extended backward over the edge that needs no swap. All exits are tried, and the
//!    run with the lowest cost per triangle is chosen.
//! 3. *Local search* at every end of a strip: see the module `local_search`. It also joins isolated
//!    triangles to their neighbours.
//!
//! On regular meshes, especially grids, a swap at the end of a row saves a strip in one place and
//! adds one elsewhere. The input order is often better. Such meshes are recognized by their low
//! cost. For these and for small meshes, where the time is negligible, the steps are repeated with
//! other policies for seeds and swaps, and the cheapest cover is kept. Plateau passes follow. They
//! repeat the local search and also apply zero-gain moves, after which moves that lower the cost
//! may be possible.
//!
//! Differences from the greedy methods of Evans et al. (1996): ties between neighbours are broken
//! by cost instead of a fixed rule, and a local search improves the strips.
//!
//! # Complexity
//! O(n) time. Memory in addition to the triangles, the dual graph and the cover: 9 bytes per
//! triangle, and 4 more per triangle in the seed lists.

#[cfg(feature = "rayon")]
mod components;
mod edge;
mod greedy;
mod local_search;
mod mutable_triangulation;
mod policy;
mod stages;
#[cfg(test)]
pub(super) mod tests;

use std::sync::atomic::{AtomicUsize, Ordering};

use super::StripPlan;
use crate::cover::PathCover;
use crate::dual::{DualGraph, Triangulation};
use crate::prepare::PreparedFaces;
use crate::strip::cover_cost;
use mutable_triangulation::{MutableTriangulation, PolygonTriangulation};
use policy::Policy;
#[cfg(feature = "rayon")]
use rayon::prelude::*;
use stages::{CoveredTriangulation, strip};

/// Regular meshes with more triangles use only the default policy, so the time per triangle stays
/// the same.
const LARGE: usize = 1 << 19;
/// Meshes whose strips cost less than this percentage in addition to one index per triangle count
/// as regular. Tuned on the test models: grids and surfaces of revolution have 0–5, fandisk 15.
const REGULAR_PERCENT: i64 = 6;
/// Minimum and maximum number of plateau passes on small and regular meshes. In between, the number
/// is a quarter of the mean strip length in triangles, so meshes with few ends get more passes.
/// Tuned on the test models.
const PLATEAU_PASSES: (usize, usize) = (8, 64);
/// Meshes with more triangles get the minimum number of plateau passes.
const PLATEAU_LIMIT: usize = 1 << 17;
/// Number of rounds that alternate between plateau passes and the choice of diagonals.
const ROUNDS: usize = 4;
/// Meshes with fewer triangles are stripped by one thread: a policy takes less than a tenth of a
/// millisecond.
#[cfg(feature = "rayon")]
const THREADING_MINIMUM: usize = 1024;

/// Computes strips over the prepared faces.
pub(super) fn plan<'a>(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> StripPlan<'a> {
    if let Some(triangulation) = Triangulation::of_triangles(prepared, graph) {
        let (_, cover) = cover(|| graph, strip_triangles(graph));
        return StripPlan::new(triangulation, cover);
    }
    let initial = || PolygonTriangulation::new(prepared.faces(), graph);
    let (polygons, cover) = cover(initial, strip(initial(), Policy::DEFAULT));
    StripPlan::new(polygons.into_triangulation(), cover)
}

/// Covers triangles with the default policy. Connected components are processed in parallel if that
/// saves time.
fn strip_triangles(graph: &DualGraph) -> CoveredTriangulation<&DualGraph> {
    #[cfg(feature = "rayon")]
    if let Some((cover, cost)) = components::cover(graph) {
        return CoveredTriangulation { triangulation: graph, cover, cost };
    }
    strip(graph, Policy::DEFAULT)
}

/// Covers a triangulation, given the result of the default policy.
fn cover<T: MutableTriangulation>(
    initial: impl Fn() -> T + Sync,
    default: CoveredTriangulation<T>,
) -> (T, PathCover) {
    let count = default.cover.len();
    let is_regular = 100 * default.cost < REGULAR_PERCENT * (count as u64).cast_signed();
    if count > T::SMALL && (count > LARGE || !is_regular) {
        return (default.triangulation, default.cover);
    }
    let first = (price(&default), Policy::DEFAULT);
    let least = least_price(default.triangulation.graph());
    let (lowest, policy, mut stripped) = if first.0 == least {
        (first.0, first.1, default)
    } else {
        // Keep only the price of each policy, and run the best policy again. This takes time but
        // saves memory.
        drop(default);
        let for_polygons: &[Policy] = if T::HAS_POLYGONS { &Policy::POLYGON_ALTERNATIVES } else { &[] };
        let alternatives = [&Policy::ALTERNATIVES, for_polygons].concat();
        let price = |policy| price(&strip(initial(), policy));
        let (lowest, policy) = cheapest(first, least, count, &alternatives, price);
        (lowest, policy, strip(initial(), policy))
    };
    search_plateaus(&mut stripped);
    let stripped = if price(&stripped) <= lowest { stripped } else { strip(initial(), policy) };
    (stripped.triangulation, stripped.cover)
}

/// Returns a lower bound of the price: one strip per component without swaps.
fn least_price(graph: &DualGraph) -> usize {
    graph.face_count() + policy::STRIP_COST as usize * graph.components().1
}

/// Alternates between plateau passes and optimizing the diagonals.
fn search_plateaus<T: MutableTriangulation>(stripped: &mut CoveredTriangulation<T>) {
    let CoveredTriangulation { triangulation, cover, .. } = stripped;
    let count = cover.len();
    let maximum = if count > PLATEAU_LIMIT { PLATEAU_PASSES.0 } else { PLATEAU_PASSES.1 };
    let passes = (count / 4).checked_div(cover.path_count()).unwrap_or(0).clamp(PLATEAU_PASSES.0, maximum);
    for _ in 0..ROUNDS {
        let strip_of = cover.renumber(triangulation.graph()).path;
        local_search::improve(triangulation.graph(), cover, strip_of, (passes / ROUNDS) as u32);
        triangulation.optimize_diagonals(cover);
    }
}

/// Returns the policy with the lowest price; ties go to the first one. `first` is the policy whose
/// price is known. Once a policy has the lowest possible price, the remaining ones are skipped.
#[cfg_attr(
    not(feature = "rayon"),
    expect(unused_variables, reason = "the triangle count decides whether to use threads")
)]
fn cheapest(
    first: (usize, Policy),
    least: usize,
    triangle_count: usize,
    policies: &[Policy],
    price: impl Fn(Policy) -> usize + Sync,
) -> (usize, Policy) {
    let first_least = AtomicUsize::new(usize::MAX);
    let price = |(i, &policy)| {
        let is_skipped = first_least.load(Ordering::Relaxed) < i;
        let price = if is_skipped { usize::MAX } else { price(policy) };
        if price == least {
            first_least.fetch_min(i, Ordering::Relaxed);
        }
        price
    };
    let cheaper = |best: (usize, _), other: (usize, _)| if other.0 < best.0 { other } else { best };
    #[cfg(feature = "rayon")]
    if triangle_count >= THREADING_MINIMUM && rayon::current_num_threads() > 1 {
        // One task per policy.
        let prices: Vec<usize> = policies.par_iter().enumerate().with_max_len(1).map(price).collect();
        return prices.into_iter().zip(policies.iter().copied()).fold(first, cheaper);
    }
    policies.iter().enumerate().map(|(i, policy)| (price((i, policy)), *policy)).fold(first, cheaper)
}

/// Returns the cost of a cover in indices.
fn price<T: MutableTriangulation>(stripped: &CoveredTriangulation<T>) -> usize {
    cover_cost(stripped.triangulation.graph(), &stripped.cover)
}
