//! Runs a computation without the GIL while the calling thread handles signals and reports
//! progress.
//!
//! ```text
//! calling thread:  detach ── every 50 ms: signals, progress ── attach ─▶ result or interrupt
//! pool:                  └─▶ computation ─ checks for cancellation ──┘
//! ```
//! After an interrupt, a search or simplification stops at its next check and returns its best
//! result so far. Other computations, and the steps between two stages of the pipeline, are
//! cancelled without a result.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass_init::PyClassInitializer;
use tristrip::StripifyOptions;
use tristrip::stripify::{Progress, Watch};
use tristrip_pipeline::{Observer, Search, SearchStop, SimplifyProgress, Stage};

use crate::errors::{Failure, with_best};
use crate::pool::threads;

/// The interval between checks for signals and between progress reports.
const CHECK_EVERY: Duration = Duration::from_millis(50);

/// The progress, time limit and interrupt options of a computation.
#[derive(Debug, Default)]
pub(crate) struct Watching {
    progress: Option<Py<PyAny>>,
    budget: Option<Duration>,
    returns_best: bool,
    keeps_best: bool,
}

impl Watching {
    /// Validates the arguments `progress`, `budget` (seconds) and `on_interrupt`.
    pub(crate) fn new(
        py: Python<'_>,
        progress: Option<Bound<'_, PyAny>>,
        budget: Option<f64>,
        on_interrupt: &str,
    ) -> Result<Self, Failure> {
        let budget = match budget {
            None => None,
            Some(seconds) => Some(
                Duration::try_from_secs_f64(seconds)
                    .map_err(|_| Failure::option("budget", seconds, "a number of seconds of 0 or more"))?,
            ),
        };
        let returns_best = match on_interrupt {
            "raise" => false,
            "return" => true,
            other => {
                return Err(Failure::option("on_interrupt", format!("{other:?}"), "'raise' or 'return'"));
            }
        };
        let progress = match progress {
            None => None,
            Some(given) => {
                let adapted = py.import("tristrip._progress")?.call_method1("adapt", (given,))?;
                (!adapted.is_none()).then(|| adapted.unbind())
            }
        };
        Ok(Self { progress, budget, returns_best, keeps_best: false })
    }

    /// Keeps the result of an interrupted search instead of cancelling the following stages.
    pub(crate) fn keeping_best(self) -> Self {
        Self { keeps_best: true, ..self }
    }

    /// Runs a computation. If [`Ended::error`] is set, the result comes from an interrupted search.
    ///
    /// # Errors
    /// The computation failed, panicked, or was cancelled without a result.
    pub(crate) fn run<T: Send>(
        self,
        py: Python<'_>,
        computation: impl FnOnce(&Watcher) -> Result<T, Failure> + Send,
    ) -> Result<Ended<T>, Failure> {
        let watcher = Watcher { budget: self.budget, keeps_best: self.keeps_best, ..Watcher::default() };
        let pool = threads()?;
        let (result, error) = py.detach(|| {
            let (sender, receiver) = mpsc::sync_channel(1);
            pool.in_place_scope(|scope| {
                scope.spawn(|_| {
                    let result = catch_unwind(AssertUnwindSafe(|| computation(&watcher)));
                    // The receiver lives until the scope ends.
                    let _ = sender.send(result);
                });
                let mut error = None;
                loop {
                    match receiver.recv_timeout(CHECK_EVERY) {
                        Ok(result) => return (Some(result), error),
                        Err(RecvTimeoutError::Disconnected) => return (None, error),
                        Err(RecvTimeoutError::Timeout) if error.is_none() => {
                            error = Python::attach(|py| self.look(py, &watcher)).err();
                            if error.is_some() {
                                watcher.stop();
                            }
                        }
                        Err(RecvTimeoutError::Timeout) => (),
                    }
                }
            })
        });
        let result = match result {
            Some(Ok(result)) => result,
            Some(Err(panic)) => return Err(Failure::Panic(panic_text(&*panic))),
            None => return Err(Failure::Panic("the computation ended without a result".into())),
        };
        let is_interrupt =
            error.as_ref().is_some_and(|e| e.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py));
        match (result, error) {
            (Ok(value), error) => {
                Ok(Ended { value, error: error.filter(|_| !(is_interrupt && self.returns_best)) })
            }
            // The interrupt is the cause; the error of the cancelled computation adds nothing.
            (Err(_), Some(error)) => Err(error.into()),
            (Err(failure), None) => Err(failure),
        }
    }

    /// Handles signals and reports progress.
    fn look(&self, py: Python<'_>, watcher: &Watcher) -> PyResult<()> {
        py.check_signals()?;
        let Some(progress) = &self.progress else { return Ok(()) };
        let state = *watcher.state.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((stage, p)) = state else { return Ok(()) };
        progress.call1(py, (stage.to_string(), p.steps, p.step_limit, p.strips, p.cost)).map(drop)
    }
}

/// The end of a computation.
#[derive(Debug)]
pub(crate) struct Ended<T> {
    pub(crate) value: T,
    /// The exception to raise after an interrupted search.
    pub(crate) error: Option<PyErr>,
}

impl<T> Ended<T> {
    /// Returns the result. Raises a pending exception without it.
    pub(crate) fn result(self) -> PyResult<T> {
        self.error.map_or(Ok(self.value), Err)
    }

    /// Converts the result to a Python object. A pending exception carries it as `best`.
    pub(crate) fn object<O>(self, py: Python<'_>, convert: impl FnOnce(T) -> O) -> PyResult<Bound<'_, O>>
    where
        O: PyClass<BaseType = PyAny> + Into<PyClassInitializer<O>>,
    {
        let object = Bound::new(py, convert(self.value))?;
        match self.error {
            None => Ok(object),
            Some(error) => Err(with_best(py, error, object.into_any().unbind())),
        }
    }
}

/// The state of a computation, read by the calling thread, and its stop flags.
#[derive(Debug)]
pub(crate) struct Watcher {
    state: Mutex<Option<(Stage, Progress)>>,
    is_stopped: AtomicBool,
    is_over_budget: AtomicBool,
    budget: Option<Duration>,
    /// Whether the caller wants the result of an interrupted search.
    keeps_best: bool,
    has_best: AtomicBool,
    started: Instant,
}

impl Default for Watcher {
    fn default() -> Self {
        Self {
            state: Mutex::default(),
            is_stopped: AtomicBool::new(false),
            is_over_budget: AtomicBool::new(false),
            budget: None,
            keeps_best: false,
            has_best: AtomicBool::new(false),
            started: Instant::now(),
        }
    }
}

impl Watcher {
    fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    fn set(&self, stage: Stage, progress: Progress) {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = Some((stage, progress));
    }
}

impl Watch for Watcher {
    fn go_on(&self, progress: Progress) -> bool {
        self.goes_on(progress, self.started, &self.is_over_budget)
    }
}

impl Watcher {
    /// Returns why a search was stopped, if it was.
    pub(crate) fn stopped(&self) -> Option<SearchStop> {
        self.why_stopped(&self.is_over_budget)
    }

    /// Returns whether the calling thread has requested a stop.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    fn why_stopped(&self, is_over_budget: &AtomicBool) -> Option<SearchStop> {
        if self.is_interrupted() {
            Some(SearchStop::Interrupt)
        } else {
            is_over_budget.load(Ordering::Relaxed).then_some(SearchStop::Budget)
        }
    }

    /// Reports the progress of a search, and returns whether to continue.
    fn goes_on(&self, progress: Progress, started: Instant, is_over_budget: &AtomicBool) -> bool {
        self.set(Stage::Stripify, progress);
        if self.budget.is_some_and(|budget| started.elapsed() >= budget) {
            is_over_budget.store(true, Ordering::Relaxed);
        }
        let goes_on = self.why_stopped(is_over_budget).is_none();
        if !goes_on {
            self.has_best.store(self.keeps_best, Ordering::Relaxed);
        }
        goes_on
    }
}

/// The watch of one search, with its own time budget.
struct Searches<'a> {
    watcher: &'a Watcher,
    started: Instant,
    is_over_budget: AtomicBool,
}

impl Watch for Searches<'_> {
    fn go_on(&self, progress: Progress) -> bool {
        self.watcher.goes_on(progress, self.started, &self.is_over_budget)
    }
}

impl Search for Searches<'_> {
    fn stopped(&self) -> Option<SearchStop> {
        self.watcher.why_stopped(&self.is_over_budget)
    }
}

impl Observer for Watcher {
    fn stage(&self, stage: Stage) {
        self.set(stage, Progress::default());
    }

    fn search(&self, _: &StripifyOptions) -> Box<dyn Search + '_> {
        Box::new(Searches { watcher: self, started: Instant::now(), is_over_budget: AtomicBool::new(false) })
    }

    fn simplifies(&self, progress: SimplifyProgress) -> bool {
        let removed = |left: usize| progress.before.saturating_sub(left) as u64;
        if let Some((Stage::Simplify, shown)) =
            &mut *self.state.lock().unwrap_or_else(PoisonError::into_inner)
        {
            // Parts report in any order.
            shown.steps = removed(progress.left).max(shown.steps);
            shown.step_limit = Some(removed(progress.goal));
        }
        // A result exists from here on.
        self.has_best.store(self.keeps_best, Ordering::Relaxed);
        !self.is_interrupted()
    }

    fn is_cancelled(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed) && !self.has_best.load(Ordering::Relaxed)
    }
}

/// Returns the message of a panic.
fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    format!("{text}; please report it, unless another thread modified an array while it was in use")
}
