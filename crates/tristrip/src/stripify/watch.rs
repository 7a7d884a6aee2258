//! Watching a long search: what it has reached so far, and a way to stop it with the best cover that it has.
//!
//! The library knows no clock and prints nothing, so that a progress bar, an interrupt and a time budget are the watcher's. A
//! search that is never told to stop gives the same result every time; one that is stopped gives what it had by then.

/// What a search has reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Progress {
    /// Steps done: the unit in which effort is counted.
    pub steps: u64,
    /// Steps after which the search ends, where that is known.
    pub step_limit: Option<u64>,
    /// Strips now.
    pub strips: usize,
    /// The cost that is minimized, of the best cover so far.
    pub cost: usize,
}

/// Watches a search. Every search asks it after some thousands of steps, from whatever thread it runs on.
pub trait Watch: Sync {
    /// Takes notice of the progress and tells whether the search shall go on.
    fn go_on(&self, progress: Progress) -> bool;
}

/// Watches nothing and never stops a search.
impl Watch for () {
    fn go_on(&self, _: Progress) -> bool {
        true
    }
}
