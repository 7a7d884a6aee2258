//! The memory that a call takes: an allocator that counts the bytes in use and remembers the most there were.
//!
//! A block that grows in place counts by its growth, as the system's allocator moves large blocks without a copy. What C++ code
//! allocates is not seen. Counts are of bytes asked for; the benchmarks run on one thread.
#![allow(
    unsafe_code,
    reason = "an allocator is an unsafe trait by its nature; each call is handed to the system's"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counted. A program that measures installs it as its `#[global_allocator]`.
#[derive(Debug)]
pub struct Counting;

// SAFETY: every call goes to `System` unchanged, which upholds the contract; the counters are not part of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        if new_size >= layout.size() {
            grow(new_size - layout.size());
        } else {
            LIVE.fetch_sub(layout.size() - new_size, Relaxed);
        }
        // SAFETY: as above.
        unsafe { System.realloc(block, layout, new_size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

fn grow(by: usize) {
    let live = LIVE.fetch_add(by, Relaxed) + by;
    PEAK.fetch_max(live, Relaxed);
}

/// Runs a call and gives the most bytes that it used at once beyond what was there before and what it leaves behind, which is its
/// result; `None` where the allocator is not installed.
pub fn extra_bytes<R>(call: impl FnOnce() -> R) -> (R, Option<usize>) {
    PEAK.store(LIVE.load(Relaxed), Relaxed);
    let result = call();
    let (peak, left) = (PEAK.load(Relaxed), LIVE.load(Relaxed));
    (result, (left > 0).then(|| peak.saturating_sub(left)))
}
