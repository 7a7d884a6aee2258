//! `cache`: strips in an order that respects a vertex buffer, at few indices.
//!
//! A strip that winds its way across the mesh leaves two long borders behind, and when its neighbours are drawn, the vertices
//! there have long left the buffer. Short strips side by side find them still in it, but each begins anew with three vertices
//! and a restart. What is worth more depends on the hardware, so that both are weighed:
//! `index weight × indices + miss weight × misses`.
//!
//! ```text
//!  ═══════════════════════   drawn
//!  ╲╱╲╱╲╱╲╱╲╱╲╱╲╱╲╱ ─▶       a strip along the border of what is drawn: one row of its vertices are hits,
//!  ○ . . . . . . . .          and it leaves the other row in the buffer
//!  ╰─ there the next strip begins, as soon as going on would cost more than a restart
//! ```
//!
//! # Algorithm
//! A strip is grown triangle by triangle along the border of what is drawn (Hoppe 1999, section 5). At each decision:
//! 1. *Look ahead.* Lay down, for trial, as many triangles as the horizon has: first n more of this strip, then a restart at the
//!    oldest place of the border whose vertices are still in the buffer, and so on as strips end by themselves. Try n = 0, 1, 2, 4 …
//! 2. *Take the cheapest* n by its cost a triangle, undo the trial, and lay down these n for good; n = 0 is a restart.
//! 3. Where no place of the border is in the buffer any more, go on from where something was drawn last, else from the lowest
//!    triangle left.
//!
//! A strip turns toward the border as long as it can. This takes a swap where a vertex has not three triangles left, and leaves no
//! triangle behind alone.
//!
//! Where few indices are preferred, the strips are those of `best`, and only their order and direction are chosen: next comes the
//! strip at the border's oldest place, from its cheaper end. From effort 3 on, other growths are tried too, some of them guided by the
//! strips of another method, which they follow, cut, and go on from; the cheapest is taken. From there a search goes on by exchanges
//! between strips, cuts, turns and moves in the order (module `polish`), for FIFO buffers of up to 256 places.
//!
//! # Effort
//! On one core, for the bunny of 69,451 triangles and a FIFO buffer of 16 places: indices and misses a triangle.
//!
//! | level | 0 to 2 | 3 | 4 | 5 | 6 |
//! |---|---|---|---|---|---|
//! | indices | 1.162, 0.989 | 1.140, 0.975 | 1.128, 0.973 | 1.120, 0.971 | 1.114, 0.967 |
//! | balanced | 1.329, 0.796 | 1.239, 0.829 | 1.232, 0.805 | 1.227, 0.786 | 1.217, 0.786 |
//! | misses | 1.426, 0.608 | 1.401, 0.599 | 1.390, 0.596 | 1.380, 0.593 | 1.373, 0.592 |
//! | seconds, balanced | 0.05 | 0.4 | 0.8 | 2 | 3.5 |
//!
//! meshoptimizer's two orders give 1.334, 0.890 and 1.741, 0.706 there.
//!
//! Departures from Hoppe: indices are weighed, not only misses; triangles left behind with one neighbour or none count as the
//! restarts that they will need; a restart keeps away from vertices that are about to leave the buffer; and all n triangles are
//! laid down at once, which is several times faster and hardly worse.
//!
//! # References
//! Hoppe: *Optimization of mesh locality for transparent vertex caching*, 1999.
//!
//! # Complexity
//! O(h log h) time a decision for a horizon of h triangles, about twice the buffer's places; 18 bytes a triangle, and 2 more for a
//! FIFO buffer.

mod arrange;
mod border;
mod buffers;
mod grow;
mod polish;
#[cfg(test)]
mod tests;

use super::{Objective, Progress, StripPlan, StripifyOptions, Watch, best, sequential};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::prepare::PreparedFaces;
use crate::random::Random;
use crate::strip::Cost;
use crate::vertex_cache::{FlushPolicy, Replacement, VertexCache, VertexCacheStatistics};
use arrange::arrange;
use border::Border;
use buffers::{FifoTrial, LruTrial};
use grow::Grower;
use polish::Sequence;

/// What indices and misses cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Weights {
    index: i64,
    miss: i64,
}

/// Strips that a growth follows where they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Guide {
    None,
    Sequential,
    Best,
}

/// How strips are grown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Growth {
    guide: Guide,
    weights: Weights,
    /// Triangles of a trial, in sixteenths of the buffer's places.
    horizon: u32,
    /// Places of the buffer from its old end in which a vertex is no longer worth a restart, in sixteenths of all.
    slack: u32,
}

/// Trials of more triangles cost time and gain nothing.
const MOST_HORIZON: u32 = 64;
const LEAST_HORIZON: u32 = 12;
/// Buffers of fewer places hardly help, whatever the strips.
const LEAST_HELP: u32 = 8;
/// Larger LRU buffers are planned as if they had so many places: no trial reaches further.
const MOST_LRU_PLACES: u32 = 128;

const fn growth(guide: Guide, index: i64, miss: i64, horizon: u32, slack: u32) -> Growth {
    Growth { guide, weights: Weights { index, miss }, horizon, slack }
}

/// The growths for a balance, the first for every effort. Which lie where both are low was found on bunny, fandisk, horse and
/// armadillo with a FIFO buffer of 16 places; the weights of growth are not those of the choice, since a guide alone saves indices.
const BALANCED: [Growth; 8] = [
    growth(Guide::None, 8, 1, 32, 2),
    growth(Guide::Sequential, 1, 1, 24, 2),
    growth(Guide::Best, 1, 1, 24, 2),
    growth(Guide::None, 3, 1, 32, 2),
    growth(Guide::Best, 2, 3, 24, 2),
    growth(Guide::Sequential, 2, 3, 24, 2),
    growth(Guide::Best, 1, 1, 40, 2),
    growth(Guide::None, 6, 1, 36, 2),
];

/// The same for few misses.
const FEW_MISSES: [Growth; 8] = [
    growth(Guide::None, 1, 4, 28, 3),
    growth(Guide::None, 1, 4, 32, 3),
    growth(Guide::None, 1, 4, 28, 4),
    growth(Guide::None, 1, 2, 28, 3),
    growth(Guide::None, 1, 8, 28, 3),
    growth(Guide::None, 1, 4, 24, 3),
    growth(Guide::None, 1, 4, 36, 3),
    growth(Guide::None, 1, 2, 32, 4),
];
/// How many of them are tried, by effort.
const GROWTHS: [usize; 10] = [1, 1, 1, 3, 5, 8, 8, 8, 8, 8];

/// Vertices that the search by exchanges sends for trial for each triangle, by effort: a change takes some 150.
const SENT: [u64; 10] = [0, 0, 0, 300, 750, 1800, 3600, 7200, 14400, 28800];
/// Places of buffers that are searched over: what one holds is kept for each strip.
const SEARCHED: std::ops::RangeInclusive<u32> = 1..=256;

impl Objective {
    fn weights(self) -> Weights {
        match self {
            Self::Indices => Weights { index: 10, miss: 1 },
            Self::Balanced => Weights { index: 3, miss: 2 },
            Self::Misses => Weights { index: 1, miss: 4 },
        }
    }

    /// Gives the heat at which the search by exchanges begins and ends, in indices: what is few already is kept. Tuned on bunny,
    /// fandisk and armadillo.
    fn heat(self) -> [f64; 2] {
        match self {
            Self::Indices => [0.1, 0.03],
            Self::Balanced | Self::Misses => [1.0, 0.2],
        }
    }
}

pub(super) fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let start = start(prepared, graph, options, watch);
    let limit = SENT[usize::from(options.effort().level())] * start.cover.len() as u64;
    let is_searched = options.vertex_cache().replacement == Replacement::Fifo
        && SEARCHED.contains(&options.vertex_cache().entries);
    if limit == 0 || !is_searched {
        return start;
    }
    polished(start, limit, prepared.vertex_count(), options, watch)
}

/// Grows strips in one way or in several.
fn start<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let (buffer, prefer, seed) = (options.vertex_cache(), options.objective(), options.seed());
    let (effort, vertex_count) = (options.effort(), prepared.vertex_count());
    let guide = |guide| match guide {
        Guide::None => Triangulation::of_triangles(prepared, graph).map_or_else(
            || sequential::plan(prepared, graph),
            |triangulation| StripPlan::new(triangulation, PathCover::isolated(graph.face_count())),
        ),
        Guide::Sequential => sequential::plan(prepared, graph),
        Guide::Best => best::plan(prepared, graph, Cost::Restart, effort, seed, watch),
    };
    let growths = match prefer {
        Objective::Indices => return arranged(guide(Guide::Best), buffer, vertex_count),
        Objective::Balanced => BALANCED,
        Objective::Misses => FEW_MISSES,
    };
    let growths = &growths[..GROWTHS[usize::from(effort.level())]];
    let mut best = grown(&guide(growths[0].guide), growths[0], buffer, vertex_count);
    if growths.len() == 1 {
        return best;
    }
    let mut lowest = price(&best, buffer, prefer.weights(), vertex_count);
    let mut guides: [Option<StripPlan<'a>>; 3] = [const { None }; 3];
    // Where a buffer is too small to help, nothing is cheaper than `best` in order. A balance does not begin there: it would stay.
    let with_best = prefer == Objective::Misses || buffer.entries < LEAST_HELP;
    let candidates = growths[1..].iter().map(Some).chain(with_best.then_some(None));
    for (i, growth) in candidates.enumerate() {
        let progress = Progress {
            steps: i as u64,
            step_limit: Some(growths.len() as u64),
            strips: best.cover.path_count(),
            cost: lowest,
        };
        if !watch.go_on(progress) {
            break;
        }
        let kind = growth.map_or(Guide::Best, |growth| growth.guide);
        let guide = guides[kind as usize].get_or_insert_with(|| guide(kind));
        let plan = match growth {
            Some(&growth) => grown(guide, growth, buffer, vertex_count),
            None => arranged(guide.clone(), buffer, vertex_count),
        };
        let price = price(&plan, buffer, prefer.weights(), vertex_count);
        if price < lowest {
            (lowest, best) = (price, plan);
        }
    }
    best
}

/// Searches on from a plan by exchanges; gives what was found where that is cheaper.
fn polished<'a>(
    start: StripPlan<'a>,
    limit: u64,
    vertex_count: usize,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let (buffer, prefer, seed) = (options.vertex_cache(), options.objective(), options.seed());
    let Some(order) = &start.order else { return start };
    let before = price(&start, buffer, prefer.weights(), vertex_count);
    let mut sequence =
        Sequence::new(&start.triangulation, &start.cover, order, buffer.entries, prefer.weights());
    sequence.anneal(&mut Random::new(seed), limit, prefer.heat(), |steps, strips, saved| {
        watch.go_on(Progress {
            steps,
            step_limit: Some(limit),
            strips,
            cost: before.saturating_add_signed(-saved as isize),
        })
    });
    let (cover, order) = sequence.finish();
    let found = StripPlan { triangulation: start.triangulation.clone(), cover, order: Some(order) };
    if price(&found, buffer, prefer.weights(), vertex_count) < before { found } else { start }
}

/// Counts what a plan costs in the end.
fn price(plan: &StripPlan<'_>, buffer: VertexCache, weights: Weights, vertex_count: usize) -> usize {
    let strips = plan.strips();
    let misses = VertexCacheStatistics::of(&strips, buffer, FlushPolicy::Keep, vertex_count).misses;
    let indices = strips.vertices_sent() + strips.len();
    let [index, miss] = [weights.index, weights.miss].map(|weight| weight.unsigned_abs() as usize);
    index * indices + miss * misses
}

/// Lays strips down.
fn grown<'a>(
    guide: &StripPlan<'a>,
    growth: Growth,
    buffer: VertexCache,
    vertex_count: usize,
) -> StripPlan<'a> {
    let triangulation = guide.triangulation.clone();
    let cover = (growth.guide != Guide::None).then_some(&guide.cover);
    let (cover, order) = match buffer.replacement {
        Replacement::Fifo => {
            let trial = FifoTrial::new(buffer.entries, vertex_count);
            Grower::new(Border::new(&triangulation, trial, growth.weights), growth, cover).run()
        }
        Replacement::Lru => {
            let trial = LruTrial::new(buffer.entries.min(MOST_LRU_PLACES));
            Grower::new(Border::new(&triangulation, trial, growth.weights), growth, cover).run()
        }
    };
    StripPlan { triangulation, cover, order: Some(order) }
}

/// Puts the strips of a plan in order.
fn arranged(plan: StripPlan<'_>, buffer: VertexCache, vertex_count: usize) -> StripPlan<'_> {
    let StripPlan { triangulation, cover, .. } = plan;
    let weights = Objective::Indices.weights();
    let order = match buffer.replacement {
        Replacement::Fifo => {
            let trial = FifoTrial::new(buffer.entries, vertex_count);
            arrange(Border::new(&triangulation, trial, weights), &cover)
        }
        Replacement::Lru => {
            let trial = LruTrial::new(buffer.entries.min(MOST_LRU_PLACES));
            arrange(Border::new(&triangulation, trial, weights), &cover)
        }
    };
    StripPlan { triangulation, cover, order: Some(order) }
}
