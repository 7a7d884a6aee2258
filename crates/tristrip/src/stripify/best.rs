//! `best`: this library's search for the cheapest cover, for a given cost and effort.
//!
//! # Algorithm
//! 1. *Start*: the cheapest of the covers of `sequential`, `input` and `quad-rows`.
//! 2. *Cold*: annealing from a low temperature. It improves the start and keeps the regular parts
//!    of the start.
//! 3. *Hot*: slow annealing from a temperature that destroys the start. On irregular meshes this
//!    gains the most.
//! 4. The result is the cheapest of the three by measured cost. It is never worse than the start,
//!    at any effort.
//!
//! If the start has one strip per component and no swaps, no cover is cheaper and no search is
//! needed.
//!
//! The module `anneal` implements the moves. They consist of joins and cuts, which [`PricedPaths`]
//! prices exactly. One of the moves flips a diagonal, so polygons are retriangulated during the
//! search.
//!
//! # Effort
//! Each level makes about twice as many sweeps over the mesh as the previous one. Measured on one
//! core, for the bunny with 69,451 triangles and the cost `restart`:
//!
//! | level | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 |
//! |---|---|---|---|---|---|---|---|---|
//! | indices per triangle | 1.180 | 1.178 | 1.162 | 1.141 | 1.129 | 1.120 | 1.114 | 1.110 |
//! | times meshoptimizer's strip pipeline | 0.5 | 0.8 | 3 | 7 | 15 | 40 | 80 | 160 |
//! | seconds | 0.007 | 0.013 | 0.045 | 0.12 | 0.28 | 0.8 | 1.5 | 2.9 |
//!
//! Levels 8 and 9 take two and four times as long as level 7. For larger meshes, the time is
//! proportional to the size. Smaller meshes take the same time as the bunny, down to an eighth of
//! its size.
//!
//! # References
//! Kirkpatrick, Gelatt, Vecchi: *Optimization by Simulated Annealing*, 1983; Pósa: *Hamiltonian
//! circuits in random graphs*, 1976 (rotations); Stewart: *Tunneling for Triangle Strips in
//! Continuous Level-of-Detail Meshes*, 2001.
//!
//! # Complexity
//! O(sweeps · n) time, see [`SWEEPS`]. 16 bytes per triangle in addition to the memory of the
//! start, and 13 more for meshes with polygons.

mod anneal;
#[cfg(test)]
mod tests;

use super::options::QUAD_ROWS_CUTOFF;
use super::stripe::quad_rows;
use super::{Effort, StripPlan, Watch, input, sequential};
use crate::cover::priced::{PricedPaths, TRIANGLE_LIMIT};
use crate::dual::DualGraph;
use crate::prepare::PreparedFaces;
use crate::strip::{Cost, cover_cost};
use anneal::{Annealer, AnnealingPhase};

/// Number of sweeps over the mesh, by effort. Tuned on the bunny; see the module documentation.
const SWEEPS: [u32; 10] = [0, 1, 8, 36, 100, 300, 600, 1200, 2400, 4800];
/// Smaller meshes get up to [`MAX_ROUNDS`] times as many sweeps, so a level takes the time of a
/// mesh of this size.
const SMALL: usize = 1 << 16;
const MAX_ROUNDS: usize = 8;
/// The lowest level with `quad-rows` among the starts, because `quad-rows` takes longer than level
/// 1.
const QUAD_ROWS_LEVEL: u8 = 2;

/// Computes strips by annealing.
pub(super) fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    cost: Cost,
    effort: Effort,
    seed: u64,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let (start, start_price) = cheapest_start(prepared, graph, cost, effort, seed);
    let phases = phases(cost, effort, start.cover.len());
    if phases.is_empty()
        || is_lowest_possible(&start, start_price, cost)
        || start.cover.is_empty()
        || start.cover.len() > TRIANGLE_LIMIT
    {
        return start;
    }
    let mut paths = PricedPaths::new(prepared.faces(), &start.triangulation, &start.cover, cost.prices());
    // The prices of the search are exact, except for strips joined by degenerate triangles.
    let price = |paths: &PricedPaths, plan: &StripPlan<'_>| match cost {
        Cost::Degenerate => joined(plan).cast_signed() as i64,
        _ => paths.cost(),
    };
    let index_count = start.cover.len().saturating_sub(without_last(cost));
    let mut annealer = Annealer::new(seed, watch, &phases, start.cover.len(), index_count);
    let mut best = (price(&paths, &start), start);
    for phase in phases {
        let goes_on = annealer.run(&mut paths, phase);
        if cost == Cost::Degenerate || paths.cost() < best.0 {
            let (triangulation, cover) = paths.to_parts(&best.1.triangulation);
            let found = StripPlan::new(triangulation, cover);
            let price = price(&paths, &found);
            if price < best.0 {
                best = (price, found);
            }
        }
        if !goes_on {
            break;
        }
    }
    best.1
}

/// Returns the cheapest plan of the fast methods, and its price.
fn cheapest_start<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    cost: Cost,
    effort: Effort,
    seed: u64,
) -> (StripPlan<'a>, usize) {
    let mut best = sequential::plan(prepared, graph);
    let mut best_price = price(&best, cost);
    if is_lowest_possible(&best, best_price, cost) {
        return (best, best_price);
    }
    let mut offer = |plan: StripPlan<'a>| {
        // The number of strips often decides: the plan may be more expensive even without swaps.
        let strip = cost.prices().strip.unsigned_abs() as usize;
        let without_swaps = plan.cover.len() + strip * plan.cover.path_count();
        let is_more_expensive = cost != Cost::Degenerate && without_swaps >= best_price + without_last(cost);
        let price = if is_more_expensive { best_price } else { price(&plan, cost) };
        if price < best_price {
            (best_price, best) = (price, plan);
        }
    };
    offer(input::plan(prepared, graph));
    if effort.level() >= QUAD_ROWS_LEVEL
        && let Ok(plan) = quad_rows::plan(prepared, graph, QUAD_ROWS_CUTOFF, seed)
    {
        offer(plan);
    }
    (best, best_price)
}

/// Returns the cost of the strips of a plan.
fn price(plan: &StripPlan<'_>, cost: Cost) -> usize {
    let strips = plan.cover.path_count();
    match cost {
        Cost::Restart => plan.indices_restart(),
        Cost::OpenGl => cover_cost(plan.triangulation.graph(), &plan.cover) - strips,
        Cost::Degenerate => joined(plan),
        Cost::Gl => plan.cover.len() + 2 * strips,
    }
}

/// Returns whether no plan is cheaper than this one: it has one strip per component and no swaps
/// that cost anything.
fn is_lowest_possible(plan: &StripPlan<'_>, price: usize, cost: Cost) -> bool {
    let (triangles, strips) = (plan.cover.len(), plan.cover.path_count());
    let strip = cost.prices().strip.unsigned_abs() as usize;
    // A join by degenerate triangles has a different price than a restart.
    (cost != Cost::Degenerate || strips == 1)
        && price + without_last(cost) == triangles + strip * strips
        && plan.triangulation.graph().has_components(strips)
}

/// Returns the number of indices of a plan's strips joined by degenerate triangles.
fn joined(plan: &StripPlan<'_>) -> usize {
    plan.strips().to_degenerate().len()
}

/// Returns the number of indices that the prices count after the last strip. They occur only
/// between strips.
fn without_last(cost: Cost) -> usize {
    match cost {
        Cost::Restart | Cost::Degenerate => 1,
        Cost::OpenGl | Cost::Gl => 0,
    }
}

/// Distributes the sweeps of an effort over the phases.
fn phases(cost: Cost, effort: Effort, triangle_count: usize) -> Vec<AnnealingPhase> {
    let rounds = (SMALL / triangle_count.max(1)).clamp(1, MAX_ROUNDS) as u32;
    let sweeps = SWEEPS[usize::from(effort.level())] * rounds;
    let scale = if cost == Cost::Gl { 0.8 } else { 1.0 };
    let cold =
        AnnealingPhase { sweeps: sweeps.min(10 + sweeps / 10), hottest: 0.3 * scale, coldest: 0.15 * scale };
    let hot = AnnealingPhase { sweeps: sweeps - cold.sweeps, hottest: 0.9 * scale, coldest: 0.15 * scale };
    [cold, hot].into_iter().filter(|phase| phase.sweeps > 0).collect()
}
