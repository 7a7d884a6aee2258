//! Progress reports of a long search. A watcher can stop the search.
//!
//! The library reads no clock and prints nothing. Progress bars, interrupts and time budgets are
//! implemented by the watcher. A search that is not stopped always returns the same result. A
//! stopped search returns its best result so far.

/// The state of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Progress {
    /// Steps done. Effort is measured in steps.
    pub steps: u64,
    /// The number of steps after which the search ends, if known.
    pub step_limit: Option<u64>,
    /// Current number of strips.
    pub strips: usize,
    /// Cost of the best result so far, as minimized by the search.
    pub cost: usize,
}

/// Receives the progress of a search and may stop it. A search calls its watcher every few thousand
/// steps, on the thread that runs the search.
pub trait Watch: Sync {
    /// Receives the progress. Returns whether to continue the search.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// struct Budget(u64);
    /// impl Watch for Budget {
    ///     fn go_on(&self, progress: Progress) -> bool {
    ///         progress.steps < self.0
    ///     }
    /// }
    /// # let mesh = Mesh::new(vec![[0.0; 3]; 289], Faces::from_triangles(grid)?)?;
    /// # let prepared = PreparedFaces::new(&mesh, false);
    /// # let graph = DualGraph::new(prepared.faces());
    /// let options = StripifyOptions::default().with_effort(Effort::default());
    /// let indices = |steps| plan_watched(&prepared, &graph, &options, &Budget(steps)).map(|plan| plan.indices_restart());
    /// // A stopped search returns the best strips found so far.
    /// assert!(indices(0)? > indices(u64::MAX)?);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn go_on(&self, progress: Progress) -> bool;

    /// Called at the end of each search of [`Method::Eta`](super::Method::Eta) from one end of a
    /// strip, with the number of node accesses and whether two strips were joined.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
    /// #[derive(Default)]
    /// struct Searches(AtomicU64, AtomicU64);
    /// impl Watch for Searches {
    ///     fn go_on(&self, _: Progress) -> bool {
    ///         true
    ///     }
    ///     fn search_ended(&self, _accesses: u64, has_found: bool) {
    ///         self.0.fetch_add(1, Relaxed);
    ///         self.1.fetch_add(u64::from(has_found), Relaxed);
    ///     }
    /// }
    /// # let mesh = Mesh::new(vec![[0.0; 3]; 289], Faces::from_triangles(grid)?)?;
    /// # let prepared = PreparedFaces::new(&mesh, false);
    /// # let graph = DualGraph::new(prepared.faces());
    /// let options = StripifyOptions::default().with_method("eta".parse()?);
    /// let searches = Searches::default();
    /// plan_watched(&prepared, &graph, &options, &searches)?;
    /// assert!(searches.0.into_inner() >= searches.1.into_inner());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn search_ended(&self, accesses: u64, has_found: bool) {
        let _ = (accesses, has_found);
    }
}

/// A closure can be a watcher: it receives the progress and returns whether to continue.
///
/// ```
/// use tristrip::stripify::{Progress, Watch};
/// fn is_stopped(watch: &dyn Watch) -> bool {
///     !watch.go_on(Progress::default())
/// }
/// assert!(is_stopped(&|progress: Progress| progress.steps > 0));
/// ```
impl<F: Fn(Progress) -> bool + Sync> Watch for F {
    fn go_on(&self, progress: Progress) -> bool {
        self(progress)
    }
}

/// Ignores progress and never stops a search.
impl Watch for () {
    fn go_on(&self, _: Progress) -> bool {
        true
    }
}
