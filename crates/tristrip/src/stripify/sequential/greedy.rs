//! The greedy stripper removes strips from the free triangles, one at a time. It implements steps 1
//! and 2 of [`super`].

use super::edge::{next, previous};
use super::mutable_triangulation::MutableTriangulation;
use super::policy::{Policy, PolygonCuts, STRIP_COST, SeedOrder, SwapPolicy};
use crate::cover::PathCover;

/// Marks a triangle of a strip, in place of its number of free neighbours.
const TAKEN: u8 = 0xff;

/// The state of the stripper between steps.
pub(super) struct GreedyStripper<T> {
    policy: Policy,
    triangulation: T,
    cover: PathCover,
    /// The number of free neighbours of each free triangle.
    free: Vec<u8>,
    /// The last tentative run over each free triangle; the strip of each taken triangle.
    visited_by: Vec<u32>,
    tentative_count: u32,
    strip_count: u32,
    swap_count: u64,
    /// Triangles that had 0, 1 and 2 free neighbours when they were added. Each list has the
    /// position of its first unused entry.
    candidates: [(Vec<u32>, usize); 3],
    /// All triangles before this one are taken or are candidates.
    first_untouched: usize,
}

/// The result of the greedy stripper.
pub(super) struct GreedyStrips<T> {
    pub(super) triangulation: T,
    pub(super) cover: PathCover,
    /// The strip of each triangle.
    pub(super) strip_of: Vec<u32>,
    /// Cost in addition to one index per triangle, without swaps at the starts of strips.
    pub(super) cost: u64,
}

/// The two exits of a triangle that a run has entered, as half-edges.
struct Fork {
    straight: u32,
    swap: u32,
}

/// The cost of a run in indices, and its number of triangles.
#[derive(Debug, Clone, Copy)]
struct RunCost {
    cost: u32,
    triangles: u32,
}

impl RunCost {
    fn is_cheaper_per_triangle(self, than: Self) -> bool {
        u64::from(self.cost) * u64::from(than.triangles) < u64::from(than.cost) * u64::from(self.triangles)
    }
}

impl<T: MutableTriangulation> GreedyStripper<T> {
    /// Creates a stripper of a triangulation. All triangles are free.
    pub(super) fn new(triangulation: T, policy: Policy) -> Self {
        let free: Vec<u8> = triangulation.graph().neighbour_counts().collect();
        let mut candidates: [(Vec<u32>, usize); 3] = Default::default();
        for t in (0..free.len() as u32).rev() {
            if let Some((list, _)) = candidates.get_mut(usize::from(free[t as usize])) {
                list.push(t);
            }
        }
        if policy.seeds == SeedOrder::FirstAdded {
            candidates.iter_mut().for_each(|(list, _)| list.reverse());
        }
        Self {
            policy,
            triangulation,
            cover: PathCover::isolated(free.len()),
            visited_by: vec![0; free.len()],
            free,
            tentative_count: 0,
            strip_count: 0,
            swap_count: 0,
            candidates,
            first_untouched: 0,
        }
    }

    /// Covers all triangles with strips.
    pub(super) fn run(mut self) -> GreedyStrips<T> {
        while let Some(seed) = self.next_seed() {
            let exit = self.best_exit(seed);
            self.take(seed, exit.and_then(|exit| self.twin(exit)));
            if let Some(exit) = exit {
                self.grow(exit, false);
                let back = backward(exit);
                if self.free_across(back).is_some() {
                    self.grow(back, true);
                }
            }
            self.strip_count += 1;
        }
        let cost = u64::from(STRIP_COST) * u64::from(self.strip_count) + self.swap_count;
        GreedyStrips { triangulation: self.triangulation, cover: self.cover, strip_of: self.visited_by, cost }
    }

    /// Returns a free triangle as the seed of the next strip.
    fn next_seed(&mut self) -> Option<u32> {
        for (count, (list, first)) in self.candidates.iter_mut().enumerate() {
            let is_valid = |t: u32| usize::from(self.free[t as usize]) == count;
            match self.policy.seeds {
                SeedOrder::LastAdded => {
                    while let Some(t) = list.pop() {
                        if is_valid(t) {
                            return Some(t);
                        }
                    }
                }
                SeedOrder::FirstAdded => {
                    while let Some(&t) = list.get(*first) {
                        *first += 1;
                        if is_valid(t) {
                            return Some(t);
                        }
                    }
                }
                SeedOrder::Input => break,
            }
        }
        let free = self.free.get(self.first_untouched..)?.iter().position(|&free| free != TAKEN)?;
        self.first_untouched += free + 1;
        Some(self.first_untouched as u32 - 1)
    }

    /// Returns the exit of a free triangle whose run has the lowest cost per triangle, the first
    /// one in a tie.
    fn best_exit(&mut self, seed: u32) -> Option<u32> {
        let mut best: Option<(u32, RunCost)> = None;
        for exit in 3 * seed..3 * seed + 3 {
            if self.free_across(exit).is_none() {
                continue;
            }
            if self.free[seed as usize] == 1 {
                return Some(exit);
            }
            let run = self.try_both_directions(seed, exit);
            if best.is_none_or(|(_, than)| run.is_cheaper_per_triangle(than)) {
                best = Some((exit, run));
            }
        }
        best.map(|(exit, _)| exit)
    }

    /// Adds a triangle to the strip. `next_entry` is the half-edge through which the strip will
    /// enter the next triangle.
    #[inline]
    fn take(&mut self, t: u32, next_entry: Option<u32>) {
        self.free[t as usize] = TAKEN;
        self.visited_by[t as usize] = self.strip_count;
        for half_edge in 3 * t..3 * t + 3 {
            if let Some(twin) = self.free_across(half_edge) {
                let neighbour = twin / 3;
                let free = &mut self.free[neighbour as usize];
                *free -= 1;
                if Some(twin) != next_entry {
                    self.candidates[usize::from(*free)].0.push(neighbour);
                }
            }
        }
    }

    /// Extends a strip from a taken triangle over its half-edge `exit`, until no triangle is free.
    fn grow(&mut self, mut exit: u32, mut even: bool) {
        while let Some(entry) = self.enter(exit, even) {
            self.cover.link_unchecked(exit, entry);
            let fork = fork(entry, even);
            // The triangle itself still counts as a free neighbour of both.
            let remaining = |h: u32| self.free[h as usize / 3] - 1;
            let (swaps, next_entry) = match (self.free_across(fork.straight), self.free_across(fork.swap)) {
                (Some(straight), Some(swap)) => {
                    let swaps = self.saves_an_end(remaining(straight), remaining(swap));
                    (swaps, if swaps { swap } else { straight })
                }
                (Some(straight), None) => (false, straight),
                (None, Some(swap)) if self.policy.swaps != SwapPolicy::Never => (true, swap),
                _ => {
                    self.take(entry / 3, None);
                    return;
                }
            };
            exit = if swaps { fork.swap } else { fork.straight };
            even ^= !swaps;
            self.swap_count += u64::from(swaps);
            self.take(entry / 3, Some(next_entry));
        }
    }

    /// Computes the cost of the run that [`GreedyStripper::run`] would take from a seed, without
    /// taking triangles.
    fn try_both_directions(&mut self, seed: u32, exit: u32) -> RunCost {
        self.tentative_count += 1;
        self.visited_by[seed as usize] = self.tentative_count;
        let forward = self.try_run(exit, false);
        let back = backward(exit);
        let backward = if self.unvisited_across(back).is_some() {
            self.try_run(back, true)
        } else {
            RunCost { cost: 0, triangles: 0 }
        };
        RunCost {
            cost: 1 + STRIP_COST + forward.cost + backward.cost,
            triangles: 1 + forward.triangles + backward.triangles,
        }
    }

    fn try_run(&mut self, mut exit: u32, mut even: bool) -> RunCost {
        let mut run = RunCost { cost: 0, triangles: 0 };
        while let Some(entry) = self.enter(exit, even) {
            self.visited_by[entry as usize / 3] = self.tentative_count;
            run.cost += 1;
            run.triangles += 1;
            let fork = fork(entry, even);
            let remaining = |h: u32| self.unvisited_neighbours(h / 3);
            let swaps = match (self.unvisited_across(fork.straight), self.unvisited_across(fork.swap)) {
                _ if run.triangles == self.policy.lookahead => return run,
                (Some(straight), Some(swap)) => self.saves_an_end(remaining(straight), remaining(swap)),
                (Some(_), None) => false,
                (None, Some(_)) if self.policy.swaps != SwapPolicy::Never => true,
                _ => return run,
            };
            exit = if swaps { fork.swap } else { fork.straight };
            even ^= !swaps;
            run.cost += u32::from(swaps);
        }
        run
    }

    #[inline]
    fn twin(&self, half_edge: u32) -> Option<u32> {
        self.triangulation.graph().twin_of(half_edge)
    }

    /// Crosses a half-edge. Triangulates a polygon for the run if necessary. Returns the half-edge
    /// through which the next triangle is entered.
    #[inline]
    fn enter(&mut self, exit: u32, even: bool) -> Option<u32> {
        if self.policy.cuts == PolygonCuts::Before {
            return self.twin(exit);
        }
        let (free, visited_by, count) = (&self.free, &self.visited_by, self.tentative_count);
        let is_touched = |t: u32| free[t as usize] == TAKEN || visited_by[t as usize] == count;
        if let Some(triangles) = self.triangulation.enter(exit, even, is_touched) {
            for t in triangles {
                let free = (3 * t..3 * t + 3).filter(|&h| self.free_across(h).is_some()).count();
                self.free[t as usize] = free as u8;
                if let Some((list, _)) = self.candidates.get_mut(free) {
                    list.push(t);
                }
            }
        }
        self.twin(exit)
    }

    /// Returns whether to swap although the strip could continue without a swap. `straight` and
    /// `swap` are the numbers of free neighbours that the two possible next triangles keep.
    #[inline]
    fn saves_an_end(&self, straight: u8, swap: u8) -> bool {
        self.policy.swaps == SwapPolicy::Lookahead && swap == 1 && straight == 2
    }

    /// Returns the twin of a half-edge if its triangle is free.
    #[inline]
    fn free_across(&self, half_edge: u32) -> Option<u32> {
        self.twin(half_edge).filter(|&twin| self.free[twin as usize / 3] != TAKEN)
    }

    /// Returns the twin of a half-edge if its triangle is free and not visited by the tentative
    /// run.
    #[inline]
    fn unvisited_across(&self, half_edge: u32) -> Option<u32> {
        self.free_across(half_edge).filter(|&twin| self.visited_by[twin as usize / 3] != self.tentative_count)
    }

    /// Counts the neighbours of a triangle that are free and not visited by the tentative run.
    #[inline]
    fn unvisited_neighbours(&self, t: u32) -> u8 {
        (3 * t..3 * t + 3).map(|h| u8::from(self.unvisited_across(h).is_some())).sum()
    }
}

/// Returns the exits of the triangle that a run enters through a half-edge.
#[inline]
fn fork(entry: u32, even: bool) -> Fork {
    let (base, edge) = (entry / 3 * 3, entry % 3);
    let (straight, swap) = if even { (next(edge), previous(edge)) } else { (previous(edge), next(edge)) };
    Fork { straight: base + straight, swap: base + swap }
}

/// Returns the half-edge over which a strip continues backward from its seed without a swap.
#[inline]
fn backward(exit: u32) -> u32 {
    exit / 3 * 3 + previous(exit % 3)
}
