//! Memory use of a call: an allocator that counts the bytes in use and records their peak.
//!
//! For a block that grows, only its growth counts, because the system allocator moves large blocks
//! without a copy. Allocations of C++ code are not counted. Counts are requested bytes. The
//! benchmarks run on one thread.
#![allow(unsafe_code, reason = "`GlobalAlloc` is an unsafe trait; each call goes to the system's allocator")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// The system allocator with counters. A program that measures memory installs it as its
/// `#[global_allocator]`.
#[derive(Debug)]
pub struct CountingAllocator;

// SAFETY: every call is passed unchanged to `System`, which upholds the contract. The counters are
// not part of it.
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

/// Runs a call. Returns its result and the peak of the bytes that it used, beyond those in use
/// before and those of the result; `None` if the allocator is not installed.
pub fn extra_bytes<R>(call: impl FnOnce() -> R) -> (R, Option<usize>) {
    PEAK.store(LIVE.load(Relaxed), Relaxed);
    let result = call();
    let (peak, left) = (PEAK.load(Relaxed), LIVE.load(Relaxed));
    (result, (left > 0).then(|| peak.saturating_sub(left)))
}

#[cfg(test)]
mod tests {
    use tristrip::stream::{Decoder, StreamLimits, StreamOptions};
    use tristrip::{Faces, Mesh};
    use tristrip_pipeline::stream_of_mesh;

    use super::*;

    #[global_allocator]
    static ALLOCATOR: CountingAllocator = CountingAllocator;

    #[test]
    fn a_poll_of_an_incomplete_chunk_formats_no_message() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2]).unwrap()).unwrap();
        let stream = stream_of_mesh(&mesh, 0, &StreamOptions::default()).unwrap().stream;
        let bytes = stream.bytes();
        let mut decoder = Decoder::new(StreamLimits::default());
        decoder.update(&bytes[..bytes.len() - 1]).unwrap();
        let ((), bytes) =
            extra_bytes(|| drop(format!("chunk {} at byte {}", decoder.chunk_count(), decoder.offset())));
        assert!(bytes > Some(0), "the allocator does not count");
        // Other tests may allocate during some polls, but not during all of them.
        let polls = (0..1000).map(|_| extra_bytes(|| decoder.update(&[])));
        let least = polls.map(|(decoded, bytes)| (decoded.unwrap(), bytes.unwrap())).min();
        assert_eq!(least, Some((0, 0)), "chunks decoded, and the fewest bytes that a poll allocated");
    }
}
