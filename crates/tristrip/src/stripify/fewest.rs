//! `fewest`: a local search that minimizes the number of strips. The ends of paths move until the
//! ends of two different paths are adjacent and can be joined. If this takes too long, one end is
//! guided to another.
//!
//! ```text
//!   rotation walk  w ┄┄ v ━━ x        link w–v, cut v–x: x is the new end. If v is inside w's own
//!                                     path, x is on the side of w (a rotation) and the path stays
//!                                     one path. If v is inside another path, x is on either side,
//!                                     and two paths remain.
//!   join           w ┄┄ y             y is an end of another path: one path fewer
//!   close          w ┄┄ h, y ┄┄ v     h is the other end of w's path: link w–h. The closed path
//!                                     can be opened next to any of its triangles, for example at
//!                                     v, to which the end y of another path is joined.
//!   guided walk    p ─ ─ a┃x ─ ─ q    cut a–x ahead of p on the way to q, and walk from a, x and p
//!                                     until two of them join. The third is the new p. Continue if
//!                                     it is not much farther from q; otherwise undo.
//! ```
//! # Algorithm
//! The tunnels of Stewart (2001) and of Porcu and Scateni are implemented as rotations of Pósa
//! (1976): a new link at an end w requires a cut, which creates a new end, and so on. Every
//! intermediate state is a path cover. No cycle can arise, and a walk may have any length. Each
//! component is searched separately, starting from the cover of `sequential`, until the number of
//! strips reaches its lower bound or the steps of the effort are used up.
//!
//! 1. *Tunnels* (see [`super::guided_tunnels`]): in components that are not large, the long tunnels
//!    of `guided-tunnels` make most of the joins. They work better than walks for ends at a
//!    boundary, where walks get stuck.
//! 2. *Rotation walks* start at random ends. In a triangle with three neighbours the next step is
//!    usually forced. If the step enters another path, the side of the cut is random. While there
//!    are many ends, two of them soon meet.
//! 3. *Close* paths while there are few of them. The two ends of one path meet as often as the ends
//!    of different paths, and a closed path can be opened anywhere.
//! 4. *Guided walks* start after some time without a join. The orbits of the last few ends are
//!    often short and never meet. A cut creates two more ends, which soon join again, but in a
//!    different way. This moves an end along the shortest way to another one. It takes a few dozen
//!    cuts, and each cut is undone unless it brings the end closer.
//!
//! With [`SegmentedPaths`] a step takes about 0.3 µs, regardless of the length of the paths.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001; Porcu,
//! Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*, 2006;
//! Pósa: *Hamiltonian circuits in random graphs*, 1976.
//!
//! # Complexity
//! A step takes O(√(n / paths)). 40 bytes per triangle in addition to the cover, and 21 more for
//! the searched components if there are several.

mod components;
mod distance_map;
mod segmented_paths;
#[cfg(test)]
mod tests;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use super::bound::strip_lower_bounds;
use super::options::{StripifyOptions, TunnelOptions};
use super::plan::StripPlan;
use super::watch::{Progress, Watch};
use super::{guided_tunnels, sequential};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::effort::Effort;
use crate::prepare::PreparedFaces;
use crate::random::Random;
use components::UnfinishedComponent;
use distance_map::DistanceMap;
use segmented_paths::{SegmentedPaths, WalkStep};

/// Steps without a join after which a guided walk starts. This and the following constants were
/// tuned on horse, armadillo, buddha and david; 60 and 1000 take 1.5 times as long.
const PATIENCE: u64 = 300;
/// Maximum number of triangles that a guided end advances at once.
const LEAP: usize = 8;
/// Cuts without progress after which a guided walk ends.
const ATTEMPTS: usize = 60;
/// Maximum number of triangles that a guided end may move away from its goal.
const SLACK: u32 = 6;
/// Maximum number of steps of each of the three ends after a cut.
const TURN_STEPS: usize = 16;
/// Number of nearest ends among which the goal of a guided walk is chosen.
const NEAREST: usize = 3;
/// Paths are closed only while there are at most this many, because the ends of all paths are
/// examined.
const CLOSING_LIMIT: usize = 64;
/// Paths are renumbered when this many of them are touched,
const TOUCHED_LIMIT: usize = 16;
/// or when the number of segments exceeds this multiple of the square root of the mean path length,
/// within these limits:
const SEGMENTS_PER_ROOT: usize = 4;
const SEGMENT_LIMITS: (usize, usize) = (32, 4096);
/// Number of triangles reached by a distance map that count as one step.
const REACHED_PER_STEP: u64 = 64;

/// Number of triangle accesses of tunnels that take about as long as a step of a walk.
const ACCESSES_PER_STEP: u64 = 64;
/// Maximum number of triangles of a component in which tunnels are tried first. In larger ones they
/// take longer than walks for the same result.
const TUNNEL_LIMIT: usize = 1 << 18;
/// Steps per four triangles of a component at effort 0. Each level doubles them.
const STEPS_PER_FOUR_TRIANGLES: u64 = 5;
/// Minimum number of steps of a component.
const MIN_STEPS: u64 = 10_000;

/// Chooses a cover with as few paths as the effort finds.
pub(super) fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let StripPlan { triangulation, mut cover, .. } = sequential::plan(prepared, graph);
    let lower_bounds = strip_lower_bounds(triangulation.graph());
    reduce_paths(triangulation.graph(), &mut cover, &lower_bounds, options, watch);
    StripPlan::new(triangulation, cover)
}

/// Joins paths until each component meets its lower bound or the effort is used up.
fn reduce_paths(
    graph: &DualGraph,
    cover: &mut PathCover,
    lower_bounds: &[usize],
    options: &StripifyOptions,
    watch: &dyn Watch,
) {
    let mut components = components::unfinished(graph, cover, lower_bounds);
    let step_limit =
        components.iter().map(|c| step_budget(c.triangle_count(), options.effort_or_default())).sum();
    let shared = SharedProgress::new(watch, step_limit, cover.path_count());
    let search = |component: &mut UnfinishedComponent| search_component(component, options, &shared);
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        components.par_iter_mut().for_each(search);
    }
    #[cfg(not(feature = "rayon"))]
    components.iter_mut().for_each(search);
    for component in components {
        component.write_back(graph, cover);
    }
}

/// Returns the number of steps of a component.
fn step_budget(triangle_count: usize, effort: Effort) -> u64 {
    MIN_STEPS + ((STEPS_PER_FOUR_TRIANGLES * triangle_count as u64) << effort.level()) / 4
}

/// Searches one component, first by tunnels, then by walks.
fn search_component(
    component: &mut UnfinishedComponent,
    options: &StripifyOptions,
    shared: &SharedProgress<'_>,
) {
    let seed = options.seed;
    let (first, lower_bound) = (u64::from(component.first_triangle()), component.lower_bound());
    let mut budget = step_budget(component.triangle_count(), options.effort_or_default());
    let (graph, cover) = component.graph_and_cover();
    if cover.len() <= TUNNEL_LIMIT {
        let reported = Mutex::new((0, cover.path_count()));
        let watch = TunnelWatch { lower_bound, budget, shared, reported };
        guided_tunnels::join(graph, cover, TunnelOptions::default(), seed, &watch);
        budget -= watch.report(None, cover.path_count()).0.min(budget);
    }
    FewestSearch::new(graph, cover, Random::new(seed ^ first << 32)).run(lower_bound, budget, shared);
}

/// The progress of all components.
struct SharedProgress<'a> {
    watch: &'a dyn Watch,
    steps: AtomicU64,
    step_limit: u64,
    strips: AtomicUsize,
    stopped: AtomicBool,
}

impl<'a> SharedProgress<'a> {
    fn new(watch: &'a dyn Watch, step_limit: u64, strip_count: usize) -> Self {
        Self {
            watch,
            steps: AtomicU64::new(0),
            step_limit,
            strips: AtomicUsize::new(strip_count),
            stopped: AtomicBool::new(false),
        }
    }

    /// Adds steps and joins. Returns whether to continue the search.
    fn go_on(&self, steps: u64, joins: usize) -> bool {
        let strips = self.strips.fetch_sub(joins, Ordering::Relaxed) - joins;
        let steps = self.steps.fetch_add(steps, Ordering::Relaxed) + steps;
        let progress = Progress { steps, step_limit: Some(self.step_limit), strips, cost: strips };
        if !self.watch.go_on(progress) {
            self.stopped.store(true, Ordering::Relaxed);
        }
        !self.stopped.load(Ordering::Relaxed)
    }
}

/// Watches tunnelling in one component, which ends at the lower bound or when the budget is used
/// up.
struct TunnelWatch<'a> {
    lower_bound: usize,
    budget: u64,
    shared: &'a SharedProgress<'a>,
    /// Steps and paths at the last report to `shared`.
    reported: Mutex<(u64, usize)>,
}

impl TunnelWatch<'_> {
    /// Reports the progress since the last report. Returns the steps so far, and whether to
    /// continue the search.
    fn report(&self, steps: Option<u64>, path_count: usize) -> (u64, bool) {
        let Ok(mut reported) = self.reported.lock() else { return (0, false) };
        let steps = steps.unwrap_or(reported.0);
        let goes_on = self.shared.go_on(steps - reported.0, reported.1.saturating_sub(path_count));
        *reported = (steps, path_count);
        (steps, goes_on)
    }
}

impl Watch for TunnelWatch<'_> {
    fn go_on(&self, progress: Progress) -> bool {
        let (steps, goes_on) = self.report(Some(progress.steps / ACCESSES_PER_STEP), progress.strips);
        goes_on && progress.strips > self.lower_bound && steps < self.budget
    }
}

/// The walks in one component.
struct FewestSearch<'a> {
    paths: SegmentedPaths<'a>,
    distances: DistanceMap<'a>,
    random: Random,
    triangle_count: usize,
    steps: u64,
    /// The step of the last join or guided walk.
    last_join: u64,
}

impl<'a> FewestSearch<'a> {
    fn new(graph: &'a DualGraph, cover: &'a mut PathCover, random: Random) -> Self {
        Self {
            triangle_count: cover.len(),
            paths: SegmentedPaths::new(graph, cover),
            distances: DistanceMap::new(graph),
            random,
            steps: 0,
            last_join: 0,
        }
    }

    /// Searches until there are at most `lower_bound` paths, or for about `budget` steps.
    fn run(&mut self, lower_bound: usize, budget: u64, shared: &SharedProgress<'_>) {
        let mut reported = (self.steps, self.paths.path_count());
        while self.paths.path_count() > lower_bound && self.steps < budget {
            self.round(lower_bound, budget);
            self.paths.renumber_touched();
            let now = (self.steps, self.paths.path_count());
            if !shared.go_on(now.0 - reported.0, reported.1 - now.1) {
                return;
            }
            reported = now;
        }
    }

    /// Searches until the paths have to be renumbered.
    fn round(&mut self, lower_bound: usize, budget: u64) {
        let mean = self.triangle_count / self.paths.path_count();
        let segment_limit = (SEGMENTS_PER_ROOT * mean.isqrt()).clamp(SEGMENT_LIMITS.0, SEGMENT_LIMITS.1);
        let walk_limit = (4 * mean).clamp(16, 1024);
        // Ends that are stuck make steps but no segments.
        let step_limit = budget.min(self.steps + 8 * segment_limit as u64);
        while self.paths.path_count() > lower_bound
            && self.steps < step_limit
            && self.paths.segment_count() < segment_limit
            && self.paths.touched_count() < TOUCHED_LIMIT
        {
            if self.steps - self.last_join > PATIENCE {
                self.guided_walk(2 * segment_limit);
                self.last_join = self.steps;
            } else {
                self.rotation_walk(walk_limit);
            }
        }
    }

    /// Walks from a random end until it joins another one, for at most `limit` steps.
    fn rotation_walk(&mut self, limit: usize) {
        let mut end = self.paths.random_end(&mut self.random);
        for _ in 0..limit {
            self.steps += 1;
            match self.paths.step(end, CLOSING_LIMIT, &mut self.random) {
                WalkStep::Joined => {
                    self.last_join = self.steps;
                    return;
                }
                WalkStep::Moved(moved) => end = moved,
                WalkStep::Stuck => return,
            }
        }
    }

    /// Guides a random end to a nearby one, as long as it gets closer.
    fn guided_walk(&mut self, segment_limit: usize) {
        let end = self.paths.random_end(&mut self.random);
        let (mut end, _) = self.paths.triangle_and_back(end);
        let Some(mut distance) = self.set_goal(end) else { return };
        let path_count = self.paths.path_count();
        let mut failures = 0;
        let mut nearest = distance;
        self.paths.save();
        while failures < ATTEMPTS
            && self.paths.segment_count() < segment_limit
            && self.paths.touched_count() < 2 * TOUCHED_LIMIT
        {
            let ends = self.guided_step(end);
            if self.paths.path_count() < path_count {
                return;
            }
            failures += 1;
            let left = ends.into_iter().flatten().filter(|&e| self.paths.is_end(e));
            let known = left.filter_map(|e| Some((self.distances.distance(e)?, e)));
            match known.min_by_key(|&(distance, _)| distance) {
                Some((new_distance, new_end)) if new_distance <= distance + SLACK => {
                    if new_distance < nearest {
                        nearest = new_distance;
                        failures = 0;
                    }
                    (distance, end) = (new_distance, new_end);
                    self.paths.save();
                }
                _ => self.paths.restore(),
            }
        }
    }

    /// Computes the distances to one of the ends nearest to `end`. Returns the distance of `end`,
    /// or `None` if there is no other end.
    fn set_goal(&mut self, end: u32) -> Option<u32> {
        let mut ends_left = 1 + self.random.below(NEAREST);
        let paths = &self.paths;
        let goal = self.distances.search_from(end, |t| {
            ends_left -= usize::from(paths.is_end(t));
            ends_left == 0
        });
        self.steps += 1 + self.distances.reached_count() as u64 / REACHED_PER_STEP;
        self.distances.search_from(goal?, |t| t == end);
        self.steps += self.distances.reached_count() as u64 / REACHED_PER_STEP;
        self.distances.distance(end)
    }

    /// Cuts a path ahead of an end, on the way to the goal, and walks from the three ends until two
    /// are joined. Returns the three triangles, of which two are no longer ends, or `None` if no
    /// two met.
    fn guided_step(&mut self, end: u32) -> Option<[u32; 3]> {
        self.steps += 1;
        let leap = 1 + self.random.below(LEAP);
        let ahead = self.distances.toward_goal(end, leap, &mut self.random);
        let cut = self.paths.cut_after(ahead)?;
        let twin = self.paths.twin(cut);
        // The two must not be joined again in the same way.
        let mut ends = [(cut / 3, Some(cut)), (twin / 3, Some(twin)), (end, None)];
        let first = self.random.below(ends.len());
        for turn in (first..first + ends.len()).map(|turn| turn % 3) {
            let (t, back) = ends[turn];
            let Some(mut walk_end) = self.paths.walk_end(t, back) else { continue };
            for _ in 0..=self.random.below(TURN_STEPS) {
                self.steps += 1;
                match self.paths.step(walk_end, CLOSING_LIMIT, &mut self.random) {
                    WalkStep::Joined => return Some(ends.map(|(t, _)| t)),
                    WalkStep::Moved(moved) => walk_end = moved,
                    WalkStep::Stuck => break,
                }
            }
            ends[turn] = self.paths.triangle_and_back(walk_end);
        }
        None
    }
}
