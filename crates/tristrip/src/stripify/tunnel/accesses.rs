//! Node accesses: the unit of effort of tunnel searches. The number of accesses also determines
//! when the watcher is called.

use crate::cover::PathCover;
use crate::stripify::watch::{Progress, Watch};

/// Number of accesses between two calls of the watcher.
const WATCH_INTERVAL: u64 = 1 << 13;

/// How a search from a terminal ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::stripify) enum SearchOutcome {
    /// The search found a tunnel.
    Found,
    /// The search found no tunnel.
    NotFound,
    /// The watcher stopped the search.
    Stopped,
}

/// Counts accesses to nodes, and calls the watcher at regular intervals.
pub(in crate::stripify) struct AccessCounter<'a> {
    accesses: u64,
    /// The count at which the watcher is called next.
    next_check: u64,
    watch: &'a dyn Watch,
}

impl<'a> AccessCounter<'a> {
    /// Creates a counter with the value 0.
    pub(in crate::stripify) fn new(watch: &'a dyn Watch) -> Self {
        Self { accesses: 0, next_check: WATCH_INTERVAL, watch }
    }

    /// Returns the accesses so far.
    pub(in crate::stripify) fn accesses(&self) -> u64 {
        self.accesses
    }

    /// Reports the end of a search to the watcher. `start` is the count at which the search
    /// started.
    pub(in crate::stripify) fn end_search(&self, start: u64, has_found: bool) {
        self.watch.search_ended(self.accesses - start, has_found);
    }

    /// Adds accesses without calling the watcher.
    #[inline]
    pub(in crate::stripify) fn add(&mut self, accesses: u64) {
        self.accesses += accesses;
    }

    /// Counts one access. Returns whether the search may continue.
    #[inline]
    pub(in crate::stripify) fn count(&mut self, cover: &PathCover) -> bool {
        self.accesses += 1;
        self.may_continue(cover)
    }

    /// Returns whether the search may continue.
    #[inline]
    pub(in crate::stripify) fn may_continue(&mut self, cover: &PathCover) -> bool {
        if self.accesses < self.next_check {
            return true;
        }
        self.next_check = self.accesses + WATCH_INTERVAL;
        let strips = cover.path_count();
        self.watch.go_on(Progress { steps: self.accesses, strips, cost: strips, ..Progress::default() })
    }
}
