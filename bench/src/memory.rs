//! Memory use of a call: an allocator that counts the bytes in use and records their peak.
//!
//! A block that grows counts only its growth, because the system's allocator moves large blocks without a copy. Allocations of C++ code
//! are not counted. Counts are requested bytes; the benchmarks run on one thread.
#![allow(unsafe_code, reason = "`GlobalAlloc` is an unsafe trait; each call goes to the system's allocator")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator with counters. A program that measures memory installs it as its `#[global_allocator]`.
#[derive(Debug)]
pub struct CountingAllocator;

// SAFETY: every call goes to `System` unchanged, which upholds the contract; the counters are not part of it.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: the caller upholds the contract that `System` requires.
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

/// Runs a call, and returns its result and the peak of the bytes that it used beyond those in use before and those of the result;
/// `None` if the allocator is not installed.
pub fn extra_bytes<R>(call: impl FnOnce() -> R) -> (R, Option<usize>) {
    PEAK.store(LIVE.load(Relaxed), Relaxed);
    let result = call();
    let (peak, left) = (PEAK.load(Relaxed), LIVE.load(Relaxed));
    (result, (left > 0).then(|| peak.saturating_sub(left)))
}
