//! `fewest`: as few strips as can be found. Ends of strips wander until two of different strips meet and are joined; where they
//! do not meet by themselves, one is led to the other.
//!
//! ```text
//!   walk   w ┄┄ v ━━ x        link w–v, cut v–x: x is the new end. One path stays one path (v inside w's own path, x toward w:
//!                             a rotation), or two paths stay two (v inside another one, x on either side)
//!   join   w ┄┄ y             y is an end of another path: one path fewer
//!   close  w ┄┄ h, y ┄┄ v     h is the other end of w's path: link w–h, and the path may be opened beside any of its
//!                             triangles, so also at v, where the end y of another path is joined to it
//!   lead   p ─ ─ a┃x ─ ─ q    cut a–x ahead of p on the way to q, walk with a, x and p until two of them join: the third is p
//!                             now. Where it is nearer to q, or not much farther, go on; else undo
//! ```
//! # Algorithm
//! The tunnels of Stewart (2001) and of Porcu and Scateni, taken as rotations of Pósa (1976): at an end w a link is made, which asks
//! for a cut, which makes a new end, and so on. Every state on the way is a cover of paths, so that no loop can arise, and a walk
//! may be as long as one likes. Each component is worked on by itself, from the cover of `sequential`, until it meets its lower bound
//! or the steps of the effort are done.
//!
//! 1. *Tunnel* (see [`super::eta`]): the long tunnels of `eta` make most of the joins in components that are not large, and are
//!    better than walks at ends that are stuck at a boundary.
//! 2. *Walk* from random ends. In a triangle of three neighbours the way on is mostly forced; where it leads into another path, the
//!    side of the cut is drawn by lot. While there are many ends, two soon meet.
//! 3. *Close* paths while there are few of them: their ends meet as often as those of different paths do, and it is all the same
//!    where a closed path is opened.
//! 4. *Lead* when there was no join for a while. The orbits of the last few ends are often short, so that they never meet. A cut
//!    makes two more ends, which soon join again, but not in the way that they were joined; so an end moves
//!    ahead on the shortest way to another one. That takes a few dozen cuts, each undone unless it leads nearer.
//!
//! The module `strands` makes a step take about 0.3 µs, whatever the length of the paths.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001; Porcu, Scateni: *Partitioning Meshes
//! into Strips using the Enhanced Tunnelling Algorithm (ETA)*, 2006; Pósa: *Hamiltonian circuits in random graphs*, 1976.
//!
//! # Complexity
//! A step takes O(√(n / paths)). 40 bytes a triangle beyond the cover, and 21 more for the components that are worked on, where there
//! are several.

mod components;
mod field;
mod strands;
#[cfg(test)]
mod tests;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use super::bound::least_strips;
use super::{Effort, EtaOptions, Progress, StripPlan, Watch, eta, sequential};
use crate::cover::PathCover;
use crate::prepare::PreparedFaces;
use crate::random::Random;
use crate::{DualGraph, stripify::fewest::components::Component};
use field::Field;
use strands::{Step, Strands};

/// After so many steps without a join an end is led to another. Tuned, as all below, on horse, armadillo, buddha and david: 60 and
/// 1000 take half as long again.
const PATIENCE: u64 = 300;
/// How far ahead an end is led at once, in triangles.
const LEAP: usize = 8;
/// Cuts that may bring an end no nearer than it was before, until it is let go.
const ATTEMPTS: usize = 60;
/// By how much an end may fall back, in triangles.
const SLACK: u32 = 6;
/// After a cut each of the three ends has a turn of at most so many steps.
const TURN_STEPS: usize = 16;
/// An end is led to one of so many nearest.
const NEAREST: usize = 3;
/// Paths are closed only while there are so few, since the ends of all are looked at.
const CLOSING_LIMIT: usize = 64;
/// Paths are numbered anew when so many of them are touched,
const TOUCHED_LIMIT: usize = 16;
/// or when they are cut to so many segments for each root of the triangles of a path on average, at least and at most:
const SEGMENTS_PER_ROOT: usize = 4;
const SEGMENT_LIMITS: (usize, usize) = (32, 4096);
/// Triangles that count as a step when distances are found.
const REACHED_PER_STEP: u64 = 64;

/// Accesses to triangles in tunnels that take about as long as a step of a walk.
const ACCESSES_PER_STEP: u64 = 64;
/// Components of at most so many triangles are tunnelled first. In larger ones tunnels take longer than walks for the same.
const TUNNEL_LIMIT: usize = 1 << 18;
/// Steps for each four triangles of a component at effort 0; each level doubles them.
const STEPS_PER_FOUR_TRIANGLES: u64 = 5;
/// Steps that even the smallest component gets.
const LEAST_STEPS: u64 = 10_000;

pub(super) fn plan<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    effort: Effort,
    seed: u64,
    watch: &dyn Watch,
) -> StripPlan<'a> {
    let StripPlan { triangulation, mut cover, .. } = sequential::plan(surface, graph);
    let floors = least_strips(triangulation.graph());
    reduce(triangulation.graph(), &mut cover, &floors, effort, seed, watch);
    StripPlan::new(triangulation, cover)
}

/// Joins paths until no component has more than its floor, or the effort is spent.
fn reduce(
    graph: &DualGraph,
    cover: &mut PathCover,
    floors: &[usize],
    effort: Effort,
    seed: u64,
    watch: &dyn Watch,
) {
    let mut components = components::unfinished(graph, cover, floors);
    let budget = |triangle_count: usize| {
        LEAST_STEPS + ((STEPS_PER_FOUR_TRIANGLES * triangle_count as u64) << effort.level()) / 4
    };
    let tally = Tally {
        watch,
        steps: AtomicU64::new(0),
        step_limit: components.iter().map(|c| budget(c.triangle_count())).sum(),
        strips: AtomicUsize::new(cover.path_count()),
        stopped: AtomicBool::new(false),
    };
    let search = |component: &mut Component| {
        let (first, floor) = (u64::from(component.first_triangle()), component.floor());
        let mut budget = budget(component.triangle_count());
        let (graph, cover) = component.parts();
        if cover.len() <= TUNNEL_LIMIT {
            let told = Mutex::new((0, cover.path_count()));
            let watch = TunnelWatch { floor, budget, tally: &tally, told };
            eta::join(graph, cover, EtaOptions::default(), seed, &watch);
            budget -= watch.tell(None, cover.path_count()).0.min(budget);
        }
        Search::new(graph.twins(), cover, Random::new(seed ^ first << 32)).run(floor, budget, &tally);
    };
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        components.par_iter_mut().for_each(search);
    }
    #[cfg(not(feature = "rayon"))]
    components.iter_mut().for_each(search);
    for component in components {
        component.put_back(graph, cover);
    }
}

/// What all components together have reached.
struct Tally<'a> {
    watch: &'a dyn Watch,
    steps: AtomicU64,
    step_limit: u64,
    strips: AtomicUsize,
    stopped: AtomicBool,
}

impl Tally<'_> {
    /// Adds steps and joins, and tells whether the search shall go on.
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

/// Watches tunnelling in one component, which shall end at the floor, or when the budget is spent.
struct TunnelWatch<'a> {
    floor: usize,
    budget: u64,
    tally: &'a Tally<'a>,
    /// Steps and paths when the tally was told last.
    told: Mutex<(u64, usize)>,
}

impl TunnelWatch<'_> {
    /// Tells the tally what there is since last time. Gives the steps so far, and whether the search shall go on.
    fn tell(&self, steps: Option<u64>, path_count: usize) -> (u64, bool) {
        let Ok(mut told) = self.told.lock() else { return (0, false) };
        let steps = steps.unwrap_or(told.0);
        let goes_on = self.tally.go_on(steps - told.0, told.1.saturating_sub(path_count));
        *told = (steps, path_count);
        (steps, goes_on)
    }
}

impl Watch for TunnelWatch<'_> {
    fn go_on(&self, progress: Progress) -> bool {
        let (steps, goes_on) = self.tell(Some(progress.steps / ACCESSES_PER_STEP), progress.strips);
        goes_on && progress.strips > self.floor && steps < self.budget
    }
}

/// The search in one component.
struct Search<'a> {
    strands: Strands<'a>,
    field: Field<'a>,
    random: Random,
    triangle_count: usize,
    steps: u64,
    /// The step of the last join, or of the last time that an end was led.
    last_join: u64,
}

impl<'a> Search<'a> {
    fn new(twins: &'a [u32], cover: &'a mut PathCover, random: Random) -> Self {
        Self {
            triangle_count: cover.len(),
            strands: Strands::new(twins, cover),
            field: Field::new(twins),
            random,
            steps: 0,
            last_join: 0,
        }
    }

    /// Searches until there are no more than `floor` paths, or for about `budget` steps.
    fn run(&mut self, floor: usize, budget: u64, tally: &Tally<'_>) {
        let mut told = (self.steps, self.strands.path_count());
        while self.strands.path_count() > floor && self.steps < budget {
            self.round(floor, budget);
            self.strands.settle();
            let now = (self.steps, self.strands.path_count());
            if !tally.go_on(now.0 - told.0, told.1 - now.1) {
                return;
            }
            told = now;
        }
    }

    /// Searches until it is time to number the paths anew.
    fn round(&mut self, floor: usize, budget: u64) {
        let mean = self.triangle_count / self.strands.path_count();
        let segment_limit = (SEGMENTS_PER_ROOT * mean.isqrt()).clamp(SEGMENT_LIMITS.0, SEGMENT_LIMITS.1);
        let walk_limit = (4 * mean).clamp(16, 1024);
        // Ends that are stuck make steps, but no segments.
        let step_limit = budget.min(self.steps + 8 * segment_limit as u64);
        while self.strands.path_count() > floor
            && self.steps < step_limit
            && self.strands.segment_count() < segment_limit
            && self.strands.touched_count() < TOUCHED_LIMIT
        {
            if self.steps - self.last_join > PATIENCE {
                self.lead(2 * segment_limit);
                self.last_join = self.steps;
            } else {
                self.walk(walk_limit);
            }
        }
    }

    /// Walks from a random end until it joins another.
    fn walk(&mut self, limit: usize) {
        let mut walker = self.strands.random_end(&mut self.random);
        for _ in 0..limit {
            self.steps += 1;
            match self.strands.step(walker, CLOSING_LIMIT, &mut self.random) {
                Step::Joined => {
                    self.last_join = self.steps;
                    return;
                }
                Step::Moved(moved) => walker = moved,
                Step::Stuck => return,
            }
        }
    }

    /// Leads a random end to one nearby, as long as it comes nearer.
    fn lead(&mut self, segment_limit: usize) {
        let walker = self.strands.random_end(&mut self.random);
        let (mut end, _) = self.strands.end(walker);
        if !self.set_goal(end) {
            return;
        }
        let path_count = self.strands.path_count();
        let mut failures = 0;
        let mut nearest = self.field.distance(end);
        self.strands.save();
        while failures < ATTEMPTS
            && self.strands.segment_count() < segment_limit
            && self.strands.touched_count() < 2 * TOUCHED_LIMIT
        {
            let ends = self.shift(end);
            if self.strands.path_count() < path_count {
                return;
            }
            failures += 1;
            let limit = self.field.distance(end) + SLACK;
            let left = ends.into_iter().flatten().filter(|&e| self.strands.is_end(e));
            match left.min_by_key(|&e| self.field.distance(e)) {
                Some(e) if self.field.distance(e) <= limit => {
                    if self.field.distance(e) < nearest {
                        nearest = self.field.distance(e);
                        failures = 0;
                    }
                    end = e;
                    self.strands.save();
                }
                _ => self.strands.restore(),
            }
        }
    }

    /// Finds the distances to one of the ends nearest to this one; `false` where there is none.
    fn set_goal(&mut self, end: u32) -> bool {
        let mut ends_left = 1 + self.random.below(NEAREST);
        let strands = &self.strands;
        let goal = self.field.spread(end, |t| {
            ends_left -= usize::from(strands.is_end(t));
            ends_left == 0
        });
        self.steps += 1 + self.field.reached_count() as u64 / REACHED_PER_STEP;
        let Some(goal) = goal else { return false };
        self.field.spread(goal, |t| t == end);
        self.steps += self.field.reached_count() as u64 / REACHED_PER_STEP;
        true
    }

    /// Cuts a path ahead of an end, on the way to the goal, and walks from the three ends until two are joined. Gives the three, two
    /// of which are no ends any more, or `None` where none met.
    fn shift(&mut self, end: u32) -> Option<[u32; 3]> {
        self.steps += 1;
        let leap = 1 + self.random.below(LEAP);
        let ahead = self.field.toward(end, leap, &mut self.random);
        let cut = self.strands.cut_behind(ahead)?;
        let twin = self.strands.twin(cut);
        // The two must not be joined again as they were.
        let mut ends = [(cut / 3, Some(cut)), (twin / 3, Some(twin)), (end, None)];
        let first = self.random.below(ends.len());
        for turn in (first..first + ends.len()).map(|turn| turn % 3) {
            let (t, back) = ends[turn];
            let Some(mut walker) = self.strands.walker(t, back) else { continue };
            for _ in 0..=self.random.below(TURN_STEPS) {
                self.steps += 1;
                match self.strands.step(walker, CLOSING_LIMIT, &mut self.random) {
                    Step::Joined => return Some(ends.map(|(t, _)| t)),
                    Step::Moved(moved) => walker = moved,
                    Step::Stuck => break,
                }
            }
            ends[turn] = self.strands.end(walker);
        }
        None
    }
}
