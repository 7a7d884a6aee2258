//! Memory that a decoder allocates when it is polled. The test is alone in its program, because it counts
//! the allocations of all threads.

#![allow(clippy::unwrap_used, reason = "a test")]

use tristrip::stream::{Decoder, StreamLimits, StreamOptions};
use tristrip::{Faces, Mesh};
use tristrip_bench::memory::{CountingAllocator, extra_bytes};
use tristrip_pipeline::stream_of_mesh;

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
    // The thread of the harness may allocate during some polls, but not during all of them.
    let polls = (0..1000).map(|_| extra_bytes(|| decoder.update(&[])));
    let least = polls.map(|(decoded, bytes)| (decoded.unwrap(), bytes.unwrap())).min();
    assert_eq!(least, Some((0, 0)), "chunks decoded, and bytes allocated by each poll at least");
}
