//! `cache`: strips in an order that uses a vertex cache well, with few indices.
//!
//! The vertices of a long strip have left the cache when its neighbouring strips are drawn. Short
//! adjacent strips still find these vertices in the cache, but each strip starts with three
//! vertices and a restart. Which cost matters more depends on the hardware, so both are weighted:
//! `index weight × indices + miss weight × misses`.
//!
//! ```text
//!  ═══════════════════════   drawn
//!  ╲╱╲╱╲╱╲╱╲╱╲╱╲╱╲╱ ─▶       a strip along the front of the drawn triangles: one row of its
//!  ○ . . . . . . . .          vertices are hits, and the other row remains in the cache
//!  ╰─ the next strip starts here, as soon as continuing costs more than a restart
//! ```
//!
//! # Algorithm
//! A strip grows triangle by triangle along the front of the drawn triangles (Hoppe 1999, section
//! 5). At each decision:
//! 1. *Look ahead.* Speculatively draw n more triangles of this strip. Then restart at the oldest
//!    edge of the front whose vertices are still in the cache, and again at each dead end, until
//!    the number of triangles drawn reaches the horizon. Try n = 0, 1, 2, 4 …
//! 2. *Choose the n* with the lowest cost per triangle, undo the speculation, and draw these n
//!    triangles. n = 0 is a restart.
//! 3. If no edge of the front is in the cache, continue at the newest edge of the front, or at the
//!    lowest remaining triangle if the front is empty.
//!
//! A strip turns toward the front as long as it can. This takes a swap at vertices with fewer than
//! three remaining triangles, but leaves no isolated triangles.
//!
//! With the objective `indices`, the strips come from `best`, and only their order and direction
//! are chosen. The next strip is the one at the oldest edge of the front, in its cheaper direction.
//! From effort 3 on, further growth policies are tried. Some of them follow, cut and extend seed
//! strips of another method. The cheapest result is used. Then order annealing moves triangles
//! between strips, and cuts, reverses and reorders strips (module `anneal_order`), for FIFO caches
//! of up to 256 entries.
//!
//! # Effort
//! Indices and misses per triangle on one core, for the bunny with 69,451 triangles and a FIFO
//! cache of 16 entries:
//!
//! | level | 0 to 2 | 3 | 4 | 5 | 6 |
//! |---|---|---|---|---|---|
//! | indices | 1.162, 0.989 | 1.140, 0.975 | 1.128, 0.973 | 1.120, 0.971 | 1.114, 0.967 |
//! | balanced | 1.329, 0.796 | 1.239, 0.829 | 1.232, 0.805 | 1.227, 0.786 | 1.217, 0.786 |
//! | misses | 1.426, 0.608 | 1.401, 0.599 | 1.390, 0.596 | 1.380, 0.593 | 1.373, 0.592 |
//! | seconds, balanced | 0.05 | 0.4 | 0.8 | 2 | 3.5 |
//!
//! For comparison, the two triangle orders of meshoptimizer reach 1.334, 0.890 and 1.741, 0.706.
//!
//! Differences from Hoppe: indices are weighted in addition to misses. Triangles with at most one
//! open neighbour are priced as the restarts that they will need. A restart avoids vertices that
//! are about to leave the cache. All n triangles are drawn at once. This is several times faster,
//! and the result is hardly worse.
//!
//! # References
//! Hoppe: *Optimization of mesh locality for transparent vertex caching*, 1999.
//!
//! # Complexity
//! O(h log h) time per decision for a horizon of h triangles, about twice the number of cache
//! entries. 18 bytes per triangle, and 2 more for a FIFO cache.

mod active_front;
mod anneal_order;
mod arrange;
mod grow;
mod policy;
mod resettable_fifo;
mod speculative;
#[cfg(test)]
mod tests;

use super::{Objective, Progress, StripPlan, StripifyOptions, Watch, best, sequential};
use crate::cover::PathCover;
use crate::dual::{DualGraph, Triangulation};
use crate::prepare::PreparedFaces;
use crate::random::Random;
use crate::strip::Cost;
use crate::vertex_cache::{FlushPolicy, Replacement, VertexCache, VertexCacheStatistics};
use active_front::ActiveFront;
use anneal_order::StripSequence;
use arrange::arrange;
use grow::StripGrower;
use policy::{GrowthPolicy, PolicyWeights, SeedStrips};
use speculative::{SpeculativeFifo, SpeculativeLru};

/// Smaller caches hardly help, regardless of the strips.
const MIN_USEFUL_ENTRIES: u32 = 8;
/// Larger LRU caches are simulated with this many entries, because no simulation reaches further.
const MAX_LRU_ENTRIES: u32 = 128;
/// Number of growth policies that are tried, by effort.
const POLICY_COUNT: [usize; 10] = [1, 1, 1, 3, 5, 8, 8, 8, 8, 8];

/// Vertices per triangle that order annealing sends in simulations, by effort. A move takes about
/// 150.
const SIMULATED_VERTICES: [u64; 10] = [0, 0, 0, 300, 750, 1800, 3600, 7200, 14400, 28800];
/// Cache sizes with order annealing, which stores the cache contents for each strip.
const ANNEALED_ENTRIES: std::ops::RangeInclusive<u32> = 1..=256;

/// Returns the first and last temperature of order annealing, in indices. Low temperatures keep
/// indices that are already few. Tuned on bunny, fandisk and armadillo.
fn temperatures(objective: Objective) -> [f64; 2] {
    match objective {
        Objective::Indices => [0.1, 0.03],
        Objective::Balanced | Objective::Misses => [1.0, 0.2],
    }
}

/// Computes strips and their order.
pub(super) fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let start = start(prepared, graph, options, watch);
    let limit =
        SIMULATED_VERTICES[usize::from(options.effort_or_default().level())] * start.cover.len() as u64;
    let is_annealed = options.vertex_cache.replacement == Replacement::Fifo
        && ANNEALED_ENTRIES.contains(&options.vertex_cache.entries);
    if limit == 0 || !is_annealed {
        return start;
    }
    annealed(start, limit, options, watch)
}

/// Grows strips with one or several policies, and returns the cheapest result.
fn start<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let (vertex_cache, objective, seed) = (options.vertex_cache, options.objective, options.seed);
    let (effort, vertex_count) = (options.effort_or_default(), prepared.vertex_count());
    let seed_plan = |seeds| match seeds {
        SeedStrips::None => Triangulation::of_triangles(prepared, graph).map_or_else(
            || sequential::plan(prepared, graph),
            |triangulation| StripPlan::new(triangulation, PathCover::isolated(graph.face_count())),
        ),
        SeedStrips::Sequential => sequential::plan(prepared, graph),
        SeedStrips::Best => best::plan(prepared, graph, Cost::Restart, effort, seed, watch),
    };
    let policies = GrowthPolicy::all(objective);
    let count = POLICY_COUNT[usize::from(effort.level())].min(policies.len());
    let Some((&first, others)) = policies[..count].split_first() else {
        return arranged(seed_plan(SeedStrips::Best), vertex_cache, vertex_count);
    };
    let mut best = grown(&seed_plan(first.seeds), first, vertex_cache, vertex_count);
    if others.is_empty() {
        return best;
    }
    let weights = PolicyWeights::of(objective);
    let mut lowest = price(&best, vertex_cache, weights);
    let mut seed_plans: [Option<StripPlan<'a>>; 3] = [const { None }; 3];
    // If the cache is too small to help, nothing is cheaper than the ordered strips of `best`.
    // Otherwise a balanced search does not start from them, because it would get stuck there.
    let with_best = objective == Objective::Misses || vertex_cache.entries < MIN_USEFUL_ENTRIES;
    let candidates = others.iter().map(Some).chain(with_best.then_some(None));
    for (i, policy) in candidates.enumerate() {
        let progress = Progress {
            steps: i as u64,
            step_limit: Some(count as u64),
            strips: best.cover.path_count(),
            cost: lowest,
        };
        if !watch.go_on(progress) {
            break;
        }
        let seeds = policy.map_or(SeedStrips::Best, |policy| policy.seeds);
        let seed_plan = seed_plans[seeds as usize].get_or_insert_with(|| seed_plan(seeds));
        let plan = match policy {
            Some(&policy) => grown(seed_plan, policy, vertex_cache, vertex_count),
            None => arranged(seed_plan.clone(), vertex_cache, vertex_count),
        };
        let price = price(&plan, vertex_cache, weights);
        if price < lowest {
            (lowest, best) = (price, plan);
        }
    }
    best
}

/// Improves a plan by order annealing. Returns the original plan unless the result is cheaper.
fn annealed<'a>(
    start: StripPlan<'a>,
    limit: u64,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let (vertex_cache, objective) = (options.vertex_cache, options.objective);
    let weights = PolicyWeights::of(objective);
    let Some(order) = &start.order else { return start };
    let before = price(&start, vertex_cache, weights);
    let mut sequence =
        StripSequence::new(&start.triangulation, &start.cover, order, vertex_cache.entries, weights);
    let mut random = Random::new(options.seed);
    sequence.anneal(&mut random, limit, temperatures(objective), |steps, strips, saved| {
        watch.go_on(Progress {
            steps,
            step_limit: Some(limit),
            strips,
            cost: before.saturating_add_signed(-saved as isize),
        })
    });
    let (cover, order) = sequence.finish();
    let found = StripPlan::in_order(start.triangulation.clone(), cover, order);
    if price(&found, vertex_cache, weights) < before { found } else { start }
}

/// Returns the weighted cost of a plan's strips.
fn price(plan: &StripPlan<'_>, vertex_cache: VertexCache, weights: PolicyWeights) -> usize {
    let strips = plan.strips();
    let misses = VertexCacheStatistics::of(&strips, vertex_cache, FlushPolicy::Keep).misses;
    let indices = strips.vertices_sent() + strips.len();
    let [index, miss] = [weights.index, weights.miss].map(|weight| weight.unsigned_abs() as usize);
    index * indices + miss * misses
}

/// Grows strips on the triangulation of a plan. The plan's strips are the seed strips.
fn grown<'a>(
    seed_plan: &StripPlan<'a>,
    policy: GrowthPolicy,
    vertex_cache: VertexCache,
    vertex_count: usize,
) -> StripPlan<'a> {
    let triangulation = seed_plan.triangulation.clone();
    let seed_strips = (policy.seeds != SeedStrips::None).then_some(&seed_plan.cover);
    let (cover, order) = match vertex_cache.replacement {
        Replacement::Fifo => {
            let cache = SpeculativeFifo::new(vertex_cache.entries, vertex_count);
            StripGrower::new(ActiveFront::new(&triangulation, cache, policy.weights), policy, seed_strips)
                .run()
        }
        Replacement::Lru => {
            let cache = SpeculativeLru::new(vertex_cache.entries.min(MAX_LRU_ENTRIES));
            StripGrower::new(ActiveFront::new(&triangulation, cache, policy.weights), policy, seed_strips)
                .run()
        }
    };
    StripPlan::in_order(triangulation, cover, order)
}

/// Chooses the order and direction of a plan's strips.
fn arranged(plan: StripPlan<'_>, vertex_cache: VertexCache, vertex_count: usize) -> StripPlan<'_> {
    let StripPlan { triangulation, cover, .. } = plan;
    let weights = PolicyWeights::of(Objective::Indices);
    let order = match vertex_cache.replacement {
        Replacement::Fifo => {
            let cache = SpeculativeFifo::new(vertex_cache.entries, vertex_count);
            arrange(ActiveFront::new(&triangulation, cache, weights), &cover)
        }
        Replacement::Lru => {
            let cache = SpeculativeLru::new(vertex_cache.entries.min(MAX_LRU_ENTRIES));
            arrange(ActiveFront::new(&triangulation, cache, weights), &cover)
        }
    };
    StripPlan::in_order(triangulation, cover, order)
}
