//! Watches searches: progress, time budget and Ctrl-C.
//!
//! The first Ctrl-C during a search stops the search. Its best result so far is then verified and
//! written. A second Ctrl-C, or a Ctrl-C outside a search, ends the command as usual.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use tristrip::stripify::{Objective, Progress, Watch};
use tristrip::{Method, StripifyOptions};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Search, SearchStop};

use crate::failure::Failure;

/// The exit code of a command that Ctrl-C ended, by the convention of shells.
const INTERRUPTED_CODE: i32 = 130;
/// The time between two updates of the progress display.
const SHOW_EVERY: Duration = Duration::from_millis(100);

static HANDLER: Once = Once::new();
static SEARCHES: AtomicUsize = AtomicUsize::new(0);
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Returns whether Ctrl-C stopped a search.
fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Checks that the next input may be processed.
///
/// # Errors
/// Ctrl-C stopped the search of an earlier input.
pub(crate) fn check_interrupt() -> Result<(), Failure> {
    if interrupted() { Err(Failure::Input("not processed: interrupted".into())) } else { Ok(()) }
}

/// Forgets a Ctrl-C that stopped an earlier command of this process.
pub(crate) fn forget_interrupt() {
    INTERRUPTED.store(false, Ordering::SeqCst);
}

/// The lowest effort at which `cache` searches for every objective.
const CACHE_SEARCHES: u8 = 3;

/// Watches the searches of one input.
pub(crate) struct SearchWatch {
    bar: ProgressBar,
    /// Whether the method searches. Other methods cannot be stopped.
    searches: bool,
    started: Instant,
    budget: Option<Duration>,
    over_budget: AtomicBool,
    /// The time of the last update of the progress display, in milliseconds since the start.
    shown: AtomicU64,
}

impl SearchWatch {
    pub(crate) fn new(bar: ProgressBar, budget: Option<Duration>, options: &StripifyOptions) -> Self {
        let searches = match options.method {
            Method::Best
            | Method::Fewest
            | Method::Tunnel { .. }
            | Method::Eta { .. }
            | Method::GuidedTunnels(_) => true,
            Method::Cache => {
                options.objective == Objective::Indices
                    || options.effort_or_default().level() >= CACHE_SEARCHES
            }
            _ => false,
        };
        if searches {
            // Count before installing the handler: once it is installed, Ctrl-C stops the search.
            SEARCHES.fetch_add(1, Ordering::SeqCst);
            // If no handler can be installed, Ctrl-C ends the command as usual.
            HANDLER.call_once(|| ctrlc::set_handler(on_interrupt).unwrap_or_default());
        }
        Self {
            bar,
            searches,
            started: Instant::now(),
            budget,
            over_budget: AtomicBool::new(false),
            shown: AtomicU64::new(0),
        }
    }

    fn show(&self, progress: &Progress, elapsed: Duration) {
        let now = elapsed.as_millis() as u64;
        let last = self.shown.load(Ordering::Relaxed);
        if now < last + SHOW_EVERY.as_millis() as u64
            || self.shown.compare_exchange(last, now, Ordering::Relaxed, Ordering::Relaxed).is_err()
        {
            return;
        }
        let share = progress.step_limit.map(|limit| 100 * progress.steps / limit.max(1));
        let share = share.map(|percent| format!(", {percent} % of the effort")).unwrap_or_default();
        let strips = counted(progress.strips, "strip");
        self.bar.set_message(format!("stripify: {strips}, cost {}{share}", count(progress.cost)));
    }
}

impl Watch for SearchWatch {
    fn go_on(&self, progress: Progress) -> bool {
        let elapsed = self.started.elapsed();
        self.show(&progress, elapsed);
        if self.budget.is_some_and(|budget| elapsed >= budget) {
            self.over_budget.store(true, Ordering::Relaxed);
        }
        self.stopped().is_none()
    }
}

impl Search for SearchWatch {
    fn stopped(&self) -> Option<SearchStop> {
        if interrupted() {
            Some(SearchStop::Interrupt)
        } else {
            self.over_budget.load(Ordering::Relaxed).then_some(SearchStop::Budget)
        }
    }
}

impl Drop for SearchWatch {
    fn drop(&mut self) {
        if self.searches {
            SEARCHES.fetch_sub(1, Ordering::SeqCst);
        }
    }
}

fn on_interrupt() {
    let searching = SEARCHES.load(Ordering::SeqCst) > 0;
    if INTERRUPTED.swap(true, Ordering::SeqCst) || !searching {
        std::process::exit(INTERRUPTED_CODE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::Effort;

    /// Regression: during a method that does not search, the first Ctrl-C only printed a note.
    #[test]
    fn only_searches_handle_an_interrupt() {
        let searches_of = |options: StripifyOptions| {
            let _watch = SearchWatch::new(ProgressBar::hidden(), None, &options);
            SEARCHES.load(Ordering::SeqCst)
        };
        let searches_with = |method| searches_of(StripifyOptions::default().with_method(method));
        let cache = StripifyOptions::default().with_method(Method::Cache);
        let efforts = [2, 3].map(|level| cache.with_effort(Effort::new(level).unwrap()));
        assert_eq!(efforts.map(searches_of), [0, 1]);
        assert_eq!([Method::Input, Method::Sequential, Method::STRIPE].map(searches_with), [0; 3]);
        assert_eq!([Method::Best, Method::Fewest, Method::Tunnel { length: 9 }].map(searches_with), [1; 3]);
        assert_eq!(SEARCHES.load(Ordering::SeqCst), 0);
    }

    #[test]
    fn the_next_command_is_not_interrupted() {
        INTERRUPTED.store(true, Ordering::SeqCst);
        let message = check_interrupt().unwrap_err().to_string();
        assert_eq!(message, "not processed: interrupted");
        forget_interrupt();
        assert!(check_interrupt().is_ok());
    }
}
