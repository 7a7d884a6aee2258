//! `sequential`: our fast method. Strips are peeled off greedily, each step weighing what it leaves behind, and the ends that
//! remain are then joined by small exchanges.
//!
//! # Algorithm
//! A strip that goes on costs one index a triangle, one more for a swap; a new strip costs three more. So swaps are cheap and ends
//! are dear: a triangle that is left with a single free neighbour will be the end of a strip, half of those three indices.
//!
//! ```text
//!          ╱╲  s   leaving over s takes a swap, over f none
//!         ╱ t╲     go to f, unless then s were left with one free neighbour while f would keep two:
//!   enter ────── f that swap (1) is cheaper than the end (1.5) that s would become
//! ```
//! 1. *Seed*: a triangle with the fewest free neighbours, the last come of them first, so that the free region is peeled
//!    from its rim, next to the last strip; where no triangle has lost a neighbour yet, the first in the input's order.
//! 2. *Run*: a strip's first turn is fixed by its winding, so that each exit of the seed makes one run. Each is tried, and the one
//!    of the least cost a triangle is kept.
//! 3. *Exchange*: at every end of a strip, see [`exchange`]. This also extends strips backward and folds isolated triangles in.
//!
//! Departures from the greedy methods of Evans et al. (1996): the tie between neighbours is broken by price, not by rule,
//! and strips are extended backward by the exchanges, which find the cheapest way to do it.
//!
//! # Complexity
//! O(n) time. Beyond the triangles, the dual graph and the cover: 5 bytes a triangle, and 4 for each triangle that loses a neighbour, while it waits.

pub(crate) mod exchange;

use super::Plan;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::mesh::{Surface, Triangulation};

const NONE: u32 = u32::MAX;
/// What a strip costs beyond one index a triangle: two vertices and the restart.
const STRIP: u32 = 3;
/// Marks a triangle that a strip has taken, in place of its number of free neighbours.
/// Triangles after which a trial run has shown what it costs; a tenth of it would still do for irregular meshes.
const TRIAL_LIMIT: u32 = 256;
const TAKEN: u8 = 0xff;

pub(super) fn plan<'a>(surface: &'a Surface<'_>, graph: &'a DualGraph) -> Plan<'a> {
    let triangulation = Triangulation::zigzag(surface, graph);
    let (mut cover, strip_of) = Peeler::new(triangulation.graph()).peel();
    exchange::improve(triangulation.graph(), &mut cover, strip_of);
    Plan { triangulation, cover }
}

#[inline]
fn next(edge: u32) -> u32 {
    if edge == 2 { 0 } else { edge + 1 }
}

#[inline]
fn previous(edge: u32) -> u32 {
    if edge == 0 { 2 } else { edge - 1 }
}

/// Peels strips off the free triangles.
struct Peeler<'a> {
    twins: &'a [u32],
    /// Free neighbours of each free triangle.
    free: Vec<u8>,
    /// The trial run that last passed each free triangle; the strip of each taken one.
    trial: Vec<u32>,
    trial_count: u32,
    strip_count: u32,
    /// Triangles with 0, 1 and 2 free neighbours when they were stacked.
    stacks: [Vec<u32>; 3],
    /// All triangles before this one are taken or stacked.
    first_untouched: u32,
    cover: PathCover,
}

impl<'a> Peeler<'a> {
    fn new(graph: &'a DualGraph) -> Self {
        let twins = graph.twins();
        let mut stacks: [Vec<u32>; 3] = Default::default();
        let free: Vec<u8> =
            twins.chunks_exact(3).map(|t| t.iter().filter(|&&h| h != NONE).count() as u8).collect();
        for t in (0..free.len() as u32).rev() {
            let count = free[t as usize];
            if count < 3 {
                stacks[usize::from(count)].push(t);
            }
        }
        let cover = PathCover::isolated(free.len());
        let trial = vec![0; free.len()];
        Self { twins, free, trial, trial_count: 0, strip_count: 0, stacks, first_untouched: 0, cover }
    }

    /// Gives the cover, and the strip of each triangle.
    fn peel(mut self) -> (PathCover, Vec<u32>) {
        while let Some(seed) = self.seed() {
            let exit = self.best_exit(seed);
            self.take(seed, exit.map_or(NONE, |exit| self.twins[exit as usize]));
            if let Some(exit) = exit {
                self.run(exit);
            }
            self.strip_count += 1;
        }
        (self.cover, self.trial)
    }

    /// Gives the exit of a free triangle whose run has the least cost a triangle, of equals the first.
    fn best_exit(&mut self, seed: u32) -> Option<u32> {
        let mut best: Option<(u32, (u32, u32))> = None;
        for exit in 3 * seed..3 * seed + 3 {
            if !self.is_free(self.twins[exit as usize]) {
                continue;
            }
            if self.free[seed as usize] == 1 {
                return Some(exit);
            }
            let run = self.try_run(seed, exit);
            let cheaper = |than: (u32, u32)| {
                u64::from(run.0) * u64::from(than.1) < u64::from(than.0) * u64::from(run.1)
            };
            if best.is_none_or(|(_, than)| cheaper(than)) {
                best = Some((exit, run));
            }
        }
        best.map(|(exit, _)| exit)
    }

    /// Gives a free triangle with the fewest free neighbours.
    fn seed(&mut self) -> Option<u32> {
        for (count, stack) in self.stacks.iter_mut().enumerate() {
            while let Some(t) = stack.pop() {
                if usize::from(self.free[t as usize]) == count {
                    return Some(t);
                }
            }
        }
        while let Some(&free) = self.free.get(self.first_untouched as usize) {
            self.first_untouched += 1;
            if free == 3 {
                return Some(self.first_untouched - 1);
            }
        }
        None
    }

    #[inline]
    fn is_free(&self, half_edge: u32) -> bool {
        half_edge != NONE && self.free[half_edge as usize / 3] != TAKEN
    }

    /// Takes a triangle for the strip; `toward` is the half-edge by which the strip will enter the next one.
    #[inline]
    fn take(&mut self, t: u32, toward: u32) {
        self.free[t as usize] = TAKEN;
        self.trial[t as usize] = self.strip_count;
        for edge in 0..3 {
            let twin = self.twins[(3 * t + edge) as usize];
            if self.is_free(twin) {
                let neighbour = twin / 3;
                let free = &mut self.free[neighbour as usize];
                *free -= 1;
                if twin != toward {
                    self.stacks[usize::from(*free)].push(neighbour);
                }
            }
        }
    }

    /// Runs from a taken triangle over its half-edge `exit`, taking and linking triangles, until none is free.
    fn run(&mut self, mut exit: u32) {
        let mut even = false;
        loop {
            let entry = self.twins[exit as usize];
            self.cover.link_unchecked(exit, entry);
            let (t, edge) = (entry / 3, entry % 3);
            let (straight, swap) =
                if even { (next(edge), previous(edge)) } else { (previous(edge), next(edge)) };
            let (straight, swap) = (3 * t + straight, 3 * t + swap);
            let (after_straight, after_swap) = (self.twins[straight as usize], self.twins[swap as usize]);
            let swaps = match (self.is_free(after_straight), self.is_free(after_swap)) {
                (false, false) => {
                    self.take(t, NONE);
                    return;
                }
                (true, false) => false,
                (false, true) => true,
                (true, true) => {
                    // This triangle still counts as a free neighbour of both.
                    self.free[after_swap as usize / 3] == 2 && self.free[after_straight as usize / 3] == 3
                }
            };
            exit = if swaps { swap } else { straight };
            even ^= !swaps;
            self.take(t, self.twins[exit as usize]);
        }
    }

    /// Follows the run that [`Peeler::run`] would take, taking nothing. Gives its cost in indices and its triangles.
    fn try_run(&mut self, seed: u32, mut exit: u32) -> (u32, u32) {
        self.trial_count += 1;
        let trial = self.trial_count;
        self.trial[seed as usize] = trial;
        let (mut triangles, mut swap_count, mut even) = (1, 0, false);
        loop {
            let entry = self.twins[exit as usize];
            let (t, edge) = (entry / 3, entry % 3);
            self.trial[t as usize] = trial;
            triangles += 1;
            let (straight, swap) =
                if even { (next(edge), previous(edge)) } else { (previous(edge), next(edge)) };
            let (straight, swap) = (3 * t + straight, 3 * t + swap);
            let (after_straight, after_swap) = (self.twins[straight as usize], self.twins[swap as usize]);
            let swaps = match (self.is_untried(after_straight), self.is_untried(after_swap)) {
                (false, false) => return (triangles + swap_count + STRIP, triangles),
                _ if triangles >= TRIAL_LIMIT => return (triangles + swap_count + STRIP, triangles),
                (true, false) => false,
                (false, true) => true,
                (true, true) => self.untried(after_swap / 3) == 1 && self.untried(after_straight / 3) == 2,
            };
            exit = if swaps { swap } else { straight };
            even ^= !swaps;
            swap_count += u32::from(swaps);
        }
    }

    #[inline]
    fn is_untried(&self, half_edge: u32) -> bool {
        self.is_free(half_edge) && self.trial[half_edge as usize / 3] != self.trial_count
    }

    /// Counts the neighbours of a triangle that are free and not passed by the trial.
    #[inline]
    fn untried(&self, t: u32) -> usize {
        (3 * t..3 * t + 3).filter(|&h| self.is_untried(self.twins[h as usize])).count()
    }
}
