//! The thread pool for all computations. There is one per process, built on first use.
//!
//! A forked process has its parent's memory but not its threads, so it builds its own pool.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::Failure;

/// The stack size per thread, the same as for a typical main thread.
const STACK_BYTES: usize = 8 << 20;
/// A limit above any core count that systems still accept.
const MAX_THREADS: usize = 1024;

static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Returns the pool of this process.
pub(crate) fn threads() -> Result<Arc<ThreadPool>, Failure> {
    let mut slot = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, pool)) = &*slot
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let built = build(0)?;
    // Dropping the inherited pool would wait for threads that do not exist in this process.
    if let Some((_, inherited)) = slot.replace((process, Arc::clone(&built))) {
        std::mem::forget(inherited);
    }
    Ok(built)
}

/// Builds a pool. With 0, the number of threads is `RAYON_NUM_THREADS` or the number of cores.
fn build(threads: usize) -> Result<Arc<ThreadPool>, Failure> {
    let built = ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK_BYTES)
        .thread_name(|number| format!("tristrip-{number}"))
        .build();
    built
        .map(Arc::new)
        .map_err(|error| Failure::option("threads", error, "a number of threads that the system allows"))
}

/// Set the number of threads of this process. Results do not depend on it.
///
/// Args:
///     threads: 1 to 1024, or None for the default: the environment variable RAYON_NUM_THREADS,
///         else the number of cores.
///
/// Raises:
///     ParameterError: the number is out of range, or the system cannot start that many threads.
///
/// >>> import tristrip
/// >>> tristrip.set_threads(2)
/// >>> tristrip.set_threads(None)
#[pyfunction]
#[pyo3(signature = (threads))]
pub(crate) fn set_threads(threads: Option<i64>) -> PyResult<()> {
    let count = match threads {
        None => 0,
        Some(count) => usize::try_from(count)
            .ok()
            .filter(|count| (1..=MAX_THREADS).contains(count))
            .ok_or_else(|| Failure::option("threads", count, "1 to 1024, or None"))?,
    };
    let built = build(count)?;
    let mut slot = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((owner, inherited)) = slot.replace((std::process::id(), built))
        && owner != std::process::id()
    {
        std::mem::forget(inherited);
    }
    Ok(())
}
