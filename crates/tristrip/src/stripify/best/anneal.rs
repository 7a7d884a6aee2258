//! Annealing of a path cover by changes at the ends of its paths.
//!
//! ```text
//!   w ┄┄ v ━━ a        *join*: v is an end, too: w–v is linked
//!        ┃             *graft*: v is inside a path: v–a is cut, w–v linked, and a is an end in the place of w
//!        b             *cut*: v–a is cut, which pays where it does away with swaps
//!                       *turn*: where v and a are of one polygon, the diagonal between them is turned
//! ```
//! # Algorithm
//! A sweep goes over the triangles in order, so that it reads memory as it lies. At each end it tries a join or a graft, at random
//! over one of the free edges; after a graft the new end goes on in its place for a hop. Then it tries to cut
//! links, one for each triangle, and to turn diagonals. A change that raises the cost by r is done with odds e^(−r/T); the temperature T falls from
//! sweep to sweep. The greatest rise to be accepted is drawn first, so that most changes are refused by what the swaps around
//! them cost, before anything is changed.
//!
//! Two grafts in turn are a tunnel through two paths, and a graft with a join is Stewart's; the annealing finds longer ones by itself.
//!
//! # Complexity
//! A sweep takes O(n) and, for each graft accepted, as many steps as there are to the nearer end of the path that it cuts.

use crate::cover::moves::{EndMove, cut, flip_diagonal, move_end};
use crate::cover::priced::PricedPaths;
use crate::random::Random;
use crate::random::metropolis;
use crate::stripify::{Progress, Watch};

/// Triangles in a block: those of which the ends stand in one word.
const BLOCK: u32 = 64;
/// Changes tried at an end before the sweep goes on. Tuned on the bunny and the cow: 1 gives worse covers, 4 takes longer for the same.
const HOPS: u32 = 2;
/// Triangles of a block of which a diagonal is turned, where they have one. Tuned on skyscraper and triceratops: 4 gives worse covers,
/// 64 takes twice the time for the same.
const TURNS: u32 = 16;
/// Blocks after which the watcher is asked.
const WATCH_PERIOD: u64 = 1 << 10;
/// Greatest rise that is ever accepted.
const RISES: usize = 8;

/// Sweeps while the temperature falls evenly; it is counted in indices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Phase {
    pub(super) sweeps: u32,
    pub(super) hottest: f64,
    pub(super) coldest: f64,
}

impl Phase {
    /// Sweeps at the end in which nothing is accepted that raises the cost. A single sweep is cold enough without.
    fn last_sweeps(&self) -> u32 {
        u32::from(self.sweeps > 1)
    }
}

/// Draws the random numbers and asks the watcher.
pub(super) struct Annealer<'a> {
    random: Random,
    watch: &'a dyn Watch,
    /// Blocks gone over.
    steps: u64,
    step_limit: u64,
    index_count: usize,
    /// Cost of the best cover so far.
    lowest: i64,
    /// Of 2³² draws, those that accept a rise of at least 1, 2, ….
    odds: [u32; RISES],
}

impl<'a> Annealer<'a> {
    /// `index_count` is what there is besides the cost that the paths know.
    pub(super) fn new(
        seed: u64,
        watch: &'a dyn Watch,
        phases: &[Phase],
        triangle_count: usize,
        index_count: usize,
    ) -> Self {
        let sweeps: u64 = phases.iter().map(|phase| u64::from(phase.sweeps + phase.last_sweeps())).sum();
        let step_limit = sweeps * triangle_count.div_ceil(BLOCK as usize) as u64;
        Self {
            random: Random::new(seed),
            watch,
            steps: 0,
            step_limit,
            index_count,
            lowest: i64::MAX,
            odds: [0; RISES],
        }
    }

    /// Anneals. Returns whether the watcher wants it to go on; if not, only the last sweeps are still done.
    pub(super) fn run(&mut self, paths: &mut PricedPaths, phase: Phase) -> bool {
        self.lowest = self.lowest.min(paths.cost());
        let mut goes_on = true;
        for sweep in 0..phase.sweeps {
            let part = f64::from(sweep + 1) / f64::from(phase.sweeps);
            self.odds = metropolis(phase.hottest + (phase.coldest - phase.hottest) * part);
            goes_on = self.sweep(paths, true);
            if !goes_on {
                break;
            }
        }
        self.odds = [0; RISES];
        for _ in 0..phase.last_sweeps() {
            self.sweep(paths, false);
        }
        self.lowest = self.lowest.min(paths.cost());
        goes_on
    }

    /// Goes over all triangles once. Returns whether the watcher wants to go on.
    fn sweep(&mut self, paths: &mut PricedPaths, asks: bool) -> bool {
        for block in 0..(paths.len() as u32).div_ceil(BLOCK) {
            self.steps += 1;
            if asks && self.steps.is_multiple_of(WATCH_PERIOD) && !self.watch.go_on(self.progress(paths)) {
                return false;
            }
            self.change_ends(paths, block);
            self.cut_links(paths, block);
            if paths.has_diagonals() {
                self.turn_diagonals(paths, block);
            }
        }
        true
    }

    fn progress(&self, paths: &PricedPaths) -> Progress {
        Progress {
            steps: self.steps,
            step_limit: Some(self.step_limit),
            strips: paths.strip_count(),
            cost: self.index_count + usize::try_from(self.lowest.min(paths.cost())).unwrap_or(0),
        }
    }

    /// Tries changes at each end of a block, also at those that come to be behind the one at hand.
    #[inline]
    fn change_ends(&mut self, paths: &mut PricedPaths, block: u32) {
        let mut left = u64::MAX;
        loop {
            let ends = paths.ends_of(block as usize) & left;
            if ends == 0 {
                break;
            }
            let bit = ends.trailing_zeros();
            left = u64::MAX.checked_shl(bit + 1).unwrap_or(0);
            let mut end = Some(block * BLOCK + bit);
            for _ in 0..HOPS {
                end = end.and_then(|end| self.change_end(paths, end));
            }
        }
    }

    /// Tries a join or a graft at an end. Returns the end that is there in its place.
    #[inline]
    fn change_end(&mut self, paths: &mut PricedPaths, w: u32) -> Option<u32> {
        let draw = self.random.next_u64();
        match move_end(paths, w, draw, self.highest_rise(draw as u32)) {
            EndMove::Refused => Some(w),
            EndMove::Joined(_) => None,
            EndMove::Rotated { end, .. } => Some(end),
        }
    }

    /// Tries to cut as many links of a block as there are triangles.
    #[inline]
    fn cut_links(&mut self, paths: &mut PricedPaths, block: u32) {
        for _ in 0..BLOCK {
            let draw = self.random.next_u64();
            let t = block * BLOCK + (draw >> 58) as u32;
            let link = 4 * t + (draw >> 32 & 0xffff) as u32 * 3 / 0x1_0000;
            if (t as usize) < paths.len() && paths.mask(t) >> (link % 4) & 1 == 1 {
                let highest_rise = self.highest_rise(draw as u32);
                cut(paths, link, highest_rise);
            }
        }
    }

    /// Tries to turn diagonals of a block.
    fn turn_diagonals(&mut self, paths: &mut PricedPaths, block: u32) {
        for _ in 0..TURNS {
            let draw = self.random.next_u64();
            let t = block * BLOCK + (draw >> 58) as u32;
            let edge = (draw >> 32 & 0xffff) as u32 * 3 / 0x1_0000;
            if (t as usize) < paths.len() && paths.diagonals(t) >> edge & 1 == 1 {
                let highest_rise = self.highest_rise(draw as u32);
                flip_diagonal(paths, 4 * t + edge, draw >> 57 & 1 == 1, highest_rise);
            }
        }
    }

    /// Turns a draw into the greatest rise that it accepts.
    #[inline]
    fn highest_rise(&self, draw: u32) -> i32 {
        self.odds.iter().zip(1..).take_while(|&(&odds, _)| draw < odds).last().map_or(0, |(_, rise)| rise)
    }
}
