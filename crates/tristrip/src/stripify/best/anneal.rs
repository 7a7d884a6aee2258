//! Annealing of a path cover by moves at the ends of its paths.
//!
//! ```text
//!   w ┄┄ v ━━ a        *join*: v is also an end: link w–v
//!        ┃             *rotation*: v is inside a path: cut v–a, link w–v; a replaces w as an end
//!        b             *cut*: cut v–a, which lowers the cost if it removes swaps
//!                      *flip*: if v and a belong to one polygon, flip the diagonal between them
//! ```
//! # Algorithm
//! A sweep visits the triangles in order. Memory access is then sequential. At each end it tries a
//! join or a rotation over a random free edge. After a rotation it tries the new end instead. Then
//! it tries to cut links, one per triangle, and to flip diagonals. A move that raises the cost by r
//! is accepted with probability e^(−r/T). The temperature T decreases with each sweep. The highest
//! acceptable cost increase is drawn at random before the move is made. A count of the local swaps
//! then rejects most moves before anything changes.
//!
//! Two consecutive rotations form a tunnel through two paths, and a rotation followed by a join is
//! Stewart's tunnel. Annealing finds longer tunnels without additional kinds of moves.
//!
//! # Complexity
//! A sweep takes O(n). A rotation or a cut takes as many steps as the distance to the nearer end of
//! the path that it cuts. The steps of a phase are limited; when they are used up, only cuts near
//! an end are tried.

use crate::cover::moves::{EndMove, cut, flip_diagonal, move_end};
use crate::cover::priced::PricedPaths;
use crate::random::{Random, metropolis};
use crate::stripify::{Progress, Watch};

/// Triangles per block: one word has a bit for each.
const BLOCK: u32 = 64;
/// Moves tried at an end before the sweep continues. Tuned on the bunny and the cow: 1 gives worse
/// covers, and 4 takes longer for the same covers.
const MOVES_PER_END: u32 = 2;
/// Flips tried per block, at random triangles. Tuned on skyscraper and triceratops: 4 gives worse
/// covers, and 64 takes twice the time for the same covers.
const FLIPS: u32 = 16;
/// Number of blocks between two calls of the watcher.
const WATCH_PERIOD: u64 = 1 << 10;
/// Minimum and maximum steps per triangle and sweep for walks to the ends of paths. The maximum
/// applies to meshes whose sweep takes less than [`WALK_STEPS`] in total. The test models need up
/// to 16, those of more than 50,000 triangles up to 2. Meshes of a few long strips would need as
/// many as a strip has triangles.
const WALK_STEPS_PER_TRIANGLE: (u64, u64) = (4, 64);
const WALK_STEPS: u64 = 1 << 20;
/// The highest cost increase that is ever accepted.
const RISES: usize = 8;

/// Sweeps with a linearly decreasing temperature. Temperatures are in indices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AnnealingPhase {
    pub(super) sweeps: u32,
    pub(super) hottest: f64,
    pub(super) coldest: f64,
}

impl AnnealingPhase {
    /// Returns the number of final sweeps, which accept no cost increase. A phase of a single sweep
    /// has none.
    fn final_sweeps(&self) -> u32 {
        u32::from(self.sweeps > 1)
    }
}

/// The state of the annealing without the paths.
pub(super) struct Annealer<'a> {
    random: Random,
    watch: &'a dyn Watch,
    /// Number of blocks visited.
    steps: u64,
    step_limit: u64,
    index_count: usize,
    /// The lowest cost so far.
    lowest: i64,
    /// The number of draws out of 2³² that accept a cost increase of at least 1, 2, ….
    odds: [u32; RISES],
}

impl<'a> Annealer<'a> {
    /// Creates an annealer. `index_count` is the number of indices that the cost of the paths does
    /// not include.
    pub(super) fn new(
        seed: u64,
        watch: &'a dyn Watch,
        phases: &[AnnealingPhase],
        triangle_count: usize,
        index_count: usize,
    ) -> Self {
        let sweeps: u64 = phases.iter().map(|phase| u64::from(phase.sweeps + phase.final_sweeps())).sum();
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

    /// Returns the maximum steps of the walks of a phase.
    pub(super) fn walk_steps(triangle_count: usize, phase: AnnealingPhase) -> u64 {
        let [least, most] =
            <[u64; 2]>::from(WALK_STEPS_PER_TRIANGLE).map(|steps| steps * triangle_count as u64);
        WALK_STEPS.clamp(least, most) * u64::from(phase.sweeps + phase.final_sweeps())
    }

    /// Runs one phase. Returns whether the watcher lets the search continue. If not, only the final
    /// sweeps of the phase are run.
    pub(super) fn run(&mut self, paths: &mut PricedPaths, phase: AnnealingPhase) -> bool {
        self.lowest = self.lowest.min(paths.cost());
        paths.allow_walks(Self::walk_steps(paths.len(), phase));
        let mut goes_on = true;
        for sweep in 0..phase.sweeps {
            let progress = f64::from(sweep + 1) / f64::from(phase.sweeps);
            self.odds = metropolis(phase.hottest + (phase.coldest - phase.hottest) * progress);
            goes_on = self.sweep(paths, true);
            if !goes_on {
                break;
            }
        }
        self.odds = [0; RISES];
        for _ in 0..phase.final_sweeps() {
            self.sweep(paths, false);
        }
        self.lowest = self.lowest.min(paths.cost());
        goes_on
    }

    /// Visits all triangles once. Returns whether the watcher lets the search continue.
    fn sweep(&mut self, paths: &mut PricedPaths, asks: bool) -> bool {
        for block in 0..(paths.len() as u32).div_ceil(BLOCK) {
            self.steps += 1;
            if asks && self.steps.is_multiple_of(WATCH_PERIOD) && !self.watch.go_on(self.progress(paths)) {
                return false;
            }
            self.move_ends(paths, block);
            self.cut_links(paths, block);
            if paths.has_diagonals() {
                self.flip_diagonals(paths, block);
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

    /// Tries moves at each end of a block, including new ends after the current one.
    #[inline]
    fn move_ends(&mut self, paths: &mut PricedPaths, block: u32) {
        let mut remaining = u64::MAX;
        loop {
            let ends = paths.ends_of(block as usize) & remaining;
            if ends == 0 {
                break;
            }
            let bit = ends.trailing_zeros();
            remaining = u64::MAX.checked_shl(bit + 1).unwrap_or(0);
            let mut end = Some(block * BLOCK + bit);
            for _ in 0..MOVES_PER_END {
                end = end.and_then(|end| self.move_end(paths, end));
            }
        }
    }

    /// Tries a join or a rotation at an end. Returns the end that replaces it, if any.
    #[inline]
    fn move_end(&mut self, paths: &mut PricedPaths, w: u32) -> Option<u32> {
        let draw = self.random.next_u64();
        match move_end(paths, w, draw, self.highest_rise(draw as u32)) {
            EndMove::Refused => Some(w),
            EndMove::Joined(_) => None,
            EndMove::Rotated { end, .. } => Some(end),
        }
    }

    /// Tries to cut links of a block, once per triangle.
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

    /// Tries to flip diagonals of a block.
    fn flip_diagonals(&mut self, paths: &mut PricedPaths, block: u32) {
        for _ in 0..FLIPS {
            let draw = self.random.next_u64();
            let t = block * BLOCK + (draw >> 58) as u32;
            let edge = (draw >> 32 & 0xffff) as u32 * 3 / 0x1_0000;
            if (t as usize) < paths.len() && paths.diagonals(t) >> edge & 1 == 1 {
                let highest_rise = self.highest_rise(draw as u32);
                flip_diagonal(paths, 4 * t + edge, draw >> 57 & 1 == 1, highest_rise);
            }
        }
    }

    /// Converts a random draw to the highest cost increase that it accepts.
    #[inline]
    fn highest_rise(&self, draw: u32) -> i32 {
        self.odds.iter().zip(1..).take_while(|&(&odds, _)| draw < odds).last().map_or(0, |(_, rise)| rise)
    }
}
