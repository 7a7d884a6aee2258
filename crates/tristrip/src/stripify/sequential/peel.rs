//! Peels strips off the free triangles, one after the other: steps 1 and 2 of [`super`].

use super::sheet::Sheet;
use super::{Cuts, Manner, NONE, STRIP, Seeds, Swaps, next, previous};
use crate::cover::PathCover;

/// Marks a triangle that a strip has taken, in place of its number of free neighbours.
const TAKEN: u8 = 0xff;

pub(super) struct Peeler<S> {
    manner: Manner,
    sheet: S,
    cover: PathCover,
    /// Free neighbours of each free triangle.
    free: Vec<u8>,
    /// The trial run that last passed each free triangle; the strip of each taken one.
    trial: Vec<u32>,
    trial_count: u32,
    strip_count: u32,
    swap_count: u64,
    /// Triangles with 0, 1 and 2 free neighbours when they came, each list with the place of its first.
    waiting: [(Vec<u32>, usize); 3],
    /// All triangles before this one are taken or wait.
    first_untouched: usize,
}

/// What peeling makes.
pub(super) struct Peeled<S> {
    pub(super) sheet: S,
    pub(super) cover: PathCover,
    /// The strip of each triangle.
    pub(super) strip_of: Vec<u32>,
    /// What the strips cost beyond one index a triangle, but for swaps at their starts.
    pub(super) cost: u64,
}

/// The two ways out of a triangle that a run has entered.
struct Fork {
    straight: u32,
    swap: u32,
    after_straight: u32,
    after_swap: u32,
}

/// The cost of a run in indices, and its triangles.
#[derive(Debug, Clone, Copy)]
struct Run {
    cost: u32,
    triangles: u32,
}

impl Run {
    fn is_cheaper_a_triangle(self, than: Self) -> bool {
        u64::from(self.cost) * u64::from(than.triangles) < u64::from(than.cost) * u64::from(self.triangles)
    }
}

impl<S: Sheet> Peeler<S> {
    pub(super) fn new(sheet: S, manner: Manner) -> Self {
        let twins = sheet.graph().twins();
        let free: Vec<u8> =
            twins.chunks_exact(3).map(|t| t.iter().filter(|&&h| h != NONE).count() as u8).collect();
        let mut waiting: [(Vec<u32>, usize); 3] = Default::default();
        for t in (0..free.len() as u32).rev() {
            if let Some((list, _)) = waiting.get_mut(usize::from(free[t as usize])) {
                list.push(t);
            }
        }
        if manner.seeds == Seeds::First {
            waiting.iter_mut().for_each(|(list, _)| list.reverse());
        }
        Self {
            manner,
            sheet,
            cover: PathCover::isolated(free.len()),
            trial: vec![0; free.len()],
            free,
            trial_count: 0,
            strip_count: 0,
            swap_count: 0,
            waiting,
            first_untouched: 0,
        }
    }

    pub(super) fn peel(mut self) -> Peeled<S> {
        while let Some(seed) = self.seed() {
            let exit = self.best_exit(seed);
            self.take(seed, exit.map_or(NONE, |exit| self.twin(exit)));
            if let Some(exit) = exit {
                self.run(exit, false);
                let back = backward(exit);
                if self.is_free(self.twin(back)) {
                    self.run(back, true);
                }
            }
            self.strip_count += 1;
        }
        let cost = u64::from(STRIP) * u64::from(self.strip_count) + self.swap_count;
        Peeled { sheet: self.sheet, cover: self.cover, strip_of: self.trial, cost }
    }

    /// Gives a free triangle to begin a strip with.
    fn seed(&mut self) -> Option<u32> {
        for (count, (list, first)) in self.waiting.iter_mut().enumerate() {
            let is_due = |t: u32| usize::from(self.free[t as usize]) == count;
            match self.manner.seeds {
                Seeds::Last => {
                    while let Some(t) = list.pop() {
                        if is_due(t) {
                            return Some(t);
                        }
                    }
                }
                Seeds::First => {
                    while let Some(&t) = list.get(*first) {
                        *first += 1;
                        if is_due(t) {
                            return Some(t);
                        }
                    }
                }
                Seeds::Input => break,
            }
        }
        let free = self.free.get(self.first_untouched..)?.iter().position(|&free| free != TAKEN)?;
        self.first_untouched += free + 1;
        Some(self.first_untouched as u32 - 1)
    }

    /// Gives the exit of a free triangle whose run has the least cost a triangle, of equals the first.
    fn best_exit(&mut self, seed: u32) -> Option<u32> {
        let mut best: Option<(u32, Run)> = None;
        for exit in 3 * seed..3 * seed + 3 {
            if !self.is_free(self.twin(exit)) {
                continue;
            }
            if self.free[seed as usize] == 1 {
                return Some(exit);
            }
            let run = self.try_both_ways(seed, exit);
            if best.is_none_or(|(_, than)| run.is_cheaper_a_triangle(than)) {
                best = Some((exit, run));
            }
        }
        best.map(|(exit, _)| exit)
    }

    /// Takes a triangle for the strip; `toward` is the half-edge by which the strip will enter the next one.
    #[inline]
    fn take(&mut self, t: u32, toward: u32) {
        self.free[t as usize] = TAKEN;
        self.trial[t as usize] = self.strip_count;
        for half_edge in 3 * t..3 * t + 3 {
            let twin = self.twin(half_edge);
            if self.is_free(twin) {
                let neighbour = twin / 3;
                let free = &mut self.free[neighbour as usize];
                *free -= 1;
                if twin != toward {
                    self.waiting[usize::from(*free)].0.push(neighbour);
                }
            }
        }
    }

    /// Runs from a taken triangle over its half-edge `exit`, taking and linking triangles, until none is free.
    fn run(&mut self, mut exit: u32, mut even: bool) {
        loop {
            let entry = self.enter(exit, even);
            self.cover.link_unchecked(exit, entry);
            let fork = self.fork(entry, even);
            // The triangle itself still counts as a free neighbour of both.
            let left_with = |h: u32| self.free[h as usize / 3] - 1;
            let swaps = match (self.is_free(fork.after_straight), self.is_free(fork.after_swap)) {
                (true, true) => self.saves_an_end(left_with(fork.after_straight), left_with(fork.after_swap)),
                (true, false) => false,
                (false, true) if self.manner.swaps != Swaps::Never => true,
                _ => {
                    self.take(entry / 3, NONE);
                    return;
                }
            };
            exit = if swaps { fork.swap } else { fork.straight };
            even ^= !swaps;
            self.swap_count += u64::from(swaps);
            self.take(entry / 3, if swaps { fork.after_swap } else { fork.after_straight });
        }
    }

    /// Follows the runs that [`Peeler::peel`] would take from a seed, taking nothing.
    fn try_both_ways(&mut self, seed: u32, exit: u32) -> Run {
        self.trial_count += 1;
        self.trial[seed as usize] = self.trial_count;
        let forward = self.try_run(exit, false);
        let back = backward(exit);
        let backward = if self.is_untried(self.twin(back)) {
            self.try_run(back, true)
        } else {
            Run { cost: 0, triangles: 0 }
        };
        Run {
            cost: 1 + STRIP + forward.cost + backward.cost,
            triangles: 1 + forward.triangles + backward.triangles,
        }
    }

    fn try_run(&mut self, mut exit: u32, mut even: bool) -> Run {
        let mut run = Run { cost: 0, triangles: 0 };
        loop {
            let entry = self.enter(exit, even);
            self.trial[entry as usize / 3] = self.trial_count;
            run.cost += 1;
            run.triangles += 1;
            let fork = self.fork(entry, even);
            let left_with = |h: u32| self.untried(h / 3);
            let swaps = match (self.is_untried(fork.after_straight), self.is_untried(fork.after_swap)) {
                _ if run.triangles == self.manner.trial_limit => return run,
                (true, true) => self.saves_an_end(left_with(fork.after_straight), left_with(fork.after_swap)),
                (true, false) => false,
                (false, true) if self.manner.swaps != Swaps::Never => true,
                _ => return run,
            };
            exit = if swaps { fork.swap } else { fork.straight };
            even ^= !swaps;
            run.cost += u32::from(swaps);
        }
    }

    #[inline]
    fn twin(&self, half_edge: u32) -> u32 {
        self.sheet.graph().twins()[half_edge as usize]
    }

    /// Goes over a half-edge, and gives the one by which the next triangle is entered; a polygon is cut for it.
    #[inline]
    fn enter(&mut self, exit: u32, even: bool) -> u32 {
        if self.manner.cuts == Cuts::Before {
            return self.twin(exit);
        }
        let (free, trial, count) = (&self.free, &self.trial, self.trial_count);
        let is_touched = |t: u32| free[t as usize] == TAKEN || trial[t as usize] == count;
        if let Some(triangles) = self.sheet.enter(exit, even, is_touched) {
            for t in triangles {
                let free = (3 * t..3 * t + 3).filter(|&h| self.is_free(self.twin(h))).count();
                self.free[t as usize] = free as u8;
                if let Some((list, _)) = self.waiting.get_mut(free) {
                    list.push(t);
                }
            }
        }
        self.twin(exit)
    }

    /// Finds the ways out of the triangle that a run enters by a half-edge.
    #[inline]
    fn fork(&self, entry: u32, even: bool) -> Fork {
        let (base, edge) = (entry / 3 * 3, entry % 3);
        let (straight, swap) = if even { (next(edge), previous(edge)) } else { (previous(edge), next(edge)) };
        let (straight, swap) = (base + straight, base + swap);
        let (after_straight, after_swap) = (self.twin(straight), self.twin(swap));
        Fork { straight, swap, after_straight, after_swap }
    }

    /// Tells whether to swap although going straight is possible, by the free neighbours that the two ways out have left.
    #[inline]
    fn saves_an_end(&self, straight: u8, swap: u8) -> bool {
        self.manner.swaps == Swaps::Ahead && swap == 1 && straight == 2
    }

    #[inline]
    fn is_free(&self, half_edge: u32) -> bool {
        half_edge != NONE && self.free[half_edge as usize / 3] != TAKEN
    }

    #[inline]
    fn is_untried(&self, half_edge: u32) -> bool {
        self.is_free(half_edge) && self.trial[half_edge as usize / 3] != self.trial_count
    }

    /// Counts the neighbours of a triangle that are free and not passed by the trial.
    #[inline]
    fn untried(&self, t: u32) -> u8 {
        (3 * t..3 * t + 3).map(|h| u8::from(self.is_untried(self.twin(h)))).sum()
    }
}

/// The edge over which a strip goes on backward from its seed without a swap.
#[inline]
fn backward(exit: u32) -> u32 {
    exit / 3 * 3 + previous(exit % 3)
}
