//! `best`: our searching method. The cheapest cover that can be had for a cost that the user names and an effort.
//!
//! # Algorithm
//! 1. *Start*: the cheapest of the covers of `sequential`, `input` and `stripe`.
//! 2. *Cold*: annealing from a low temperature, which mends the start and keeps what is regular about it.
//! 3. *Hot*: annealing from a temperature at which the start is forgotten, slowly. On irregular meshes this gains the most.
//! 4. The cheapest of the three, by the cost as it is measured in the end, is the result, so that no effort makes it worse than
//!    the start.
//!
//! The changes that the annealing tries are those of the module `anneal`, made of joins and cuts whose prices the module `paths`
//! knows exactly. Polygons are cut anew on the way: to turn a diagonal is one more change.
//!
//! # Effort
//! A level is so many sweeps over the mesh, about twice as many as the level below. On one core, for the bunny of
//! 69,451 triangles and restarts:
//!
//! | level | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 |
//! |---|---|---|---|---|---|---|---|---|
//! | indices a triangle | 1.180 | 1.178 | 1.162 | 1.141 | 1.129 | 1.120 | 1.114 | 1.110 |
//! | times meshoptimizer's strip pipeline | 0.5 | 0.8 | 3 | 7 | 15 | 40 | 80 | 160 |
//! | seconds | 0.007 | 0.013 | 0.045 | 0.12 | 0.28 | 0.8 | 1.5 | 2.9 |
//!
//! Levels 8 and 9 take two and four times as long as 7. Larger meshes take longer in proportion, smaller ones as long, down to an
//! eighth of the size.
//!
//! # References
//! Kirkpatrick, Gelatt, Vecchi: *Optimization by Simulated Annealing*, 1983; Pósa: *Hamiltonian circuits in random graphs*, 1976
//! (rotations); Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001.
//!
//! # Complexity
//! O(sweeps · n) time, see [`SWEEPS`]; 16 bytes a triangle and those of the start; 13 more where there are polygons.

mod anneal;
#[cfg(test)]
mod tests;

use super::{Effort, Patches, StripPlan, Watch, input, sequential, stripe};
use crate::cover::priced::{PricedPaths, TRIANGLE_LIMIT};
use crate::dual::DualGraph;
use crate::prepare::PreparedFaces;
use crate::strip::{Cost, cover_cost};
use anneal::{Annealer, Phase};

/// Times that the annealing goes over the mesh, by effort. Tuned on the bunny; see the module's head.
const SWEEPS: [u32; 10] = [0, 1, 8, 36, 100, 300, 600, 1200, 2400, 4800];
/// Smaller meshes are gone over more often, up to so many times, so that a level's time is that of a mesh of this size.
const SMALL: usize = 1 << 16;
const MOST_ROUNDS: usize = 8;
/// From this level on the start may also be `stripe`'s, which takes longer than level 1 does.
const STRIPE_LEVEL: u8 = 2;

pub(super) fn plan<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    cost: Cost,
    effort: Effort,
    seed: u64,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let start = cheapest_start(surface, graph, cost, effort, seed);
    let phases = phases(cost, effort, start.cover.len());
    if phases.is_empty() || start.cover.is_empty() || start.cover.len() > TRIANGLE_LIMIT {
        return start;
    }
    let mut paths = PricedPaths::new(surface.faces(), &start.triangulation, &start.cover, cost.prices());
    // The prices of the search are those of the result, but where strips are joined.
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

/// Finds the cheapest of what the fast methods make.
fn cheapest_start<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    cost: Cost,
    effort: Effort,
    seed: u64,
) -> StripPlan<'a> {
    let mut best = sequential::plan(surface, graph);
    let mut best_price = price(&best, cost);
    let mut offer = |plan: StripPlan<'a>| {
        // The strips alone often tell: swaps are at most one for each triangle inside a strip.
        let [strips, most_strips] = [&plan, &best].map(|plan| plan.cover.path_count());
        let [strip, swap] =
            [cost.prices().strip, cost.prices().swap].map(|price| price.unsigned_abs() as usize);
        let inside = best.cover.len().saturating_sub(2 * most_strips);
        let is_dearer = cost != Cost::Degenerate && strip * strips > strip * most_strips + swap * inside;
        let price = if is_dearer { best_price } else { price(&plan, cost) };
        if price < best_price {
            (best_price, best) = (price, plan);
        }
    };
    offer(input::plan(surface, graph));
    if effort.level() >= STRIPE_LEVEL
        && let Ok(plan) = stripe::plan_global(surface, graph, Patches::Rows, 5, seed)
    {
        offer(plan);
    }
    best
}

/// Counts what a plan costs in the end.
fn price(plan: &StripPlan<'_>, cost: Cost) -> usize {
    let strips = plan.cover.path_count();
    match cost {
        Cost::Restart => plan.indices_restart(),
        Cost::OpenGl => cover_cost(plan.triangulation.graph(), &plan.cover) - strips,
        Cost::Degenerate => joined(plan),
        Cost::Gl => plan.cover.len() + 2 * strips,
    }
}

/// Counts the indices of a plan's strips joined by degenerate triangles.
fn joined(plan: &StripPlan<'_>) -> usize {
    plan.strips().to_degenerate().len()
}

/// Indices that stand only between strips, so that after the last one there are none.
fn without_last(cost: Cost) -> usize {
    match cost {
        Cost::Restart | Cost::Degenerate => 1,
        Cost::OpenGl | Cost::Gl => 0,
    }
}

/// Divides the sweeps of a level of effort.
fn phases(cost: Cost, effort: Effort, triangle_count: usize) -> Vec<Phase> {
    let rounds = (SMALL / triangle_count.max(1)).clamp(1, MOST_ROUNDS) as u32;
    let sweeps = SWEEPS[usize::from(effort.level())] * rounds;
    let scale = if cost == Cost::Gl { 0.8 } else { 1.0 };
    let cold = Phase { sweeps: sweeps.min(10 + sweeps / 10), hottest: 0.3 * scale, coldest: 0.15 * scale };
    let hot = Phase { sweeps: sweeps - cold.sweeps, hottest: 0.9 * scale, coldest: 0.15 * scale };
    [cold, hot].into_iter().filter(|phase| phase.sweeps > 0).collect()
}
