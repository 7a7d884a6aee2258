//! The threads on which everything runs: one pool of this process, built when it is first used.
//!
//! A process that was forked has the memory of its parent without its threads, so that it gets a pool of its own.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::Failure;

/// The stack of each thread: that of a main thread.
const STACK_BYTES: usize = 8 << 20;
/// More threads than any machine has, and fewer than a system refuses.
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
    // Threads of the parent do not exist here: its pool must not wait for them.
    if let Some((_, inherited)) = slot.replace((process, Arc::clone(&built))) {
        std::mem::forget(inherited);
    }
    Ok(built)
}

/// Builds a pool; 0 threads are as many as the machine has cores, or as `RAYON_NUM_THREADS` says.
fn build(threads: usize) -> Result<Arc<ThreadPool>, Failure> {
    let built = ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK_BYTES)
        .thread_name(|number| format!("tristrip-{number}"))
        .build();
    built
        .map(Arc::new)
        .map_err(|error| Failure::option("threads", error, "threads that the system can start"))
}

/// Set the number of threads on which this process works. Results do not depend on it.
///
/// Args:
///     threads: from 1 to 1024; None for the number of cores, or the value of the environment variable RAYON_NUM_THREADS.
///
/// Raises:
///     ParameterError: the number is out of range, or the system cannot start so many.
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
